/* Quadrature fine enough for a wanted error. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/adaptive_quadrature.h"

#include "base/memory.h"
#include "base/ordered_sum.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rules at their finest may miss the wanted error, on `plane` most of all; up to this relative error a surface still
 * counts as resolved: far from where an optimizer could gain anything in the gap. */
static const double ACCEPTABLE = 1e-2;
static const double HYSTERESIS = 3;
/* Coarser rules may bring the error up to this share of the tolerance, and are taken where they bring the cost below
 * this share of what it was: values change, which an optimizer has to be told. */
static const double COARSENING = 0.5, WORTH = 0.8;
/* Faces that two rules alone are compared on are off by no more than this share of all errors together. */
static const double UNSEEN = 0.2;
/* Errors below this share of the tolerance, by two rules, are not worth a third: it costs more than both. */
static const double NEGLIGIBLE = 1e-2;
static const double ALIKE = 1 - 1e-6;     /* errors that differ by less are those of symmetric patches */
static const double SMALLEST_AREA = 1e-9; /* of the cage's size squared */

static void store_shares(const co_assembly *a, const co_element_batches *l, double area, int third,
                         co_patch_terms *out) {
#pragma omp parallel for schedule(static) num_threads(a->n_threads)
    for (int32_t b = 0; b < l->n_blocks; b++)
        for (int32_t lane = 0; lane < l->block[b].n_used; lane++) {
            double term[CURVOPT_MAX_TERMS], integral[CO_N_INTEGRALS];
            co_patch_terms *share = &out[l->patch[b * l->lanes + lane]];
            for (int i = 0; i < CO_N_INTEGRALS; i++)
                integral[i] = co_element_batches_sum(l, b, lane, i);
            share->area = integral[CO_INT_AREA];
            integral[CO_INT_AREA] = area;
            co_functional_terms(integral, third, term);
            memcpy(share->term, term, sizeof share->term);
        }
}

static co_quadrature_error_measure measure_of(const co_assembly *a, int every_term, const co_patch_terms *shares) {
    co_quadrature_error_measure m = {.weights = a->weights, .every_term = every_term};
    double sum[CO_ORDERED_SUM_CHUNKS][CURVOPT_N_TERMS];
    size_t n = (size_t)a->patches.n_patches;
#pragma omp parallel for schedule(static) num_threads(a->n_threads) if (n >= CO_ORDERED_SUM_WORTH_THREADS)
    for (int k = 0; k < CO_ORDERED_SUM_CHUNKS; k++) {
        memset(sum[k], 0, sizeof sum[k]);
        for (size_t p = co_ordered_sum_begin(n, k); p < co_ordered_sum_begin(n, k + 1); p++)
            for (int t = 0; t < CURVOPT_N_TERMS; t++)
                sum[k][t] += shares[p].term[t];
    }
    for (int k = 0; k < CO_ORDERED_SUM_CHUNKS; k++)
        for (int t = 0; t < CURVOPT_N_TERMS; t++)
            m.whole.term[t] += sum[k][t];
    return m;
}

/* Into a->patch_error, what the shares by two rules differ by, relative to the whole. */
static void compare_shares(co_assembly *a, int every_term) {
    co_quadrature_error_measure measure = measure_of(a, every_term, a->fine);
#pragma omp parallel for schedule(static) num_threads(a->n_threads)
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        a->patch_error[p] = co_quadrature_error_relative(&measure, &a->coarse[p], &a->fine[p]);
}

int32_t co_adaptive_quadrature_evaluate_finer(co_assembly *a, int third, co_values *values, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    if (!a->finer.n_blocks)
        status = co_element_batches_create(&a->patches, a->cache, a->kernel->lanes, a->rule, 1, 0, 0, &a->finer, error);
    if (status == CURVOPT_OK)
        status = co_assembly_evaluate_layout(a, &a->finer, third, values, error);
    if (status != CURVOPT_OK) {
        co_element_batches_free(&a->finer);
        return status;
    }
    return status;
}

/* Into a->price what each patch's error is worth: its size by what it costs to have a finer rule, or by what a coarser
 * one saves. */
