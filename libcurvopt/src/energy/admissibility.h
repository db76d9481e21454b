/* Which surface can carry which energies on a cage's fans. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ADMISSIBILITY_H
#define CO_ENERGY_ADMISSIBILITY_H

#include "energy/functional.h"
#include "surface/patches.h"

/* ERROR_SURFACE, with the vertex's name, if the functional is infinite or not known on this cage's `surface`
 * (curvopt_surface). *third_allowed: whether it can carry third-order energies. */
int32_t co_admissibility_check(const curvopt_mesh *mesh, const co_patches *patches, const co_functional *functional,
                               int32_t surface, int *third_allowed, curvopt_error *error);

#endif
