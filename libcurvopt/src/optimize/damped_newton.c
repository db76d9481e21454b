/* Newton's method, its matrix damped.
 *
 * A shift makes steps short (Levenberg 1944, Marquardt 1963; More, "The Levenberg-Marquardt algorithm: implementation
 * and theory", 1978, for what a step's success says of the next shift). Of a step that comes true longer ones by the
 * same matrix are tried, which costs little beside a new one (Dennis, Schnabel, "Numerical methods for unconstrained
 * optimization and nonlinear equations", 1983, section 6.4.3). Near the end the matrix of a step that came true does
 * for the next ones, too. Where the matrix is indefinite, what makes it so is not the Gauss-Newton part: that is mixed
 * in, before a shift would have to make everything stiff (Dennis, Gay, Welsch, "An adaptive nonlinear least-squares
 * algorithm", 1981, choose between the two). The matrix may be the lifted method's (objective.h). libcurvopt/notes, 54
 * to 57, have what each of these brings.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "optimize/damped_newton.h"

#include "base/memory.h"
#include "linalg/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct solver {
    const co_objective *f;
    const co_method_options *options;
    const co_tuning *tuning;
    co_outcome *outcome;
    co_iterate trial; /* the step that was tried last */
    co_iterate other; /* the best one before it by the same matrix */
    double *direction;
    co_step_control control; /* its length and predicted decrease are those of the last direction */
    double shift;            /* the first one for the next matrix */
    co_damping used;         /* damping of the last direction */
    co_damping too_soft;     /* damping that was found to be too little; 0 where none is known */
    int indefinite;          /* whether the matrix at hand is, with the least shift */
    int closely;             /* whether matrices are asked for closely from now on */
    double needed;           /* shift that the matrix at hand needs; -1 where that was not looked for */
    double gain_ratio;       /* of the last step that was found, as far as it is by the matrix */
    int is_exact;            /* whether it came true, and stands, and matrices are kept */
} solver;

typedef enum search { FOUND, FOUND_NOTHING, FOUND_FAILURE, FOUND_INDEFINITE } search;

