/* One level of a run. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level.h"

#include "base/memory.h"
#include "linalg/vector.h"
#include "optimize/damped_newton.h"
#include "optimize/lbfgs.h"
#include "solve/negative_curvature.h"
#include "solve/newton_decrement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static size_t n_of(const co_level *l) {
    return co_level_objective_n(&l->objective);
}

static int is_cancelled(const co_level *l) {
    return co_run_context_is_cancelled(l->objective.run);
}

/* Whether callbacks have nothing more to do: the run is to end, or one of them has failed. */
static int is_over(const co_level *l) {
    return l->failed != CURVOPT_OK || is_cancelled(l);
}

/* ------------------------------------------------------------------------- what the review sees of it -- */

static void evaluate_always(void *context, co_iterate *at) {
    co_level *l = context;
    co_level_objective_evaluate(&l->objective, at);
    if (co_repulsion_failed(&l->objective.repulsion) != CURVOPT_OK)
        l->failed = co_status_no_memory(l->error);
}

static int32_t resolve(void *context, const double *x, int *resolved, int *changed, double *defect,
                       curvopt_error *error) {
    co_level *l = context;
    curvopt_energies energies;
    co_level_objective_place(&l->objective, x);
    int32_t status = co_adaptive_quadrature_resolve(
        &l->objective.assembly, l->objective.positions,
        &(co_quadrature_goal){.tolerance = l->working_tolerance, .terms = CO_TERMS_OBJECTIVE, .is_normalized = 1},
        &energies, resolved, changed, error);
    if (status == CURVOPT_OK)
        *defect = l->objective.assembly.leaves_out ? 0 : energies.gauss_bonnet_defect;
    return status;
}

static int32_t coarsen(void *context, int *changed, curvopt_error *error) {
    co_level *l = context;
    return co_adaptive_quadrature_coarsen(&l->objective.assembly, l->working_tolerance, changed, error);
}

/* ---------------------------------------------------------------------- what an optimizer sees of it -- */

/* The optimizer finds no way on when the run is to end. */
static void evaluate(void *context, co_iterate *at) {
    if (is_cancelled(context))
        at->value = (double)INFINITY;
    else
        evaluate_always(context, at);
}

static double step_length(void *context, const double *d) {
    const co_level *l = context;
    return co_level_objective_length(&l->objective, d);
}

/* In units of the objective. Where vertices slide, the energy may be next to nothing, and is blind to most of that
 * motion: then a sphere's stiffness counts for it. */
static double worth_of_spacing(const co_level *l, const co_iterate *at) {
    const co_tuning *t = l->objective.run->tuning;
    double energy = fabs(co_level_objective_energy(&l->objective, at));
    if (l->motion == CO_MOTION_SLIDE)
        return t->spacing_slide * fmax(energy, co_penalty_stiffness(l->objective.run->options->weights));
    double worth = !l->objective.assembly.functional.has_third ? t->spacing
                   : l->is_forming && l->number == 1           ? t->spacing_forming
                                                               : t->spacing_third;
    for (int32_t k = 1; k < l->number; k++)
        worth *= t->spacing_fall;
    return worth * energy;
}

/* Where the energy has fallen to half of what spacing or springs were weighed by, that counts for too much. */
static co_step_verdict weigh_anew(co_level *l, co_iterate *now, co_step_verdict verdict) {
    co_level_objective *o = &l->objective;
    const double energy = co_level_objective_energy(o, now);
    if (!co_step_stands(verdict))
        return verdict;
    if (co_level_objective_weigh_springs(o, energy, 0.5)) {
        co_level_objective_evaluate(o, now);
        verdict = CO_STEP_CHANGED;
    }
    if (co_level_objective_weigh_repulsion(o, energy, 0.5, now))
        verdict = CO_STEP_CHANGED;
    if (o->spacing.weight == 0 || l->motion == CO_MOTION_SLIDE || energy > 0.5 * o->spaced_energy)
        return verdict;
    co_level_objective_weigh_spacing(o, worth_of_spacing(l, now), now);
    return CO_STEP_CHANGED;
}

