/* Pairs of faces that cross or touch each other. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/face_pairs.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

enum { RINGS = 2 /* of faces round a crossing, into which it may move */ };

/* Marks all faces at vertices of marked faces. vertex [n_vertices] is work space. */
static void add_ring(const curvopt_mesh *m, uint8_t *face, uint8_t *vertex) {
    memset(vertex, 0, (size_t)m->info.n_vertices);
    for (int32_t h = 0; h < m->info.n_corners; h++)
        vertex[m->corner_vertex[h]] |= face[m->corner_face[h]];
    for (int32_t h = 0; h < m->info.n_corners; h++)
        face[m->corner_face[h]] |= vertex[m->corner_vertex[h]];
}

int32_t co_face_pairs_create(const curvopt_mesh *mesh, const co_crossings *crossings, co_face_pairs *out,
                             curvopt_error *error) {
    uint8_t *vertex = CO_NEW(uint8_t, mesh->info.n_vertices);
    *out = (co_face_pairs){.n = crossings->n,
                           .pair = co_memory_zeroed(crossings->n, sizeof *out->pair),
                           .is_near = CO_NEW(uint8_t, mesh->info.n_faces)};
    const int fits = vertex && out->pair && out->is_near;
    for (size_t k = 0; fits && k < crossings->n; k++) {
        const co_face_pair *found = &crossings->pair[k];
        for (int i = 0; i < 2; i++) {
            out->pair[k][i] = found->face[i];
            out->is_near[found->face[i]] |= found->what == CO_CROSSING_PROVEN;
        }
        out->n_crossing += found->what == CO_CROSSING_PROVEN;
    }
    for (int k = 0; fits && k < RINGS; k++)
        add_ring(mesh, out->is_near, vertex);
    free(vertex);
    if (!fits)
        co_face_pairs_free(out);
    return fits ? CURVOPT_OK : co_status_no_memory(error);
}

void co_face_pairs_free(co_face_pairs *pairs) {
    free(pairs->pair);
    free(pairs->is_near);
    *pairs = (co_face_pairs){0};
}

static int compare(const void *a, const void *b) {
    const int32_t *x = a, *y = b;
    const int k = x[0] == y[0];
    return (x[k] > y[k]) - (x[k] < y[k]);
}

/* The pair of the first cage's faces, ascending. */
static void find_origin(const co_face_pairs *p, int32_t one, int32_t other, int32_t out[2]) {
    const int32_t a = p->origin ? p->origin[one] : one, b = p->origin ? p->origin[other] : other;
    out[0] = a < b ? a : b;
    out[1] = a < b ? b : a;
}

int co_face_pairs_have(const co_face_pairs *p, int32_t one, int32_t other) {
    int32_t key[2];
    find_origin(p, one, other, key);
    return (p->is_near[key[0]] && p->is_near[key[1]]) ||
           (p->n && bsearch(key, p->pair, p->n, sizeof *p->pair, compare) != NULL);
}

static int compare_pairs(const void *a, const void *b) {
    return compare(((const co_face_pair *)a)->face, ((const co_face_pair *)b)->face);
}

/* The crossings become those of the first cage's faces, each once, at the beginning of the list; their number. */
static size_t to_first_cage(const co_face_pairs *p, co_crossings *crossings) {
    size_t n = 0, n_pairs = 0;
    for (size_t k = 0; k < crossings->n; k++) {
        const co_face_pair found = crossings->pair[k];
        if (found.what == CO_CROSSING_PROVEN)
            find_origin(p, found.face[0], found.face[1], crossings->pair[n++].face);
    }
    if (n > 1)
        qsort(crossings->pair, n, sizeof *crossings->pair, compare_pairs);
    for (size_t k = 0; k < n; k++)
        if (n_pairs == 0 || compare_pairs(&crossings->pair[n_pairs - 1], &crossings->pair[k]) != 0)
            crossings->pair[n_pairs++] = crossings->pair[k];
    return n_pairs;
}

int co_face_pairs_allow(const co_face_pairs *p, co_crossings *crossings) {
    const size_t n = to_first_cage(p, crossings);
    for (size_t k = 0; k < n; k++)
        if (!p->is_near[crossings->pair[k].face[0]] || !p->is_near[crossings->pair[k].face[1]])
            return 0;
    return n <= p->n_crossing;
}

void co_face_pairs_accept(co_face_pairs *p, co_crossings *crossings) {
    const size_t n = to_first_cage(p, crossings);
    for (size_t k = 0; k < n; k++)
        p->is_near[crossings->pair[k].face[0]] = p->is_near[crossings->pair[k].face[1]] = 1;
    p->n_crossing = n > p->n_crossing ? n : p->n_crossing;
}
