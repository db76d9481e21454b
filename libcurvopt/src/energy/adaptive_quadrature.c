/* Adaptive quadrature: chooses the rule of each patch from error estimates. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "energy/adaptive_quadrature.h"

#include "base/constants.h"
#include "base/memory.h"
#include "base/ordered_sum.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------------- terms and errors of patches -- */

/* A patch's terms are work of 16 steps or so. */
static co_thread_pool *pool_for_terms(const co_assembly *a) {
    return co_thread_pool_if_worth(a->threads, 16 * (size_t)a->patches.n_patches);
}

/* What store_terms() is about. */
typedef struct stored_terms {
    const co_element_batches *batches;
    double area;
    int third;
    co_patch_terms *out;
} stored_terms;

static void store_terms_of_blocks(void *context, size_t begin, size_t end) {
    const stored_terms *s = context;
    const co_element_batches *l = s->batches;
    for (int32_t b = (int32_t)begin; b < (int32_t)end; b++)
        for (int32_t lane = 0; lane < l->block[b].n_used; lane++) {
            double term[CURVOPT_MAX_TERMS], integral[CO_N_INTEGRALS];
            co_patch_terms *to = &s->out[co_element_batches_patch(l, b, lane)];
            for (int i = 0; i < CO_N_INTEGRALS; i++)
                integral[i] = co_element_batches_sum(l, b, lane, i);
            to->number[CURVOPT_SCALAR_AREA] = integral[CO_INT_AREA];
            to->number[CURVOPT_SCALAR_VOLUME] = integral[CO_INT_VOLUME];
            to->number[CURVOPT_SCALAR_MEAN_CURVATURE] = integral[CO_INT_MEAN];
            to->jump = s->area * co_element_batches_sum(l, b, lane, CO_SUM_JUMP);
            integral[CO_INT_AREA] = s->area;
            co_functional_terms(integral, s->third, term);
            memcpy(to->term, term, sizeof to->term);
        }
}

/* Terms of every patch of these batches, whose integrals were evaluated last, into `out`; `area`: the whole surface's.
 */
static void store_terms(const co_assembly *a, const co_element_batches *l, double area, int third,
                        co_patch_terms *out) {
    stored_terms s = {.batches = l, .area = area, .third = third, .out = out};
    co_thread_pool_for(pool_for_terms(a), (size_t)l->n_blocks, store_terms_of_blocks, &s);
}

/* Sums of terms over patches, chunk by chunk (ordered_sum.h). */
typedef struct term_sums {
    const co_patch_terms *terms;
    size_t n;
    double sum[CO_ORDERED_SUM_CHUNKS][CURVOPT_N_TERMS];
} term_sums;

static void sum_terms(void *context, size_t begin, size_t end) {
    term_sums *s = context;
    for (int k = (int)begin; k < (int)end; k++)
        for (size_t p = co_ordered_sum_begin(s->n, k); p < co_ordered_sum_begin(s->n, k + 1); p++)
            for (int t = 0; t < CURVOPT_N_TERMS; t++)
                s->sum[k][t] += s->terms[p].term[t];
}

/* Of the objective at a surface with these integrals, which was evaluated last. */
static co_quadrature_weights weights_at(const co_assembly *a, const double integral[CO_N_INTEGRALS]) {
    const co_spontaneous_part part = co_spontaneous_curvature_add(&a->spontaneous, a->radius, integral);
    co_quadrature_weights w = {.term = a->weights};
    memcpy(w.number, part.added.slope, sizeof w.number);
    return w;
}

/* The measure whose whole is the sum of these patches' terms, whose values they were. */
static co_quadrature_error_measure measure_of(const co_assembly *a, int every_term, const co_patch_terms *terms,
                                              const co_values *values) {
    const co_spontaneous_part part = co_spontaneous_curvature_add(&a->spontaneous, a->radius, values->integral);
    co_quadrature_error_measure m = {.weights = weights_at(a, values->integral),
                                     .every_term = every_term,
                                     .more = part.added.value + part.reference};
    term_sums s = {.terms = terms, .n = (size_t)a->patches.n_patches};
    co_ordered_sum_run(a->threads, s.n, sum_terms, &s);
    for (int k = 0; k < CO_ORDERED_SUM_CHUNKS; k++)
        for (int t = 0; t < CURVOPT_N_TERMS; t++)
            m.whole.term[t] += s.sum[k][t];
    return m;
}

