/* Sums over faces: a surface's energies and their gradients. SPDX-License-Identifier: GPL-3.0-or-later */
#include "assemble.h"

#include "carry.h"
#include "memory.h"
#include "placement.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

/* Rule of every face at first; and of the report's settings, which never refine. */
/* Rules at their finest may miss the wanted error, on `plane` most of all; up to this relative error a surface still
 * counts as resolved: far from where an optimizer could gain anything in the gap. */
static const double ACCEPTABLE = 1e-2;
static const double HYSTERESIS = 3;
static const double ALIKE = 1 - 1e-6;     /* errors that differ by less are those of symmetric patches */
static const double SMALLEST_AREA = 1e-9; /* of the cage's size squared */
enum { FIRST_RULE = 0, REPORT_RULE = 1 };

static int needs_area_gradient(const co_assembly *a) {
    return a->functional.has_third;
}

static int32_t ensure_work(co_assembly *a, const co_layout *l, curvopt_error *error) {
    size_t stride = 9 * (size_t)l->max_points * (size_t)l->lanes;
    if (stride <= a->work_stride)
        return CURVOPT_OK;
    free(a->work);
    a->work_stride = 0;
    a->work = CO_NEW_ALIGNED(double, stride *(size_t)a->n_threads);
    if (!a->work)
        return co_status_no_memory(error);
    a->work_stride = stride;
    return CURVOPT_OK;
}

/* The layout that goes with the present rules; empty on failure. */
static int32_t renew_layout(co_assembly *a, curvopt_error *error) {
    co_layout_free(&a->layout);
    co_layout_free(&a->finer);
    a->rules_version++;
    int32_t status = co_layout_create(&a->patches, a->cache, a->kernel->lanes, a->rule, 0, 1, needs_area_gradient(a),
                                      &a->layout, error);
    if (status == CURVOPT_OK)
        status = ensure_work(a, &a->layout, error);
    if (status != CURVOPT_OK)
        co_layout_free(&a->layout);
    return status;
}

/* Rules at first, and weights by faces. */
static int32_t start_rules(co_assembly *a, int first_rule, const double *face_weight, curvopt_error *error) {
    a->rule = CO_NEW(uint8_t, a->patches.n_patches);
    a->weight = face_weight ? CO_NEW(double, a->patches.n_patches) : NULL;
    if (!a->rule || (face_weight && !a->weight))
        return co_status_no_memory(error);
    memset(a->rule, first_rule, (size_t)a->patches.n_patches);
    for (int32_t p = 0; a->weight && p < a->patches.n_patches; p++) {
        a->weight[p] = face_weight[a->patches.place[p].face];
        if (a->weight[p] == 0)
            a->rule[p] = CO_LAYOUT_SKIP;
    }
    return CURVOPT_OK;
}

/* Points that patches with a weight are made of; and of derived points, the cage's vertices behind them. */
static int32_t find_active(co_assembly *a, curvopt_error *error) {
    const co_patches *patches = &a->patches;
    int32_t n_points = patches->n_points;
    uint8_t *used = CO_NEW(uint8_t, n_points);
    a->active = CO_NEW(int32_t, n_points);
    if (!used || !a->active) {
        free(used);
        return co_status_no_memory(error);
    }
    for (int32_t p = 0; p < patches->n_patches; p++)
        for (size_t i = patches->start[p]; a->weight[p] > 0 && i < patches->start[p + 1]; i++)
            used[patches->points[i]] = 1;
    for (int32_t p = n_points - 1; p >= patches->n_cage; p--) { /* all derived points are computed, used or not */
        size_t row = (size_t)(p - patches->n_cage);
        for (size_t e = patches->derived.start[row]; e < patches->derived.start[row + 1]; e++)
            used[patches->derived.column[e]] = 1;
    }
    for (int32_t p = 0; p < n_points; p++) {
        if (used[p])
            a->active[a->n_active++] = p;
        a->n_active_cage += p < patches->n_cage && used[p];
    }
    free(used);
    return CURVOPT_OK;
}

