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

co_step_control co_step_control_begin(const co_tuning *tuning, double max_step, const co_iterate *now) {
    return (co_step_control){.tuning = tuning,
                             .max_step = max_step,
                             .cap = max_step,
                             .mark = now->value,
                             .length = (double)NAN,
                             .predicted = (double)NAN,
                             .shift = (double)NAN};
}

static int report(const co_step_control *c, const co_objective *f, co_method method, const co_iterate *now,
                  double decrease, const co_outcome *outcome) {
    const co_step_record record = {.method = method,
                                   .iteration = outcome->iterations,
                                   .evaluations = outcome->evaluations,
                                   .rejected = outcome->rejected,
                                   .length = c->length,
                                   .predicted = c->predicted,
                                   .gain_ratio = decrease / c->predicted,
                                   .shift = c->shift};
    return f->report(f->context, now, &record);
}

int co_step_control_take(co_step_control *c, const co_objective *f, co_method method, co_iterate *now,
                         co_iterate *trial, co_outcome *outcome, co_step_verdict *verdict) {
    const co_tuning *t = c->tuning;
    double before = now->value;
    *verdict = f->review_step(f->context, now, trial, outcome->iterations + 1);
    co_iterate swap = *now;
    *now = *trial;
    *trial = swap;
    c->last_stands = co_step_stands(*verdict);
    outcome->rejected += !c->last_stands;
    if (*verdict == CO_STEP_STOP)
        return CURVOPT_STOP_UNRESOLVED;
    if (*verdict == CO_STEP_REJECT) {
        c->cap *= t->cap_rejected;
        return c->cap < sqrt(t->rounding) * c->max_step ? CURVOPT_STOP_UNRESOLVED : -1;
    }
    c->cap = fmin(t->cap_accepted * c->cap, c->max_step);
    outcome->iterations++;
    c->quiet_steps = before - now->value > t->rounding * fabs(before) ? 0 : c->quiet_steps + 1;
    if (report(c, f, method, now, before - now->value, outcome))
        return CURVOPT_STOP_CANCELLED;
    return c->quiet_steps >= t->slow_steps ? CURVOPT_STOP_STALLED : -1;
}

int co_step_control_has_settled(co_step_control *c, const co_iterate *now, int iterations, int steps, double decrease) {
    if (!c->last_stands || iterations % steps != 0)
        return 0;
    int settled = fabs(c->mark - now->value) < decrease * fabs(now->value);
    c->mark = now->value;
    return settled;
}
