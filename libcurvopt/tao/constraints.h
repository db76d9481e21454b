/* What is held. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_HOLD_H
#define CURVOPT_TAO_HOLD_H

#include "level.h"

/* projectors [9 n_own], the caller's, of what pins, boundary (curvopt_boundary) and creases leave each own vertex, as
 * the library has it; NULL where nothing is held on any rank. *any_free: whether any vertex can move at all. */
PetscErrorCode hold_find(const portion *on, int32_t boundary, const level_pins *pins, double **projectors,
                         int *any_free);

/* Only motion along the cage's normals at x, where any is allowed. */
PetscErrorCode hold_to_normals(energy *e, Vec x);

#endif
