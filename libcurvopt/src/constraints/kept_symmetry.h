/* What of a cage's symmetry can be kept beside the values of the surface that are held.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_KEPT_SYMMETRY_H
#define CO_CONSTRAINTS_KEPT_SYMMETRY_H

#include "constraints/constraints.h"
#include "constraints/symmetry_group.h"

/* Leaves of a symmetry of mesh and constraints the largest subgroup by whose orbits pivots can be chosen (pivots.h) for
 * what is held on this level, with `boundary`. ERROR_MEMORY. */
int32_t co_kept_symmetry_restrict(const curvopt_mesh *mesh, const co_constraints *constraints, int32_t boundary,
                                  co_symmetry *symmetry, curvopt_error *error);

#endif
