/* Edges of a cage as sums of the positions that variables move. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_CAGE_EDGES_H
#define CO_HESSIAN_CAGE_EDGES_H

#include "constraints/interpolation.h"
#include "hessian/sparse_hessian.h"

/* All of them the caller's. */
typedef struct co_cage_edges {
    const curvopt_mesh *mesh;
    const co_dof_map *dofs;
    const co_interpolation *interpolation; /* of the positions that dofs give; NULL: these are the cage's vertices */
} co_cage_edges;

typedef struct co_cage_edge {
    int32_t v, w;
    double along[3]; /* from w to v */
    double square;   /* of the length */
} co_cage_edge;

/* Edge k, 0 .. n_edges - 1, of cage x [3 n_vertices]; 0 if neither of its ends can move. */
int co_cage_edges_find(const co_cage_edges *edges, const double *x, int32_t k, co_cage_edge *out);

/* Of a term of each edge, its second derivatives by the edge's vector. */
typedef void (*co_cage_edge_term)(const void *context, const co_cage_edge *edge, double block[9]);
/* hessian += those of the terms of all edges that can move, of cage x, with respect to positions. ERROR_MEMORY. */
int32_t co_cage_edges_add_hessian(const co_cage_edges *edges, const double *x, co_cage_edge_term term,
                                  const void *context, co_sparse_hessian *hessian, curvopt_error *error);

#endif
