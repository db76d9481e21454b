/* Stages of a level, and its best iterate. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level_solve.h"

#include "optimize/damped_newton.h"
#include "optimize/lbfgs.h"
#include "solve/level_even.h"
#include "solve/newton_decrement.h"

#include <math.h>
#include <string.h>

/* Steps between two moves of held numbers towards what the run wants. */
enum { APPROACH_STEPS = 5, APPROACH_ROUNDS = 100 };

static int32_t run_once(co_level *l, const co_objective *f, co_method method, const co_method_options *options,
                        co_outcome *outcome, curvopt_error *error) {
    l->review.value = l->now.value; /* by what spacing and springs count for now, and numbers are held at */
    int32_t status = method == CO_METHOD_NEWTON ? co_damped_newton(f, options, &l->now, outcome, error)
                                                : co_lbfgs(f, options, &l->now, outcome, error);
    return status == CURVOPT_OK ? l->failed : status;
}

static void count(co_outcome *all, const co_outcome *more) {
    all->iterations += more->iterations;
    all->evaluations += more->evaluations;
    all->rejected += more->rejected;
}

static int32_t run_method(void *context, co_method method, const co_method_options *options, const co_outcome *before,
                          co_outcome *outcome, curvopt_error *error) {
    co_level *l = context;
    const co_objective f = co_level_function(l);
    int changed, is_there;
    co_method_options rest = *options;
    if (l->is_lost) {
        *outcome = (co_outcome){.stop = CURVOPT_STOP_UNRESOLVED};
        return CURVOPT_OK;
    }
    int32_t status = co_level_aim(l, &is_there, &changed, error);
    l->before = *before;
    co_level_weigh_spacing(l);
    for (int round = 0; round < APPROACH_ROUNDS && status == CURVOPT_OK && !is_there && changed && !co_level_is_over(l);
         round++) {
        co_method_options some = rest;
        some.max_iterations = rest.max_iterations < APPROACH_STEPS ? rest.max_iterations : APPROACH_STEPS;
        status = run_once(l, &f, method, &some, outcome, error);
        count(&l->before, outcome);
        rest.max_iterations -= outcome->iterations;
        if (status == CURVOPT_OK)
            status = co_level_aim(l, &is_there, &changed, error);
    }
    const co_outcome approach = l->before;
    if (status == CURVOPT_OK)
        status = run_once(l, &f, method, &rest, outcome, error);
    outcome->iterations += approach.iterations - before->iterations;
    outcome->evaluations += approach.evaluations - before->evaluations;
    outcome->rejected += approach.rejected - before->rejected;
    return status;
}

/* Change of the cage's size, by itself, that smooths umbilics much as before. */
static const double SAME_SIZE = 1e-3;

static int32_t review_for_figures(void *context, co_step_verdict *verdict, curvopt_error *error) {
    co_level *l = context;
    l->objective.assembly.met = 0;
    co_level_objective_place(&l->objective, l->now.x);
    const int is_other = co_level_objective_take_size(&l->objective) > SAME_SIZE;
    if (is_other)
        co_level_objective_evaluate(&l->objective, &l->now);
    int32_t status = co_level_check(l, &l->now, verdict, error);
    if (is_other && *verdict == CO_STEP_KEEP)
        *verdict = CO_STEP_CHANGED;
    return status;
}

/* Rules that are good enough for a result, or for what comes before it; the iterate is held against them. */
static int32_t refine(void *context, curvopt_error *error) {
    co_level *l = context;
    const double wanted = (l->is_final ? 1 : l->objective.run->tuning->working_factor) * l->tolerance;
    co_step_verdict verdict;
    l->is_forming = 0;
    const int was_rough = co_level_is_rough(l);
    const int32_t status = co_assembly_set_coarsest(&l->objective.assembly, 0, error);
    if (status != CURVOPT_OK || !(was_rough || wanted < l->working_tolerance))
        return status;
    l->working_tolerance = wanted;
    l->objective.assembly.met = 0;
    if (was_rough) /* the function is another one, and what is held is measured anew */
        co_level_evaluate(l, &l->now);
    co_level_objective_place(&l->objective, l->now.x);
    return co_level_check(l, &l->now, &verdict, error);
}

static int32_t decrement(void *context, double *left, curvopt_error *error) {
    co_level *l = context;
    return co_newton_decrement(&l->hessian, &l->now, 0, left, error);
}

static double value(void *context) {
    const co_level *l = context;
    return l->now.value;
}

