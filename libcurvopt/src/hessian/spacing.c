/* An evenly spaced cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/spacing.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
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

static int compare(const void *a, const void *b) {
    const co_weighted_vertex *x = a, *y = b;
    if (x->node != y->node)
        return (x->node > y->node) - (x->node < y->node);
    return (x->vertex > y->vertex) - (x->vertex < y->vertex);
}

/* An edge's vector as a sum of positions. */
typedef struct edge_sum {
    int32_t *slot;            /* [n_vertices] place of a vertex in `term`; -1: none */
    co_weighted_vertex *term; /* [n_vertices], of which n are used */
    size_t n;
} edge_sum;

static int32_t edge_sum_create(size_t n_vertices, edge_sum *sum, curvopt_error *error) {
    *sum = (edge_sum){.slot = CO_NEW(int32_t, n_vertices), .term = CO_NEW(co_weighted_vertex, n_vertices)};
    if (!sum->slot || !sum->term)
        return co_status_no_memory(error);
    for (size_t v = 0; v < n_vertices; v++)
        sum->slot[v] = -1;
    return CURVOPT_OK;
}

static void edge_sum_free(edge_sum *sum) {
    free(sum->slot);
    free(sum->term);
}

static void make_sum(const co_spacing *s, const edge *e, edge_sum *sum) {
    const int32_t end[2] = {e->v, e->w};
    sum->n = 0;
    for (int k = 0; k < 2; k++) {
        const co_point_row row = positions_of(s, &end[k]);
        for (size_t i = 0; i < row.n; i++) {
            const int32_t v = row.vertex[i];
            if (s->dofs->node[v] < 0 || fabs(row.weight[i]) <= NEGLIGIBLE)
                continue;
            if (sum->slot[v] < 0) {
                sum->slot[v] = (int32_t)sum->n;
                sum->term[sum->n++] = (co_weighted_vertex){.node = s->dofs->node[v], .vertex = v};
            }
            sum->term[sum->slot[v]].weight += k ? -row.weight[i] : row.weight[i];
        }
    }
    for (size_t i = 0; i < sum->n; i++)
        sum->slot[sum->term[i].vertex] = -1;
    if (sum->n > 1)
        qsort(sum->term, sum->n, sizeof *sum->term, compare);
}

int32_t co_spacing_add_hessian(const co_spacing *s, const double *x, co_sparse_hessian *hessian, curvopt_error *error) {
    edge_sum sum;
    edge e;
    const int32_t status = edge_sum_create((size_t)s->mesh->info.n_vertices, &sum, error);
    for (int32_t k = 0; status == CURVOPT_OK && k < s->mesh->info.n_edges; k++) {
        double own[9];
        if (!find_edge(s, x, k, &e))
            continue;
        for (int i = 0; i < 9; i++)
            own[i] = 4 * s->weight * ((i % 4 == 0) * e.square + 2 * e.along[i / 3] * e.along[i % 3]);
        make_sum(s, &e, &sum);
        co_sparse_hessian_add_sum(hessian, sum.n, sum.term, own);
    }
    edge_sum_free(&sum);
    return status;
}
