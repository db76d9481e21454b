/* The aim of vertices while a shape forms: an elastic sheet.
 *
 * The edges' fourth powers (spacing.h) are a tension, which pinches tubes, and lets faces collapse there. Each corner
 * of a face is the image of a regular polygon's corner, all of one size, and costs the symmetric Dirichlet energy of
 * that map (Smith, Schaefer, "Bijective parameterization with free boundaries", 2015), which has no bound where the
 * corner loses its area. With J the map's derivative, of singular values p and q, and r the area of the rest square,
 *
 *     f = (p^2 + q^2) (1 / r + r / (p^2 q^2)) .
 *
 * Rest squares are smaller than the cage's faces, so that the sheet is under tension and does not buckle
 * (libcurvopt/notes/53-shape-and-spacing.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_SHEET_H
#define CO_HESSIAN_SHEET_H

#include "hessian/sparse_hessian.h"

/* weight times the sum of f over all corners that can move, of faces that are not left out. */
typedef struct co_sheet {
    const curvopt_mesh *mesh;
    const co_dof_map *dofs;
    const uint8_t *left_out; /* [n_faces]; NULL: none */
    double weight;           /* 0: there is none */
    double rest;             /* r */
} co_sheet;

/* r for cage x [3 n_vertices]: `part` of the mean area of its corners; above 0. */
double co_sheet_rest(const co_sheet *sheet, const double *x, double part);
/* The value of cage x; gradient [3 n_vertices] becomes that with respect to x, unless NULL. */
double co_sheet_value(const co_sheet *sheet, const double *x, double *gradient);
/* hessian += the second derivatives at cage x, less what is negative of each corner's, with respect to positions. */
void co_sheet_add_hessian(const co_sheet *sheet, const double *x, co_sparse_hessian *hessian);

#endif
