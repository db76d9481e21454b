/* The cage vertices in whose place values are unknowns. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_PIVOTS_H
#define CO_CONSTRAINTS_PIVOTS_H

#include "constraints/constraints.h"
#include "constraints/symmetry_group.h"

/* Chooses a pivot for each value of constraints->values, whose rows it makes, among the vertices that nothing
 * constrains, and enters the value's constraint there: freedom, direction, anchor, of_limit. Values that have
 * a vertex in common that could be a pivot are one group; in a group rows are eliminated with complete pivoting, after
 * those of limit points (of_limit) that the group depends on, whose pivots are their own vertices. Optional values
 * come last, and stay without a pivot where nothing is left for them.
 *
 * With a symmetry, of order 1 or NULL: none, positions are taken to positions where it takes vertices to vertices:
 * pivots come in orbits, and `values` become what stands in their places (pivot_orbits.h). None may be optional, or of
 * curvatures.
 *
 * ERROR_ARGUMENT, the element the number of the user's entry, where a value depends on nothing that may move, or
 * on no more than the others do, and where no pivots come in such orbits. As co_surface_values_make_rows. */
int32_t co_pivots_choose(const curvopt_mesh *mesh, const co_symmetry *symmetry, co_constraints *constraints,
                         curvopt_error *error);

#endif
