/* Down from saddles that symmetry hides. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_SYMMETRY_REDUCTION_H
#define CO_SOLVE_SYMMETRY_REDUCTION_H

#include "solve/run.h"

/* What a level has come to, to go back to. */
typedef struct co_record {
    curvopt_energies end;
    curvopt_level_report level;
    double pull;
    double *xyz;
    co_symmetry symmetry;
    double *start;
} co_record;

/* A level's way down. */
typedef struct co_symmetry_reduction {
    co_attempt slot[3];
    co_attempt *now;  /* what the run shows */
    co_attempt *sure; /* NULL, or where the last step began, for that is gone back to if the next one does not make it
                      worth while, */
    co_record before; /* and what the run showed there */
} co_symmetry_reduction;

/* A level's minimum into d->now, and further down as long as symmetries are worth giving up, or, with options.escape,
 * there is a way. d is zero before, and to be freed whatever comes of it. As curvopt_minimize. */
int32_t co_symmetry_reduction_solve(co_run *r, int32_t number, co_symmetry_reduction *d, curvopt_error *error);
void co_symmetry_reduction_free(co_symmetry_reduction *d);

#endif
