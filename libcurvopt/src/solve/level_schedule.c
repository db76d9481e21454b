/* The schedule of a level. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level_schedule.h"

#include <math.h>

/* --------------------------------------------------------------------------------------- the plan -- */

/* Whether Newton's method takes over as soon as the shape stands. */
static int hands_over(const co_level_facts *f) {
    return f->is_third_order && f->is_linear;
}

static int slides(const co_level_facts *f) {
    return f->is_last && !f->is_third_order && !f->expects_saddle;
}

static co_end_game end_of(const co_level_facts *f) {
    if (f->is_third_order)
        return f->is_last || hands_over(f) ? CO_END_NEWTON : CO_END_NONE;
    return !f->is_last ? CO_END_NONE : slides(f) ? CO_END_SLIDE : CO_END_FINER_RULES;
}

static co_method_options first_stage(const co_level_facts *f, const co_tuning *t) {
    int is_quick = slides(f) && !f->expects_plateau;
    double tolerance = f->decrement_tolerance;
    co_method_options o = {.tuning = t,
                           .max_iterations = f->max_iterations,
                           .gradient_tolerance = f->gradient_tolerance,
                           .decrement_tolerance = f->is_last ? tolerance : fmax(tolerance, t->coarse_decrement),
                           .settled_decrease =
                               f->is_last && !is_quick ? t->final_settled * tolerance : t->coarse_settled,
                           .settled_steps = is_quick ? t->quick_steps : t->slow_steps,
                           .max_step = f->max_step,
                           .memory = t->lbfgs_memory,
                           .update_every = t->lbfgs_update_every};
    if (!hands_over(f))
        return o;
    /* A last level that began with the shape of the one before takes a single step, for what subdivision leaves in each
     * vertex. With many variables Newton's factors cost more than all the rest, and it comes when L-BFGS is done. */
    int has_many = f->n_variables > t->many_variables, at_once = !has_many && !f->is_first && f->is_last;
    o.settled_steps = at_once ? 1 : t->quick_steps;
    o.settled_decrease = at_once ? (double)INFINITY : has_many ? t->coarse_settled : t->shape_settled;
    return o;
}

co_level_schedule co_level_schedule_make(const co_level_facts *f, const co_tuning *t) {
    const double settled = t->final_settled * f->decrement_tolerance;
    co_level_schedule s = {.tuning = t,
                           .max_iterations = f->max_iterations,
                           .has_hessian = f->has_hessian,
                           .first = first_stage(f, t),
                           .end = f->has_hessian ? end_of(f) : CO_END_NONE,
                           .rounds = f->is_last ? CO_LEVEL_SCHEDULE_ROUNDS : 0,
                           .stationary = t->stationary * f->decrement_tolerance};
    s.between = s.newton = s.slide = s.slow = s.first;
    s.between.settled_decrease = s.newton.settled_decrease = f->is_last ? settled : t->coarse_settled;
    s.between.settled_steps = t->slow_steps;
    s.newton.settled_steps = f->is_last ? t->slow_steps : t->quick_steps;
    /* Without a history: pairs of steps as different as these make the matrix worse. */
    s.slide.memory = 0;
    s.slide.update_every = 1;
    s.slide.settled_decrease = t->sliding_settled * f->decrement_tolerance;
    s.slow.settled_steps = t->slow_steps;
    s.goes_on_slowly = s.slow.settled_decrease > settled;
    s.slow.settled_decrease = fmin(s.slow.settled_decrease, settled);
    return s;
}

/* --------------------------------------------------------------------------------------- running it -- */

typedef struct runner {
    const co_level_schedule *schedule;
    const co_scheduled *on;
    co_outcome *outcome; /* of all stages so far; its stop is the last one's */
    curvopt_error *error;
} runner;

/* Converged or settled, and not cancelled, out of steps or unresolved. */
static int ended_well(const runner *r) {
    return r->outcome->stop == CURVOPT_STOP_CONVERGED || r->outcome->stop == CURVOPT_STOP_SETTLED;
}

/* One stage, of at most so many steps in all. */
static int32_t run_stage(runner *r, co_method method, const co_method_options *options, int max_iterations) {
    const co_outcome before = *r->outcome;
    co_method_options rest = *options;
    rest.max_iterations = max_iterations - before.iterations;
    int32_t status = r->on->run(r->on->context, method, &rest, &before, r->outcome, r->error);
    r->outcome->iterations += before.iterations;
    r->outcome->evaluations += before.evaluations;
    r->outcome->rejected += before.rejected;
    return status;
}

/* The figures at the end are wanted as accurate as the tolerance says, not only within the multiple that rules are left
 * alone for: where that takes finer ones, the stage goes on by these. */
static int32_t go_on_by_finer_rules(runner *r, const co_method_options *options, int max_iterations) {
    co_step_verdict verdict;
    int32_t status = r->on->review_for_figures(r->on->context, &verdict, r->error);
    if (status == CURVOPT_OK && verdict == CO_STEP_CHANGED)
        status = run_stage(r, CO_METHOD_LBFGS, options, max_iterations);
    return status;
}

/* ----- SLIDE ----- */

/* Where sliding has come nearest to the certificate. */
typedef struct nearest {
    double left; /* to gain there */
    int is_met;  /* the decrement */
} nearest;