/* What compare_terms() is about. */
typedef struct compared_terms {
    co_quadrature_error_measure measure;
    const co_patch_terms *other;
    co_quadrature_estimates *estimates;
} compared_terms;

static void compare_terms_of_patches(void *context, size_t begin, size_t end) {
    const compared_terms *c = context;
    for (size_t p = begin; p < end; p++)
        c->estimates->error[p] = co_quadrature_error_relative(&c->measure, &c->estimates->used[p], &c->other[p]);
}

/* Fills estimates.error with the differences between the terms by the patches' rules and those by other rules, by which
 * the whole has these values. */
static void compare_terms(co_assembly *a, int every_term, const co_patch_terms *other, const co_values *values) {
    compared_terms c = {
        .measure = measure_of(a, every_term, other, values), .other = other, .estimates = &a->estimates};
    co_thread_pool_for(pool_for_terms(a), (size_t)a->patches.n_patches, compare_terms_of_patches, &c);
}

void co_adaptive_quadrature_by_face(const co_assembly *a, int32_t n_faces, double *energy) {
    memset(energy, 0, sizeof *energy * (size_t)n_faces);
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        for (int t = 0; t < CURVOPT_N_TERMS; t++)
            if (a->weights[t] > 0) /* the others may be unknown */
                energy[a->patches.place[p].face] += a->weights[t] * a->estimates.used[p].term[t];
}

int32_t co_adaptive_quadrature_evaluate_finer(co_assembly *a, int third, co_values *values, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    co_element_batches_spec spec = {
        .patches = &a->patches, .cache = a->cache, .lanes = a->kernel->lanes, .rule = a->rule, .step = 1};
    if (!a->finer_batches.n_blocks)
        status = co_element_batches_create(&spec, &a->finer_batches, error);
    if (status == CURVOPT_OK)
        status = co_assembly_evaluate_batches(a, &a->finer_batches, third, values, error);
    if (status != CURVOPT_OK)
        co_element_batches_free(&a->finer_batches);
    return status;
}

/* ---------------------------------------------------------------------------------------------- marking -- */

/* Fills estimates.error_per_cost: each patch's error by the difference in cost between the finer and the coarser of two
 * rules, of which it has one. */
static void divide_by_costs(co_assembly *a, const co_element_batches *coarse, const co_element_batches *fine) {
    co_quadrature_estimates *e = &a->estimates;
    double *cost = e->error_per_cost;
    memset(cost, 0, sizeof *cost * (size_t)a->patches.n_patches);
    for (int side = 0; side < 2; side++) {
        const co_element_batches *l = side ? coarse : fine;
        for (int32_t b = 0; b < l->n_blocks; b++)
            for (int32_t lane = 0; lane < l->block[b].n_used; lane++)
                cost[co_element_batches_patch(l, b, lane)] += (side ? -1 : 1) * co_block_cost(&l->block[b]);
    }
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        e->error_per_cost[p] = co_marking_error_per_cost(e->error[p], cost[p]);
}

static int is_refinable(const co_assembly *a, int32_t p) {
    return a->rule[p] < CO_FINEST_RULE;
}

static int is_coarsenable(const co_assembly *a, int32_t p) {
    return a->rule[p] > co_assembly_coarsest_of(a, p);
}

/* The threshold (marking.h) among the patches for which `can_change` holds. */
static double threshold_of(co_assembly *a, int (*can_change)(const co_assembly *, int32_t), double unmarked) {
    co_quadrature_estimates *e = &a->estimates;
    int32_t n = 0;
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        if (can_change(a, p))
            e->candidates[n++] = (co_marking_candidate){.error_per_cost = e->error_per_cost[p], .error = e->error[p]};
    return co_marking_threshold(e->candidates, n, unmarked, CO_MARKING_TIE);
}

/* Raises the rules of the patches where that brings most for its cost; returns how many were raised. */
static int32_t refine_rules(co_assembly *a, double tolerance) {
    int32_t raised = 0;
    divide_by_costs(a, &a->batches, &a->finer_batches);
    double threshold = threshold_of(a, is_refinable, a->tuning->quadrature_unmarked * tolerance);
    for (int32_t p = 0; threshold < INFINITY && p < a->patches.n_patches; p++)
        if (is_refinable(a, p) && !(a->estimates.error_per_cost[p] < threshold)) {
            a->rule[p]++;
            raised++;
        }
    return raised;
}

/* ----------------------------------------------------------------------------------------- claimed errors -- */

