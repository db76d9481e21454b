/* An evenly spaced cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/spacing.h"

#include <math.h>
#include <string.h>

/* Weights up to this are left out of the Hessian: where many limit points touch, those of far ones fall by a factor a
 * vertex. */
static const double NEGLIGIBLE = 1e-12;

/* An edge that can move. */
typedef struct edge {
    int32_t v, w;
    double along[3]; /* from w to v */
    double square;   /* of the length */
} edge;

/* Vertex v as a combination of positions. */
static co_point_row positions_of(const co_spacing *s, const int32_t *v) {
    static const double one = 1;
    const int32_t i = s->interpolation ? co_interpolation_find(s->interpolation, *v) : -1;
    if (i < 0)
        return (co_point_row){v, &one, 1};
    const co_sparse_rows *rows = &s->interpolation->cage;
    return (co_point_row){rows->column + rows->start[i], rows->value + rows->start[i],
                          rows->start[i + 1] - rows->start[i]};
}

/* Whether vertex v can move, as far as its own position tells: of one that interpolates it does not. */
static int can_move(const co_spacing *s, int32_t v) {
    return s->dofs->node[v] >= 0 || (s->interpolation && co_interpolation_find(s->interpolation, v) >= 0);
}

/* 0 if neither end of edge k can move. */
static int find_edge(const co_spacing *s, const double *x, int32_t k, edge *out) {
    int32_t h = s->mesh->edge_corner[k];
    *out = (edge){.v = s->mesh->corner_vertex[h], .w = co_mesh_destination(s->mesh, h)};
    if (!can_move(s, out->v) && !can_move(s, out->w))
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

/* Block of two of the positions that an edge is a combination of, with their weights. */
static void add_pair(co_sparse_hessian *hessian, int32_t v, int32_t w, double weight, const double own[9]) {
    double block[9];
    for (int i = 0; i < 9; i++)
        block[i] = weight * own[i];
    co_sparse_hessian_add_block(hessian, v, w, block);
}

/* Blocks of an edge from w to v, whose ends may be combinations: end[0] of v with its weights, end[1] of w with -1
 * times its. */
static void add_edge(co_sparse_hessian *hessian, const co_point_row end[2], const double own[9]) {
    const size_t n = end[0].n + end[1].n;
    for (size_t i = 0; i < n; i++) {
        const int b = i >= end[0].n;
        const size_t at = b ? i - end[0].n : i;
        const double weight = b ? -end[1].weight[at] : end[0].weight[at];
        const int32_t v = end[b].vertex[at];
        if (fabs(weight) <= NEGLIGIBLE)
            continue;
        add_pair(hessian, v, v, weight * weight, own);
        for (size_t j = 0; j < i; j++) {
            const int d = j >= end[0].n;
            const size_t to = d ? j - end[0].n : j;
            const double product = weight * (d ? -end[1].weight[to] : end[0].weight[to]);
            const int32_t w = end[d].vertex[to];
            if (fabs(product) > NEGLIGIBLE)
                add_pair(hessian, v, w, v == w ? 2 * product : product, own);
        }
    }
}

void co_spacing_add_hessian(const co_spacing *s, const double *x, co_sparse_hessian *hessian) {
    edge e;
    for (int32_t k = 0; s->weight > 0 && k < s->mesh->info.n_edges; k++) {
        double own[9];
        if (!find_edge(s, x, k, &e))
            continue;
        for (int i = 0; i < 9; i++)
            own[i] = 4 * s->weight * ((i % 4 == 0) * e.square + 2 * e.along[i / 3] * e.along[i % 3]);
        const co_point_row end[2] = {positions_of(s, &e.v), positions_of(s, &e.w)};
        add_edge(hessian, end, own);
    }
}
