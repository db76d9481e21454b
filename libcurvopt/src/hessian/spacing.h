/* The aim of vertices within the surface: an evenly spaced cage.
 *
 * How a cage lies in its surface is not the surface's shape, and energies are nearly blind to it: what they do gain
 * from vertices that slide is the discretization's. Left to itself that motion is ill-posed. The aim is an elastic
 * sheet: each corner of a face is the image of a regular polygon's corner, all of one size, and costs the symmetric
 * Dirichlet energy of that map (Smith, Schaefer, "Bijective parameterization with free boundaries", 2015), which is
 * without bound where the face has no area. With J the map's derivative, of singular values p and q, and r the area
 * of the rest square,
 *
 *     f = (p^2 + q^2) (1 / r + r / (p^2 q^2)) .
 *
 * Rest squares are smaller than the cage's faces, so that the sheet is under tension and does not buckle
 * (libcurvopt/notes/53-shape-and-spacing.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_SPACING_H
#define CO_HESSIAN_SPACING_H

#include "constraints/interpolation.h"
#include "hessian/sparse_hessian.h"

/* weight times the sum of f over all corners of faces that can move. */
typedef struct co_spacing {
    const curvopt_mesh *mesh;
    const co_dof_map *dofs;
    const co_interpolation *interpolation; /* of the positions that dofs give; NULL: these are the cage's vertices */
    const double *face_weight;             /* [n_faces] as in dof_map.h; NULL: all are 1 */
    double weight;                         /* 0: there is none */
    double rest;                           /* r */
} co_spacing;

/* r for cage x [3 n_vertices]: `part` of the area that its faces' corners would have, were they even; above 0. */
double co_spacing_rest(const co_spacing *spacing, const double *x, double part);
/* The value of cage x; gradient [3 n_vertices] becomes that with respect to x, unless NULL. With face weights it is as
 * in the whole cage for what symmetric motions bring, and no other. */
double co_spacing_value(const co_spacing *spacing, const double *x, double *gradient);
/* hessian += the second derivatives at cage x, less what is negative of each corner's, with respect to positions. */
void co_spacing_add_hessian(const co_spacing *spacing, const double *x, co_sparse_hessian *hessian);

#endif