int32_t co_assembly_create(const curvopt_mesh *mesh, const curvopt_options *options, co_table_cache *tables,
                           const double *face_weight, co_assembly *a, curvopt_error *error) {
    *a = (co_assembly){.surface = options->surface};
    a->functional = co_functional_of_weights(options->weights);
    memcpy(a->weights, options->weights, sizeof a->weights);
    a->kernel = co_sweep_select(NULL);
    a->n_threads = options->threads > 0 ? options->threads : omp_get_max_threads();
    int32_t status = co_patches_create(mesh, &a->patches, error);
    if (status != CURVOPT_OK)
        return status;
    status = co_carry_check(mesh, &a->patches, &a->functional, a->surface, &a->third_allowed, error);
    if (status == CURVOPT_OK)
        status = co_rim_create(mesh, &a->patches, &a->rim, error);
    co_table_cache_create(a->surface, &a->own_cache);
    a->cache = tables ? tables : &a->own_cache;
    if (status == CURVOPT_OK) {
        a->points = CO_NEW(double, 3 * (size_t)a->patches.n_points);
        a->point_gradient = CO_NEW(double, 3 * (size_t)a->patches.n_points);
        if (!a->points || !a->point_gradient)
            status = co_status_no_memory(error);
    }
    if (status == CURVOPT_OK)
        status = start_rules(a, options->as_report ? REPORT_RULE : FIRST_RULE, face_weight, error);
    if (status == CURVOPT_OK && a->weight)
        status = find_active(a, error);
    if (status == CURVOPT_OK)
        status = renew_layout(a, error);
    if (status != CURVOPT_OK)
        co_assembly_free(a);
    return status;
}

void co_assembly_free(co_assembly *a) {
    co_patches_free(&a->patches);
    co_rim_free(&a->rim);
    co_table_cache_free(&a->own_cache);
    co_layout_free(&a->layout);
    co_layout_free(&a->finer);
    free(a->rule);
    free(a->weight);
    free(a->active);
    free(a->points);
    free(a->point_gradient);
    free(a->work);
    free(a->coarse);
    free(a->fine);
    free(a->patch_error);
    *a = (co_assembly){0};
}

int32_t co_assembly_copy_rules(co_assembly *a, const co_assembly *from, curvopt_error *error) {
    memcpy(a->rule, from->rule, (size_t)a->patches.n_patches);
    a->met = from->met;
    return renew_layout(a, error);
}

/* a->points from xyz: the cage's, normalized, and what is derived from them. The radius that was divided by. */
static double normalize(co_assembly *a, const double *xyz) {
    size_t n = (size_t)a->patches.n_cage;
    double radius = 1;
    if (a->frame_held && a->active) {
        for (int32_t i = 0; i < a->n_active_cage; i++)
            memcpy(a->points + 3 * (size_t)a->active[i], xyz + 3 * (size_t)a->active[i], 3 * sizeof *xyz);
    } else if (a->frame_held) {
        memcpy(a->points, xyz, 3 * n * sizeof *xyz);
    } else {
        double centroid[3];
        radius = co_placement_frame(n, xyz, centroid);
        const double unit = 1 / radius;
#pragma omp parallel for schedule(static) num_threads(a->n_threads)
        for (size_t v = 0; v < n; v++)
            for (size_t c = 0; c < 3; c++)
                a->points[3 * v + c] = (xyz[3 * v + c] - centroid[c]) * unit;
    }
    if (a->patches.derived.n_rows)
        co_rows_apply(&a->patches.derived, a->points, a->points + 3 * n);
    return radius;
}

/* Gradient with respect to positions from that with respect to normalized ones: what would change centroid and radius
 * drops out, the rest scales. */
static void gradient_of_normalized(const co_assembly *a, double radius, double *gradient) {
    size_t n = (size_t)a->patches.n_cage;
    const double part = 1 / (double)n, unit = 1 / radius;
    double mean[3] = {0, 0, 0}, along[3] = {0, 0, 0};
    for (size_t v = 0; v < n; v++)
        for (size_t c = 0; c < 3; c++) {
            mean[c] += part * gradient[3 * v + c];
            along[c] += part * gradient[3 * v + c] * a->points[3 * v + c];
        }
    const double radial = along[0] + along[1] + along[2];
#pragma omp parallel for schedule(static) num_threads(a->n_threads)
    for (size_t v = 0; v < n; v++)
        for (size_t c = 0; c < 3; c++)
            gradient[3 * v + c] = (gradient[3 * v + c] - mean[c] - radial * a->points[3 * v + c]) * unit;
}

