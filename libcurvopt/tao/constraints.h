/* What is held. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_HOLD_H
#define CURVOPT_TAO_HOLD_H

#include "objective.h"

/* Vertices that are held beside those of boundaries and creases: freedom [n_own] 0 to 3, direction [3 n_own]; or
 * freedom NULL. */
typedef struct level_pins {
    unsigned char *freedom;
    double *direction;
} level_pins;

/* projectors [9 n_own], the caller's, of what pins, boundary (curvopt_boundary) and creases leave each own vertex, as
 * the library has it; NULL where nothing is held on any rank. *any_free: whether any vertex can move at all. */
PetscErrorCode hold_find(const portion *on, int32_t boundary, const level_pins *pins, double **projectors,
                         int *any_free);

/* Only motion along the cage's normals at x, where any is allowed. */
PetscErrorCode hold_to_normals(energy *e, Vec x);

#endif
