/* Sums over faces: a surface's energies and their gradients. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/assembly.h"

#include "base/constants.h"
#include "base/memory.h"
#include "base/ordered_sum.h"
#include "energy/admissibility.h"
#include "energy/normalization.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rule of every face at first, and of the fixed settings of Joshi and Sequin's report, which never refine. */
enum { FIRST_RULE = 0, REPORT_RULE = 1 };

static int needs_area_gradient(const co_assembly *a) {
    return a->functional.has_third;
}

static size_t work_of_kernel(const co_element_batches *l) {
    return 9 * (size_t)l->max_points * (size_t)l->lanes;
}

static int32_t ensure_work(co_assembly *a, const co_element_batches *l, curvopt_error *error) {
    size_t stride = work_of_kernel(l) + l->batch_size;
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
                                    .gradients = 1 + needs_area_gradient(a)};
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
        status = ensure_work(a, &a->batches, error);
    if (status != CURVOPT_OK)
        co_element_batches_free(&a->batches);
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

static co_normalization normalization_of(const co_assembly *a) {
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
        const co_normalization c = normalization_of(a);
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

/* Multiplies a block's results by the weights of its patches. gradients: the block's, or NULL. */
static void weigh_block(const co_assembly *a, const co_element_batches *l, int32_t b, double *gradients, int area) {
    const co_block *block = &l->block[b];
    size_t lanes = (size_t)l->lanes, n = 3 * (size_t)block->table->n_points * (size_t)(1 + area);
    for (int32_t k = 0; k < block->n_used; k++) {
        double weight = a->weight[co_element_batches_patch(l, b, k)], *sum = co_element_batches_sums(l, b, k);
        for (size_t i = 0; i < CO_N_INTEGRALS; i++)
            sum[i * lanes] *= weight;
        for (size_t i = 0; gradients && i < n; i++)
            gradients[co_lane_place((size_t)k, n, lanes) + i * lanes] *= weight;
    }
}

/* Whether the volume is evaluated with the energies, or area and volume instead of them, which costs a fraction. */
typedef enum numbers_wanted { NO_VOLUME, WITH_VOLUME, FIRST_ORDER_ALONE } numbers_wanted;

/* CO_SUM_JUMP is told from the finer of two rules. */
static int wants_jump(const co_assembly *a, const co_element_batches *l) {
    return l != &a->batches;
}

/* Evaluates a block. gradients: where its gradients go, or NULL; work: this thread's. */
static void run_block(co_assembly *a, const co_element_batches *l, int32_t b, const co_integrand *integrand, int third,
                      numbers_wanted numbers, double *gradients, double *work) {
    const co_block *block = &l->block[b];
    int gradient = gradients != NULL, area = gradient && needs_area_gradient(a);
    co_element_block element = {.table = block->table,
                                .n_used = block->n_used,
                                .points = l->points + block->points,
                                .xyz = a->points,
                                .eps4 = a->eps4,
                                .integrand = *integrand,
                                .third = third,
                                .cancel = a->cancel,
                                .gradient = gradient,
                                .area_gradient = area,
                                .volume = numbers == WITH_VOLUME,
                                .jump = wants_jump(a, l),
                                .first_order = numbers == FIRST_ORDER_ALONE,
                                .sums = co_element_batches_sums(l, b, 0),
                                .gradients = gradients,
                                .work = work};
    a->kernel->run(&element);
    if (a->weight)
        weigh_block(a, l, b, gradients, area);
}

/* Evaluates the blocks of a batch, and adds their gradients up by points: the integrand's, and the area's behind it. */
static void run_batch(co_assembly *a, const co_element_batches *l, int32_t batch, const co_integrand *integrand,
                      int third, numbers_wanted numbers, double *work) {
    double *gradients = work + work_of_kernel(l);
    size_t lanes = (size_t)l->lanes, n = needs_area_gradient(a) ? 6 : 3;
    for (int32_t b = l->batch_block[batch]; b < l->batch_block[batch + 1]; b++)
        run_block(a, l, b, integrand, third, numbers, gradients + l->block[b].gradient, work);
    for (size_t k = l->batch_touched[batch]; k < l->batch_touched[batch + 1]; k++) {
        double sum[6] = {0};
        for (size_t e = l->touched[k].incident; e < l->touched[k + 1].incident; e++)
            for (size_t c = 0; c < n; c++)
                sum[c] += gradients[l->incident[e] + c * lanes];
        memcpy(l->batch_sums + n * k, sum, n * sizeof *sum);
    }
}

/* Adds up the contributions of all batches to a point, in their order. `first`: its first entry in
 * co_element_batches.touched. */
static void add_batches(co_assembly *a, const co_element_batches *l, size_t first) {
    size_t n = needs_area_gradient(a) ? 6 : 3;
    double *sum = a->point_sums + 6 * (size_t)l->touched[first].point;
    memcpy(sum, l->batch_sums + n * first, n * sizeof *sum);
    for (size_t k = l->touched[first].next; k; k = l->touched[k].next)
        for (size_t c = 0; c < n; c++)
            sum[c] += l->batch_sums[n * k + c];
}

/* What run_blocks() is about. */
typedef struct block_run {
    co_assembly *assembly;
    const co_element_batches *batches;
    const co_integrand *integrand;
    int third, gradient;
    numbers_wanted numbers;
} block_run;

static void run_shared_blocks(void *context, int32_t thread, int32_t n_threads) {
    const block_run *r = context;
    co_assembly *a = r->assembly;
    const co_element_batches *l = r->batches;
    double *work = a->work + (size_t)thread * a->work_stride;
    co_work_sharing_thread me = {.thread = thread, .n_threads = n_threads};
    int32_t k;
    while (!co_cancel_is_due(a->cancel) &&
           (k = co_work_sharing_next(a->sharing, r->gradient ? l->n_batches : l->n_blocks, &me)) >= 0)
        if (r->gradient)
            run_batch(a, l, k, r->integrand, r->third, r->numbers, work);
        else if (!l->is_known[k])
            run_block(a, l, k, r->integrand, r->third, r->numbers, NULL, work);
}

static void add_batches_of_points(void *context, size_t begin, size_t end) {
    const block_run *r = context;
    for (size_t first = begin; first < end; first++)
        if (r->batches->touched[first].is_first)
            add_batches(r->assembly, r->batches, first);
}

/* A sample is work of about so many steps (co_thread_pool_if_worth), 10 to 15 ns, and twice as many with a gradient. */
enum { STEPS_OF_SAMPLE = 2 };

/* All blocks are known, for what `wanted` says, or none if it is NULL. */
static void set_known(const co_sums_of *wanted, co_element_batches *l) {
    if (l->n_blocks) /* there are none when memory was out */
        memset(l->is_known, wanted != NULL, (size_t)l->n_blocks);
    l->n_known = wanted ? l->n_blocks : 0;
    l->sums_of = wanted ? *wanted : (co_sums_of){0};
}

/* Marks the blocks as known whose sums have what is wanted already. */
static void find_known(const co_assembly *a, const co_sums_of *wanted, co_element_batches *l) {
    if (co_sums_of_has(&l->sums_of, wanted))
        return;
    set_known(NULL, l);
    l->sums_of = *wanted;
    co_known_sums_give(&a->known, wanted, l);
}

/* Evaluates blocks whose sums are not known, or all of them with gradients, which are those of `integrand`. */
static void run_blocks(co_assembly *a, co_element_batches *l, const co_integrand *integrand, int third,
                       numbers_wanted numbers, int gradient) {
    block_run r = {.assembly = a,
                   .batches = l,
                   .integrand = integrand,
                   .third = third,
                   .gradient = gradient,
                   .numbers = numbers == NO_VOLUME && a->measures_volume ? WITH_VOLUME : numbers};
    const int are_energies = r.numbers != FIRST_ORDER_ALONE;
    const co_sums_of wanted = {
        .placement = a->placement, .third = third, .volume = r.numbers == WITH_VOLUME, .jump = wants_jump(a, l)};
    const size_t steps = (size_t)l->n_samples * STEPS_OF_SAMPLE * (gradient ? 2 : 1);
    if (gradient || !are_energies)
        set_known(NULL, l);
    else
        find_known(a, &wanted, l);
    if (l->n_known == l->n_blocks)
        return;
    co_work_sharing_start(a->sharing, a->n_threads);
    co_thread_pool_run(co_thread_pool_if_worth(a->threads, steps), run_shared_blocks, &r);
    if (gradient)
        co_thread_pool_for(co_thread_pool_if_worth(a->threads, l->batch_touched[l->n_batches]),
                           l->batch_touched[l->n_batches], add_batches_of_points, &r);
    set_known(are_energies && !co_cancel_is_due(a->cancel) ? &wanted : NULL, l);
}

/* Adds blocks begin .. end - 1 to a sum of blocks. */
static void add_blocks(const co_assembly *a, const co_element_batches *l, int32_t begin, int32_t end, co_values *sum) {
    for (int32_t b = begin; b < end; b++)
        for (int32_t lane = 0; lane < l->block[b].n_used; lane++) {
            for (int i = 0; i < CO_N_INTEGRALS; i++)
                sum->integral[i] += co_element_batches_sum(l, b, lane, i);
            double jacobian = co_element_batches_sum(l, b, lane, CO_SUM_MIN_JACOBIAN) /
                              co_element_batches_sum(l, b, lane, CO_SUM_MEAN_JACOBIAN);
            if (!isnan(sum->min_jacobian) && !(jacobian >= sum->min_jacobian)) {
                sum->min_jacobian = jacobian;
                sum->worst_face = a->patches.place[co_element_batches_patch(l, b, lane)].face;
            }
        }
}

/* Values chunk by chunk (ordered_sum.h). */
typedef struct value_sums {
    const co_assembly *assembly;
    const co_element_batches *batches;
    co_values part[CO_ORDERED_SUM_CHUNKS];
} value_sums;

static void sum_values(void *context, size_t begin, size_t end) {
    value_sums *s = context;
    const size_t n = (size_t)s->batches->n_blocks;
    for (int k = (int)begin; k < (int)end; k++) {
        s->part[k] = (co_values){.min_jacobian = INFINITY, .worst_face = -1};
        add_blocks(s->assembly, s->batches, (int32_t)co_ordered_sum_begin(n, k),
                   (int32_t)co_ordered_sum_begin(n, k + 1), &s->part[k]);
    }
}

static void total(const co_assembly *a, const co_element_batches *l, co_values *out) {
    value_sums s = {.assembly = a, .batches = l};
    const co_values *part = s.part;
    if (co_cancel_is_due(a->cancel)) { /* some blocks may be missing */
        *out = (co_values){.objective = (double)NAN, .reference = (double)NAN, .min_jacobian = (double)NAN};
        for (int i = 0; i < CO_N_INTEGRALS; i++)
            out->integral[i] = (double)NAN;
        return;
    }
    co_ordered_sum_run(a->threads, (size_t)l->n_blocks, sum_values, &s);
    *out = part[0];
    for (int k = 1; k < CO_ORDERED_SUM_CHUNKS; k++) {
        for (int i = 0; i < CO_N_INTEGRALS; i++)
            out->integral[i] += part[k].integral[i];
        if (!isnan(out->min_jacobian) && !(part[k].min_jacobian >= out->min_jacobian)) {
            out->min_jacobian = part[k].min_jacobian;
            out->worst_face = part[k].worst_face;
        }
    }
    const co_spontaneous_part own = co_spontaneous_curvature_add(&a->spontaneous, a->radius, out->integral);
    out->objective = co_functional_value(&a->functional, out->integral) + own.added.value;
    out->reference = own.reference;
}

/* What collect_gradient() is about. */
typedef struct collected_gradient {
    co_assembly *assembly;
    double factor, area_factor;
    double *gradient;
} collected_gradient;

static void collect_points(void *context, size_t begin, size_t end) {
    const collected_gradient *g = context;
    const co_assembly *a = g->assembly;
    const int area = needs_area_gradient(a);
    const size_t n_cage = (size_t)a->patches.n_cage;
    for (size_t i = begin; i < end; i++) {
        size_t p = a->active ? (size_t)a->active[i] : i;
        const double *sum = a->point_sums + 6 * p;
        double *to = p < n_cage ? g->gradient : a->point_gradient;
        for (size_t c = 0; c < 3; c++)
            to[3 * p + c] = g->factor * sum[c] + (area ? g->area_factor * sum[3 + c] : 0);
    }
}

/* The gradient factor * the integrand's + area_factor * the area's, that of derived points taken back to the cage. */
static void collect_gradient(co_assembly *a, double factor, double area_factor, double *gradient) {
    collected_gradient g = {.assembly = a, .factor = factor, .area_factor = area_factor, .gradient = gradient};
    const size_t n = (size_t)(a->active ? a->n_active : a->patches.n_points);
    co_thread_pool_for(co_thread_pool_if_worth(a->threads, n), n, collect_points, &g);
    co_patches_add_derived(&a->patches, a->point_gradient, gradient);
}

void co_assembly_evaluate(co_assembly *a, const double *xyz, const co_request *request, co_values *out) {
    const co_functional *f = &a->functional;
    int third = f->has_third || (request->all_terms && a->third_allowed);
    co_integrand integrand = f->has_third ? f->third : f->second;
    double factor = 1, area_factor = 0, scaling = 0;
    const int has_spontaneous = a->spontaneous.curvature != 0; /* then f->has_second, too */
    double radius = a->radius = co_assembly_place(a, xyz, request->is_normalized);
    /* second + A third, or a function of numbers: the integrand depends on them */
    if (request->gradient && ((f->has_third && f->has_second) || has_spontaneous)) {
        run_blocks(a, &a->batches, &f->second, 0, NO_VOLUME, 0);
        total(a, &a->batches, out);
        integrand = f->second;
        co_integrand_add(&integrand, out->integral[CO_INT_AREA], &f->third);
        scaling = co_spontaneous_curvature_add_integrands(&a->spontaneous, radius, out->integral, &integrand);
    }
    run_blocks(a, &a->batches, &integrand, third, request->volume ? WITH_VOLUME : NO_VOLUME, request->gradient != NULL);
    total(a, &a->batches, out);
    out->radius = radius;
    a->worst_face = out->worst_face;
    if (!request->gradient)
        return;
    if (f->has_third) {
        area_factor = co_functional_integrate(&f->third, out->integral);
        factor = f->has_second ? 1 : out->integral[CO_INT_AREA];
    }
    collect_gradient(a, factor, area_factor, request->gradient);
    if (!request->is_normalized) {
        const co_normalization c = normalization_of(a);
        co_normalization_gradient(&c, a->points, radius, scaling, request->gradient);
    }
}

void co_assembly_pieces(co_assembly *a, const double *x, int all_terms, const co_pieces *gradients, co_values *out) {
    const co_functional *f = &a->functional;
    int third = f->has_third || (all_terms && a->third_allowed);
    a->radius = co_assembly_place(a, x, 1);
    if (gradients->second && f->has_second) {
        run_blocks(a, &a->batches, &f->second, third && !f->has_third, NO_VOLUME, 1);
        collect_gradient(a, 1, 0, gradients->second);
    }
    if (gradients->third && f->has_third) {
        run_blocks(a, &a->batches, &f->third, 1, NO_VOLUME, 1);
        collect_gradient(a, 1, 0, gradients->third);
        collect_gradient(a, 0, 1, gradients->area);
    }
    if (!gradients->second && !gradients->third)
        run_blocks(a, &a->batches, &f->second, third, NO_VOLUME, 0);
    total(a, &a->batches, out);
    out->radius = a->radius;
    a->worst_face = out->worst_face;
}

void co_assembly_numbers(co_assembly *a, const double *x, int mean, double integral[CO_N_INTEGRALS]) {
    co_values values;
    co_assembly_place(a, x, 1);
    run_blocks(a, &a->batches, &a->functional.second, 0, mean ? WITH_VOLUME : FIRST_ORDER_ALONE, 0);
    total(a, &a->batches, &values);
    memcpy(integral, values.integral, sizeof values.integral);
}

void co_assembly_number_gradient(co_assembly *a, int scalar, double *gradient) {
    co_integrand integrand = {0};
    co_held_numbers_add(scalar, 1, &integrand);
    run_blocks(a, &a->batches, &integrand, 0, scalar == CURVOPT_SCALAR_MEAN_CURVATURE ? NO_VOLUME : FIRST_ORDER_ALONE,
               1);
    collect_gradient(a, 1, 0, gradient);
}

int32_t co_assembly_evaluate_batches(co_assembly *a, co_element_batches *l, int third, co_values *out,
                                     curvopt_error *error) {
    int32_t status = ensure_work(a, l, error);
    if (status != CURVOPT_OK)
        return status;
    run_blocks(a, l, &a->functional.second, third, NO_VOLUME, 0);
    total(a, l, out);
    return co_cancel_is_due(a->cancel) ? CO_CANCELLED : CURVOPT_OK;
}

double co_assembly_turning(const co_assembly *a) {
    return co_boundary_turning_total(&a->turning, &a->patches, a->weight, a->points);
}

double co_assembly_defect(const co_assembly *a, const co_values *values) {
    if (a->leaves_out)
        return 0;
    return fabs(values->integral[CO_INT_K] + co_assembly_turning(a) - a->turning.target);
}