/* What a block found, times the weights of its patches. */
static void weigh_block(const co_assembly *a, const co_layout *l, int32_t b, int gradient, int area) {
    const co_block *block = &l->block[b];
    size_t lanes = (size_t)l->lanes, n = gradient ? 3 * (size_t)block->table->n_points * (size_t)(1 + area) : 0;
    for (size_t lane = 0; lane < (size_t)block->n_used; lane++) {
        double weight = a->weight[l->patch[(size_t)b * lanes + lane]];
        double *sum = l->sums + (size_t)b * CO_N_SUMS * lanes + lane;
        for (size_t i = 0; i < CO_N_INTEGRALS; i++)
            sum[i * lanes] *= weight;
        for (size_t i = 0; i < n; i++)
            l->gradients[block->gradient + i * lanes + lane] *= weight;
    }
}

/* All blocks of a layout; `integrand` is what gradients are of. */
static void run_blocks(co_assembly *a, const co_layout *l, const co_integrand *integrand, int third, int gradient) {
    int area = gradient && needs_area_gradient(a);
#pragma omp parallel for schedule(dynamic, 4) num_threads(a->n_threads)
    for (int32_t b = 0; b < l->n_blocks; b++) {
        const co_block *block = &l->block[b];
        co_sweep sweep = {.table = block->table,
                          .points = l->points + block->points,
                          .xyz = a->points,
                          .eps4 = CO_UMBILIC * CO_UMBILIC * CO_UMBILIC * CO_UMBILIC,
                          .integrand = *integrand,
                          .third = third,
                          .gradient = gradient,
                          .area_gradient = area,
                          .sums = l->sums + (size_t)b * CO_N_SUMS * (size_t)l->lanes,
                          .gradients = gradient ? l->gradients + block->gradient : NULL,
                          .work = a->work + (size_t)omp_get_thread_num() * a->work_stride};
        a->kernel->run(&sweep);
        if (a->weight)
            weigh_block(a, l, b, gradient, area);
    }
}

static double patch_sum(const co_layout *l, int32_t b, int32_t lane, int which) {
    return l->sums[((size_t)b * CO_N_SUMS + (size_t)which) * (size_t)l->lanes + (size_t)lane];
}

static void total(const co_assembly *a, const co_layout *l, co_values *out) {
    *out = (co_values){.min_jacobian = INFINITY, .worst_face = -1};
    for (int32_t b = 0; b < l->n_blocks; b++)
        for (int32_t lane = 0; lane < l->block[b].n_used; lane++) {
            for (int i = 0; i < CO_N_INTEGRALS; i++)
                out->integral[i] += patch_sum(l, b, lane, i);
            double jacobian = patch_sum(l, b, lane, CO_SUM_MIN_JACOBIAN) / patch_sum(l, b, lane, CO_SUM_MEAN_JACOBIAN);
            if (!isnan(out->min_jacobian) && !(jacobian >= out->min_jacobian)) {
                out->min_jacobian = jacobian;
                out->worst_face = a->patches.place[l->patch[b * l->lanes + lane]].face;
            }
        }
    out->objective = co_functional_value(&a->functional, out->integral);
}

/* Adds up each point's shares, factor * integrand's + area_factor * area's, and takes derived points' to the cage. */
static void collect_gradient(co_assembly *a, double factor, double area_factor, double *gradient) {
    const co_layout *l = &a->layout;
    size_t lanes = (size_t)l->lanes;
    int area = needs_area_gradient(a);
    int32_t n = a->active ? a->n_active : a->patches.n_points;
#pragma omp parallel for schedule(static) num_threads(a->n_threads)
    for (int32_t i = 0; i < n; i++) {
        int32_t p = a->active ? a->active[i] : i;
        double sum[3] = {0, 0, 0};
        for (size_t e = l->incident_start[p]; e < l->incident_start[p + 1]; e++) {
            const double *share = l->gradients + l->incident[e];
            for (size_t c = 0; c < 3; c++) {
                sum[c] += factor * share[c * lanes];
                if (area)
                    sum[c] += area_factor * share[(3 + c) * lanes];
            }
        }
        memcpy(a->point_gradient + 3 * (size_t)p, sum, sizeof sum);
    }
    for (int32_t i = 0; a->active && i < a->n_active_cage; i++)
        memcpy(gradient + 3 * (size_t)a->active[i], a->point_gradient + 3 * (size_t)a->active[i], 3 * sizeof *gradient);
    if (!a->active)
        memcpy(gradient, a->point_gradient, sizeof(double) * 3 * (size_t)a->patches.n_cage);
    if (a->patches.derived.n_rows)
        co_rows_add_transposed(&a->patches.derived, a->point_gradient + 3 * (size_t)a->patches.n_cage, gradient);
}