static co_level_schedule schedule_of(const co_level *l, const co_level_prospect *prospect) {
    const curvopt_options *o = l->objective.run->options;
    int is_last = l->motion != CO_MOTION_SLIDE && co_run_context_is_last(l->objective.run, l->number);
    const co_level_facts facts = {.is_last = is_last,
                                  .is_final = l->is_final,
                                  .is_on_normals = l->motion == CO_MOTION_NORMALS,
                                  .has_hessian = l->hessian.exists,
                                  .is_rough = co_level_is_rough(l),
                                  .has_repulsion = l->objective.repulsion.mesh != NULL,
                                  .expects_plateau = prospect->expects_plateau,
                                  .is_near = prospect->is_near,
                                  .stops_short = prospect->stops_short,
                                  .closely = prospect->closely,
                                  .decrement = prospect->decrement,
                                  .max_iterations = o->max_iterations - l->spent,
                                  .gradient_tolerance = o->gradient_tolerance,
                                  .decrement_tolerance = o->decrement_tolerance,
                                  .max_step = o->max_step};
    return co_level_schedule_make(&facts, l->objective.run->tuning);
}

static double value_without_crossing(co_level *l, const double *x) {
    return co_level_objective_crosses(&l->objective, x) ? (double)INFINITY : co_level_objective_value(&l->objective, x);
}

/* The last steps may not have been reviewed, and a fold may hide from two rules that follow each other: by the rules
 * that the figures at the end need, the best of the last iterate, the last that stood, and the first. When that is cut
 * off, values are not finite, and nothing can be said of what is not known to stand: CO_CANCELLED. */
static int32_t keep_best(co_level *l, int *stop, curvopt_error *error) {
    curvopt_energies energies;
    int resolved, changed, is_there;
    const double *others[2] = {l->review.safe, l->review.first};
    co_level_objective_place(&l->objective, l->now.x);
    int32_t status = co_adaptive_quadrature_resolve(
        &l->objective.assembly, l->objective.positions,
        &(co_quadrature_goal){.tolerance = l->tolerance, .terms = CO_TERMS_REPORT, .is_normalized = 1}, &energies,
        &resolved, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    const double *best = l->now.x;
    double least = value_without_crossing(l, best);
    for (int k = 0; k < 2; k++) {
        const double at = value_without_crossing(l, others[k]);
        if (isfinite(at) && !(least <= at)) {
            least = at;
            best = others[k];
        }
    }
    if (!isfinite(least) && co_level_is_cancelled(l))
        return CO_CANCELLED;
    if (!isfinite(least))
        best = l->review.first;
    if (best == l->review.first && *stop != CURVOPT_STOP_CANCELLED)
        *stop = CURVOPT_STOP_UNRESOLVED;
    if (best != l->now.x)
        memcpy(l->now.x, best, co_level_n(l) * sizeof *l->now.x);
    if (!isfinite(least)) /* by these rules held numbers are elsewhere, and the way there may leave a limit */
        return co_level_aim(l, &is_there, &changed, error);
    co_level_objective_evaluate(&l->objective, &l->now);
    co_level_objective_go_back(&l->objective, &l->now);
    return CURVOPT_OK;
}

int32_t co_level_solve(co_level *l, const co_level_prospect *prospect, co_outcome *outcome, curvopt_error *error) {
    const co_level_schedule schedule = schedule_of(l, prospect);
    const co_scheduled scheduled = {.context = l,
                                    .run = run_method,
                                    .refine = refine,
                                    .review_for_figures = review_for_figures,
                                    .decrement = decrement,
                                    .value = value,
                                    .begin_even = co_level_begin_even,
                                    .end_even = co_level_end_even};
    *outcome = (co_outcome){.stop = CURVOPT_STOP_CANCELLED};
    l->keeps_factor = prospect->is_near;
    l->is_forming = schedule.forms && !prospect->is_passing; /* a solver that stays has its cage to be near */
    if (!prospect->is_near && co_level_tell(l))
        return CURVOPT_OK;
    int32_t status = co_level_schedule_run(&schedule, &scheduled, outcome, error);
    if (co_level_is_cancelled(l))
        outcome->stop = CURVOPT_STOP_CANCELLED;
    if (status == CURVOPT_OK && !l->objective.run->options->joshi_sequin && !prospect->is_passing)
        status = keep_best(l, &outcome->stop, error);
    if (outcome->stop == CURVOPT_STOP_UNRESOLVED && !l->is_final) /* what stood was kept, and what follows goes on */
        outcome->stop = CURVOPT_STOP_SETTLED;
    if (status == CURVOPT_OK)
        l->reached = l->now.x;
    return status;
}