/* Terms of one patch that its error is told from. */
typedef struct patch_comparison {
    const co_patch_terms *used;   /* by its own rule */
    const co_patch_terms *finest; /* by the finest rule that it was compared with */
    const co_patch_terms *before; /* by the rule one step coarser than that */
} patch_comparison;

static patch_comparison comparison_of(const co_quadrature_estimates *e, size_t p) {
    int third = e->has_third_rule[p];
    return (patch_comparison){.used = &e->used[p],
                              .finest = third ? &e->finest[p] : &e->finer[p],
                              .before = third ? &e->finer[p] : &e->used[p]};
}

/* Errors of an evaluation. */
typedef struct errors {
    co_quadrature_error objective, area, term[CURVOPT_N_TERMS];
} errors;

/* A patch's change of the objective. */
static co_quadrature_change change_of_objective(const co_quadrature_weights *w, const double *weight_of_x,
                                                const patch_comparison *s) {
    co_quadrature_change c = {.all = co_quadrature_error_difference(w, s->used, s->finest),
                              .first = co_quadrature_error_difference(w, s->used, s->before),
                              .last = co_quadrature_error_difference(w, s->before, s->finest)};
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        c.jump += w->term[t] * weight_of_x[t] * s->finest->jump;
    return c;
}

/* A patch's change of a value that each of its rules has. */
static co_quadrature_change change_of(double used, double before, double finest, double jump) {
    return (co_quadrature_change){.all = used - finest, .first = used - before, .last = before - finest, .jump = jump};
}

/* Sums over patches begin .. end - 1. */
static errors errors_of_patches(const co_assembly *a, const co_quadrature_weights *w, size_t begin, size_t end) {
    errors e = {0};
    double weight_of_x[CURVOPT_N_TERMS];
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        weight_of_x[t] = co_functional_weight_of_x(t);
    for (size_t p = begin; p < end; p++) {
        const int area = CURVOPT_SCALAR_AREA;
        const patch_comparison s = comparison_of(&a->estimates, p);
        const co_quadrature_change objective = change_of_objective(w, weight_of_x, &s);
        const co_quadrature_change surface =
            change_of(s.used->number[area], s.before->number[area], s.finest->number[area], 0);
        co_quadrature_error_add(&e.objective, a->tuning, &objective);
        co_quadrature_error_add(&e.area, a->tuning, &surface);
        for (int t = 0; t < CURVOPT_N_TERMS; t++) {
            const co_quadrature_change term =
                change_of(s.used->term[t], s.before->term[t], s.finest->term[t], weight_of_x[t] * s.finest->jump);
            co_quadrature_error_add(&e.term[t], a->tuning, &term);
        }
    }
    return e;
}

/* Errors chunk by chunk (ordered_sum.h). */
typedef struct error_sums {
    const co_assembly *assembly;
    co_quadrature_weights weights;
    size_t n;
    errors part[CO_ORDERED_SUM_CHUNKS];
} error_sums;

static void sum_errors(void *context, size_t begin, size_t end) {
    error_sums *s = context;
    for (int k = (int)begin; k < (int)end; k++)
        s->part[k] = errors_of_patches(s->assembly, &s->weights, co_ordered_sum_begin(s->n, k),
                                       co_ordered_sum_begin(s->n, k + 1));
}

/* By term, of an evaluation with these terms: a third-order one is off by its part of the area's error, too. */
static errors errors_of(const co_assembly *a, const co_values *v, const double *term) {
    errors e = {0};
    error_sums s = {.assembly = a, .weights = weights_at(a, v->integral), .n = (size_t)a->patches.n_patches};
    const errors *part = s.part;
    double weights[CURVOPT_N_TERMS];
    memcpy(weights, a->weights, sizeof weights);
    s.weights.number[CURVOPT_SCALAR_AREA] += weights[CURVOPT_TERM_AREA]; /* a patch's own: the term is the whole's */
    weights[CURVOPT_TERM_AREA] = 0;
    s.weights.term = weights;
    co_ordered_sum_run(a->threads, s.n, sum_errors, &s);
    for (int k = 0; k < CO_ORDERED_SUM_CHUNKS; k++) {
        co_quadrature_error_join(&e.objective, &part[k].objective);
        co_quadrature_error_join(&e.area, &part[k].area);
        for (int t = 0; t < CURVOPT_N_TERMS; t++)
            co_quadrature_error_join(&e.term[t], &part[k].term[t]);
    }
    e.term[CURVOPT_TERM_AREA] = e.area;
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        if (co_functional_is_third_order(t) && isfinite(term[t])) {
            const double by_area = fabs(term[t]) * e.area.finest / v->integral[CO_INT_AREA];
            e.term[t].finest += by_area;
            e.objective.finest += a->weights[t] * by_area;
        }
    return e;
}

