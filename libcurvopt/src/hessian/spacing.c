/* An evenly spaced cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/spacing.h"

#include <string.h>

/* An edge that can move. */
typedef struct edge {
    int32_t v, w;
    double along[3]; /* from w to v */
    double square;   /* of the length */
} edge;

/* 0 if neither end of edge k can move. */
static int find_edge(const co_spacing *s, const double *x, int32_t k, edge *out) {
    int32_t h = s->mesh->edge_corner[k];
    *out = (edge){.v = s->mesh->corner_vertex[h], .w = co_mesh_destination(s->mesh, h)};
    if (s->dofs->node[out->v] < 0 && s->dofs->node[out->w] < 0)
        return 0;
    for (size_t c = 0; c < 3; c++) {
        out->along[c] = x[3 * (size_t)out->v + c] - x[3 * (size_t)out->w + c];
        out->square += out->along[c] * out->along[c];
    }
    return 1;
}

double co_spacing_value(const co_spacing *s, const double *x, double *gradient) {
    double sum = 0;
    edge e;
    if (gradient)
        memset(gradient, 0, 3 * sizeof *gradient * (size_t)s->mesh->info.n_vertices);
    for (int32_t k = 0; k < s->mesh->info.n_edges; k++) {
        if (!find_edge(s, x, k, &e))
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

void co_spacing_add_hessian(const co_spacing *s, const double *x, co_sparse_hessian *hessian) {
    edge e;
    for (int32_t k = 0; s->weight > 0 && k < s->mesh->info.n_edges; k++) {
        double own[9], other[9];
        if (!find_edge(s, x, k, &e))
            continue;
        for (int i = 0; i < 9; i++) {
            own[i] = 4 * s->weight * ((i % 4 == 0) * e.square + 2 * e.along[i / 3] * e.along[i % 3]);
            other[i] = -own[i];
        }
        co_sparse_hessian_add_block(hessian, e.v, e.v, own);
        co_sparse_hessian_add_block(hessian, e.w, e.w, own);
        co_sparse_hessian_add_block(hessian, e.v, e.w, other);
    }
}
