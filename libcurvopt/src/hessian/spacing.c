/* An evenly spaced cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/spacing.h"

#include <string.h>

double co_spacing_value(const co_spacing *s, const double *x, double *gradient) {
    const curvopt_mesh *mesh = s->edges.mesh;
    double sum = 0;
    co_cage_edge e;
    if (gradient)
        memset(gradient, 0, 3 * sizeof *gradient * (size_t)mesh->info.n_vertices);
    for (int32_t k = 0; k < mesh->info.n_edges; k++) {
        if (!co_cage_edges_find(&s->edges, x, k, &e))
            continue;
        sum += e.square * e.square;
        for (size_t c = 0; gradient && c < 3; c++) {
            double force = 4 * s->weight * e.square * e.along[c];
            gradient[3 * (size_t)e.v + c] += force;
            gradient[3 * (size_t)e.w + c] -= force;
        }
    }
    return s->weight * sum;
}

/* Of weight |edge|^4. */
static void fourth_power(const void *context, const co_cage_edge *e, double block[9]) {
    const co_spacing *s = context;
    for (int i = 0; i < 9; i++)
        block[i] = 4 * s->weight * ((i % 4 == 0) * e->square + 2 * e->along[i / 3] * e->along[i % 3]);
}

int32_t co_spacing_add_hessian(const co_spacing *s, const double *x, co_sparse_hessian *hessian, curvopt_error *error) {
    return co_cage_edges_add_hessian(&s->edges, x, fourth_power, s, hessian, error);
}