static void price_errors(co_assembly *a, const co_element_batches *coarse, const co_element_batches *fine) {
    memset(a->price, 0, sizeof *a->price * (size_t)a->patches.n_patches);
    for (int side = 0; side < 2; side++) {
        const co_element_batches *l = side ? coarse : fine;
        for (int32_t b = 0; b < l->n_blocks; b++)
            for (int32_t lane = 0; lane < l->block[b].n_used; lane++)
                a->price[l->patch[b * l->lanes + lane]] += (side ? -1 : 1) * co_block_cost(&l->block[b]);
    }
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        a->price[p] = isnan(a->patch_error[p]) ? (double)INFINITY : a->patch_error[p] / a->price[p];
}

static int is_refinable(const co_assembly *a, int32_t p) {
    return a->rule[p] < CO_FINEST_RULE;
}

static int is_coarsenable(const co_assembly *a, int32_t p) {
    return a->rule[p] > 0;
}

static int compare_prices(const void *a, const void *b) {
    const double *x = a, *y = b;
    return (x[0] > y[0]) - (x[0] < y[0]);
}

/* Of the patches that `counts`, those priced below the result are off by no more than `bearable` together; like patches
 * are treated alike. INFINITY: that is all of them. */
static double marking_threshold(const co_assembly *a, int (*counts)(const co_assembly *, int32_t), double bearable) {
    int32_t n = 0, kept = 0;
    double sum = 0, *sorted = a->sorted;
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        if (counts(a, p)) {
            sorted[2 * n] = a->price[p];
            sorted[2 * n++ + 1] = a->patch_error[p];
        }
    qsort(sorted, (size_t)n, 2 * sizeof *sorted, compare_prices);
    while (kept < n && sum + sorted[2 * kept + 1] <= bearable)
        sum += sorted[2 * kept++ + 1];
    return kept == n ? (double)INFINITY : sorted[2 * kept] * ALIKE;
}

/* Raises the rules of the patches where that brings most for its cost, so that those that keep theirs are off by no
 * more than half of the tolerance together; returns how many were raised. */
static int32_t refine_rules(co_assembly *a, double tolerance) {
    int32_t raised = 0;
    price_errors(a, &a->layout, &a->finer);
    double cut = marking_threshold(a, is_refinable, 0.5 * tolerance);
    for (int32_t p = 0; cut < INFINITY && p < a->patches.n_patches; p++)
        if (is_refinable(a, p) && !(a->price[p] < cut)) {
            a->rule[p]++;
            raised++;
        }
    return raised;
}

/* What is known of patch p's error: the share by its rule, by the finest one that it was held against, and by the one
 * before that. */
typedef struct shares {
    const co_patch_terms *used, *finest, *before;
} shares;

static shares shares_of(const co_assembly *a, size_t p) {
    int looked = a->looked[p];
    return (shares){.used = &a->coarse[p],
                    .finest = looked ? &a->finest[p] : &a->fine[p],
                    .before = looked ? &a->fine[p] : &a->coarse[p]};
}

/* What an evaluation is off. */
typedef struct errors {
    co_quadrature_error objective, area, term[CURVOPT_N_TERMS];
} errors;

/* Patches begin .. end - 1. */
static errors errors_of_patches(const co_assembly *a, size_t begin, size_t end) {
    errors e = {0};
    for (size_t p = begin; p < end; p++) {
        shares s = shares_of(a, p);
        co_quadrature_error_add(&e.objective, co_quadrature_error_difference(a->weights, s.used, s.finest),
                                co_quadrature_error_difference(a->weights, s.before, s.finest));
        co_quadrature_error_add(&e.area, s.used->area - s.finest->area, s.before->area - s.finest->area);
        for (int t = 0; t < CURVOPT_N_TERMS; t++)
            co_quadrature_error_add(&e.term[t], s.used->term[t] - s.finest->term[t],
                                    s.before->term[t] - s.finest->term[t]);
    }
    return e;
}

static errors errors_of(const co_assembly *a) {
    errors part[CO_ORDERED_SUM_CHUNKS], e = {0};
    size_t n = (size_t)a->patches.n_patches;
#pragma omp parallel for schedule(static) num_threads(a->n_threads) if (n >= CO_ORDERED_SUM_WORTH_THREADS)
    for (int k = 0; k < CO_ORDERED_SUM_CHUNKS; k++)
        part[k] = errors_of_patches(a, co_ordered_sum_begin(n, k), co_ordered_sum_begin(n, k + 1));
    for (int k = 0; k < CO_ORDERED_SUM_CHUNKS; k++) {
        co_quadrature_error_join(&e.objective, &part[k].objective);
        co_quadrature_error_join(&e.area, &part[k].area);
        for (int t = 0; t < CURVOPT_N_TERMS; t++)
            co_quadrature_error_join(&e.term[t], &part[k].term[t]);
    }
    return e;
}

