/* A group of symmetries of a cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/symmetry_group.h"

#include "base/memory.h"

#include <stdlib.h>

void co_symmetry_free(co_symmetry *s) {
    free(s->corner);
    free(s->mirrored);
    free(s->matrix);
    free(s->product);
    *s = (co_symmetry){0};
}

int32_t co_symmetry_none(const curvopt_mesh *m, co_symmetry *out, curvopt_error *error) {
    *out = (co_symmetry){.order = 1,
                         .n_corners = m->info.n_corners,
                         .corner = CO_NEW(int32_t, m->info.n_corners),
                         .mirrored = CO_NEW(uint8_t, 1),
                         .matrix = CO_NEW(double, 9),
                         .product = CO_NEW(int32_t, 1)};
    if (!out->corner || !out->mirrored || !out->matrix || !out->product) {
        co_symmetry_free(out);
        return co_status_no_memory(error);
    }
    for (int32_t h = 0; h < m->info.n_corners; h++)
        out->corner[h] = h;
    for (int k = 0; k < 3; k++)
        out->matrix[4 * k] = 1;
    return CURVOPT_OK;
}

int32_t co_symmetry_subdivide(co_symmetry *s, curvopt_error *error) {
    size_t n = (size_t)s->n_corners;
    int32_t *fine = CO_NEW(int32_t, 4 * n * (size_t)s->order);
    if (!fine)
        return co_status_no_memory(error);
    for (size_t g = 0; g < (size_t)s->order; g++)
        for (size_t h = 0; h < n; h++)
            for (int32_t k = 0; k < 4; k++) /* a child's corners: vertex, edge leaving it, face, edge arriving */
                fine[(g * n + h) * 4 + (size_t)k] = 4 * s->corner[g * n + h] + (s->mirrored[g] ? (4 - k) % 4 : k);
    free(s->corner);
    s->corner = fine;
    s->n_corners *= 4;
    return CURVOPT_OK;
}
