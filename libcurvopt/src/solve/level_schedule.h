/* A level's minimum, in stages. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LEVEL_SCHEDULE_H
#define CO_SOLVE_LEVEL_SCHEDULE_H

#include "optimize/step_control.h"
#include "solve/level.h"

/* From `now`, in place. level->report is told of every step. As curvopt_minimize. */
int32_t co_level_schedule_solve(co_level *level, co_iterate *now, co_outcome *result, curvopt_error *error);

#endif