void co_assembly_evaluate(co_assembly *a, const double *xyz, const co_request *request, co_values *out) {
    const co_functional *f = &a->functional;
    int third = f->has_third || (request->all_terms && a->third_allowed);
    co_integrand integrand = f->has_third ? f->third : f->second;
    double factor = 1, area_factor = 0;
    double radius = a->radius = normalize(a, xyz);
    if (request->gradient && f->has_third && f->has_second) { /* second + A third: the sweep must know A */
        run_blocks(a, &a->layout, &f->second, 0, 0);
        total(a, &a->layout, out);
        integrand = f->second;
        co_integrand_add(&integrand, out->integral[CO_INT_AREA], &f->third);
    }
    run_blocks(a, &a->layout, &integrand, third, request->gradient != NULL);
    total(a, &a->layout, out);
    out->radius = radius;
    a->worst_face = out->worst_face;
    if (!request->gradient)
        return;
    if (f->has_third) {
        area_factor = f->third.f1 * out->integral[CO_INT_F1] + f->third.f3 * out->integral[CO_INT_F3] +
                      f->third.x * out->integral[CO_INT_X];
        factor = f->has_second ? 1 : out->integral[CO_INT_AREA];
    }
    collect_gradient(a, factor, area_factor, request->gradient);
    if (!a->frame_held)
        gradient_of_normalized(a, radius, request->gradient);
}

void co_assembly_factor_gradients(co_assembly *a, const double *xyz, double *area, double *third) {
    normalize(a, xyz);
    run_blocks(a, &a->layout, &a->functional.third, 1, 1);
    collect_gradient(a, 0, 1, area);
    collect_gradient(a, 1, 0, third);
}

static void store_shares(const co_assembly *a, const co_layout *l, double area, int third, co_share *out) {
#pragma omp parallel for schedule(static) num_threads(a->n_threads)
    for (int32_t b = 0; b < l->n_blocks; b++)
        for (int32_t lane = 0; lane < l->block[b].n_used; lane++) {
            double term[8], integral[CO_N_INTEGRALS];
            co_share *share = &out[l->patch[b * l->lanes + lane]];
            for (int i = 0; i < CO_N_INTEGRALS; i++)
                integral[i] = patch_sum(l, b, lane, i);
            share->area = integral[CO_INT_AREA];
            integral[CO_INT_AREA] = area;
            co_functional_terms(integral, third, term);
            memcpy(share->term, term, sizeof share->term);
        }
}

static co_share_measure measure_of(const co_assembly *a, int every_term, const co_share *shares) {
    co_share_measure m = {.weights = a->weights, .every_term = every_term};
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        for (int t = 0; t < CURVOPT_N_TERMS; t++)
            m.whole.term[t] += shares[p].term[t];
    return m;
}

/* Values of the rules one step finer; by patch into a->fine. */
static int32_t evaluate_finer(co_assembly *a, int third, co_values *values, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    if (!a->finer.n_blocks) {
        status = co_layout_create(&a->patches, a->cache, a->kernel->lanes, a->rule, 1, 0, 0, &a->finer, error);
        if (status == CURVOPT_OK)
            status = ensure_work(a, &a->finer, error);
        if (status != CURVOPT_OK) {
            co_layout_free(&a->finer);
            return status;
        }
    }
    run_blocks(a, &a->finer, &a->functional.second, third, 0);
    total(a, &a->finer, values);
    store_shares(a, &a->finer, values->integral[CO_INT_AREA], third, a->fine);
    return status;
}

double co_assembly_defect(const co_assembly *a, const co_values *values) {
    return fabs(values->integral[CO_INT_K] + co_rim_turning(&a->rim, &a->patches, a->points) - a->rim.target);
}

static void report_energies(const co_assembly *a, const co_values *v, int third, curvopt_energies *out) {
    const co_share *coarse = a->coarse, *fine = a->fine;
    double gauss = v->integral[CO_INT_K], unit = v->radius * v->radius;
    *out = (curvopt_energies){.objective = v->objective, .area = unit * v->integral[CO_INT_AREA], .gauss = gauss};
    co_functional_terms(v->integral, third, out->term);
    out->h2 = (v->integral[CO_INT_H2] + 2 * gauss) / 4;
    out->gauss_bonnet_defect = co_assembly_defect(a, v);
    out->min_jacobian = v->min_jacobian;
    out->surface = a->surface;
    out->n_samples = a->layout.n_samples > INT32_MAX ? INT32_MAX : (int32_t)a->layout.n_samples;
    for (int t = 0; t < 8; t++)
        out->term_error[t] = isnan(out->term[t]) ? (double)NAN : 0;
    co_error_sum objective = {0, 0}, area = {0, 0}, term[CURVOPT_N_TERMS] = {{0, 0}};
    for (int32_t p = 0; p < a->patches.n_patches; p++) {
        co_error_add(&objective, co_share_difference(a->weights, &coarse[p], &fine[p]));
        co_error_add(&area, unit * (coarse[p].area - fine[p].area));
        for (int t = 0; t < CURVOPT_N_TERMS; t++)
            co_error_add(&term[t], coarse[p].term[t] - fine[p].term[t]);
    }
    out->objective_error = co_error_claimed(&objective);
    out->area_error = co_error_claimed(&area);
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        out->term_error[t] += co_error_claimed(&term[t]);
}

