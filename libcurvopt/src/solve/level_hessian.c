/* The matrices of one level. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level_hessian.h"

#include "base/memory.h"
#include "hessian/strain_metric.h"
#include "linalg/vector.h"

#include <math.h>
#include <stdlib.h>

enum { LARGEST_COUNT = CURVOPT_MAX_COUNTED_VARIABLES }; /* that factor is slower */

/* The Gauss-Newton matrix preconditions only, and is positive with any rules: the coarsest will do. */
static const co_second_kind preconditioner = {.coarser = CO_COARSEST_RULES};

static const co_tuning *tuning_of(const co_level_hessian *h) {
    return h->objective->run->tuning;
}

static int32_t create_system(co_level_hessian *h, curvopt_error *error) {
    co_level_objective *o = h->objective;
    co_couplings couplings = {0};
    int32_t status = o->repulsion.facings.n ? co_repulsion_couplings(&o->repulsion, &couplings, error) : CURVOPT_OK;
    if (status == CURVOPT_OK && o->penalty.surface.n)
        status = co_surface_springs_couple(&o->penalty.surface, &couplings, error);
    if (status == CURVOPT_OK)
        status = co_newton_system_create(&o->assembly, &o->reduction, &couplings, &h->system, error);
    co_couplings_free(&couplings);
    if (status != CURVOPT_OK)
        return status;
    h->system.held = o->numbers.numbers.n && !o->numbers.is_idle ? &o->numbers.newton : NULL;
    h->system.leaves_motions_out = o->sliding != NULL;
    h->exists = 1;
    return CURVOPT_OK;
}

static void free_system(co_level_hessian *h) {
    co_newton_system_free(&h->system);
    free(h->metric);
    h->metric = NULL;
}

/* What repels each other at z, which was placed last, has its entries: else the system is made anew. */
static int32_t cover_repulsion(co_level_hessian *h, curvopt_error *error) {
    co_level_objective *o = h->objective;
    if (!o->repulsion.mesh)
        return CURVOPT_OK;
    co_repulsion_look(&o->repulsion, o->positions);
    if (h->exists && co_repulsion_is_covered(&o->repulsion, &h->system.hessian.pattern, &o->reduction))
        return CURVOPT_OK;
    free_system(h);
    h->exists = h->has_factor = h->has_gauss_newton = 0;
    return create_system(h, error);
}

int32_t co_level_hessian_create(co_level_objective *objective, co_level_hessian *h, curvopt_error *error) {
    const curvopt_options *o = objective->run->options;
    *h = (co_level_hessian){.objective = objective};
    return o->method != CURVOPT_METHOD_LMVM && co_level_objective_n(objective) ? create_system(h, error) : CURVOPT_OK;
}

void co_level_hessian_free(co_level_hessian *h) {
    free_system(h);
    *h = (co_level_hessian){0};
}

double co_level_hessian_least_shift(const co_level_hessian *h, double value) {
    return tuning_of(h)->shift_least * fabs(value) / h->objective->mesh->info.n_vertices;
}

/* What springs and spacing add at z, which was placed last. */
static int32_t add_to_energy(co_level_hessian *h, const double *z, int exact, curvopt_error *error) {
    co_level_objective *o = h->objective;
    co_penalty_add_hessian(&o->penalty, z, exact, &h->system.hessian);
    if (o->repulsion.mesh)
        co_repulsion_add_hessian(&o->repulsion, &h->system.hessian);
    if (!(o->spacing.weight > 0))
        return CURVOPT_OK;
    const double *x = co_level_objective_cage(o);
    const int32_t status = co_spacing_add_hessian(&o->spacing, x, &h->system.hessian, error);
    return status == CURVOPT_OK ? co_corner_walls_add_hessian(&o->corners, x, &h->system.hessian, error) : status;
}

/* Steps have no part of the motions that the objective leaves out, which are those of where the level began: by a
 * matrix without those of where it stands, what is cut off a step afterwards may be its stiffest part. */
static void leave_out(co_level_hessian *h, co_gauge gauge) {
    const co_level_objective *o = h->objective;
    h->system.left_out = gauge == co_gauge_exact(o->gauge) ? o->sliding : NULL;
    h->system.n_left_out = o->n_sliding;
}

/* The system's matrix becomes that at z, with the springs'. kind.before [n_variables]: as co_objective's assemble. */
static int32_t assemble_at(co_level_hessian *h, const double *z, co_second_kind kind, co_gauge gauge,
                           curvopt_error *error) {
    co_level_objective *o = h->objective;
    const double *before = kind.before;
    if (h->system.held && kind.exact) { /* its multipliers are wanted */
        co_iterate at = {.x = (double *)z, .gradient = o->numbers.work};
        co_level_objective_evaluate(o, &at);
    }
    kind.before = before ? o->point_gradient : NULL;
    h->system.metric = NULL;
    co_level_objective_place(o, z);
    int32_t status = cover_repulsion(h, error);
    if (status == CURVOPT_OK && !h->exists)
        status = create_system(h, error);
    if (before)
        co_dof_map_expand(&o->reduction, before, o->point_gradient);
    leave_out(h, gauge);
    if (status == CURVOPT_OK)
        status = co_newton_system_assemble(&h->system, o->positions, &kind, gauge, error);
    if (status == CURVOPT_OK)
        status = add_to_energy(h, z, kind.exact, error);
    return status;
}

