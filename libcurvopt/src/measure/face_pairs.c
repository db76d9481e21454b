/* A set of pairs of faces. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/face_pairs.h"

#include "base/memory.h"

#include <stdlib.h>

int32_t co_face_pairs_create(const co_crossings *crossings, co_crossing least, co_face_pairs *out,
                             curvopt_error *error) {
    *out = (co_face_pairs){0};
    out->pair = co_memory_zeroed(crossings->n, sizeof *out->pair);
    if (!out->pair)
        return co_status_no_memory(error);
    for (size_t k = 0; k < crossings->n; k++)
        if (crossings->pair[k].what >= (int32_t)least) {
            out->pair[out->n][0] = crossings->pair[k].face[0];
            out->pair[out->n++][1] = crossings->pair[k].face[1];
        }
    return CURVOPT_OK;
}

void co_face_pairs_free(co_face_pairs *pairs) {
    free(pairs->pair);
    *pairs = (co_face_pairs){0};
}

static int compare(const void *a, const void *b) {
    const int32_t *x = a, *y = b;
    const int k = x[0] == y[0];
    return (x[k] > y[k]) - (x[k] < y[k]);
}

int co_face_pairs_have(const co_face_pairs *p, int32_t one, int32_t other) {
    const int32_t a = p->origin ? p->origin[one] : one, b = p->origin ? p->origin[other] : other;
    const int32_t key[2] = {a < b ? a : b, a < b ? b : a};
    return p->n && bsearch(key, p->pair, p->n, sizeof *p->pair, compare) != NULL;
}