static int compare_reals(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int is_refinable(const co_assembly *a, int32_t p) {
    return a->rule[p] != CO_LAYOUT_SKIP && a->rule[p] + 2 < CO_N_RULES;
}

/* Raises the rules of the patches with the largest errors, so that those that keep theirs are off by no more than half
 * of the tolerance together; returns how many were raised. sorted [n_patches] is work space. */
static int32_t refine_rules(co_assembly *a, const double *error, double tolerance, double *sorted) {
    int32_t n = 0, kept = 0, raised = 0;
    double sum = 0;
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        if (is_refinable(a, p))
            sorted[n++] = isnan(error[p]) ? INFINITY : error[p];
    qsort(sorted, (size_t)n, sizeof *sorted, compare_reals);
    while (kept < n && sum + sorted[kept] <= 0.5 * tolerance)
        sum += sorted[kept++];
    if (kept == n)
        return 0;
    double cut = sorted[kept] * ALIKE; /* like patches are treated alike */
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        if (is_refinable(a, p) && !(error[p] < cut)) {
            a->rule[p]++;
            raised++;
        }
    return raised;
}

/* Room for what is known by patch, once. */
static int32_t ensure_shares(co_assembly *a, curvopt_error *error) {
    size_t n = (size_t)a->patches.n_patches;
    if (!a->coarse)
        a->coarse = CO_NEW(co_share, n);
    if (!a->fine)
        a->fine = CO_NEW(co_share, n);
    if (!a->patch_error)
        a->patch_error = CO_NEW(double, 2 * n);
    return a->coarse && a->fine && a->patch_error ? CURVOPT_OK : co_status_no_memory(error);
}

int32_t co_assembly_resolve(co_assembly *a, const double *xyz, double tolerance, co_terms terms,
                            curvopt_energies *energies, int *resolved, int *changed, curvopt_error *error) {
    size_t n = (size_t)a->patches.n_patches;
    int third = a->functional.has_third || (terms != CO_TERMS_OBJECTIVE && a->third_allowed);
    double bearable = a->met ? HYSTERESIS * tolerance : tolerance;
    *resolved = *changed = 0;
    int32_t status = ensure_shares(a, error);
    if (status == CURVOPT_OK && !a->layout.n_blocks) /* memory was out last time */
        status = renew_layout(a, error);
    while (status == CURVOPT_OK) {
        co_request request = {.all_terms = third};
        co_values values, finer;
        double difference = 0;
        co_assembly_evaluate(a, xyz, &request, &values);
        store_shares(a, &a->layout, values.integral[CO_INT_AREA], third, a->coarse);
        status = evaluate_finer(a, third, &finer, error);
        if (status != CURVOPT_OK)
            break;
        co_share_measure measure = measure_of(a, terms == CO_TERMS_ALL, a->fine);
#pragma omp parallel for schedule(static) num_threads(a->n_threads)
        for (size_t p = 0; p < n; p++)
            a->patch_error[p] = co_share_relative(&measure, &a->coarse[p], &a->fine[p]);
        for (size_t p = 0; p < n; p++)
            difference += a->patch_error[p];
        *resolved = difference <= fmax(bearable, ACCEPTABLE);
        a->met |= difference <= bearable;
        if (difference <= bearable || !isfinite(values.objective) ||
            refine_rules(a, a->patch_error, tolerance, a->patch_error + n) == 0) {
            report_energies(a, &values, third, energies);
            break;
        }
        bearable = tolerance;
        *changed = 1;
        status = renew_layout(a, error);
    }
    return status;
}

int32_t co_assembly_check_energies(const co_assembly *a, const curvopt_energies *e, curvopt_error *error) {
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
