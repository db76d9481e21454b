/* The chains of edges whose limit curves the user wants to follow curves. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_GIVEN_CHAINS_H
#define CO_CONSTRAINTS_GIVEN_CHAINS_H

#include "constraints/constraints.h"

/* Adds the chains of `through`, checked, to constraints, which has room for them, and holds what they hold on a cage at
 * xyz [3 n_vertices]. ERROR_ARGUMENT naming what is wrong, the element the chain's number; ERROR_MEMORY. */
int32_t co_given_chains_create(const curvopt_mesh *mesh, const double *xyz, const curvopt_through *through,
                               int32_t levels, co_constraints *constraints, curvopt_error *error);

#endif
