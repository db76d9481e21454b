/* What the user wants the surface to go through. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_GIVEN_THROUGH_H
#define CO_CONSTRAINTS_GIVEN_THROUGH_H

#include "constraints/constraints.h"

/* A copy of the caller's struct, which may be an older one. ERROR_ARGUMENT where it cannot be read. */
int32_t co_given_through_take(const curvopt_through *from, curvopt_through *out, curvopt_error *error);
/* Adds the entries of options->through, checked, to constraints->values, and to constraints->drawn those of a weight
 * below 1, of a cage at xyz [3 n_vertices]. ERROR_ARGUMENT naming what is wrong, the element the entry's number;
 * ERROR_MEMORY. On failure there are no constraints any more. */
int32_t co_given_through_create(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                                co_constraints *constraints, curvopt_error *error);
/* Puts positions xyz [3 n_vertices] (interpolation.h) to where the values are to be, which have pivots, the nearest
 * way. ERROR_ARGUMENT where a tangent plane or a tangent begins at right angles to what it is to be. */
int32_t co_given_through_place(const co_constraints *constraints, double *xyz, curvopt_error *error);

#endif