static double h2_of(const co_values *v) {
    return (v->integral[CO_INT_H2] + 2 * v->integral[CO_INT_K]) / 4;
}

/* Less of the bound than this is no error of rules that met a tolerance: the surface is folded between samples. */
static const double LEAST_PART = 0.9;

static int has_least_h2(const co_assembly *a, double h2) {
    return a->leaves_out || !(h2 < LEAST_PART * a->least_h2);
}

static void report_energies(const co_assembly *a, const co_values *v, int third, curvopt_energies *out) {
    double gauss = v->integral[CO_INT_K], unit = v->radius * v->radius;
    *out = (curvopt_energies){.objective = v->objective, .area = unit * v->integral[CO_INT_AREA], .gauss = gauss};
    co_functional_terms(v->integral, third, out->term);
    out->h2 = h2_of(v);
    out->volume = a->is_closed && !a->leaves_out ? unit * v->radius * v->integral[CO_INT_VOLUME] : (double)NAN;
    out->total_mean_curvature = v->radius * v->integral[CO_INT_MEAN];
    out->helfrich = 4 * out->h2;
    if (a->spontaneous.curvature != 0)
        out->helfrich += 4 / a->spontaneous.weight *
                         co_spontaneous_curvature_add(&a->spontaneous, a->radius, v->integral).added.value;
    out->gauss_bonnet_defect = a->leaves_out ? (double)NAN : co_assembly_defect(a, v);
    out->min_jacobian = v->min_jacobian;
    out->surface = a->surface;
    out->n_samples = a->batches.n_samples > INT32_MAX ? INT32_MAX : (int32_t)a->batches.n_samples;
    errors e = errors_of(a, v, out->term);
    out->objective_error = co_quadrature_error_claimed(&e.objective);
    out->area_error = unit * co_quadrature_error_claimed(&e.area);
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        out->term_error[t] = isnan(out->term[t]) ? (double)NAN : co_quadrature_error_claimed(&e.term[t]);
}

/* Makes the batches by a third rule, unless those that are there have the same patches. */
static int32_t update_finest(co_assembly *a, curvopt_error *error) {
    co_quadrature_estimates *e = &a->estimates;
    const size_t n = (size_t)a->patches.n_patches;
    const co_element_batches_spec spec = {.patches = &a->patches,
                                          .cache = a->cache,
                                          .lanes = a->kernel->lanes,
                                          .rule = a->rule,
                                          .only = e->in_finest,
                                          .step = 2};
    if (a->finest_batches.n_blocks && memcmp(e->in_finest, e->has_third_rule, n) == 0)
        return CURVOPT_OK;
    co_element_batches_free(&a->finest_batches);
    memcpy(e->in_finest, e->has_third_rule, n);
    return co_element_batches_create(&spec, &a->finest_batches, error);
}

/* Compares the rules one step finer with those two steps finer, where that tells most for its cost: an estimate is as
 * good as the finer of two rules, and two may miss the same fold. `area`: the whole one, by the former. */
static int32_t evaluate_third_rule(co_assembly *a, double area, int third, curvopt_error *error) {
    co_quadrature_estimates *e = &a->estimates;
    co_values values;
    divide_by_costs(a, &a->batches, &a->finer_batches);
    double threshold = threshold_of(a, is_refinable, a->tuning->quadrature_two_rules * e->sum);
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        e->has_third_rule[p] = is_refinable(a, p) && !(e->error_per_cost[p] < threshold);
    int32_t status = update_finest(a, error);
    if (status == CURVOPT_OK)
        status = co_assembly_evaluate_batches(a, &a->finest_batches, third, &values, error);
    if (status != CURVOPT_OK) {
        co_element_batches_free(&a->finest_batches);
        return status;
    }
    store_terms(a, &a->finest_batches, area, third, e->finest);
    co_quadrature_estimates_use_best_area(e, (size_t)a->patches.n_patches, area);
    return CURVOPT_OK;
}

/* --------------------------------------------------------------------------------------------- refinement -- */

/* One call of co_adaptive_quadrature_resolve(). */
typedef struct resolution {
    const double *xyz;              /* [3 n_cage] */
    const co_quadrature_goal *goal; /* the caller's */
    int third;                      /* third-order integrals are evaluated */
    co_values used, finer;          /* values by the present rules, and by those one step finer */
} resolution;

