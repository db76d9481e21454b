/* Components in which nothing is held. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_LOOSE_COMPONENTS_H
#define CO_CONSTRAINTS_LOOSE_COMPONENTS_H

#include "constraints/constraints.h"

/* Where `constraints` or `boundary` hold or draw some components of a cage, the others are left out of the energy, and
 * so held: nothing says where they are to be. ERROR_MEMORY. */
int32_t co_loose_components_leave_out(const curvopt_mesh *mesh, int32_t boundary, co_constraints *constraints,
                                      curvopt_error *error);

#endif
