/* What an optimizer sees of a problem. SPDX-License-Identifier: GPL-3.0-or-later */
#include "minimand.h"

#include "curvopt.h"

#include <math.h>
#include <string.h>

double co_vector_dot(size_t n, const double *a, const double *b) {
    double sum[4] = {0, 0, 0, 0};
    size_t i = 0;
    for (; i + 4 <= n; i += 4)
        for (size_t k = 0; k < 4; k++)
            sum[k] += a[i + k] * b[i + k];
    for (; i < n; i++)
        sum[0] += a[i] * b[i];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

double co_vector_norm(size_t n, const double *a) {
    return sqrt(co_vector_dot(n, a, a));
}

void co_vector_add(size_t n, double s, const double *x, double *y) {
    for (size_t i = 0; i < n; i++)
        y[i] += s * x[i];
}

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

co_pace co_pace_begin(double max_step, const co_iterate *now) {
    return (co_pace){.max_step = max_step, .cap = max_step, .mark = now->value};
}

int co_pace_take_step(co_pace *p, const co_minimand *f, co_iterate *now, co_iterate *trial, co_outcome *outcome,
                      co_settlement *verdict) {
    double before = now->value;
    *verdict = f->settle(f->context, now, trial, outcome->iterations + 1);
    co_iterate swap = *now;
    *now = *trial;
    *trial = swap;
    if (*verdict == CO_SETTLE_STOP)
        return CURVOPT_STOP_UNRESOLVED;
    if (*verdict == CO_SETTLE_REJECT) {
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

int co_pace_has_settled(co_pace *p, const co_iterate *now, int iterations, int steps, double decrease) {
    if (iterations % steps != 0)
        return 0;
    int settled = p->mark - now->value < decrease * fabs(now->value);
    p->mark = now->value;
    return settled;
}
