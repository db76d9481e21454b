/* Newton's method, its matrix damped.
 *
 * A shift makes steps short (Levenberg 1944, Marquardt 1963; More, "The Levenberg-Marquardt algorithm: implementation
 * and theory", 1978, for what a step's success says of the next shift). Of a step that comes true longer ones by the
 * same matrix are tried, which costs little beside a new one (Dennis, Schnabel, "Numerical methods for unconstrained
 * optimization and nonlinear equations", 1983, section 6.4.3). Where the matrix is indefinite, what makes it so is not
 * the Gauss-Newton part: that is mixed in, before a shift would have to make everything stiff (Dennis, Gay, Welsch, "An
 * adaptive nonlinear least-squares algorithm", 1981, choose between the two). The matrix may be the lifted method's
 * (objective.h). tests/bench has what each of these brings.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "optimize/damped_newton.h"

#include "base/memory.h"
#include "linalg/vector.h"
#include "optimize/step_control.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A step stands that brings so much of what the model said; from a good one on the shift falls, from a poor one it
 * rises, and far off twice as much. */
static const double STANDS = 0.01, GOOD = 0.5, POOR = 0.1, FAR = -30, CHANGE = 3;
static const double EXACT = 0.9, FALL = 8;       /* from such a step on it falls like this */
static const double RAISE = 4, RAISE_MOST = 100; /* of a shift that leaves the matrix indefinite, or steps too long */
static const double MIXED = 1.0 / 3;             /* the first mixture, the second is all; */
static const double STIFF = 1.1;                 /* more than the model said: there is too much in it */
/* From such a step on longer ones are tried, by damping that is softer by so much at least. */
static const double PROMISING = 0.7, SOFTER = 1.3;
static const double ROUNDING = 1e-15; /* of the value */
enum { MOST_RAISES = 60, MOST_LONGER = 2, HALVINGS = 12 };

typedef struct solver {
    const co_objective *f;
    const co_damped_newton_options *options;
    co_outcome *outcome;
    co_iterate trial, other;
    double *direction;
    co_step_control pace;
    double shift;        /* for the next matrix */
    co_damping used;     /* that of the last direction; */
    co_damping too_soft; /* what was found to be too little; 0: not known */
    double predicted;    /* decrease by the last direction */
    int indefinite;      /* the matrix at hand, with the least shift */
} solver;

typedef enum found { FOUND, FOUND_NOTHING, FOUND_FAILURE } found;

/* M with the shift, or with so much more damping that it is positive; nonzero if there is none. */
static int factorize(solver *s, double least) {
    int positive = 0;
    s->used = (co_damping){.shift = fmax(s->shift, least)};
    s->too_soft.mix = 0;
    for (int k = 0; k < MOST_RAISES; k++) {
        if (s->f->factorize(s->f->context, &s->used, &positive))
            return 1;
        if (positive)
            return 0;
        s->indefinite = 1;
        s->too_soft.mix = s->used.mix;
        if (s->used.mix < 1)
            s->used.mix = s->used.mix > 0 ? 1 : MIXED;
        else
            s->used.shift *= RAISE;
    }
    return 1;
}

/* direction = -M^-1 gradient, and what a quadratic model says of it; its length, or NAN if that failed. */
static double find_direction(solver *s, const co_iterate *now) {
    size_t n = s->f->n;
    double *d = s->direction;
    for (size_t i = 0; i < n; i++)
        d[i] = -now->gradient[i];
    if (s->f->precondition(s->f->context, d, d))
        return (double)NAN;
    s->predicted = 0.5 * (s->used.shift * co_vector_dot(n, d, d) - co_vector_dot(n, d, now->gradient));
    return s->f->step_length(s->f->context, d);
}

static void try_step(solver *s, const co_iterate *now, double scale) {
    memcpy(s->trial.x, now->x, s->f->n * sizeof *now->x);
    co_vector_add(s->f->n, scale, s->direction, s->trial.x);
    s->trial.value = s->f->evaluate(s->f->context, s->trial.x, s->trial.gradient);
    s->outcome->evaluations++;
}

