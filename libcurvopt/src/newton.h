/* Newton's method, its matrix damped. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_NEWTON_H
#define CO_NEWTON_H

#include "minimand.h"
#include "status.h"

typedef struct co_newton_options {
    int max_iterations;
    double gradient_tolerance;  /* converged when |gradient| <= this * |value|, */
    double decrement_tolerance; /* or, the matrix being positive, when there is no more than this * |value| to gain */
    double settled_decrease;    /* settled when settled_steps steps bring less than this * |value| */
    int settled_steps;
    double max_step; /* cap, in the minimand's step_length() */
} co_newton_options;

/* From `now` (value and gradient filled in) to the last accepted iterate, in place; f has what Newton's method needs.
 * ERROR_MEMORY only. */
int32_t co_newton(const co_minimand *f, const co_newton_options *options, co_iterate *now, co_outcome *outcome,
                  curvopt_error *error);

#endif
