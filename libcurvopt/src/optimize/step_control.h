/* What optimizers share: how long steps may be, whether they still lead anywhere, how a run of one ended.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_OPTIMIZE_STEP_CONTROL_H
#define CO_OPTIMIZE_STEP_CONTROL_H

#include "optimize/objective.h"

/* How an optimizer ended. */
typedef struct co_outcome {
    int stop; /* curvopt_stop */
    int iterations;
    int evaluations;
    int restarts; /* times a history was dropped */
} co_outcome;

/* How long steps may be, and whether they still lead anywhere. */
typedef struct co_step_control {
    double max_step, cap; /* in the minimand's step_length(); the cap shrinks where steps are rejected */
    double mark;          /* value when co_step_control_has_settled() looked last */
    int quiet_steps;      /* in a row without a decrease worth the name */
} co_step_control;

co_step_control co_step_control_begin(double max_step, const co_iterate *now);
/* Settles `trial`, reports it, and lets it change places with `now`, which becomes the iterate before. *verdict is
 * settle()'s. A stop reason, or -1 to go on. */
int co_step_control_take(co_step_control *pace, const co_objective *f, co_iterate *now, co_iterate *trial,
                         co_outcome *outcome, co_step_verdict *verdict);
/* Whether `steps` steps brought less than `decrease` times |value|; looked at once in so many. */
int co_step_control_has_settled(co_step_control *pace, const co_iterate *now, int iterations, int steps,
                                double decrease);

/* Optimizers let iterates change places: `now` back into the arrays that it came in. */
void co_iterate_hand_back(size_t n, co_iterate *now, double *x, double *gradient);
#endif
