/* A level of a run. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_RUN_LEVEL_H
#define CO_SOLVE_RUN_LEVEL_H

#include "solve/run.h"

/* Minimizes over the present mesh, which is level `number`; at the run's end the verdict follows. The report goes into
 * run->result->level. As curvopt_minimize. */
int32_t co_run_level_solve(co_run *run, int32_t number, curvopt_error *error);
/* Whether no level follows level `number`, which has been solved. */
int co_run_level_ends_run(const co_run *run, int32_t number);
/* To the next level's cage: run->result->mesh, run->at.xyz and what goes with them, subdivided. ERROR_SIZE,
 * ERROR_MEMORY, and as co_given_constraints_place. */
int32_t co_run_level_subdivide(co_run *run, curvopt_error *error);

#endif
