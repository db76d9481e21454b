/* Newton's method, its matrix damped. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_OPTIMIZE_DAMPED_NEWTON_H
#define CO_OPTIMIZE_DAMPED_NEWTON_H

#include "base/status.h"
#include "optimize/objective.h"
#include "optimize/step_control.h"

typedef struct co_damped_newton_options {
    int max_iterations;
    double gradient_tolerance;  /* converged when |gradient| <= this * |value|, */
    double decrement_tolerance; /* or, the matrix being positive, when there is no more than this * |value| to gain */
    double settled_decrease;    /* settled when settled_steps steps bring less than this * |value| */
    int settled_steps;
    double max_step; /* cap, in the minimand's step_length() */
} co_damped_newton_options;

/* From `now` (value and gradient filled in) to the last accepted iterate, in place; f has what Newton's method needs.
 * ERROR_MEMORY only. */
int32_t co_damped_newton(const co_objective *f, const co_damped_newton_options *options, co_iterate *now,
                         co_outcome *outcome, curvopt_error *error);

#endif
