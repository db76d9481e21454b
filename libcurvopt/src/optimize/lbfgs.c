/* Limited-memory variable metric minimization.
 *
 * Follows: Nocedal, "Updating quasi-Newton matrices with limited storage", Math. Comp. 35, 1980 (two-loop recursion;
 * initial scaling s.y / y.y), the method of the report (TAO's LMVM). The ladder when a step fails: drop the history and
 * try a scaled gradient step; if that fails as well, stay where we are and stop.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "optimize/lbfgs.h"

#include "base/memory.h"
#include "linalg/vector.h"
#include "optimize/line_search.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct history {
    int memory, n_pairs, newest;
    double *s, *y;      /* [memory][n] */
    double *inverse_sy; /* [memory] */
    double *alpha;      /* [memory] work */
} history;

typedef struct solver {
    const co_objective *f;
    const co_method_options *options;
    co_outcome *outcome;
    history h;
    co_iterate trial;
    double *direction; /* [n] */
    double *image;     /* [n] work: what the preconditioner makes of a vector */
    co_step_control control;
    double decrease;    /* by the last step; 0 where none is known */
    double slope;       /* gradient.direction */
    double step_excess; /* step_excess_of() the last direction */
    int stale_steps;    /* steps since the preconditioner was updated */
    int small_steps;    /* steps in a row whose predicted decrease is below the tolerance */
} solver;

static void history_update(history *h, size_t n, double least_curvature, const co_iterate *before,
                           const co_iterate *after) {
    if (h->memory == 0)
        return;
    int slot = h->n_pairs ? (h->newest + 1) % h->memory : 0;
    double *s = h->s + (size_t)slot * n, *y = h->y + (size_t)slot * n;
    for (size_t i = 0; i < n; i++) {
        s[i] = after->x[i] - before->x[i];
        y[i] = after->gradient[i] - before->gradient[i];
    }
    double sy = co_vector_dot(n, s, y);
    if (!(sy > least_curvature * co_vector_norm(n, s) * co_vector_norm(n, y)))
        return; /* would spoil positive definiteness; can happen at the step cap */
    h->inverse_sy[slot] = 1 / sy;
    h->newest = slot;
    if (h->n_pairs < h->memory)
        h->n_pairs++;
}

/* What of the preconditioner's step the newest pair has found to be right: s.y / y.P^-1 y, at most all. Where P is too
 * soft that makes shorter what P alone knows of, and leaves what the pairs know of as it is, where a shorter step would
 * cut both (Oren, Luenberger, "Self-scaling variable metric (SSVM) algorithms", Management Science 20, 1974). */
static double part_of_preconditioner(const solver *s) {
    const history *h = &s->h;
    const double *y = h->y + (size_t)h->newest * s->f->n;
    if (!h->n_pairs || s->f->precondition(s->f->context, y, s->image) != 0)
        return 1;
    const double part = 1 / (h->inverse_sy[h->newest] * co_vector_dot(s->f->n, y, s->image));
    return fmin(1, fmax(s->options->tuning->lbfgs_least_part, part));
}

/* The initial inverse Hessian: so much of the preconditioner's; or, without one, the scaling of the newest pair; or,
 * without any pair, a tenth of the cap along the gradient. */
static void apply_initial(const solver *s, double *d) {
    size_t n = s->f->n;
    const history *h = &s->h;
    double scale;
    if (s->f->precondition && s->f->precondition(s->f->context, d, d) == 0) {
        scale = s->options->is_scaled ? part_of_preconditioner(s) : 1;
    } else if (h->n_pairs) {
        const double *y = h->y + (size_t)h->newest * n;
        scale = 1 / (h->inverse_sy[h->newest] * co_vector_dot(n, y, y));
    } else {
        double length = s->f->step_length(s->f->context, d);
        scale = length > 0 ? s->control.cap / length : 1;
    }
    for (size_t i = 0; i < n; i++)
        d[i] *= scale;
}

/* direction = -H gradient. */
static void find_direction(solver *s, const double *gradient) {
    size_t n = s->f->n;
    history *h = &s->h;
    double *d = s->direction;
    for (size_t i = 0; i < n; i++)
        d[i] = -gradient[i];
    for (int k = 0, slot = h->newest; k < h->n_pairs; k++, slot = (slot + h->memory - 1) % h->memory) {
        h->alpha[slot] = h->inverse_sy[slot] * co_vector_dot(n, h->s + (size_t)slot * n, d);
        co_vector_add(n, -h->alpha[slot], h->y + (size_t)slot * n, d);
    }
    apply_initial(s, d);
    int oldest = h->n_pairs ? (h->newest + 1 + h->memory - h->n_pairs) % h->memory : 0;
    for (int k = 0, slot = oldest; k < h->n_pairs; k++, slot = (slot + 1) % h->memory) {
        double beta = h->inverse_sy[slot] * co_vector_dot(n, h->y + (size_t)slot * n, d);
        co_vector_add(n, h->alpha[slot] - beta, h->s + (size_t)slot * n, d);
    }
    s->slope = co_vector_dot(n, d, gradient);
}

/* Updates the preconditioner when it has gone stale. The pairs tell of the function, which has not changed: they stay.
 */
static void keep_fresh(solver *s, const co_iterate *now) {
    if (s->f->update_preconditioner && s->stale_steps++ % s->options->update_every == 0)
        s->f->update_preconditioner(s->f->context, now, s->step_excess, s->options->by_hessian);
}

/* How many times longer than it ought to have been the last direction was: than the cap, or than what of it stood.
 * Where the model is trusted too far, step after step is cut back in the search, at several evaluations each. */