static void exchange(co_iterate *a, co_iterate *b) {
    co_iterate was = *a;
    *a = *b;
    *b = was;
}

/* Damping for a longer step than that of s->used, of which this share came true; 0 if there is none worth a trial. */
static int soften(const solver *s, double share, double least, co_damping *out) {
    *out = s->used;
    if (s->used.mix > 0 && (share > STIFF || s->used.shift < SOFTER * least)) {
        out->mix = s->too_soft.mix > 0 ? sqrt(s->used.mix * s->too_soft.mix) : s->used.mix / 4;
        return s->used.mix > SOFTER * out->mix;
    }
    double lower = s->used.shift / (share > EXACT ? FALL : CHANGE);
    out->shift = fmax(least, s->too_soft.shift > 0 ? sqrt(s->used.shift * s->too_soft.shift) : lower);
    return s->used.shift > SOFTER * out->shift;
}

/* The step with the damping s->used into s->trial, and what share of it came true; -INFINITY if it cannot be made. */
static double probe(solver *s, const co_iterate *now) {
    int positive = 0;
    if (s->f->factorize(s->f->context, &s->used, &positive) || !positive || !(find_direction(s, now) <= s->pace.cap))
        return -(double)INFINITY;
    try_step(s, now, 1);
    return (now->value - s->trial.value) / s->predicted;
}

/* Of a step in s->trial that stands, longer ones as long as they bring more. The share of the last. */
static double lengthen(solver *s, const co_iterate *now, double share, double least) {
    co_damping softer;
    for (int k = 0; k < MOST_LONGER && share > PROMISING && soften(s, share, least, &softer); k++) {
        const co_damping used = s->used;
        const double predicted = s->predicted;
        exchange(&s->trial, &s->other);
        s->used = softer;
        double longer = probe(s, now);
        if (longer > -INFINITY && s->trial.value < s->other.value) {
            share = longer;
            continue;
        }
        exchange(&s->trial, &s->other);
        s->used = used;
        s->predicted = predicted;
        if (softer.mix < used.mix)
            s->too_soft.mix = softer.mix;
        else
            s->too_soft.shift = softer.shift;
    }
    return share;
}

static int is_small(const solver *s, const co_iterate *now) {
    return s->predicted <= s->options->decrement_tolerance * fabs(now->value);
}

/* A step into s->trial that stands. The shift rises until there is one, and is then made ready for the next. */
static found find_step(solver *s, const co_iterate *now) {
    double least = s->f->least_shift(s->f->context, now);
    s->indefinite = 0;
    s->too_soft.shift = 0;
    for (int k = 0; k < MOST_RAISES; k++) {
        if (factorize(s, least))
            return FOUND_FAILURE;
        double length = find_direction(s, now);
        if (!(length < INFINITY))
            return FOUND_FAILURE;
        s->shift = s->used.shift;
        if (length > s->pace.cap) {
            s->too_soft.shift = s->shift;
            s->shift *= fmin(fmax(length / s->pace.cap, CHANGE), RAISE_MOST);
            continue;
        }
        try_step(s, now, 1);
        double share = (now->value - s->trial.value) / s->predicted;
        if (share > STANDS) {
            if (!is_small(s, now))
                share = lengthen(s, now, share, least);
            s->shift = s->used.shift * (share > EXACT  ? 1 / FALL
                                        : share > GOOD ? 1 / CHANGE
                                        : share < POOR ? CHANGE
                                                       : 1);
            return FOUND;
        }
        if (s->predicted <= ROUNDING * fabs(now->value))
            return FOUND_NOTHING;
        s->too_soft.shift = s->shift;
        s->shift *= share > FAR ? CHANGE : CHANGE * CHANGE; /* also if it is not a number */
    }
    return FOUND_NOTHING;
}