int32_t co_level_hessian_factorize_shifted(co_level_hessian *h, double shift, curvopt_error *error) {
    const co_tuning *t = tuning_of(h);
    int32_t status = CURVOPT_OK;
    int positive = 0, raises = isfinite(co_newton_system_mean_diagonal(&h->system)) ? t->trials : 0;
    h->shift = shift;
    for (int k = 0; k < raises && !positive && status == CURVOPT_OK; k++) {
        status = co_newton_system_factorize(&h->system, h->shift, &positive, error);
        h->shift *= positive ? 1 : t->shift_raise;
    }
    h->has_factor = positive && status == CURVOPT_OK;
    return status;
}

/* How the shift changes after a step that was so many times too long. */
static double shift_change(const co_tuning *t, double excess) {
    return excess > t->stiffen_from ? t->stiffen_factor : excess > t->soften_below ? 1 : t->soften_factor;
}

/* The system's shifts become multiples of the metric at the place of its matrix, with the least shift besides. */
static int32_t damp_strains(co_level_hessian *h, double least, curvopt_error *error) {
    co_level_objective *o = h->objective;
    const co_cage_edges edges = co_level_objective_edges(o);
    if (!h->metric)
        h->metric = CO_NEW(double, h->system.hessian.pattern.n_entries);
    if (!h->metric)
        return co_status_no_memory(error);
    h->system.metric = h->metric;
    h->system.unit_shift = least;
    return co_strain_metric(&edges, co_level_objective_cage(o), o->edge, &h->system.hessian, h->metric, error);
}

/* In the mean half of the matrix's trace times what a random direction has along each axis, CURVOPT_TOUCH^2 / 3 of a
 * mean edge. The vertices of a node share its variables. */
double co_level_hessian_touch_rise(const co_level_hessian *h) {
    const co_sparse_hessian *m = &h->system.hessian;
    const co_dof_map *r = m->dofs;
    const double touch = CURVOPT_TOUCH * h->objective->edge;
    double trace = 0;
    for (int32_t node = 0; node < r->n_nodes; node++) {
        const double vertices = r->stretch ? 1 / (r->stretch[node] * r->stretch[node]) : 1;
        for (int32_t k = r->first[node]; k < r->first[node + 1]; k++)
            trace += vertices * m->value[m->pattern.column_start[k]];
    }
    return 0.5 * touch * touch / 3 * trace;
}

int32_t co_level_hessian_update(co_level_hessian *h, const co_iterate *now, double step_excess, int by_hessian,
                                curvopt_error *error) {
    double least = co_level_hessian_least_shift(h, now->value);
    h->has_factor = 0; /* factorizing spoils the old one, even if it fails */
    if (co_run_context_is_cancelled(h->objective->run))
        return CURVOPT_OK;
    const co_second_kind hessian = {.exact = 1, .coarser = tuning_of(h)->newton_coarser};
    const co_second_kind *kind = by_hessian ? &hessian : &preconditioner;
    int32_t status = assemble_at(h, now->x, *kind, co_gauge_exact(h->objective->gauge), error);
    if (status != CURVOPT_OK || co_run_context_is_cancelled(h->objective->run))
        return status;
    status = damp_strains(h, least, error);
    if (status != CURVOPT_OK || co_run_context_is_cancelled(h->objective->run))
        return status;
    double wanted = h->shift * shift_change(tuning_of(h), step_excess);
    return co_level_hessian_factorize_shifted(h, fmax(wanted, least), error);
}

int32_t co_level_hessian_assemble(co_level_hessian *h, const co_iterate *now, const double *before, int closely,
                                  curvopt_error *error) {
    const co_second_kind kind = {.exact = 1, .before = before, .coarser = closely ? 0 : tuning_of(h)->newton_coarser};
    h->has_factor = h->has_gauss_newton = 0;
    h->assembled = now->x;
    return assemble_at(h, now->x, kind, co_gauge_exact(h->objective->gauge), error);
}

/* The system's matrix becomes the Hessian with so much of the Gauss-Newton matrix, which is assembled when first asked
 * for. */
