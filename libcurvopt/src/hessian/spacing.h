/* The aim of vertices within the surface: an evenly spaced cage.
 *
 * How a cage lies in its surface is not the surface's shape, and energies are nearly blind to it: what they do gain
 * from vertices that slide is the discretization's. Left to itself that motion is ill-posed. The sum of |edge|^4 over
 * the cage is convex, and least, for a given surface, where edges are of one length
 * (libcurvopt/notes/53-shape-and-spacing.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_SPACING_H
#define CO_HESSIAN_SPACING_H

#include "hessian/cage_edges.h"

/* Over all edges that can move weight |edge|^4, and wall ((shortest / |edge|)^2 - 1)^3 where that is shorter: for
 * |edge|^4 has no force against an edge that vanishes. */
typedef struct co_spacing {
    co_cage_edges edges;
    double weight;   /* 0: there is none */
    double shortest; /* length from which an edge is too short; 0: none is */
    double wall;     /* what an edge of shortest / sqrt(2) costs */
} co_spacing;

/* Weights by which the fourth powers of all edges of cage x [3 n_vertices] together are worth so much, an edge that is
 * too short a tenth of its share, and all that are so in x a hundred times as much at most. Sets all but edges. */
void co_spacing_weigh(co_spacing *spacing, const double *x, double worth, double shortest);
/* The value of cage x [3 n_vertices]; gradient [3 n_vertices] becomes that with respect to x, unless NULL. */
double co_spacing_value(const co_spacing *spacing, const double *x, double *gradient);
/* hessian += the second derivatives at cage x, with respect to positions, of short edges' costs those along the edge;
 * they are positive semidefinite. ERROR_MEMORY. */
int32_t co_spacing_add_hessian(const co_spacing *spacing, const double *x, co_sparse_hessian *hessian,
                               curvopt_error *error);

#endif
