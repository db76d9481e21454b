/* A step length that satisfies the strong Wolfe conditions.
 *
 * Follows: Nocedal, Wright, "Numerical optimization", 2nd ed. 2006, algorithms 3.5 and 3.6, with cubic interpolation
 * (eq. 3.59) safeguarded to the inner 80 % of the bracket. Differs: where values agree to rounding, the decrease is
 * judged by slopes (Hager, Zhang, "A new conjugate gradient method with guaranteed descent", SIAM J. Optim. 16, 2005,
 * the approximate Wolfe condition), or a search near a minimum could not succeed.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "optimize/line_search.h"

#include "linalg/vector.h"

#include <math.h>
#include <string.h>

/* Sufficient decrease, of the slope (Nocedal, Wright, 2006). */
static const double WOLFE_DECREASE = 1e-4;

typedef struct trial {
    double step, value, slope;
} trial;

typedef struct search_state {
    const co_tuning *tuning;
    const co_objective *f;
    const co_iterate *from;
    const double *d;
    co_iterate *to;
    trial start;
    int evaluations;
} search_state;

static trial try_step(search_state *s, double step) {
    size_t n = s->f->n;
    memcpy(s->to->x, s->from->x, n * sizeof(double));
    co_vector_add(n, step, s->d, s->to->x);
    s->f->evaluate(s->f->context, s->to);
    s->evaluations++;
    return (trial){step, s->to->value, co_vector_dot(n, s->to->gradient, s->d)};
}

static int decreases(const search_state *s, const trial *t) {
    const trial *o = &s->start;
    if (!isfinite(t->value) || !isfinite(t->slope))
        return 0;
    if (t->value <= o->value + WOLFE_DECREASE * t->step * o->slope)
        return 1;
    return t->value <= o->value + s->tuning->rounding * fabs(o->value) &&
           t->slope <= (2 * WOLFE_DECREASE - 1) * o->slope;
}

static int is_flat(const search_state *s, const trial *t) {
    return fabs(t->slope) <= -s->tuning->wolfe_curvature * s->start.slope;
}

/* Minimizer of the cubic through both ends, kept off the ends. */
static double interpolate(const trial *a, const trial *b) {
    double width = b->step - a->step, guard = 0.1 * width, middle = a->step + 0.5 * width;
    if (!isfinite(b->value) || !isfinite(b->slope))
        return a->step + 0.2 * width;
    double d1 = a->slope + b->slope - 3 * (b->value - a->value) / width;
    double square = d1 * d1 - a->slope * b->slope;
    if (!(square >= 0))
        return middle;
    double d2 = copysign(sqrt(square), width);
    double at = b->step - width * (b->slope + d2 - d1) / (b->slope - a->slope + 2 * d2);
    double low = fmin(a->step + guard, b->step - guard), high = fmax(a->step + guard, b->step - guard);
    return at >= low && at <= high ? at : isfinite(at) ? fmin(fmax(at, low), high) : middle;
}

/* `low` has the lower value and decreases; the wanted step lies between it and `high`. */
static int zoom(search_state *s, trial low, trial high, trial *found) {
    while (s->evaluations < s->tuning->trials && low.step != high.step) {
        trial t = try_step(s, interpolate(&low, &high));
        if (t.step == low.step || t.step == high.step)
            break; /* the bracket is exhausted in floating point */
        if (!decreases(s, &t) || (t.value > low.value + s->tuning->rounding * fabs(low.value))) {
            high = t;
            continue;
        }
        if (is_flat(s, &t)) {
            *found = t;
            return 1;
        }
        if (t.slope * (high.step - low.step) >= 0)
            high = low;
        low = t;
    }
    if (low.step == 0)
        return 0;
    *found = try_step(s, low.step); /* sufficient decrease at least */
    return decreases(s, found);
}

int co_line_search_wolfe(const co_objective *f, const co_iterate *from, const double *d, co_line_search *search,
                         co_iterate *to) {
    search_state s = {.tuning = search->tuning, .f = f, .from = from, .d = d, .to = to};
    s.start = (trial){0, from->value, co_vector_dot(f->n, from->gradient, d)};
    trial before = s.start, found = s.start;
    int ok = 0;
    double step = fmin(search->step, search->max_step);
    while (s.start.slope < 0 && s.evaluations < s.tuning->trials) {
        trial t = try_step(&s, step);
        if (!decreases(&s, &t) || (s.evaluations > 1 && t.value >= before.value)) {
            ok = zoom(&s, before, t, &found);
            break;
        }
        found = t;
        ok = 1;
        if (is_flat(&s, &t) || step >= search->max_step)
            break;
        if (t.slope >= 0) {
            ok = zoom(&s, t, before, &found);
            break;
        }
        before = t;
        step = fmin(s.tuning->search_growth * step, search->max_step);
    }
    search->step = found.step;
    search->evaluations = s.evaluations;
    return ok && found.step > 0;
}