static int is_rough(const co_level *l) {
    return l->objective.assembly.coarsest == CO_ROUGH_RULE;
}

static int32_t check(co_level *l, co_iterate *now, co_step_verdict *verdict, curvopt_error *error) {
    const int32_t status = co_step_review_check(&l->review, now, verdict, error);
    l->is_lost = l->is_lost || (status == CURVOPT_OK && *verdict == CO_STEP_STOP);
    return status;
}

static co_step_verdict review_step(void *context, const co_iterate *before, co_iterate *now, int iteration) {
    co_level *l = context;
    co_step_verdict verdict = CO_STEP_KEEP;
    if (is_over(l)) { /* since the step was made, where nobody could be told */
        co_step_review_take_back(&l->review, now);
        return CO_STEP_STOP;
    }
    const co_step_facts facts = {.iteration = iteration,
                                 .counts_length = l->hessian.exists && !is_rough(l),
                                 .length = co_level_objective_distance(&l->objective, before->x, now->x),
                                 .defect = now->found[CO_FOUND_DEFECT]};
    co_level_objective_normalize(&l->objective, now);
    const int waits = l->objective.repulsion.mesh && iteration % l->objective.run->tuning->review_every != 0;
    if (l->objective.run->options->joshi_sequin || waits || !co_step_review_is_due(&l->review, &facts))
        return weigh_anew(l, now, verdict);
    if (co_level_objective_crosses(&l->objective, now->x)) {
        co_step_review_take_back(&l->review, now);
        return CO_STEP_REJECT;
    }
    l->failed = check(l, now, &verdict, l->error);
    return weigh_anew(l, now, verdict);
}

static int precondition(void *context, const double *in, double *out) {
    co_level *l = context;
    if (!l->hessian.has_factor)
        return 1;
    int32_t status = co_level_hessian_solve(&l->hessian, in, out, l->error);
    co_level_objective_restrict(&l->objective, out);
    if (status != CURVOPT_OK)
        l->failed = status;
    return status != CURVOPT_OK;
}

static void update_preconditioner(void *context, const co_iterate *now, double step_excess, int by_hessian) {
    co_level *l = context;
    const int keeps = l->keeps_factor && l->hessian.has_factor;
    l->keeps_factor = 0;
    if (keeps)
        return;
    l->hessian.has_factor = 0;
    if (l->failed == CURVOPT_OK)
        l->failed = co_level_hessian_update(&l->hessian, now, step_excess, by_hessian, l->error);
}

static int assemble(void *context, const co_iterate *now, const double *before, int closely) {
    co_level *l = context;
    l->hessian.has_factor = l->hessian.has_gauss_newton = 0;
    if (!is_over(l))
        l->failed = co_level_hessian_assemble(&l->hessian, now, before, closely, l->error);
    return is_over(l);
}

static int factorize(void *context, const co_damping *damping, int *positive) {
    co_level *l = context;
    *positive = 0;
    if (is_cancelled(l))
        return 1;
    l->failed = co_level_hessian_factorize(&l->hessian, damping, positive, l->error);
    return l->failed != CURVOPT_OK;
}

static double least_shift(void *context, const co_iterate *now) {
    const co_level *l = context;
    return co_level_hessian_least_shift(&l->hessian, now->value);
}

static int32_t solve_shifted(void *context, const double *in, double *out, curvopt_error *error) {
    return co_level_hessian_solve(context, in, out, error);
}

/* The direction in which the Hessian, which has been factored with its least positive shift, is most negative. That
 * shift is more than the least one only if something is negative. */
static int32_t most_negative(co_level *l, const co_iterate *now, double *d, int *found, curvopt_error *error) {
    const co_shifted_inverse inverse = {.context = &l->hessian,
                                        .n = n_of(l),
                                        .shift = l->hessian.shift,
                                        .least = co_level_hessian_least_shift(&l->hessian, now->value),
                                        .solve = solve_shifted};
    *found = 0;
    if (!l->hessian.has_factor || inverse.shift <= inverse.least)
        return CURVOPT_OK;
    return co_negative_curvature_direction(&inverse, l->objective.run->tuning, now->gradient, d,
                                           l->objective.point_gradient, found, error);
}

