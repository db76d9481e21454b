/* Components in which nothing is held. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_LOOSE_COMPONENTS_H
#define CO_CONSTRAINTS_LOOSE_COMPONENTS_H

#include "constraints/constraints.h"

/* Where `constraints` or `boundary` hold or draw some components of a cage at xyz [3 n_vertices], the vertices of the
 * others are held, too: nothing else would say where these are to be. ERROR_MEMORY. */
int32_t co_loose_components_hold(const curvopt_mesh *mesh, const double *xyz, int32_t boundary,
                                 co_constraints *constraints, curvopt_error *error);

#endif
