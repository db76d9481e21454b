/* A run: what all of its levels share, and how one of them is solved. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_RUN_H
#define CO_SOLVE_RUN_H

#include "solve/level_schedule.h"

struct curvopt_result {
    curvopt_mesh *mesh;
    double *xyz;
    curvopt_summary summary;
    curvopt_level_report *level; /* [options.levels] */
};

/* What the run shows of a level is what was solved last. */
typedef struct co_run {
    co_run_context frame;
    curvopt_progress_fn progress;
    void *user;
    double started;
    double start_energy;
    double pull;        /* what springs add to the objective of the result */
    int keeps_symmetry; /* giving some up was not worth it, and is not tried again on finer levels, where it costs more
                         */
    curvopt_result *result;
    co_symmetry symmetry; /* of the present level's mesh, which is the result's */
    co_constraints constraints;
    co_basis_table_cache tables;
    double *xyz;         /* of the present level, in the user's units */
    double *level_start; /* what the level began with */
} co_run;

/* One solution of a level's problem, and what it was solved with. */
typedef struct co_attempt {
    co_level level;
    co_iterate now;
} co_attempt;

/* The present mesh from `start`, with the symmetry that is kept; figures and positions into r. As curvopt_minimize. */
int32_t co_run_solve(co_run *r, int32_t number, const double *start, co_attempt *attempt, curvopt_error *error);
void co_attempt_free(co_attempt *attempt);

/* Whether it was cancelled at this level, or the level could not be resolved. */
int co_run_stopped_early(const co_run *r, int32_t number);
double co_now_seconds(void);

#endif