/* Evaluates by the present rules and by those one step finer; fills the estimates. */
static int32_t estimate(co_assembly *a, resolution *r, curvopt_error *error) {
    co_quadrature_estimates *e = &a->estimates;
    const co_request request = {.is_normalized = r->goal->is_normalized,
                                .all_terms = r->third,
                                .volume = a->is_closed && r->goal->terms != CO_TERMS_OBJECTIVE};
    double sum = 0;
    co_assembly_evaluate(a, r->xyz, &request, &r->used);
    store_terms(a, &a->batches, r->used.integral[CO_INT_AREA], r->third, e->used);
    int32_t status = co_adaptive_quadrature_evaluate_finer(a, r->third, &r->finer, error);
    if (status != CURVOPT_OK)
        return status;
    if (r->goal->evaluated)
        r->goal->evaluated(r->goal->user, &r->used);
    store_terms(a, &a->finer_batches, r->finer.integral[CO_INT_AREA], r->third, e->finer);
    compare_terms(a, r->goal->terms == CO_TERMS_ALL, e->finer, &r->finer);
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        sum += e->error[p];
    e->sum = sum;
    return CURVOPT_OK;
}

/* The result of the rules that were estimated last; a third rule where all terms are reported. */
static int32_t conclude(co_assembly *a, const resolution *r, curvopt_energies *energies, curvopt_error *error) {
    const co_quadrature_estimates *e = &a->estimates;
    int32_t status = CURVOPT_OK;
    memset(e->has_third_rule, 0, (size_t)a->patches.n_patches);
    if (r->goal->terms != CO_TERMS_OBJECTIVE && isfinite(e->sum) &&
        e->sum > a->tuning->quadrature_negligible * r->goal->tolerance)
        status = evaluate_third_rule(a, r->finer.integral[CO_INT_AREA], r->third, error);
    report_energies(a, &r->used, r->third, energies);
    return status;
}

int32_t co_adaptive_quadrature_resolve(co_assembly *a, const double *xyz, const co_quadrature_goal *goal,
                                       curvopt_energies *energies, int *resolved, int *changed, curvopt_error *error) {
    resolution r = {.xyz = xyz,
                    .goal = goal,
                    .third = a->functional.has_third || (goal->terms != CO_TERMS_OBJECTIVE && a->third_allowed)};
    double allowed = (a->met ? a->tuning->quadrature_hysteresis : 1) * goal->tolerance;
    *resolved = *changed = 0;
    int32_t status = co_quadrature_estimates_ensure(&a->estimates, (size_t)a->patches.n_patches, error);
    if (status == CURVOPT_OK && !a->batches.n_blocks) /* memory was out last time */
        status = co_assembly_update_batches(a, error);
    while (status == CURVOPT_OK) {
        status = estimate(a, &r, error);
        if (status != CURVOPT_OK)
            break;
        int meets = a->estimates.sum <= allowed;
        a->met |= meets;
        *resolved = a->estimates.sum <= fmax(allowed, CO_ACCEPTABLE_ERROR) &&
                    (isinf(goal->tolerance) || has_least_h2(a, h2_of(&r.used)));
        if (meets || !isfinite(r.used.objective) || refine_rules(a, goal->tolerance) == 0)
            return conclude(a, &r, energies, error);
        allowed = goal->tolerance;
        *changed = 1;
        status = co_assembly_update_batches(a, error);
    }
    return status;
}

void co_adaptive_quadrature_leave_unknown(curvopt_energies *e) {
    *e = (curvopt_energies){.objective = (double)NAN, .area = (double)NAN, .gauss = (double)NAN, .h2 = (double)NAN};
    e->gauss_bonnet_defect = e->min_jacobian = e->objective_error = e->area_error = (double)NAN;
    e->volume = e->total_mean_curvature = e->helfrich = (double)NAN;
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        e->term[t] = e->term_error[t] = (double)NAN;
}

void co_adaptive_quadrature_glance(co_assembly *a, const double *x, curvopt_energies *energies) {
    co_cancel *cancel = a->cancel;
    co_values values;
    co_adaptive_quadrature_leave_unknown(energies);
    if (!a->batches.n_blocks || !a->estimates.used)
        return;
    a->cancel = NULL;
    co_assembly_evaluate(a, x, &(co_request){.is_normalized = 1, .volume = 1}, &values);
    a->cancel = cancel;
    report_energies(a, &values, a->functional.has_third, energies);
}

/* --------------------------------------------------------------------------------------------- coarsening -- */

