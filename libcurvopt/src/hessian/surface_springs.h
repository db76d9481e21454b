/* Springs of points, tangents and curvatures of the surface (surface_values.h), over the variables of a dof_map.
 *
 * The value of a spring's row of the cage is linear in the variables, and so is r = (K k)^1/2 Q (value - wanted), with
 * the objective's stiffness K, the spring's k, and the projector Q onto the directions that are held. The springs add
 * the sum of |r|^2 / 2. Lengths are in parts of the input's size; the length of a tangent is 1 at first, so that what
 * counts of it is the sine of the angle by which it is off. A spring of curvatures is of five values, both tangents and
 * three second derivatives, and adds K k times what the second form is off by (second_form.h).
 *
 * Any number of springs may draw parts of the surface that depend on each other: none takes a vertex' place.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_SURFACE_SPRINGS_H
#define CO_HESSIAN_SURFACE_SPRINGS_H

#include "constraints/interpolation.h"
#include "hessian/second_form.h"
#include "hessian/sparse_hessian.h"

typedef struct co_surface_spring {
    size_t first_node;     /* in `vertex` */
    size_t first_number;   /* in `rest` */
    size_t by;             /* where its derivatives begin */
    int32_t n_nodes;       /* that it depends on */
    int32_t n_numbers;     /* 3: r; CO_SECOND_FORM_VALUES: its values as they are */
    double stiffness;      /* K k, of the latter */
    co_second_form wanted; /* of the latter, by normalized positions */
} co_surface_spring;

typedef struct co_surface_springs {
    int32_t n;              /* number of springs */
    const co_dof_map *dofs; /* the caller's */
    co_surface_spring *spring;
    int32_t *vertex;        /* of each spring one of each node */
    co_node_derivative *by; /* of each spring the derivatives of its first number by its nodes, ascending, and so on */
    double *rest;           /* of each spring its numbers where all variables are 0 */
    co_node_derivative *work; /* [nodes of any spring] */
} co_surface_springs;

/* Of values with rows over the cage, on positions that `interpolation` and `dofs` make. Normalized by this centroid and
 * radius; `scale`: K. ERROR_MEMORY. */
int32_t co_surface_springs_create(const co_surface_values *values, const co_interpolation *interpolation,
                                  const co_dof_map *dofs, const double centroid[3], double radius, double scale,
                                  co_surface_springs *out, curvopt_error *error);
void co_surface_springs_free(co_surface_springs *springs);
/* The value at z [n_variables]; gradient [n_variables] += weight times the gradient, unless NULL. */
double co_surface_springs_value(const co_surface_springs *springs, const double *z, double weight, double *gradient);
/* hessian += weight times the second derivatives at z; where not `exact` a matrix near these that is positive
 * semidefinite. */
void co_surface_springs_add_hessian(const co_surface_springs *springs, const double *z, int exact, double weight,
                                    co_sparse_hessian *hessian);
/* Adds to `couplings` the vertices that each spring makes depend on each other. On failure there are no couplings any
 * more. ERROR_MEMORY. */
int32_t co_surface_springs_couple(const co_surface_springs *springs, co_couplings *couplings, curvopt_error *error);

#endif
