/* Directions of negative curvature at a stationary point, and steps along them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_NEGATIVE_CURVATURE_H
#define CO_SOLVE_NEGATIVE_CURVATURE_H

#include "optimize/objective.h"

#include "base/status.h"
#include "base/tuning.h"

/* A shifted matrix H + shift that is positive, as a solver. */
typedef struct co_shifted_inverse {
    void *context;
    size_t n;
    double shift;
    double least; /* the least shift: curvature above minus this counts as none */
    /* out = (H + shift)^-1 in, [n] both, which may be the same. ERROR_MEMORY. */
    int32_t (*solve)(void *context, const double *in, double *out, curvopt_error *error);
} co_shifted_inverse;

/* The direction d [n] in which H is most negative, by inverse iteration, its sign such that `gradient` [n] does not
 * rise along it. *found: whether its curvature is below minus the least shift. work [n]. ERROR_MEMORY. */
int32_t co_negative_curvature_direction(const co_shifted_inverse *inverse, const co_tuning *tuning,
                                        const double *gradient, double *d, double *work, int *found,
                                        curvopt_error *error);

typedef struct co_negative_curvature_options {
    const co_tuning *tuning;
    double max_step; /* longest step, by the objective's step_length() */
    double gain;     /* what a step must bring, in units of the value */
} co_negative_curvature_options;

/* A step from `now` along d [n], either way, of the longest length or shorter by halves: `now` moves there, and 1 is
 * returned, if a step brings the gain. trial [n] is work. */
int co_negative_curvature_step(const co_objective *f, const co_negative_curvature_options *options, const double *d,
                               double *trial, co_iterate *now);

#endif