/* Blocks count the same however few patches they have. */
static double cost_of(const co_element_batches *l) {
    double cost = 0;
    for (int32_t b = 0; b < l->n_blocks; b++)
        cost += co_block_cost(&l->block[b]);
    return cost;
}

/* Lowers the rules of patches where the errors that this adds are least for what they save; takes it back if the cost
 * does not fall enough. spare [n_patches]: room for the rules as they are. */
static int32_t coarsen_rules(co_assembly *a, const co_element_batches *coarser, double tolerance, int8_t *spare,
                             int *changed, curvopt_error *error) {
    size_t n = (size_t)a->patches.n_patches;
    double before = cost_of(&a->batches);
    divide_by_costs(a, coarser, &a->batches);
    double threshold = threshold_of(a, is_coarsenable, a->tuning->quadrature_coarsened * tolerance - a->estimates.sum);
    memcpy(spare, a->rule, n);
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        if (is_coarsenable(a, p) && a->estimates.error_per_cost[p] < threshold)
            a->rule[p]--;
    int32_t status = co_assembly_update_batches(a, error);
    *changed = status == CURVOPT_OK && cost_of(&a->batches) <= a->tuning->quadrature_saving * before;
    if (status != CURVOPT_OK || *changed)
        return status;
    memcpy(a->rule, spare, n);
    return co_assembly_update_batches(a, error);
}

int32_t co_adaptive_quadrature_coarsen(co_assembly *a, double tolerance, int *changed, curvopt_error *error) {
    int third = a->functional.has_third;
    co_element_batches coarser;
    const co_element_batches_spec spec = {.patches = &a->patches,
                                          .cache = a->cache,
                                          .lanes = a->kernel->lanes,
                                          .rule = a->rule,
                                          .step = -1,
                                          .coarsest = a->coarsest};
    co_values values;
    *changed = 0;
    if (isinf(tolerance)) /* rules that nothing checks stay as they are */
        return CURVOPT_OK;
    int8_t *spare = CO_NEW(int8_t, a->patches.n_patches);
    if (!spare)
        return co_status_no_memory(error);
    int32_t status = co_element_batches_create(&spec, &coarser, error);
    if (status == CURVOPT_OK && cost_of(&coarser) <= a->tuning->quadrature_saving * cost_of(&a->batches)) {
        co_patch_terms *terms = a->estimates.finer; /* free for the coarser rule: its own values were compared before */
        status = co_assembly_evaluate_batches(a, &coarser, third, &values, error);
        if (status == CURVOPT_OK) {
            store_terms(a, &coarser, values.integral[CO_INT_AREA], third, terms);
            compare_terms(a, 0, terms, &values);
            status = coarsen_rules(a, &coarser, tolerance, spare, changed, error);
        }
    }
    co_element_batches_free(&coarser);
    free(spare);
    return status;
}

int32_t co_adaptive_quadrature_not_finite(const co_assembly *a, curvopt_error *error) {
    return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, a->worst_face,
                          "the energy is not finite: the surface is degenerate at face %d", a->worst_face);
}

int co_adaptive_quadrature_closes(const curvopt_energies *e) {
    return !(e->gauss_bonnet_defect > CO_LARGEST_DEFECT + CO_ACCEPTABLE_ERROR * e->term[CURVOPT_TERM_WILLMORE]);
}

int32_t co_adaptive_quadrature_check(const co_assembly *a, const curvopt_energies *e, curvopt_error *error) {
    double relative_area = e->area / (a->radius * a->radius);
    if (!(relative_area > CO_LEAST_AREA))
        return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, -1,
                              "the cage has zero area: its surface's is %g of its size squared", relative_area);
    if (!isfinite(e->objective))
        return co_adaptive_quadrature_not_finite(a, error);
    if (!co_adaptive_quadrature_closes(e))
        return co_status_fail(
            error, CURVOPT_ERROR_RESOLUTION, a->worst_face,
            "the surface cannot be resolved: its total curvature comes out %.3g off; it is folded flat "
            "or pinched, most of all at face %d",
            e->gauss_bonnet_defect, a->worst_face);
    if (!has_least_h2(a, e->h2))
        return co_status_fail(error, CURVOPT_ERROR_RESOLUTION, a->worst_face,
                              "the surface cannot be resolved: its integral of H^2 comes out %.3g, and no such surface "
                              "has less than %.4g; it is folded flat, most of all at face %d",
                              e->h2, a->least_h2, a->worst_face);
    return CURVOPT_OK;
}
