/* The user's constraints. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_GIVEN_CONSTRAINTS_H
#define CO_CONSTRAINTS_GIVEN_CONSTRAINTS_H

#include "constraints/constraints.h"

/* The user's constraints on a cage at xyz [3 n_vertices], checked; none where `given` is NULL. ERROR_ARGUMENT naming
 * what is wrong, ERROR_MEMORY. */
int32_t co_given_constraints_create(const curvopt_mesh *mesh, const double *xyz, const curvopt_constraints *given,
                                    co_constraints *out, curvopt_error *error);
/* ERROR_ARGUMENT where a place and what a strength below 1 pulls back to would be two ends of one spring, or where a
 * constraint stands against options.within. */
int32_t co_given_constraints_check_strength(const curvopt_constraints *given, const curvopt_options *options,
                                            curvopt_error *error);
/* Whether any of these, NULL for none, has a place of its own. */
int co_given_constraints_have_places(const curvopt_constraints *given);
/* Whether there are constraints for which other vertices near them move, too. */
int co_given_constraints_move_cage(const curvopt_mesh *mesh, const co_constraints *constraints);
/* Moves vertices of xyz [3 n_vertices] so that what is held exactly is where it is to be, or will be (look_ahead.h);
 * for points and tangents of the surface without what options.boundary holds, unless a vertex of that looks ahead. As
 * co_interpolation_create, co_pivots_choose and co_given_through_place; ERROR_ARGUMENT also where nothing of a chain is
 * left that boundary and creases do not hold.
 */
int32_t co_given_constraints_place(const curvopt_mesh *mesh, const co_constraints *constraints, int32_t boundary,
                                   double *xyz, curvopt_error *error);

#endif