static void report_energies(const co_assembly *a, const co_values *v, int third, curvopt_energies *out) {
    double gauss = v->integral[CO_INT_K], unit = v->radius * v->radius;
    *out = (curvopt_energies){.objective = v->objective, .area = unit * v->integral[CO_INT_AREA], .gauss = gauss};
    co_functional_terms(v->integral, third, out->term);
    out->h2 = (v->integral[CO_INT_H2] + 2 * gauss) / 4;
    out->gauss_bonnet_defect = co_assembly_defect(a, v);
    out->min_jacobian = v->min_jacobian;
    out->surface = a->surface;
    out->n_samples = a->layout.n_samples > INT32_MAX ? INT32_MAX : (int32_t)a->layout.n_samples;
    errors e = errors_of(a);
    out->objective_error = co_quadrature_error_claimed(&e.objective);
    out->area_error = unit * co_quadrature_error_claimed(&e.area);
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        out->term_error[t] = isnan(out->term[t]) ? (double)NAN : co_quadrature_error_claimed(&e.term[t]);
}

/* Holds the rules one step finer against those two steps finer, where that tells most for its cost: an estimate is as
 * good as the finer of two rules, and two may miss the same fold. area: the whole one, by the former */
static int32_t look_closer(co_assembly *a, double area, int third, curvopt_error *error) {
    co_element_batches closer;
    co_values values;
    uint8_t *rule = CO_NEW(uint8_t, a->patches.n_patches);
    if (!rule)
        return co_status_no_memory(error);
    price_errors(a, &a->layout, &a->finer);
    double cut = marking_threshold(a, is_refinable, UNSEEN * a->error);
    for (int32_t p = 0; p < a->patches.n_patches; p++) {
        a->looked[p] = is_refinable(a, p) && !(a->price[p] < cut);
        rule[p] = (uint8_t)(a->rule[p] + 2 * a->looked[p]);
    }
    int32_t status = co_element_batches_create(&a->patches, a->cache, a->kernel->lanes, rule, 0, 0, 0, &closer, error);
    if (status == CURVOPT_OK)
        status = co_assembly_evaluate_layout(a, &closer, third, &values, error);
    if (status == CURVOPT_OK)
        store_shares(a, &closer, area, third, a->finest);
    co_element_batches_free(&closer);
    free(rule);
    return status;
}

/* Room for what is known by patch, once. */
static int32_t ensure_shares(co_assembly *a, curvopt_error *error) {
    size_t n = (size_t)a->patches.n_patches;
    if (!a->coarse)
        a->coarse = CO_NEW(co_patch_terms, n);
    if (!a->fine)
        a->fine = CO_NEW(co_patch_terms, n);
    if (!a->finest)
        a->finest = CO_NEW(co_patch_terms, n);
    if (!a->looked)
        a->looked = CO_NEW(uint8_t, n);
    if (!a->patch_error)
        a->patch_error = CO_NEW(double, n);
    if (!a->price)
        a->price = CO_NEW(double, n);
    if (!a->sorted)
        a->sorted = CO_NEW(double, 2 * n);
    int all = a->coarse && a->fine && a->finest && a->looked && a->patch_error && a->price && a->sorted;
    return all ? CURVOPT_OK : co_status_no_memory(error);
}

int32_t co_adaptive_quadrature_resolve(co_assembly *a, const double *xyz, const co_quadrature_goal *goal,
                                       curvopt_energies *energies, int *resolved, int *changed, curvopt_error *error) {
    const double tolerance = goal->tolerance;
    const co_terms terms = goal->terms;
    size_t n = (size_t)a->patches.n_patches;
    int third = a->functional.has_third || (terms != CO_TERMS_OBJECTIVE && a->third_allowed);
    double bearable = a->met ? HYSTERESIS * tolerance : tolerance;
    *resolved = *changed = 0;
    int32_t status = ensure_shares(a, error);
    if (status == CURVOPT_OK && !a->layout.n_blocks) /* memory was out last time */
        status = co_assembly_update_batches(a, error);
    while (status == CURVOPT_OK) {
        co_request request = {.is_normalized = goal->is_normalized, .all_terms = third};
        co_values values, finer;
        double difference = 0;
        co_assembly_evaluate(a, xyz, &request, &values);
        store_shares(a, &a->layout, values.integral[CO_INT_AREA], third, a->coarse);
        status = co_adaptive_quadrature_evaluate_finer(a, third, &finer, error);
        if (status != CURVOPT_OK)
            break;
        store_shares(a, &a->finer, finer.integral[CO_INT_AREA], third, a->fine);
        compare_shares(a, terms == CO_TERMS_ALL);
        for (size_t p = 0; p < n; p++)
            difference += a->patch_error[p];
        a->error = difference;
        *resolved = difference <= fmax(bearable, ACCEPTABLE);
        a->met |= difference <= bearable;
        if (difference <= bearable || !isfinite(values.objective) || refine_rules(a, tolerance) == 0) {
            memset(a->looked, 0, n);
            if (terms != CO_TERMS_OBJECTIVE && isfinite(difference) && difference > NEGLIGIBLE * tolerance)
                status = look_closer(a, finer.integral[CO_INT_AREA], third, error);
            report_energies(a, &values, third, energies);
            break;
        }
        bearable = tolerance;
        *changed = 1;
        status = co_assembly_update_batches(a, error);
    }
    return status;
}

