/* Limited-memory variable metric minimization (L-BFGS). SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_OPTIMIZE_LBFGS_H
#define CO_OPTIMIZE_LBFGS_H

#include "base/status.h"
#include "optimize/objective.h"
#include "optimize/step_control.h"

typedef struct co_lbfgs_options {
    int memory; /* pairs kept */
    int max_iterations;
    double gradient_tolerance;  /* converged when |gradient| <= this * |value| */
    double decrement_tolerance; /* with a preconditioner: converged when -gradient.direction <= this * |value|
                                   for several steps */
    double
        settled_decrease; /* with a preconditioner: settled when settled_steps steps bring less than this * |value| */
    int settled_steps;
    double max_step; /* cap, in the minimand's step_length() */
    int renew_every; /* steps between renewals of the preconditioner */
} co_lbfgs_options;

/* From `now` (value and gradient filled in) to the last accepted iterate, in place. ERROR_MEMORY only. */
int32_t co_lbfgs(const co_objective *f, const co_lbfgs_options *options, co_iterate *now, co_outcome *result,
                 curvopt_error *error);

#endif
