/* The aim of vertices within the surface: an evenly spaced cage.
 *
 * How a cage lies in its surface is not the surface's shape, and energies are nearly blind to it: what they do gain
 * from vertices that slide is the discretization's. Left to itself that motion is ill-posed. The sum of |edge|^4 over
 * the cage is convex, and least, for a given surface, where edges are of one length. It is a tension, which pinches
 * tubes, and does not keep faces from losing their area. So corners of faces that are much smaller than the mean one
 * are under a pressure: each corner is the image of a regular polygon's corner with unit sides, by a linear map with
 * singular values p and q, and costs
 *
 *     a^3 (1 / (p^2 + delta) + 1 / (q^2 + delta)) ,
 *
 * with an area a. On an even cage that is next to nothing (libcurvopt/notes/53-shape-and-spacing.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_SPACING_H
#define CO_HESSIAN_SPACING_H

#include "constraints/interpolation.h"
#include "hessian/sparse_hessian.h"

/* weight times the sum over all edges and corners that can move. */
typedef struct co_spacing {
    const curvopt_mesh *mesh;
    const co_dof_map *dofs;
    const co_interpolation *interpolation; /* of the positions that dofs give; NULL: these are the cage's vertices */
    double weight;                         /* 0: there is none */
    double least;                          /* a; 0: corners cost nothing */
} co_spacing;

/* The mean area p q of corners of cage x [3 n_vertices] that can move; 0 if none can. */
double co_spacing_mean_corner(const co_spacing *spacing, const double *x);
/* The value of cage x; gradient [3 n_vertices] becomes that with respect to x, unless NULL. */
double co_spacing_value(const co_spacing *spacing, const double *x, double *gradient);
/* hessian += the second derivatives at cage x, with respect to positions. Where pressure on a corner is larger than the
 * edges' tension there, what is more negative than tension makes up for is left out: the sum is positive semidefinite.
 */
void co_spacing_add_hessian(const co_spacing *spacing, const double *x, co_sparse_hessian *hessian);

#endif