/* A step away from a saddle into s->trial, as long as the cap or shorter by halves; 0 if there is none that brings a
 * decrease worth the name. */
static int leave_saddle(solver *s, const co_iterate *now) {
    double least = s->options->decrement_tolerance * fabs(now->value);
    if (!s->f->negative_curvature(s->f->context, now, s->direction))
        return 0;
    double scale = s->pace.cap / s->f->step_length(s->f->context, s->direction);
    for (int halving = 0; halving < HALVINGS; halving++, scale *= 0.5) {
        try_step(s, now, scale);
        if (s->trial.value < now->value - least)
            return 1;
    }
    return 0;
}

/* *before is where the step began if the lifted matrix is to know it, else NULL. As co_step_control_take. */
static int take_step(solver *s, co_iterate *now, const double **before) {
    co_step_verdict verdict;
    int stop = co_step_control_take(&s->pace, s->f, now, &s->trial, s->outcome, &verdict);
    *before = verdict == CO_STEP_KEEP || verdict == CO_STEP_CHANGED ? s->trial.x : NULL;
    return stop;
}

static int has_settled(solver *s, const co_iterate *now) {
    const co_damped_newton_options *o = s->options;
    return co_step_control_has_settled(&s->pace, now, s->outcome->iterations, o->settled_steps, o->settled_decrease);
}

/* One step; a stop reason, or -1 to go on. */
static int step(solver *s, co_iterate *now, const double **before) {
    if (s->f->assemble(s->f->context, now, *before))
        return CURVOPT_STOP_SETTLED;
    found found = find_step(s, now);
    int small = is_small(s, now);
    if (found == FOUND_FAILURE)
        return CURVOPT_STOP_SETTLED;
    if (small && s->indefinite) { /* nothing to gain but along negative curvature */
        if (!leave_saddle(s, now))
            return CURVOPT_STOP_CONVERGED;
        int stop = take_step(s, now, before);
        *before = NULL; /* that step was none of the model's */
        return stop;
    }
    if (found == FOUND_NOTHING)
        return small ? CURVOPT_STOP_CONVERGED : CURVOPT_STOP_STALLED;
    double least = s->f->least_shift(s->f->context, now);
    int stop = take_step(s, now, before);
    if (stop < 0 && small && s->used.shift <= least)
        return CURVOPT_STOP_CONVERGED;
    if (small) /* short steps need no shift but one that makes the matrix positive */
        s->shift = 0;
    return stop < 0 && has_settled(s, now) ? CURVOPT_STOP_SETTLED : stop;
}

static int iterate(solver *s, co_iterate *now) {
    const double *before = NULL;
    for (;;) {
        if (co_vector_norm(s->f->n, now->gradient) <= s->options->gradient_tolerance * fabs(now->value))
            return CURVOPT_STOP_CONVERGED;
        if (s->outcome->iterations >= s->options->max_iterations)
            return CURVOPT_STOP_LIMIT;
        int stop = step(s, now, &before);
        if (stop >= 0)
            return stop;
    }
}

int32_t co_damped_newton(const co_objective *f, const co_damped_newton_options *options, co_iterate *now,
                         co_outcome *outcome, curvopt_error *error) {
    size_t n = f->n;
    int32_t status = CURVOPT_OK;
    double *work = CO_NEW(double, 5 * n), *x = now->x, *gradient = now->gradient;
    *outcome = (co_outcome){0};
    solver s = {.f = f, .options = options, .outcome = outcome, .pace = co_step_control_begin(options->max_step, now)};
    if (!work) {
        status = co_status_no_memory(error);
    } else {
        s.trial = (co_iterate){.x = work, .gradient = work + n};
        s.other = (co_iterate){.x = work + 2 * n, .gradient = work + 3 * n};
        s.direction = work + 4 * n;
        outcome->stop = iterate(&s, now);
        co_iterate_hand_back(n, now, x, gradient);
    }
    free(work);
    return status;
}