/* M with the shift, or with so much more damping that it is positive; nonzero if there is none. */
static int factorize(solver *s, double least) {
    const co_tuning *t = s->tuning;
    int positive = 0;
    s->used = (co_damping){.shift = fmax(s->shift, least)};
    s->too_soft.mix = 0;
    for (int k = 0; k < t->trials; k++) {
        if (s->f->factorize(s->f->context, &s->used, &positive))
            return 1;
        if (positive)
            return 0;
        s->indefinite = 1;
        s->too_soft.mix = s->used.mix;
        if (s->used.mix < 1)
            s->used.mix = s->used.mix > 0 ? 1 : t->newton_mix;
        else
            s->used.shift *= t->newton_raise;
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
    s->control.predicted = 0.5 * (s->used.shift * co_vector_dot(n, d, d) - co_vector_dot(n, d, now->gradient));
    s->control.length = s->f->step_length(s->f->context, d);
    return s->control.length;
}

static void try_step(solver *s, const co_iterate *now, double scale) {
    memcpy(s->trial.x, now->x, s->f->n * sizeof *now->x);
    co_vector_add(s->f->n, scale, s->direction, s->trial.x);
    s->f->evaluate(s->f->context, &s->trial);
    s->outcome->evaluations++;
}

static void exchange(co_iterate *a, co_iterate *b) {
    co_iterate was = *a;
    *a = *b;
    *b = was;
}

/* Damping for a longer step than that by s->used, which had this gain ratio; 0 if there is none worth a trial. */
static int soften(const solver *s, double gain_ratio, double least, co_damping *out) {
    const co_tuning *t = s->tuning;
    *out = s->used;
    if (s->used.mix > 0 && (gain_ratio > t->newton_stiff || s->used.shift < t->newton_softer * least)) {
        out->mix = s->too_soft.mix > 0 ? sqrt(s->used.mix * s->too_soft.mix) : s->used.mix / t->newton_mix_fall;
        return s->used.mix > t->newton_softer * out->mix;
    }
    double lower = s->used.shift / (gain_ratio > t->newton_exact ? t->newton_fall : t->newton_change);
    out->shift = fmax(least, s->too_soft.shift > 0 ? sqrt(s->used.shift * s->too_soft.shift) : lower);
    return s->used.shift > t->newton_softer * out->shift;
}

/* The step with the damping s->used into s->trial, and its gain ratio; -INFINITY if it cannot be made. */
static double probe(solver *s, const co_iterate *now) {
    int positive = 0;
    if (s->f->factorize(s->f->context, &s->used, &positive) || !positive || !(find_direction(s, now) <= s->control.cap))
        return -(double)INFINITY;
    try_step(s, now, 1);
    return (now->value - s->trial.value) / s->control.predicted;
}

/* From a step in s->trial that stands to longer ones, as long as they bring more. The gain ratio of the last. */
static double lengthen(solver *s, const co_iterate *now, double gain_ratio, double least) {
    const co_tuning *t = s->tuning;
    co_damping softer;
    for (int k = 0; k < t->newton_longer && gain_ratio > t->newton_longer_from && soften(s, gain_ratio, least, &softer);
         k++) {
        const co_damping used = s->used;
        const double predicted = s->control.predicted, length = s->control.length;
        exchange(&s->trial, &s->other);
        s->used = softer;
        double longer = probe(s, now);
        if (longer > -INFINITY && s->trial.value < s->other.value) {
            gain_ratio = longer;
            continue;
        }
        exchange(&s->trial, &s->other);
        s->used = used;
        s->control.predicted = predicted;
        s->control.length = length;
        if (softer.mix < used.mix)
            s->too_soft.mix = softer.mix;
        else
            s->too_soft.shift = softer.shift;
    }
    return gain_ratio;
}

static int is_small(const solver *s, const co_iterate *now) {
    return s->control.predicted <= s->options->decrement_tolerance * fabs(now->value);
}

/* Where the parabola through the slope along s->direction and the values before and after it is least, in parts of the
 * step in s->trial; INFINITY where it has no least value. */
static double part_of_parabola(const solver *s, const co_iterate *now, double slope) {
    const double bend = s->trial.value - now->value - slope;
    return bend > 0 ? -0.5 * slope / bend : (double)INFINITY;
}

/* Another part of the step in s->trial into it, if that is better than both; 0 if it is not. */
static int try_part(solver *s, const co_iterate *now, double part) {
    exchange(&s->trial, &s->other);
    try_step(s, now, part);
    if (s->trial.value < fmin(s->other.value, now->value)) {
        s->control.length *= part;
        return 1;
    }
    exchange(&s->trial, &s->other);
    return 0;
}

/* Where the matrix is wrong in a soft direction, small steps overshoot, however small they are, and a shift that holds
 * them back makes all others stiff. Of a step in s->trial that brought too little so much as is least on the parabola,
 * if that is better (Nocedal, Yuan, "Combining trust region and line search techniques", 1998). The gain ratio of what
 * is in s->trial. */
static double shorten(solver *s, const co_iterate *now, double gain_ratio) {
    const double slope = co_vector_dot(s->f->n, s->direction, now->gradient);
    const double part = part_of_parabola(s, now, slope);
    if (!(part > 0 && part < 1) || !try_part(s, now, part))
        return gain_ratio;
    s->control.predicted = part * (part * (slope + s->control.predicted) - slope);
    return (now->value - s->trial.value) / s->control.predicted;
}

/* Where the matrix is too stiff along a step in s->trial that stands, a softer one is not to be had and the next would
 * be as stiff: so far as the parabola is least, from twice the step on, if that is better. Then it is the parabola's
 * decrease that was predicted. The gain ratio of what is in s->trial. */
static double extend(solver *s, const co_iterate *now, double gain_ratio) {
    const size_t n = s->f->n;
    for (size_t i = 0; i < n; i++)
        s->direction[i] = s->trial.x[i] - now->x[i]; /* a softer one may have been tried since */
    const double slope = co_vector_dot(n, s->direction, now->gradient);
    const double least = part_of_parabola(s, now, slope), bend = s->trial.value - now->value - slope;
    const double part = fmin(least, s->control.cap / s->control.length);
    if (!(part >= 2) || !try_part(s, now, part))
        return gain_ratio;
    s->control.predicted = -part * (slope + part * bend);
    return (now->value - s->trial.value) / s->control.predicted;
}

/* Whether the step at hand may be the last: it is small, and, closely, not by its shift. Any step is small by a shift
 * that is large enough, and says nothing of what is left. */
static int is_last(const solver *s, const co_iterate *now) {
    return is_small(s, now) && (!s->options->closely || s->used.shift <= s->needed);
}

/* A step into s->trial that stands. The shift rises until there is one, and is then made ready for the next. A matrix
 * that is off by a little may be indefinite by that alone: then none is looked for. Closely, what is predicted if there
 * is none is what the shift that the matrix needs promises. */
static search find_step(solver *s, const co_iterate *now) {
    const co_tuning *t = s->tuning;
    double least = s->f->least_shift(s->f->context, now), promised = (double)INFINITY;
    const int from_least = s->shift <= least;
    s->indefinite = 0;
    s->needed = -1;
    s->too_soft.shift = 0;
    for (int k = 0; k < t->trials; k++) {
        if (factorize(s, least))
            return FOUND_FAILURE;
        if (s->indefinite && !s->closely)
            return FOUND_INDEFINITE;
        double length = find_direction(s, now);
        if (!(length < INFINITY))
            return FOUND_FAILURE;
        s->shift = s->used.shift;
        if (k == 0 && from_least) {
            s->needed = s->used.shift;
            promised = s->control.predicted;
        }
        if (s->control.predicted < 0) /* the gradient is rounding */
            return FOUND_NOTHING;
        if (length > s->control.cap) {
            s->too_soft.shift = s->shift;
            s->shift *= fmax(length / s->control.cap, t->newton_change);
            continue;
        }
        try_step(s, now, 1);
        double gain_ratio = s->gain_ratio = (now->value - s->trial.value) / s->control.predicted;
        if (is_last(s, now) && gain_ratio < t->newton_good)
            gain_ratio = shorten(s, now, gain_ratio);
        if (gain_ratio > t->newton_accept) {
            if (!is_small(s, now)) {
                gain_ratio = s->gain_ratio = lengthen(s, now, gain_ratio, least);
                gain_ratio = extend(s, now, gain_ratio);
            }
            s->shift = s->used.shift * (gain_ratio > t->newton_exact  ? 1 / t->newton_fall
                                        : gain_ratio > t->newton_good ? 1 / t->newton_change
                                        : gain_ratio < t->newton_poor ? t->newton_change
                                                                      : 1);
            return FOUND;
        }
        if (s->control.predicted <= t->rounding * fabs(now->value))
            break;
        s->too_soft.shift = s->shift;
        s->shift *= t->newton_change;
    }
    if (s->options->closely)
        s->control.predicted = promised;
    return FOUND_NOTHING;
}

/* After a step that came true as the matrix said its factor is good for the gradient that it led to, too (the
 * simplified Newton method: Deuflhard, "Newton methods for nonlinear problems", 2004, section 2.1). That step into
 * s->trial; 0 where it is not worth doing without a matrix of its own. */
static int find_step_by_same_matrix(solver *s, const co_iterate *now) {
    const double promised = s->control.predicted;
    if (!s->is_exact || !(find_direction(s, now) <= s->control.cap) ||
        !(s->control.predicted > 0 && s->control.predicted < promised))
        return 0;
    exchange(&s->trial, &s->other); /* where the last step began stays known */
    try_step(s, now, 1);
    s->gain_ratio = (now->value - s->trial.value) / s->control.predicted;
    if (s->gain_ratio > s->tuning->newton_good)
        return 1;
    exchange(&s->trial, &s->other);
    return 0;
}

/* A step away from a saddle into s->trial, as long as the cap or shorter by halves; 0 if there is none that brings a
 * decrease worth the name. */
static int leave_saddle(solver *s, const co_iterate *now) {
    const co_tuning *t = s->tuning;
    const double least = s->options->saddle_decrease * fabs(now->value);
    if (!s->f->negative_curvature(s->f->context, now, s->direction))
        return 0;
    double length = s->f->step_length(s->f->context, s->direction), scale = s->control.cap / length;
    s->control.predicted = (double)NAN;
    for (int halving = 0; halving < t->trials; halving++, scale *= 0.5) {
        try_step(s, now, scale);
        s->control.length = scale * length;
        if (s->trial.value < now->value - least)
            return 1;
    }
    return 0;
}

/* *before is where the step began if the lifted matrix is to know it, else NULL. As co_step_control_take. */
static int take_step(solver *s, co_iterate *now, const double **before) {
    co_step_verdict verdict;
    s->control.shift = s->used.shift;
    int stop = co_step_control_take(&s->control, s->f, CO_METHOD_NEWTON, now, &s->trial, s->outcome, &verdict);
    *before = co_step_stands(verdict) ? s->trial.x : NULL;
    s->is_exact = s->options->keeps_matrix && co_step_stands(verdict) && !s->indefinite && s->used.shift <= s->needed &&
                  fabs(s->gain_ratio - 1) < 1 - s->tuning->newton_longer_from;
    return stop;
}

static int has_settled(solver *s, const co_iterate *now) {
    const co_method_options *o = s->options;
    return co_step_control_has_settled(&s->control, now, s->outcome->iterations, o->settled_steps, o->settled_decrease);
}

static search find_step_by_new_matrix(solver *s, const co_iterate *now, const double *before) {
    if (s->f->assemble(s->f->context, now, before, s->closely))
        return FOUND_FAILURE;
    return find_step(s, now);
}

/* Beside negative curvature no promise is all: the model has more to give the farther it is trusted. So, closely, if
 * nothing comes of that the function has settled, which is not to say that it is at a minimum. */
static int end_at_saddle(solver *s, co_iterate *now, const double **before) {
    if (!leave_saddle(s, now))
        return s->options->closely ? CURVOPT_STOP_SETTLED : CURVOPT_STOP_CONVERGED;
    int stop = take_step(s, now, before);
    *before = NULL; /* that step was none of the model's */
    return stop;
}

static search find_some_step(solver *s, const co_iterate *now, const double *before) {
    const double shift = s->shift;
    search found = find_step_by_new_matrix(s, now, before);
    if (found == FOUND_INDEFINITE) {
        s->closely = 1;
        s->shift = shift;
        found = find_step_by_new_matrix(s, now, before);
    }
    if (found == FOUND_NOTHING && s->options->closely && s->needed < 0) { /* of which the shift may be the cause */
        s->shift = 0;
        found = find_step(s, now);
    }
    return found;
}

/* One step; a stop reason, or -1 to go on. */
static int step(solver *s, co_iterate *now, const double **before) {
    const search found = find_step_by_same_matrix(s, now) ? FOUND : find_some_step(s, now, *before);
    const int small = is_small(s, now), last = found == FOUND_NOTHING ? small : is_last(s, now);
    if (found == FOUND_FAILURE)
        return CURVOPT_STOP_STALLED;
    if (last && s->indefinite) /* nothing to gain but along negative curvature */
        return end_at_saddle(s, now, before);
    if (found == FOUND_NOTHING)
        return small ? CURVOPT_STOP_CONVERGED : CURVOPT_STOP_STALLED;
    const double least = s->f->least_shift(s->f->context, now);
    const int comes_true = (now->value - s->trial.value) / s->control.predicted > s->tuning->newton_good;
    if (!comes_true) /* which may be the matrix' fault: by coarser rules it may miss what is stiff */
        s->closely = 1;
    int stop = take_step(s, now, before);
    if (stop < 0 && s->control.last_stands && last && s->used.shift <= fmax(least, s->needed))
        return CURVOPT_STOP_CONVERGED;
    if (last || (small && comes_true)) /* short steps need no shift but one that makes the matrix positive */
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

int32_t co_damped_newton(const co_objective *f, const co_method_options *options, co_iterate *now, co_outcome *outcome,
                         curvopt_error *error) {
    size_t n = f->n;
    int32_t status = CURVOPT_OK;
    double *work = CO_NEW(double, 5 * n), *x = now->x, *gradient = now->gradient;
    *outcome = (co_outcome){0};
    solver s = {.f = f,
                .options = options,
                .tuning = options->tuning,
                .outcome = outcome,
                .closely = options->closely,
                .control = co_step_control_begin(options->tuning, options->max_step, now)};
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
