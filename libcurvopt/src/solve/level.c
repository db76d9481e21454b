/* One level of a run. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level.h"

#include "base/memory.h"
#include "linalg/vector.h"
#include "solve/negative_curvature.h"
#include "solve/newton_decrement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------- what the review sees of it -- */

void co_level_evaluate(void *level, co_iterate *at) {
    co_level *l = level;
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
    if (co_level_is_cancelled(context))
        at->value = (double)INFINITY;
    else
        co_level_evaluate(context, at);
}

static double step_length(void *context, const double *d) {
    const co_level *l = context;
    return co_level_objective_length(&l->objective, d);
}

int co_level_wants_even(const co_level *l) {
    return l->motion == CO_MOTION_ALL && l->objective.run->options->spacing == CURVOPT_SPACING_EVEN;
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

int32_t co_level_check(co_level *l, co_iterate *now, co_step_verdict *verdict, curvopt_error *error) {
    const int32_t status = co_step_review_check(&l->review, now, verdict, error);
    l->is_lost = l->is_lost || (status == CURVOPT_OK && *verdict == CO_STEP_STOP);
    return status;
}

static co_step_verdict review_step(void *context, const co_iterate *before, co_iterate *now, int iteration) {
    co_level *l = context;
    co_step_verdict verdict = CO_STEP_KEEP;
    if (co_level_is_over(l)) { /* since the step was made, where nobody could be told */
        co_step_review_take_back(&l->review, now);
        return CO_STEP_STOP;
    }
    const co_step_facts facts = {.iteration = iteration,
                                 .counts_length = l->hessian.exists && !co_level_is_rough(l),
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
    l->failed = co_level_check(l, now, &verdict, l->error);
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
    if (!co_level_is_over(l))
        l->failed = co_level_hessian_assemble(&l->hessian, now, before, closely, l->error);
    return co_level_is_over(l);
}

static int factorize(void *context, const co_damping *damping, int *positive) {
    co_level *l = context;
    *positive = 0;
    if (co_level_is_cancelled(l))
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
                                        .n = co_level_n(l),
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

int co_level_tell(co_level *l) {
    const co_step_record none = {
        .length = (double)NAN, .predicted = (double)NAN, .gain_ratio = (double)NAN, .shift = (double)NAN};
    return report(l, &l->now, &none);
}

co_objective co_level_function(co_level *l) {
    int has = l->hessian.exists;
    return (co_objective){.context = l,
                          .n = co_level_n(l),
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

/* ---------------------------------------------------------------------- what is weighed and aimed at anew -- */

void co_level_weigh_spacing(co_level *l) {
    if (co_level_wants_even(l) || l->motion == CO_MOTION_SLIDE)
        co_level_objective_weigh_spacing(&l->objective, worth_of_spacing(l, &l->now), &l->now);
}

int32_t co_level_aim(co_level *l, int *is_there, int *changed, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    *is_there = 1;
    *changed = 0;
    if (!l->objective.run->held || co_level_n(l) == 0)
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

/* ------------------------------------------------------------------------------------------- the level -- */

static int32_t create_room(co_level *l, curvopt_error *error) {
    const co_reviewed reviewed = {
        .context = l, .n = co_level_n(l), .evaluate = co_level_evaluate, .resolve = resolve, .coarsen = coarsen};
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
    return l->motion == CO_MOTION_NORMALS                                       ? 1
           : co_level_is_rough(l) || l->objective.assembly.functional.has_third ? t->working_forming
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
    free(l->formed.x);
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
    if (co_level_n(l) == 0)
        return CURVOPT_OK;
    int32_t status = co_level_hessian_assemble(h, &l->now, NULL, 1, error);
    if (status == CO_CANCELLED ||
        (status == CURVOPT_OK && co_level_is_cancelled(l))) { /* and the old one is not spoiled yet */
        h->has_factor = had_factor;
        return CURVOPT_OK;
    }
    for (int k = 0; k < 3 && status == CURVOPT_OK && !positive && !co_level_is_cancelled(l); k++) {
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
    status = co_level_aim(l, &is_there, &changed, error);
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
    if (isfinite(l->now.value) && isfinite(co_vector_norm(co_level_n(l), l->now.gradient)))
        return CURVOPT_OK;
    if (co_level_is_cancelled(l)) /* then evaluations may not be finite either */
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
    status = co_level_aim(l, &is_there, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    evaluate_first(l);
    co_step_review_begin(&l->review, l->now.x, l->now.found[CO_FOUND_DEFECT]);
    l->reached = l->review.safe;
    return CURVOPT_OK;
}

int32_t co_level_first_gain(co_level *l, double *gain, curvopt_error *error) {
    const size_t n = co_level_n(l);
    double *step = CO_NEW(double, n);
    *gain = (double)INFINITY;
    if (!step)
        return co_status_no_memory(error);
    co_level_weigh_spacing(l);
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
    co_objective f = co_level_function(l);
    double *d = CO_NEW(double, 2 * f.n);
    int found = 0;
    f.evaluate = co_level_evaluate;
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
