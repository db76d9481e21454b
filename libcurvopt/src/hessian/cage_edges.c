/* Edges of a cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/cage_edges.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

/* Weights up to this are left out of the Hessian: where many limit points touch, those of far ones fall by a factor a
 * vertex. */
static const double NEGLIGIBLE = 1e-12;

/* Vertex v as a combination of positions. */
static co_point_row positions_of(const co_cage_edges *s, const int32_t *v) {
    static const double one = 1;
    const int32_t i = s->interpolation ? co_interpolation_find(s->interpolation, *v) : -1;
    if (i < 0)
        return (co_point_row){v, &one, 1};
    const co_sparse_rows *rows = &s->interpolation->cage;
    return (co_point_row){rows->column + rows->start[i], rows->value + rows->start[i],
                          rows->start[i + 1] - rows->start[i]};
}

/* Whether vertex v can move, as far as its own position tells: of one that interpolates it does not. */
static int can_move(const co_cage_edges *s, int32_t v) {
    return s->dofs->node[v] >= 0 || (s->interpolation && co_interpolation_find(s->interpolation, v) >= 0);
}

int co_cage_edges_find(const co_cage_edges *s, const double *x, int32_t k, co_cage_edge *out) {
    int32_t h = s->mesh->edge_corner[k];
    *out = (co_cage_edge){.v = s->mesh->corner_vertex[h], .w = co_mesh_destination(s->mesh, h)};
    if (!can_move(s, out->v) && !can_move(s, out->w))
        return 0;
    for (size_t c = 0; c < 3; c++) {
        out->along[c] = x[3 * (size_t)out->v + c] - x[3 * (size_t)out->w + c];
        out->square += out->along[c] * out->along[c];
    }
    return 1;
}

/* The vector of an edge as a sum of positions, into sum; returns their number. Each end may have the same ones. */
static size_t make_sum(const co_cage_edges *s, const co_cage_edge *e, co_weighted_vertex *sum) {
    const int32_t end[2] = {e->v, e->w};
    size_t n = 0, n_made = 0;
    for (int k = 0; k < 2; k++) {
        const co_point_row row = positions_of(s, &end[k]);
        for (size_t i = 0; i < row.n; i++) {
            const int32_t v = row.vertex[i], node = s->dofs->node[v];
            if (node >= 0 && fabs(row.weight[i]) > NEGLIGIBLE)
                sum[n++] = (co_weighted_vertex){{node, v}, k ? -row.weight[i] : row.weight[i]};
        }
    }
    if (n > 1)
        qsort(sum, n, sizeof *sum, co_numbered_vertex_compare);
    for (size_t i = 0; i < n; i++)
        if (n_made && sum[n_made - 1].at.vertex == sum[i].at.vertex)
            sum[n_made - 1].weight += sum[i].weight;
        else
            sum[n_made++] = sum[i];
    return n_made;
}

int32_t co_cage_edges_add_hessian(const co_cage_edges *s, const double *x, co_cage_edge_term term, const void *context,
                                  co_sparse_hessian *hessian, curvopt_error *error) {
    co_weighted_vertex *sum = CO_NEW(co_weighted_vertex, 2 * (size_t)s->mesh->info.n_vertices);
    const int32_t status = sum ? CURVOPT_OK : co_status_no_memory(error);
    co_cage_edge e;
    for (int32_t k = 0; sum && k < s->mesh->info.n_edges; k++) {
        double block[9];
        if (!co_cage_edges_find(s, x, k, &e))
            continue;
        term(context, &e, block);
        co_sparse_hessian_add_sum(hessian, make_sum(s, &e, sum), sum, block);
    }
    free(sum);
    return status;
}