/* Blocks cost the same however many of their lanes are in use. */
static double cost_of(const co_element_batches *l) {
    double cost = 0;
    for (int32_t b = 0; b < l->n_blocks; b++)
        cost += co_block_cost(&l->block[b]);
    return cost;
}

/* Lowers the rules of patches where the errors that this adds are least for what they save; renews the layout if it was
 * worth it. spare: room for the rules as they are */
static int32_t coarsen_rules(co_assembly *a, const co_element_batches *coarser, double tolerance, uint8_t *spare,
                             int *changed, curvopt_error *error) {
    size_t n = (size_t)a->patches.n_patches;
    double before = cost_of(&a->layout);
    price_errors(a, coarser, &a->layout);
    double cut = marking_threshold(a, is_coarsenable, COARSENING * tolerance - a->error);
    memcpy(spare, a->rule, n);
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        if (is_coarsenable(a, p) && a->price[p] < cut)
            a->rule[p]--;
    int32_t status = co_assembly_update_batches(a, error);
    *changed = status == CURVOPT_OK && cost_of(&a->layout) <= WORTH * before;
    if (status != CURVOPT_OK || *changed)
        return status;
    memcpy(a->rule, spare, n);
    return co_assembly_update_batches(a, error);
}

int32_t co_adaptive_quadrature_coarsen(co_assembly *a, double tolerance, int *changed, curvopt_error *error) {
    size_t n = (size_t)a->patches.n_patches;
    int third = a->functional.has_third;
    co_element_batches coarser;
    co_values values;
    *changed = 0;
    if (isinf(tolerance)) /* rules that nothing checks stay as they are */
        return CURVOPT_OK;
    uint8_t *spare = CO_NEW(uint8_t, n);
    if (!spare)
        return co_status_no_memory(error);
    int32_t status =
        co_element_batches_create(&a->patches, a->cache, a->kernel->lanes, a->rule, -1, 0, 0, &coarser, error);
    if (status == CURVOPT_OK && cost_of(&coarser) <= WORTH * cost_of(&a->layout)) {
        status = co_assembly_evaluate_layout(a, &coarser, third, &values, error);
        if (status == CURVOPT_OK) {
            store_shares(a, &coarser, values.integral[CO_INT_AREA], third, a->fine);
            compare_shares(a, 0);
            status = coarsen_rules(a, &coarser, tolerance, spare, changed, error);
        }
    }
    co_element_batches_free(&coarser);
    free(spare);
    return status;
}

int32_t co_adaptive_quadrature_check(const co_assembly *a, const curvopt_energies *e, curvopt_error *error) {
    double relative_area = e->area / (a->radius * a->radius);
    if (!(relative_area > SMALLEST_AREA))
        return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, -1,
                              "the cage has zero area: its surface's is %g of its size squared", relative_area);
    if (!isfinite(e->objective))
        return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, a->worst_face,
                              "the energy is not finite: the surface is degenerate at face %d", a->worst_face);
    if (e->gauss_bonnet_defect > 1 + ACCEPTABLE * e->term[CURVOPT_TERM_WILLMORE])
        return co_status_fail(
            error, CURVOPT_ERROR_RESOLUTION, a->worst_face,
            "the surface cannot be resolved: its total curvature comes out %.3g off; it is folded flat "
            "or pinched, most of all at face %d",
            e->gauss_bonnet_defect, a->worst_face);
    return CURVOPT_OK;
}