static int32_t slide_until_settled(runner *r, const co_method_options *options, int max_iterations, double *left) {
    *left = (double)NAN;
    int32_t status = run_stage(r, CO_METHOD_LBFGS, options, max_iterations);
    if (status == CURVOPT_OK && ended_well(r))
        status = go_on_by_finer_rules(r, options, max_iterations);
    if (status == CURVOPT_OK && ended_well(r))
        status = r->on->decrement(r->on->context, left, r->error);
    return status;
}

/* So many steps more, and not more than the user's limit. */
static int limit_of(const runner *r, int steps) {
    int most = r->outcome->iterations + steps;
    return most < r->schedule->max_iterations ? most : r->schedule->max_iterations;
}

/* Slides until the decrement is met, or steps are used up. Cages that are much more distorted than at first do not
 * count. */
static int32_t slide(runner *r, nearest *best) {
    const co_scheduled *on = r->on;
    const co_tuning *t = r->schedule->tuning;
    const double jacobian = on->min_jacobian(on->context);
    co_method_options options = r->schedule->slide;
    int limit = limit_of(r, t->sliding_steps);
    for (int is_first = 1;; is_first = 0) {
        int steps = r->outcome->iterations;
        double left;
        int32_t status = slide_until_settled(r, &options, limit, &left);
        if (status != CURVOPT_OK || !ended_well(r))
            return status;
        if (left < best->left && on->min_jacobian(on->context) >= t->sliding_distorted * jacobian) {
            on->remember(on->context, CO_MILESTONE_BEST);
            best->left = left;
        }
        best->is_met = best->left <= r->schedule->stationary * fabs(on->value(on->context));
        if (r->outcome->iterations == steps || best->is_met)
            return CURVOPT_OK;
        if (is_first)
            limit = limit_of(r, t->sliding_more_steps);
        options.settled_decrease = INFINITY; /* a few steps more */
    }
}

/* Where sliding does not meet the decrement: slowly, from where it began and by the rules of then; or what it came
 * to, if that is nearer. */
static int32_t settle_slowly(runner *r, const nearest *best) {
    const co_scheduled *on = r->on;
    double left = (double)NAN;
    int32_t status = on->go_to(on->context, CO_MILESTONE_START, r->error);
    r->outcome->stop = CURVOPT_STOP_SETTLED;
    if (status == CURVOPT_OK && r->schedule->goes_on_slowly)
        status = run_stage(r, CO_METHOD_LBFGS, &r->schedule->slow, r->schedule->max_iterations);
    if (status == CURVOPT_OK && ended_well(r))
        status = on->decrement(on->context, &left, r->error);
    if (status == CURVOPT_OK && best->left < left)
        status = on->go_to(on->context, CO_MILESTONE_BEST, r->error);
    return status;
}

static int32_t end_by_sliding(runner *r) {
    const co_scheduled *on = r->on;
    nearest best = {.left = INFINITY};
    on->remember(on->context, CO_MILESTONE_START);
    on->use_hessian(on->context, 1);
    int32_t status = slide(r, &best);
    on->use_hessian(on->context, 0);
    if (status != CURVOPT_OK || r->outcome->stop == CURVOPT_STOP_CANCELLED)
        return status;
    if (best.is_met) {
        r->outcome->stop = CURVOPT_STOP_CONVERGED;
        return on->go_to(on->context, CO_MILESTONE_BEST, r->error);
    }
    return r->outcome->iterations < r->schedule->max_iterations ? settle_slowly(r, &best) : CURVOPT_OK;
}

/* ----- NEWTON ----- */

/* A level that has settled on a plateau is not at its end: while the certificate is not met, both methods go on.
 * Where figures need other rules than the optimizer has, Newton's method goes on by these. */
static int32_t end_by_newton(runner *r) {
    const co_level_schedule *s = r->schedule;
    const co_scheduled *on = r->on;
    for (int round = 0;; round++) {
        co_step_verdict verdict;
        double left;
        int32_t status = run_stage(r, CO_METHOD_NEWTON, &s->newton, s->max_iterations);
        if (status != CURVOPT_OK || !ended_well(r) || round == s->rounds)
            return status;
        status = on->review_for_figures(on->context, &verdict, r->error);
        if (status == CURVOPT_OK && (verdict == CO_STEP_CHANGED || verdict == CO_STEP_REJECT))
            continue;
        if (status != CURVOPT_OK || r->outcome->stop != CURVOPT_STOP_SETTLED)
            return status;
        status = on->decrement(on->context, &left, r->error);
        if (status != CURVOPT_OK || !(left > s->stationary * fabs(on->value(on->context))))
            return status;
        status = run_stage(r, CO_METHOD_LBFGS, &s->between, s->max_iterations);
        if (status != CURVOPT_OK || !ended_well(r))
            return status;
    }
}

int32_t co_level_schedule_run(const co_level_schedule *schedule, const co_scheduled *on, co_outcome *outcome,
                              curvopt_error *error) {
    runner r = {.schedule = schedule, .on = on, .outcome = outcome, .error = error};
    *outcome = (co_outcome){0};
    int32_t status = run_stage(&r, CO_METHOD_LBFGS, &schedule->first, schedule->max_iterations);
    if (status != CURVOPT_OK || !ended_well(&r))
        return status;
    switch (schedule->end) {
    case CO_END_FINER_RULES:
        return go_on_by_finer_rules(&r, &schedule->first, schedule->max_iterations);
    case CO_END_SLIDE:
        return end_by_sliding(&r);
    case CO_END_NEWTON:
        return end_by_newton(&r);
    default:
        return CURVOPT_OK;
    }
}