static double step_excess_of(const solver *s, double length, double step) {
    double cut = step < s->options->tuning->lbfgs_short_share ? 1 / step : 0;
    return fmax(length / s->control.cap, cut);
}

/* What of a direction to try first: all; of a matrix, where the step comes that would bring what the last one brought
 * (Nocedal, Wright, "Numerical optimization", 2nd ed. 2006, eq. 3.60). */
static double first_step(const solver *s, const co_iterate *now) {
    const double least = s->options->tuning->lbfgs_least_part, margin = 1.01;
    if (!s->f->precondition || !(s->decrease > CO_KNOWN_DECREASE * fabs(now->value)))
        return 1;
    return fmin(1, fmax(least, -2 * margin * s->decrease / s->slope));
}

/* One accepted step into s->trial; 0 if there is none to be had. */
static int find_step(solver *s, const co_iterate *now) {
    for (;;) {
        int had_history = s->h.n_pairs > 0;
        find_direction(s, now->gradient);
        if (s->slope < 0) {
            double length = s->f->step_length(s->f->context, s->direction);
            co_line_search search = {
                .tuning = s->options->tuning, .step = first_step(s, now), .max_step = s->control.cap / length};
            int ok = co_line_search_wolfe(s->f, now, s->direction, &search, &s->trial);
            s->outcome->evaluations += search.evaluations;
            s->step_excess = step_excess_of(s, length, ok ? search.step : 1);
            s->control.length = search.step * length;
            s->control.predicted = -search.step * (1 - 0.5 * search.step) * s->slope;
            s->decrease = ok ? now->value - s->trial.value : 0;
            if (ok)
                return 1;
        }
        if (!had_history)
            return 0;
        s->h.n_pairs = 0;
        s->stale_steps = 0;
        keep_fresh(s, now);
        s->outcome->restarts++;
    }
}

/* As co_step_control_take, and what the step means for the history. */
static int take_step(solver *s, co_iterate *now) {
    co_step_verdict verdict;
    int stop = co_step_control_take(&s->control, s->f, CO_METHOD_LBFGS, now, &s->trial, s->outcome, &verdict);
    if (verdict == CO_STEP_KEEP)
        history_update(&s->h, s->f->n, s->options->tuning->rounding, &s->trial, now);
    else
        s->h.n_pairs = 0;
    return stop;
}

/* Whether the model says that the last direction leads nowhere. */
static int is_small(const solver *s, const co_iterate *now) {
    return s->f->precondition && -s->slope <= s->options->decrement_tolerance * fabs(now->value);
}

static int has_settled(solver *s, const co_iterate *now) {
    const co_method_options *o = s->options;
    return s->f->precondition &&
           co_step_control_has_settled(&s->control, now, s->outcome->iterations, o->settled_steps, o->settled_decrease);
}

static int iterate(solver *s, co_iterate *now) {
    const co_method_options *o = s->options;
    const int small_steps = o->small_steps > 0 ? o->small_steps : o->tuning->lbfgs_small_steps;
    for (;;) {
        int stop;
        double norm = co_vector_norm(s->f->n, now->gradient);
        if (norm <= s->options->gradient_tolerance * fabs(now->value))
            return CURVOPT_STOP_CONVERGED;
        if (s->outcome->iterations >= s->options->max_iterations)
            return CURVOPT_STOP_LIMIT;
        keep_fresh(s, now);
        if (find_step(s, now)) {
            /* One step may be short because the preconditioner was stiffened; hence several in a row. */
            s->small_steps = is_small(s, now) ? s->small_steps + 1 : 0;
            stop = take_step(s, now);
            if (stop < 0 && s->control.last_stands && s->small_steps >= small_steps)
                stop = CURVOPT_STOP_CONVERGED;
        } else { /* of a small step rounding may hide what it would bring */
            stop = is_small(s, now) ? CURVOPT_STOP_CONVERGED : CURVOPT_STOP_STALLED;
        }
        if (stop >= 0)
            return stop;
        if (has_settled(s, now))
            return CURVOPT_STOP_SETTLED;
    }
}

int32_t co_lbfgs(const co_objective *f, const co_method_options *options, co_iterate *now, co_outcome *outcome,
                 curvopt_error *error) {
    size_t n = f->n, memory = (size_t)options->memory;
    int32_t status = CURVOPT_OK;
    *outcome = (co_outcome){0};
    solver s = {.f = f,
                .options = options,
                .outcome = outcome,
                .control = co_step_control_begin(options->tuning, options->max_step, now)};
    s.h = (history){.memory = options->memory,
                    .s = CO_NEW(double, memory *n),
                    .y = CO_NEW(double, memory *n),
                    .inverse_sy = CO_NEW(double, memory),
                    .alpha = CO_NEW(double, memory)};
    double *trial_x = CO_NEW(double, n), *trial_gradient = CO_NEW(double, n), *x = now->x, *gradient = now->gradient;
    s.trial = (co_iterate){.x = trial_x, .gradient = trial_gradient};
    s.direction = CO_NEW(double, n);
    s.image = CO_NEW(double, n);
    if (!s.h.s || !s.h.y || !s.h.inverse_sy || !s.h.alpha || !trial_x || !trial_gradient || !s.direction || !s.image) {
        status = co_status_no_memory(error);
    } else {
        outcome->stop = iterate(&s, now);
        co_iterate_hand_back(n, now, x, gradient);
    }
    free(s.h.s);
    free(s.h.y);
    free(s.h.inverse_sy);
    free(s.h.alpha);
    free(trial_x);
    free(trial_gradient);
    free(s.direction);
    free(s.image);
    return status;
}
