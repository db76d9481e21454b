/* A surface in patches, their rules, and the points that they are made of. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/assembly.h"

#include "base/constants.h"
#include "base/memory.h"
#include "energy/admissibility.h"

#include <stdlib.h>
#include <string.h>

/* Rule of every face at first, and of the fixed settings of Joshi and Sequin's report, which never refine. */
enum { FIRST_RULE = 0, REPORT_RULE = 1 };

int32_t co_assembly_ensure_work(co_assembly *a, const co_element_batches *l, curvopt_error *error) {
    size_t stride = co_element_batches_kernel_work(l) + l->batch_size;
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

int32_t co_assembly_update_batches(co_assembly *a, curvopt_error *error) {
    co_element_batches_spec spec = {.patches = &a->patches,
                                    .cache = a->cache,
                                    .lanes = a->kernel->lanes,
                                    .rule = a->rule,
                                    .coarsest = a->coarsest,
                                    .gradients = 1 + a->functional.has_third};
    int32_t status = co_element_batches_make_tables(&spec, error);
    if (status == CO_CANCELLED) /* the result is evaluated by the batches of before */
        return status;
    if (status == CURVOPT_OK && a->batches.n_known)
        status = co_known_sums_keep(&a->known, 0, a->patches.n_patches, &a->batches, a->placement, error);
    if (status == CURVOPT_OK && a->finer_batches.n_known)
        status = co_known_sums_keep(&a->known, 1, a->patches.n_patches, &a->finer_batches, a->placement, error);
    co_element_batches_free(&a->batches);
    co_element_batches_free(&a->finer_batches);
    co_element_batches_free(&a->finest_batches);
    a->rules_version++;
    if (status == CURVOPT_OK)
        status = co_element_batches_create(&spec, &a->batches, error);
    if (status == CURVOPT_OK)
        status = co_assembly_ensure_work(a, &a->batches, error);
    if (status != CURVOPT_OK)
        co_element_batches_free(&a->batches);
    /* At a pole rules differ in the points that they need (basis_table.c, window_of): what no batch adds to is 0. */
    memset(a->point_sums, 0, 6 * sizeof *a->point_sums * (size_t)a->patches.n_points);
    return status;
}

/* Sets the rules of the beginning, and the patches' weights. */
static int32_t start_rules(co_assembly *a, int first_rule, const double *face_weight, curvopt_error *error) {
    a->rule = CO_NEW(int8_t, a->patches.n_patches);
    a->weight = face_weight ? CO_NEW(double, a->patches.n_patches) : NULL;
    if (!a->rule || (face_weight && !a->weight))
        return co_status_no_memory(error);
    memset(a->rule, first_rule, (size_t)a->patches.n_patches);
    for (int32_t p = 0; a->weight && p < a->patches.n_patches; p++)
        a->weight[p] = face_weight[a->patches.place[p].face];
    return CURVOPT_OK;
}

/* Finds the active points: those that patches are made of, and the cage's vertices that derived points depend on. */
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
        for (size_t i = patches->start[p]; i < patches->start[p + 1]; i++)
            used[patches->points[i]] = 1;
    for (int32_t k = 0; k < patches->wide.n_discs; k++) {
        co_blend_disc *disc = &a->patches.wide.disc[k];
        const co_blend_disc_fit *fit = co_blend_disc_fit_of(&patches->wide, disc);
        disc->is_used = 0;
        for (int32_t p = 0; p < CO_BLEND_DISC_TERMS * fit->n_sets; p++)
            disc->is_used |= used[disc->first_point + p];
        for (int32_t i = 0; disc->is_used && i < fit->n_points; i++)
            used[patches->wide.column[disc->column + (size_t)i]] = 1;
    }
    for (size_t row = 0; row < (size_t)patches->derived.n_rows; row++) { /* all of them are computed, used or not */
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

static int32_t take_isolated(co_assembly *a, const curvopt_mesh *mesh, curvopt_error *error) {
    size_t n = (size_t)mesh->info.n_isolated;
    a->isolated = n ? CO_NEW(int32_t, n) : NULL;
    if (n && !a->isolated)
        return co_status_no_memory(error);
    if (n)
        memcpy(a->isolated, mesh->isolated, n * sizeof *a->isolated);
    a->n_isolated = mesh->info.n_isolated;
    return CURVOPT_OK;
}

static int32_t take_threads(co_assembly *a, const curvopt_options *options, const co_basis_table_cache *tables,
                            curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    a->threads = tables ? tables->threads : NULL;
    if (!a->threads) {
        status = co_thread_pool_create(options->threads, &a->own_threads, error);
        a->threads = a->own_threads;
    }
    a->n_threads = co_thread_pool_size(a->threads);
    return status;
}

/* A closed surface has int H^2 >= 4 pi (Willmore, "Note on embedded surfaces", An. Sti. Univ. Iasi 11B, 1965), and one
 * that is no sphere >= 2 pi^2 (Marques, Neves, "Min-max theory and the Willmore conjecture", Ann. Math. 179, 2014;
 * where it crosses itself >= 8 pi: Li, Yau 1982). */
static double least_h2_of(const curvopt_mesh *mesh) {
    const curvopt_mesh_info *m = &mesh->info;
    if (mesh->edge_sharpness || mesh->vertex_sharpness || m->n_flawed_edges > 0 || m->n_boundary_edges > 0)
        return 0;
    return m->n_components == 1 && m->euler <= 0 ? 2 * CO_PI * CO_PI : 4 * CO_PI * m->n_components;
}

int32_t co_assembly_create(const curvopt_mesh *mesh, const double *xyz, const co_substitution *substitution,
                           const curvopt_options *options, co_basis_table_cache *tables, const double *face_weight,
                           co_assembly *a, curvopt_error *error) {
    *a = (co_assembly){
        .surface = options->surface, .tuning = co_tuning_of_runs(), .placement = 1, .eps4 = co_functional_eps4(1)};
    a->functional = co_functional_of_weights(options->weights);
    memcpy(a->weights, options->weights, sizeof a->weights);
    a->spontaneous = co_spontaneous_curvature_of(options->weights, options->spontaneous_curvature);
    a->kernel = co_element_kernel_select(NULL);
    a->is_closed = mesh->info.n_boundary_edges == 0;
    a->least_h2 = least_h2_of(mesh);
    a->measures_volume = a->is_closed && options->spontaneous_curvature != 0; /* its sign is the orientation */
    int32_t status = take_threads(a, options, tables, error);
    if (status != CURVOPT_OK)
        return status;
    status = co_patches_create(mesh, xyz, face_weight, options->surface, options->blend_width,
                               tables ? tables->cancel : NULL, &a->patches, error);
    if (status != CURVOPT_OK) {
        co_thread_pool_destroy(a->own_threads);
        return status;
    }
    if (substitution)
        status = co_patches_substitute(&a->patches, substitution, error);
    if (status == CURVOPT_OK)
        status = co_admissibility_check(mesh, &a->patches, &a->functional, a->surface, &a->third_allowed, error);
    if (status == CURVOPT_OK)
        status = co_boundary_turning_create(mesh, &a->patches, a->surface, &a->turning, error);
    if (status == CURVOPT_OK)
        status = take_isolated(a, mesh, error);
    co_basis_table_cache_create(a->surface, &a->own_cache);
    a->own_cache.threads = a->threads;
    a->cache = tables ? tables : &a->own_cache;
    a->cancel = a->cache->cancel;
    if (status == CURVOPT_OK) {
        a->points = CO_NEW(double, 3 * (size_t)a->patches.n_points);
        a->point_gradient = CO_NEW(double, 3 * (size_t)a->patches.n_points);
        a->point_sums = CO_NEW(double, 6 * (size_t)a->patches.n_points);
        a->sharing = CO_NEW_ALIGNED(co_work_sharing, a->n_threads);
        if (!a->points || !a->point_gradient || !a->point_sums || !a->sharing)
            status = co_status_no_memory(error);
    }
    if (status == CURVOPT_OK)
        status = start_rules(a, options->joshi_sequin ? REPORT_RULE : FIRST_RULE, face_weight, error);
    if (status == CURVOPT_OK && a->weight)
        status = find_active(a, error);
    if (status == CURVOPT_OK)
        status = co_assembly_update_batches(a, error);
    if (status != CURVOPT_OK)
        co_assembly_free(a);
    return status;
}

void co_assembly_free(co_assembly *a) {
    co_patches_free(&a->patches);
    co_boundary_turning_free(&a->turning);
    co_basis_table_cache_free(&a->own_cache);
    co_element_batches_free(&a->batches);
    co_element_batches_free(&a->finer_batches);
    co_element_batches_free(&a->finest_batches);
    co_known_sums_free(&a->known);
    free(a->rule);
    free(a->weight);
    free(a->active);
    free(a->isolated);
    free(a->points);
    free(a->point_gradient);
    free(a->point_sums);
    free(a->work);
    free(a->sharing);
    co_quadrature_estimates_free(&a->estimates);
    co_thread_pool_destroy(a->own_threads);
    *a = (co_assembly){0};
}

static int32_t coarsest_of(const co_assembly *a, int32_t coarsest, int32_t p) {
    return co_element_batches_coarsest(a->surface, a->patches.kind[p], coarsest);
}

int32_t co_assembly_coarsest_of(const co_assembly *a, int32_t p) {
    return coarsest_of(a, a->coarsest, p);
}

int32_t co_assembly_n_rough(const co_assembly *a) {
    int32_t n = 0;
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        n += coarsest_of(a, CO_ROUGH_RULE, p) == CO_ROUGH_RULE;
    return n;
}

int32_t co_assembly_set_coarsest(co_assembly *a, int32_t coarsest, curvopt_error *error) {
    int is_other = 0;
    for (int32_t p = 0; p < a->patches.n_patches; p++) {
        const int32_t now = coarsest_of(a, coarsest, p);
        if (a->rule[p] != coarsest_of(a, a->coarsest, p) && a->rule[p] >= now)
            continue;
        is_other |= a->rule[p] != now;
        a->rule[p] = (int8_t)now;
    }
    a->coarsest = coarsest;
    return is_other ? co_assembly_update_batches(a, error) : CURVOPT_OK;
}

int32_t co_assembly_copy_rules(co_assembly *a, const co_assembly *from, curvopt_error *error) {
    a->met = from->met;
    for (int32_t p = 0; p < a->patches.n_patches; p++) {
        const int32_t coarsest = co_assembly_coarsest_of(a, p);
        a->rule[p] = from->rule[p] > coarsest ? from->rule[p] : (int8_t)coarsest;
    }
    return co_assembly_update_batches(a, error);
}

co_normalization co_assembly_normalization(const co_assembly *a) {
    return (co_normalization){.n = (size_t)a->patches.n_cage,
                              .n_skipped = (size_t)a->n_isolated,
                              .skipped = a->isolated,
                              .threads = a->threads};
}

int co_assembly_place_normalized(const co_assembly *a, const double *x, double *points) {
    const size_t n = (size_t)(a->active ? a->n_active_cage : a->patches.n_cage);
    int changes = 0;
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0, v = a->active ? (size_t)a->active[i] : i; c < 3; c++)
            changes |= co_normalization_set(x[3 * v + c], &points[3 * v + c]);
    if (changes)
        co_patches_derive(&a->patches, points);
    return changes;
}

double co_assembly_place(co_assembly *a, const double *xyz, int is_normalized) {
    double radius = 1;
    int changes = 0;
    if (is_normalized) {
        changes = co_assembly_place_normalized(a, xyz, a->points);
    } else {
        const co_normalization c = co_assembly_normalization(a);
        radius = co_normalization_apply(&c, xyz, a->points, &changes);
        if (changes)
            co_patches_derive(&a->patches, a->points);
    }
    a->placement += changes;
    return radius;
}

void co_assembly_take_radius(co_assembly *a, double radius) {
    const double eps4 = co_functional_eps4(radius);
    a->placement += eps4 != a->eps4;
    a->eps4 = eps4;
}
