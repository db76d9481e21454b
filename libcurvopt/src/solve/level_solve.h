/* A level's minimum: its stages, by the schedule, and the best iterate of what they found.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LEVEL_SOLVE_H
#define CO_SOLVE_LEVEL_SOLVE_H

#include "solve/level.h"
#include "solve/level_schedule.h"

/* What is known of the shape before a level is solved. */
typedef struct co_level_prospect {
    int expects_plateau; /* as in co_level_facts */
    int is_near;         /* as in co_level_facts; the first stage begins by the factor that the level has */
    int stops_short;     /* as in co_level_facts */
    int is_passing;      /* figures are wanted of nothing */
    int closely;         /* as in co_level_facts */
    double decrement;    /* as in co_level_facts */
} co_level_prospect;

/* The level's minimum. level->report is told of every step. As curvopt_minimize. */
int32_t co_level_solve(co_level *level, const co_level_prospect *prospect, co_outcome *outcome, curvopt_error *error);

#endif
