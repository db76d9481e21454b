/* Vertices of the last level's cage, held on coarser levels (libcurvopt/notes/126-pins-on-coarse-levels.md).
 *
 * A subdivision moves the vertices of a cage. Held on each level where they are to be on the last one, they are put
 * back after every subdivision, and the surface that a level has found is not the one that the next begins with. So a
 * coarse level holds in the place of a vertex where that will be after the subdivisions that follow: a value of the
 * cage (vertex_mask.h), an unknown of the level as limit points are (interpolation.h). Spaces are nested then: a finer
 * level begins on the surface with which the coarser one ended, and the last level holds the vertices themselves.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_LOOK_AHEAD_H
#define CO_CONSTRAINTS_LOOK_AHEAD_H

#include "constraints/constraints.h"

/* Marks vertices of the user's constraints, so many subdivisions before the last level. Not those that subdivision
 * leaves constrained as they are, of faces that are held; nor where a vertex has no mask; nor, with any soft
 * constraints, at all. */
void co_look_ahead(const curvopt_mesh *mesh, int32_t subdivisions, co_constraints *constraints);
/* Takes marks off whose masks overlap others', where these cannot be chosen freely. ERROR_MEMORY. */
int32_t co_look_ahead_leave_overlapping(const curvopt_mesh *mesh, co_constraints *constraints, curvopt_error *error);
/* Whether vertex v is marked, and whether any is. */
static inline int co_looks_ahead_at(const co_constraints *constraints, int32_t v) {
    return constraints->of_limit[v] == CO_OF_OWN_POINT && constraints->subdivisions[v];
}
int co_looks_ahead(const curvopt_mesh *mesh, const co_constraints *constraints);

#endif
