/* The aim of vertices within the surface: each in the middle of its neighbours.
 *
 * How a cage lies in its surface is not the surface's shape, and energies are nearly blind to it: what they do gain
 * from vertices that slide is the discretization's. Left to itself that motion is ill-posed. A vertex' offset from the
 * middle of its neighbours, squared and summed up, is convex. Along the surface it is least where neighbours are evenly
 * spaced round each vertex. Across it, it is the mean curvature: on a net of squares the sum, each term over the square
 * of the edges, is a sixteenth of the integral of 4 H^2. So it pulls the shape no other way than bending energy does.
 * (Long edges as such do not count: that would be a tension, and tension pinches tubes;
 * libcurvopt/notes/53-shape-and-spacing.md.)
 *
 * On a boundary or an infinitely sharp crease the neighbours on the curve count alone, at its corners none.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_SPACING_H
#define CO_HESSIAN_SPACING_H

#include "hessian/sparse_hessian.h"

/* weight times the sum of scale_v |x_v - the mean of its neighbours|^2 over all v. */
typedef struct co_spacing {
    const co_dof_map *dofs;
    int32_t n_vertices;
    int32_t *start;     /* [n_vertices + 1] first neighbour of each vertex */
    int32_t *count;     /* [n_vertices] its neighbours; an edge whose ends both are held counts for neither */
    int32_t *neighbour; /* [start[n_vertices]] */
    double *scale;      /* [n_vertices] 1 / mean square of the edges when this was weighed last */
    double weight;      /* 0: there is none */
} co_spacing;

/* Without a weight. mesh may go, dofs must outlive it. ERROR_MEMORY. */
int32_t co_spacing_create(const curvopt_mesh *mesh, const co_dof_map *dofs, co_spacing *out, curvopt_error *error);
void co_spacing_free(co_spacing *spacing);
/* Makes the value `worth` at positions x [3 n_vertices], and scales each term by the edges there. */
void co_spacing_weigh(co_spacing *spacing, const double *x, double worth);
/* The value at positions x; gradient [3 n_vertices] becomes that with respect to x, unless NULL. */
double co_spacing_value(const co_spacing *spacing, const double *x, double *gradient);
/* hessian += the second derivatives, which are the same everywhere and positive semidefinite. */
void co_spacing_add_hessian(const co_spacing *spacing, co_sparse_hessian *hessian);

#endif
