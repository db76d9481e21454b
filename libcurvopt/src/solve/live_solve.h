/* How a solver that stays solves. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LIVE_SOLVE_H
#define CO_SOLVE_LIVE_SOLVE_H

#include "solve/live_state.h"

/* From where the solver stands to its targets; the result is in solver->run->at. `settle`: to the optimum, with a
 * verdict. As curvopt_minimize. */
int32_t co_live_solve_level(curvopt_solver *solver, int settle, double started, curvopt_error *error);
/* What depends on where the solver stood is gone. */
void co_live_forget_levels(curvopt_solver *solver);

#endif