static int32_t mix_with_gauss_newton(co_level_hessian *h, double mix, curvopt_error *error) {
    if (mix == h->system.mix)
        return CURVOPT_OK;
    if (!h->has_gauss_newton) {
        co_level_objective_place(h->objective, h->assembled);
        int32_t status = co_newton_system_begin_gauss_newton(&h->system, h->objective->positions, error);
        if (status != CURVOPT_OK)
            return status;
        status = add_to_energy(h, h->assembled, 0, error);
        co_newton_system_end_gauss_newton(&h->system);
        if (status != CURVOPT_OK)
            return status;
        h->has_gauss_newton = 1;
    }
    co_newton_system_mix(&h->system, mix);
    return CURVOPT_OK;
}

int32_t co_level_hessian_factorize(co_level_hessian *h, const co_damping *damping, int *positive,
                                   curvopt_error *error) {
    h->shift = damping->shift;
    int32_t status = mix_with_gauss_newton(h, damping->mix, error);
    if (status == CURVOPT_OK)
        status = co_newton_system_factorize(&h->system, damping->shift, positive, error);
    h->has_factor = status == CURVOPT_OK && *positive;
    return status;
}

/* Shift of the matrix by which ways are softened, in parts of its mean diagonal: without, motions that it hardly sees
 * would be the ways, and the same ones of all numbers. */
static const double SOFTENING = 0.1;

int32_t co_level_hessian_soften_ways(co_level_hessian *h, const co_iterate *now, curvopt_error *error) {
    co_held_level *numbers = &h->objective->numbers;
    const size_t n = co_level_objective_n(h->objective);
    const double shift = h->shift;
    h->system.held = NULL; /* of the matrix itself */
    int32_t status = assemble_at(h, now->x, preconditioner, co_gauge_exact(h->objective->gauge), error);
    if (status == CURVOPT_OK)
        status = co_level_hessian_factorize_shifted(h, SOFTENING * co_newton_system_mean_diagonal(&h->system), error);
    for (int k = 0; k < numbers->numbers.n && status == CURVOPT_OK && h->has_factor; k++) {
        double *way = numbers->newton.way + (size_t)k * n;
        status = co_level_hessian_solve(h, way, way, error);
    }
    co_held_level_straighten_ways(numbers, now->x);
    h->system.held = &numbers->newton;
    h->has_factor = 0;
    h->shift = shift;
    return status;
}

int32_t co_level_hessian_solve(co_level_hessian *h, const double *in, double *out, curvopt_error *error) {
    return co_newton_system_solve(&h->system, in, out, error);
}

int32_t co_level_hessian_factorize_at(co_level_hessian *h, const co_iterate *now, int exact, int *positive,
                                      curvopt_error *error) {
    co_second_kind kind = preconditioner;
    if (exact)
        kind = (co_second_kind){.exact = 1};
    int32_t status = assemble_at(h, now->x, kind, co_gauge_exact(h->objective->gauge), error);
    return status == CURVOPT_OK
               ? co_newton_system_factorize(&h->system, co_level_hessian_least_shift(h, now->value), positive, error)
               : status;
}

int32_t co_level_hessian_assemble_exact(co_level_hessian *h, const co_iterate *now, co_gauge gauge,
                                        curvopt_error *error) {
    return assemble_at(h, now->x, (co_second_kind){.exact = 1}, gauge, error);
}

int32_t co_level_hessian_unmix(co_level_hessian *h, const co_iterate *now, curvopt_error *error) {
    int32_t status = mix_with_gauss_newton(h, 0, error);
    return status == CURVOPT_OK
               ? co_level_hessian_factorize_shifted(h, co_level_hessian_least_shift(h, now->value), error)
               : status;
}

/* Motions of this gauge become the stiff ones of the Hessian at `now`, which was assembled last. */
static void change_gauge(co_level_hessian *h, const co_iterate *now, co_gauge gauge) {
    co_level_objective_place(h->objective, now->x);
    leave_out(h, gauge);
    co_newton_system_change_gauge(&h->system, h->objective->positions, gauge);
}

int32_t co_level_hessian_count_negative(co_level_hessian *h, const co_iterate *now, int has_hessian,
                                        int32_t *n_negative, double *decrement, curvopt_error *error) {
    const co_gauge gauge = h->objective->gauge;
    size_t n = co_level_objective_n(h->objective);
    *n_negative = n > LARGEST_COUNT ? -1 : 0;
    *decrement = n > LARGEST_COUNT ? (double)NAN : 0;
    if (n == 0 || *n_negative < 0)
        return CURVOPT_OK;
    double *step = CO_NEW(double, n);
    int32_t status = step ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK && has_hessian)
        change_gauge(h, now, gauge);
    else if (status == CURVOPT_OK)
        status = co_level_hessian_assemble_exact(h, now, gauge, error);
    if (status == CURVOPT_OK)
        status = co_newton_system_count_negative(&h->system, co_level_hessian_least_shift(h, now->value), now->gradient,
                                                 step, n_negative, error);
    if (status == CURVOPT_OK)
        *decrement = *n_negative == 0 ? 0.5 * co_vector_dot(n, now->gradient, step) : (double)NAN;
    free(step);
    return status;
}