static int negative_curvature(void *context, const co_iterate *now, double *d) {
    co_level *l = context;
    int found = 0;
    l->failed = co_level_hessian_unmix(&l->hessian, now, l->error);
    if (l->failed == CURVOPT_OK)
        l->failed = most_negative(l, now, d, &found, l->error);
    return found;
}

static int report(void *context, const co_iterate *now, const co_step_record *record) {
    co_level *l = context;
    co_step_record all = *record;
    (void)now; /* it is l->now: run_method() */
    all.iteration += l->before.iterations;
    all.evaluations += l->before.evaluations;
    all.rejected += l->before.rejected;
    return l->failed != CURVOPT_OK || (l->report && l->report(l, &all, l->user));
}

static co_objective objective_of(co_level *l) {
    int has = l->hessian.exists;
    return (co_objective){.context = l,
                          .n = n_of(l),
                          .evaluate = evaluate,
                          .step_length = step_length,
                          .review_step = review_step,
                          .precondition = has ? precondition : NULL,
                          .update_preconditioner = has ? update_preconditioner : NULL,
                          .assemble = has ? assemble : NULL,
                          .factorize = has ? factorize : NULL,
                          .least_shift = has ? least_shift : NULL,
                          .negative_curvature = has ? negative_curvature : NULL,
                          .report = report};
}

/* ------------------------------------------------------------------------ what the schedule sees of it -- */

static void weigh_spacing(co_level *l) {
    int wants_even = l->motion == CO_MOTION_ALL && l->objective.run->options->spacing == CURVOPT_SPACING_EVEN;
    if (wants_even || l->motion == CO_MOTION_SLIDE)
        co_level_objective_weigh_spacing(&l->objective, worth_of_spacing(l, &l->now), &l->now);
}

