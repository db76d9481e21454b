/* Sums over faces: a surface's energies and their gradients. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/assembly_sums.h"

#include "base/ordered_sum.h"
#include "energy/held_numbers.h"

#include <math.h>
#include <string.h>

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
    int gradient = gradients != NULL, area = gradient && a->functional.has_third;
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
    double *gradients = work + co_element_batches_kernel_work(l);
    size_t lanes = (size_t)l->lanes, n = a->functional.has_third ? 6 : 3;
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
    size_t n = a->functional.has_third ? 6 : 3;
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
    const int area = a->functional.has_third;
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
        const co_normalization c = co_assembly_normalization(a);
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
    int32_t status = co_assembly_ensure_work(a, l, error);
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
