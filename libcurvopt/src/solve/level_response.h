/* How a level that was solved answers to targets that have moved. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LEVEL_RESPONSE_H
#define CO_SOLVE_LEVEL_RESPONSE_H

#include "solve/level.h"

/* The level goes to where its constraints are now, and to a first guess of its minimum there: by its factor the linear
 * response to the displacement of what is held; without one nothing else moves. `start` [3 n_vertices], which the level
 * borrows from then on, is where it stands with what is held at its new place. The iterate is evaluated, the level has
 * not begun. *fits: as co_level_move. ERROR_MEMORY. */
int32_t co_level_response(co_level *level, const co_symmetry *symmetry, const co_constraints *constraints,
                          const double *start, int *fits, curvopt_error *error);

#endif