/* Where numbers are held: to them, or as far as a step leads. As co_level_objective_aim. */
static int32_t aim(co_level *l, int *is_there, int *changed, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    *is_there = 1;
    *changed = 0;
    if (!l->objective.run->held || n_of(l) == 0)
        return CURVOPT_OK;
    co_held_level_choose_ways(&l->objective.numbers, l->now.x);
    if (l->objective.numbers.is_idle)
        l->hessian.system.held = NULL;
    else if (l->hessian.exists)
        status = co_level_hessian_soften_ways(&l->hessian, &l->now, error);
    if (status == CURVOPT_OK)
        *is_there = co_level_objective_aim(&l->objective, l->objective.run->options->max_step, &l->now, changed);
    return status;
}

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
    const co_objective f = objective_of(l);
    int changed, is_there;
    co_method_options rest = *options;
    if (l->is_lost) {
        *outcome = (co_outcome){.stop = CURVOPT_STOP_UNRESOLVED};
        return CURVOPT_OK;
    }
    int32_t status = aim(l, &is_there, &changed, error);
    l->before = *before;
    weigh_spacing(l);
    for (int round = 0; round < APPROACH_ROUNDS && status == CURVOPT_OK && !is_there && changed && !is_over(l);
         round++) {
        co_method_options some = rest;
        some.max_iterations = rest.max_iterations < APPROACH_STEPS ? rest.max_iterations : APPROACH_STEPS;
        status = run_once(l, &f, method, &some, outcome, error);
        count(&l->before, outcome);
        rest.max_iterations -= outcome->iterations;
        if (status == CURVOPT_OK)
            status = aim(l, &is_there, &changed, error);
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
    int32_t status = check(l, &l->now, verdict, error);
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
    const int was_rough = is_rough(l);
    const int32_t status = co_assembly_set_coarsest(&l->objective.assembly, 0, error);
    if (status != CURVOPT_OK || !(was_rough || wanted < l->working_tolerance))
        return status;
    l->working_tolerance = wanted;
    l->objective.assembly.met = 0;
    if (was_rough) /* the function is another one, and what is held is measured anew */
        evaluate_always(l, &l->now);
    co_level_objective_place(&l->objective, l->now.x);
    return check(l, &l->now, &verdict, error);
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
                                  .is_rough = is_rough(l),
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

/* The last steps may not have been reviewed, and a fold may hide from two rules that follow each other: by the rules
 * that the figures at the end need, the best of the last iterate, the last that stood, and the first. */
static int32_t keep_best(co_level *l, int *stop, curvopt_error *error) {
    curvopt_energies energies;
    int resolved, changed;
    const double *others[2] = {l->review.safe, l->review.first};
    co_level_objective_place(&l->objective, l->now.x);
    int32_t status = co_adaptive_quadrature_resolve(
        &l->objective.assembly, l->objective.positions,
        &(co_quadrature_goal){.tolerance = l->tolerance, .terms = CO_TERMS_REPORT, .is_normalized = 1}, &energies,
        &resolved, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    double least = co_level_objective_crosses(&l->objective, l->now.x)
                       ? (double)INFINITY
                       : co_level_objective_value(&l->objective, l->now.x);
    for (int k = 0; k < 2; k++) {
        double at = co_level_objective_crosses(&l->objective, others[k])
                        ? (double)INFINITY
                        : co_level_objective_value(&l->objective, others[k]);
        if (at < least || !isfinite(least)) {
            least = at;
            memcpy(l->now.x, others[k], n_of(l) * sizeof *l->now.x);
            if (others[k] == l->review.first && *stop != CURVOPT_STOP_CANCELLED)
                *stop = CURVOPT_STOP_UNRESOLVED;
        }
    }
    if (!isfinite(least)) { /* by these rules held numbers are elsewhere, and the way there may leave a limit */
        int is_there;
        memcpy(l->now.x, l->review.first, n_of(l) * sizeof *l->now.x);
        return aim(l, &is_there, &changed, error);
    }
    co_level_objective_evaluate(&l->objective, &l->now);
    co_level_objective_go_back(&l->objective, &l->now);
    return CURVOPT_OK;
}

int32_t co_level_solve(co_level *l, const co_level_prospect *prospect, co_outcome *outcome, curvopt_error *error) {
    const co_step_record none = {
        .length = (double)NAN, .predicted = (double)NAN, .gain_ratio = (double)NAN, .shift = (double)NAN};
    const co_level_schedule schedule = schedule_of(l, prospect);
    const co_scheduled scheduled = {.context = l,
                                    .run = run_method,
                                    .refine = refine,
                                    .review_for_figures = review_for_figures,
                                    .decrement = decrement,
                                    .value = value};
    *outcome = (co_outcome){.stop = CURVOPT_STOP_CANCELLED};
    l->keeps_factor = prospect->is_near;
    l->is_forming = schedule.forms && !prospect->is_passing; /* a solver that stays has its cage to be near */
    if (!prospect->is_near && report(l, &l->now, &none))
        return CURVOPT_OK;
    int32_t status = co_level_schedule_run(&schedule, &scheduled, outcome, error);
    if (is_cancelled(l))
        outcome->stop = CURVOPT_STOP_CANCELLED;
    if (status == CURVOPT_OK && !l->objective.run->options->joshi_sequin && !prospect->is_passing)
        status = keep_best(l, &outcome->stop, error);
    if (outcome->stop == CURVOPT_STOP_UNRESOLVED && !l->is_final) /* what stood was kept, and what follows goes on */
        outcome->stop = CURVOPT_STOP_SETTLED;
    if (status == CURVOPT_OK)
        l->reached = l->now.x;
    return status;
}

/* ------------------------------------------------------------------------------------------- the level -- */

static int32_t create_room(co_level *l, curvopt_error *error) {
    const co_reviewed reviewed = {
        .context = l, .n = n_of(l), .evaluate = evaluate_always, .resolve = resolve, .coarsen = coarsen};
    return co_step_review_create(l->objective.run->tuning, &reviewed, &l->review, error);
}

/* Nothing follows motion along normals, nor, but after sliding, where spacing is not wanted, the last level. */
static int finds_result(const co_run_context *run, co_motion motion, int32_t number) {
    return motion == CO_MOTION_NORMALS || (motion == CO_MOTION_ALL && run->options->spacing == CURVOPT_SPACING_FREE &&
                                           co_run_context_is_last(run, number));
}

/* While a shape forms, rules may be rough where evaluations are what takes the time; but where vertices slide freely
 * they slide for what rules do not see. */
static int may_be_rough(const co_level *l) {
    const co_run_context *run = l->objective.run;
    return l->is_forming && !l->is_final && !run->options->joshi_sequin &&
           co_assembly_n_rough(&l->objective.assembly) >= run->tuning->rough_from;
}

static double working_factor_of(const co_level *l) {
    const co_tuning *t = l->objective.run->tuning;
    return l->motion == CO_MOTION_NORMALS                              ? 1
           : is_rough(l) || l->objective.assembly.functional.has_third ? t->working_forming
                                                                       : t->working_factor;
}

int32_t co_level_create(const co_run_context *run, const curvopt_mesh *mesh, const co_symmetry *symmetry,
                        const co_constraints *constraints, co_motion motion, const double *start, int32_t number,
                        co_level **out, curvopt_error *error) {
    size_t n = 3 * (size_t)mesh->info.n_vertices;
    co_level *l = *out = CO_NEW(co_level, 1);
    if (!l)
        return co_status_no_memory(error);
    l->number = number;
    l->motion = motion;
    l->is_final = finds_result(run, motion, number);
    l->is_forming = motion == CO_MOTION_ALL;
    l->error = error;
    l->now = (co_iterate){.x = CO_NEW(double, n), .gradient = CO_NEW(double, n)};
    l->tolerance = co_run_context_tolerance(run);
    int32_t status = l->now.x && l->now.gradient ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status =
            co_level_objective_create(run, mesh, symmetry, constraints, motion, start, &l->objective, l->now.x, error);
    if (status == CURVOPT_OK && may_be_rough(l))
        status = co_assembly_set_coarsest(&l->objective.assembly, CO_ROUGH_RULE, error);
    if (status == CURVOPT_OK) {
        l->working_tolerance = l->tolerance * working_factor_of(l);
        status = create_room(l, error);
    }
    if (status == CURVOPT_OK)
        status = co_level_hessian_create(&l->objective, &l->hessian, error);
    if (status != CURVOPT_OK) {
        co_level_destroy(l);
        *out = NULL;
    }
    return status;
}

void co_level_destroy(co_level *l) {
    if (!l)
        return;
    co_level_hessian_free(&l->hessian);
    co_step_review_free(&l->review);
    co_level_objective_free(&l->objective);
    free(l->now.x);
    free(l->now.gradient);
    free(l);
}

int32_t co_level_move(co_level *l, const co_symmetry *symmetry, const co_constraints *constraints, const double *start,
                      int *fits, curvopt_error *error) {
    l->error = error;
    l->failed = CURVOPT_OK;
    l->before = (co_outcome){0};
    l->is_lost = 0;
    l->reached = NULL;
    return co_level_objective_move(&l->objective, symmetry, constraints, l->motion, start, l->now.x, fits, error);
}

int32_t co_level_refresh_factor(co_level *l, curvopt_error *error) {
    co_level_hessian *h = &l->hessian;
    co_damping damping = {.shift = co_level_hessian_least_shift(h, l->now.value)};
    const double mixes[3] = {0, l->objective.run->tuning->newton_mix, 1};
    const int had_factor = h->has_factor;
    int positive = 0;
    if (n_of(l) == 0)
        return CURVOPT_OK;
    int32_t status = co_level_hessian_assemble(h, &l->now, NULL, 1, error);
    if (status == CO_CANCELLED || (status == CURVOPT_OK && is_cancelled(l))) { /* and the old one is not spoiled yet */
        h->has_factor = had_factor;
        return CURVOPT_OK;
    }
    for (int k = 0; k < 3 && status == CURVOPT_OK && !positive && !is_cancelled(l); k++) {
        damping.mix = mixes[k];
        status = co_level_hessian_factorize(h, &damping, &positive, error);
    }
    return status;
}

/* The level's first evaluation. Where the run's input crosses itself, the level may begin as it is. */
static void evaluate_first(co_level *l) {
    co_level_objective *o = &l->objective;
    co_level_objective_evaluate(o, &l->now);
    if (!o->repulsion.mesh || isfinite(l->now.value))
        return;
    co_repulsion_accept(&o->repulsion, o->positions);
    co_level_objective_evaluate(o, &l->now);
}

int32_t co_level_begin(co_level *l, curvopt_error *error) {
    int resolved, changed, is_there;
    double defect;
    int32_t status = resolve(l, l->now.x, &resolved, &changed, &defect, error);
    if (status != CURVOPT_OK)
        return status;
    status = aim(l, &is_there, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    co_step_review_begin(&l->review, l->now.x, defect);
    l->reached = l->review.safe;
    evaluate_first(l);
    if (co_level_objective_weigh_springs(&l->objective, co_level_objective_energy(&l->objective, &l->now), 1))
        co_level_objective_evaluate(&l->objective, &l->now);
    co_level_objective_weigh_repulsion(&l->objective, co_level_objective_energy(&l->objective, &l->now), 1, &l->now);
    if (co_repulsion_failed(&l->objective.repulsion) != CURVOPT_OK)
        return co_status_no_memory(error);
    if (isfinite(l->now.value) && isfinite(co_vector_norm(n_of(l), l->now.gradient)))
        return CURVOPT_OK;
    if (is_cancelled(l)) /* then evaluations may not be finite either */
        return CO_CANCELLED;
    return co_adaptive_quadrature_not_finite(&l->objective.assembly, error);
}

int32_t co_level_begin_by_rules_of(co_level *l, const co_level *other, curvopt_error *error) {
    int is_there, changed;
    int32_t status = co_assembly_copy_rules(&l->objective.assembly, &other->objective.assembly, error);
    if (status != CURVOPT_OK)
        return status;
    l->objective.penalty.weight = other->objective.penalty.weight;
    if (l->objective.repulsion.mesh)
        co_repulsion_copy(&l->objective.repulsion, &other->objective.repulsion);
    status = aim(l, &is_there, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    evaluate_first(l);
    co_step_review_begin(&l->review, l->now.x, l->now.found[CO_FOUND_DEFECT]);
    l->reached = l->review.safe;
    return CURVOPT_OK;
}

int32_t co_level_first_gain(co_level *l, double *gain, curvopt_error *error) {
    const size_t n = n_of(l);
    double *step = CO_NEW(double, n);
    *gain = (double)INFINITY;
    if (!step)
        return co_status_no_memory(error);
    weigh_spacing(l);
    update_preconditioner(l, &l->now, 0, 0);
    l->keeps_factor = l->hessian.has_factor;
    if (l->failed == CURVOPT_OK && l->keeps_factor && precondition(l, l->now.gradient, step) == 0)
        *gain = 0.5 * co_vector_dot(n, l->now.gradient, step) / fabs(l->now.value);
    free(step);
    return l->failed;
}

double co_level_moved(co_level *l) {
    return co_level_objective_distance(&l->objective, l->review.first, l->now.x);
}

int32_t co_level_leave_saddle(co_level *l, int *left, curvopt_error *error) {
    const co_run_context *run = l->objective.run;
    co_objective f = objective_of(l);
    double *d = CO_NEW(double, 2 * f.n);
    int found = 0;
    f.evaluate = evaluate_always;
    *left = 0;
    int32_t status = d ? co_level_hessian_assemble_exact(&l->hessian, &l->now, l->objective.gauge, error)
                       : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = co_level_hessian_factorize_shifted(&l->hessian,
                                                    co_level_hessian_least_shift(&l->hessian, l->now.value), error);
    if (status == CURVOPT_OK)
        status = most_negative(l, &l->now, d, &found, error);
    l->objective.repulsion.is_thorough = 1; /* another level begins there */
    if (found)
        *left = co_negative_curvature_step(
            &f,
            &(co_negative_curvature_options){run->tuning, run->options->max_step, run->options->decrement_tolerance}, d,
            d + f.n, &l->now);
    free(d);
    return status;
}
