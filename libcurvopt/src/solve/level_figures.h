/* What a level says where it stands, as the user sees it: energies, and its cage.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LEVEL_FIGURES_H
#define CO_SOLVE_LEVEL_FIGURES_H

#include "solve/level.h"

/* Energies by rules that give the wanted accuracy, and positions xyz [3 n_vertices] in the user's units.
 * ERROR_GEOMETRY: by these rules the energy is not finite. */
int32_t co_level_finish(co_level *level, double *xyz, curvopt_energies *energies, int *resolved, curvopt_error *error);
/* The same of a level that was cancelled, at what it has reached, figures by the rules that there are. *springs: what
 * springs add. 0 if it has not begun or there are no rules. */
int co_level_finish_cancelled(co_level *level, double *xyz, curvopt_energies *energies, double *springs);
/* Energies of a cage xyz [3 n_vertices] that the level's variables need not reach, by the rules that there are; 0 if
 * there are none. Where something is held. */
int co_level_glance(co_level *level, const double *xyz, curvopt_energies *energies);

#endif
