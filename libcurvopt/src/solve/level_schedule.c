/* The schedule of a level. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level_schedule.h"

#include <math.h>

/* --------------------------------------------------------------------------------------- the plan -- */

/* Near its minimum a level's matrix is good for many steps, and what it predicts comes true. */
static void start_near(const co_level_facts *f, co_level_schedule *s) {
    s->options.decrement_tolerance = f->decrement;
    s->options.settled_decrease = 0.1 * f->decrement;
    s->options.small_steps = 1;
}

co_level_schedule co_level_schedule_make(const co_level_facts *f, const co_tuning *t) {
    const double tolerance = f->decrement_tolerance;
    co_level_schedule s = {
        .forms = !f->is_near && !f->is_on_normals,
        .settles = f->is_near ? f->stops_short : !f->is_on_normals && (f->is_last || f->is_final),
        .ends = f->has_hessian && f->is_final && !f->stops_short,
        .options = {.tuning = t,
                    .max_iterations = f->max_iterations,
                    .gradient_tolerance = f->gradient_tolerance,
                    .decrement_tolerance = f->is_final ? tolerance : fmax(tolerance, t->last_decrement),
                    .settled_decrease = f->is_final ? t->final_settled * tolerance : t->coarse_settled,
                    .settled_steps = t->slow_steps,
                    .max_step = f->max_step,
                    .closely = f->closely,
                    .keeps_matrix = f->is_last && f->is_on_normals, /* what slides, gains by each matrix */
                    .memory = t->lbfgs_memory,
                    .by_hessian = !f->is_final && !f->is_near,
                    .update_every = f->is_final || f->has_repulsion ? t->lbfgs_update_often : t->lbfgs_update_every},
        .stationary = t->stationary * tolerance};
    if (f->is_near && f->stops_short)
        start_near(f, &s);
    /* Closely, and where nothing slides: no single step from a saddle may bring the tolerance, and a minimum be near.
     */
    s.options.saddle_decrease = f->closely && f->is_on_normals ? CO_KNOWN_DECREASE : s.options.decrement_tolerance;
    s.forming = s.options;
    s.forming.by_hessian = 0;
    s.forming.is_scaled = f->is_rough;
    s.forming.decrement_tolerance = fmax(tolerance, t->coarse_decrement);
    s.forming.settled_steps = f->expects_plateau ? t->slow_steps : t->quick_steps;
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

/* One stage, of as many steps as are left. */
static int32_t run_stage(runner *r, co_method method, const co_method_options *options) {
    const co_outcome before = *r->outcome;
    co_method_options rest = *options;
    rest.max_iterations -= before.iterations;
    int32_t status = r->on->run(r->on->context, method, &rest, &before, r->outcome, r->error);
    r->outcome->iterations += before.iterations;
    r->outcome->evaluations += before.evaluations;
    r->outcome->rejected += before.rejected;
    return status;
}

static int32_t form(runner *r) {
    int begun = 0;
    int32_t status = run_stage(r, CO_METHOD_LBFGS, &r->schedule->forming);
    if (status == CURVOPT_OK && ended_well(r))
        status = r->on->begin_even(r->on->context, &begun, r->error);
    if (status != CURVOPT_OK || !begun)
        return status;
    status = run_stage(r, CO_METHOD_LBFGS, &r->schedule->forming);
    r->on->end_even(r->on->context);
    return status;
}

static int32_t settle(runner *r) {
    int32_t status = r->on->refine(r->on->context, r->error);
    return status == CURVOPT_OK ? run_stage(r, CO_METHOD_LBFGS, &r->schedule->options) : status;
}

/* A level that has settled on a plateau is not at its end: while the certificate is not met, both methods go on.
 * Where figures need other rules than the optimizer has, Newton's method goes on by these. */
static int32_t end_by_newton(runner *r) {
    const co_level_schedule *s = r->schedule;
    const co_scheduled *on = r->on;
    for (int round = 0;; round++) {
        co_step_verdict verdict;
        double left;
        int32_t status = run_stage(r, CO_METHOD_NEWTON, &s->options);
        if (status != CURVOPT_OK || !ended_well(r) || round == CO_LEVEL_SCHEDULE_ROUNDS)
            return status;
        status = on->review_for_figures(on->context, &verdict, r->error);
        if (status == CURVOPT_OK && (verdict == CO_STEP_CHANGED || verdict == CO_STEP_REJECT))
            continue;
        if (status == CURVOPT_OK && verdict == CO_STEP_STOP)
            r->outcome->stop = CURVOPT_STOP_UNRESOLVED;
        if (status != CURVOPT_OK || r->outcome->stop != CURVOPT_STOP_SETTLED)
            return status;
        status = on->decrement(on->context, &left, r->error);
        if (status != CURVOPT_OK || !(left > s->stationary * fabs(on->value(on->context))))
            return status;
        status = run_stage(r, CO_METHOD_LBFGS, &s->options);
        if (status != CURVOPT_OK || !ended_well(r))
            return status;
    }
}

int32_t co_level_schedule_run(const co_level_schedule *schedule, const co_scheduled *on, co_outcome *outcome,
                              curvopt_error *error) {
    runner r = {.schedule = schedule, .on = on, .outcome = outcome, .error = error};
    *outcome = (co_outcome){0};
    outcome->stop = CURVOPT_STOP_CONVERGED;
    int32_t status = schedule->forms ? form(&r) : CURVOPT_OK;
    if (status == CURVOPT_OK && ended_well(&r) && schedule->settles)
        status = settle(&r);
    if (status == CURVOPT_OK && ended_well(&r) && schedule->ends)
        status = end_by_newton(&r);
    return status;
}
