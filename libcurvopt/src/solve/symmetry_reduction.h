/* A level's minimum, and further down from saddles that symmetry hides, as far as that is worth its price.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_SYMMETRY_REDUCTION_H
#define CO_SOLVE_SYMMETRY_REDUCTION_H

#include "solve/run.h"

/* What giving up symmetries, from `order` to `left` of them, must bring, relative to the energy. A way that keeps all
 * of them costs no more a step than before, and is worth going for less. */
double co_symmetry_reduction_worth(const co_tuning *tuning, int32_t order, int32_t left);

/* The present level's minimum with the symmetry that is kept; then, as long as symmetries are worth giving up or, with
 * options.escape, there is a way down, the minimum beyond that. The results go into run->at; *level is the level that
 * they are of, the caller's to destroy, also after a failure. As curvopt_minimize. */
int32_t co_symmetry_reduction_solve(co_run *run, int32_t number, co_level **level, curvopt_error *error);

#endif
