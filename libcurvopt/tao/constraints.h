/* Vertices that may not move freely. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_CONSTRAINTS_H
#define CURVOPT_TAO_CONSTRAINTS_H

#include "objective.h"

/* Vertices that are constrained beside those of boundaries and creases: freedom [n_own] 0 to 3, direction [3 n_own]; or
 * freedom NULL. */
typedef struct constraints_pins {
    unsigned char *freedom;
    double *direction;
} constraints_pins;

/* projectors [9 n_own], the caller's, of what pins, boundary (curvopt_boundary) and creases leave each own vertex, as
 * the library has it; NULL where nothing is constrained on any rank. *any_free: whether any vertex can move at all. */
PetscErrorCode constraints_find(const subdomain *on, int32_t boundary, const constraints_pins *pins,
                                double **projectors, int *any_free);

/* Only motion along the cage's normals at x, where any is allowed. */
PetscErrorCode constraints_to_normals(objective *o, Vec x);

#endif
