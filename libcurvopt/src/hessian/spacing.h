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

/* weight times the sum of |edge|^4 over all edges that can move. */
typedef struct co_spacing {
    co_cage_edges edges;
    double weight; /* 0: there is none */
} co_spacing;

/* The value of cage x [3 n_vertices]; gradient [3 n_vertices] becomes that with respect to x, unless NULL. */
double co_spacing_value(const co_spacing *spacing, const double *x, double *gradient);
/* hessian += the second derivatives at cage x, with respect to positions; they are positive semidefinite. ERROR_MEMORY.
 */
int32_t co_spacing_add_hessian(const co_spacing *spacing, const double *x, co_sparse_hessian *hessian,
                               curvopt_error *error);

#endif
