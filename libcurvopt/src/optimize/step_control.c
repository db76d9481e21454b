/* How long steps may be, and whether they still lead anywhere. SPDX-License-Identifier: GPL-3.0-or-later */
#include "optimize/step_control.h"

#include "curvopt.h"

#include <math.h>
#include <string.h>

void co_iterate_hand_back(size_t n, co_iterate *now, double *x, double *gradient) {
    if (now->x == x)
        return;
    memcpy(x, now->x, n * sizeof *x);
    memcpy(gradient, now->gradient, n * sizeof *gradient);
    now->x = x;
    now->gradient = gradient;
}

static const double SHORTEST_CAP = 1e-7; /* of the first one */
static const double STALLED_DECREASE = 1e-15;
enum { STALLED_STEPS = 10 };

co_step_control co_step_control_begin(double max_step, const co_iterate *now) {
    return (co_step_control){.max_step = max_step, .cap = max_step, .mark = now->value};
}

int co_step_control_take(co_step_control *p, const co_objective *f, co_iterate *now, co_iterate *trial,
                         co_outcome *outcome, co_step_verdict *verdict) {
    double before = now->value;
    *verdict = f->review_step(f->context, now, trial, outcome->iterations + 1);
    co_iterate swap = *now;
    *now = *trial;
    *trial = swap;
    if (*verdict == CO_STEP_STOP)
        return CURVOPT_STOP_UNRESOLVED;
    if (*verdict == CO_STEP_REJECT) {
        p->cap *= 0.25;
        return p->cap < SHORTEST_CAP * p->max_step ? CURVOPT_STOP_UNRESOLVED : -1;
    }
    p->cap = fmin(2 * p->cap, p->max_step);
    outcome->iterations++;
    p->quiet_steps = before - now->value > STALLED_DECREASE * fabs(before) ? 0 : p->quiet_steps + 1;
    if (f->report(f->context, now, outcome->iterations, outcome->evaluations))
        return CURVOPT_STOP_CANCELLED;
    return p->quiet_steps >= STALLED_STEPS ? CURVOPT_STOP_STALLED : -1;
}

int co_step_control_has_settled(co_step_control *p, const co_iterate *now, int iterations, int steps, double decrease) {
    if (iterations % steps != 0)
        return 0;
    int settled = p->mark - now->value < decrease * fabs(now->value);
    p->mark = now->value;
    return settled;
}
