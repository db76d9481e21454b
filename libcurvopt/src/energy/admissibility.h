/* Which energies are finite on which surface of a cage. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ADMISSIBILITY_H
#define CO_ENERGY_ADMISSIBILITY_H

#include "energy/functional.h"
#include "surface/patches.h"

/* ERROR_SURFACE naming the vertex (-1 where it is the centre of a face, which the message names) if the functional is
 * infinite or not known on this cage's `surface` (curvopt_surface). *third_allowed: whether third-order energies are
 * finite. */
int32_t co_admissibility_check(const curvopt_mesh *mesh, const co_patches *patches, const co_functional *functional,
                               int32_t surface, int *third_allowed, curvopt_error *error);

#endif
