/* One level of a run.
 *
 * With a fixed quadrature rule the discrete energy has no lower bound, and an optimizer finds that out. Here every
 * accepted step is looked at: Gauss-Bonnet's defect is free, and when it grows, after a long step of the strong method,
 * or after a few steps in any case, the rules are held against finer ones. A step that looked like progress only to a
 * rule too coarse is taken back.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level.h"

#include "base/memory.h"
#include "linalg/vector.h"
#include "mesh/similarity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { RESOLVE_EVERY = 20, RESOLVE_STRONG = 5, INVERSE_ITERATIONS = 30, SADDLE_HALVINGS = 12 };
enum { LARGEST_COUNT = 15000 }; /* variables up to which negative directions are counted: that factor is slower */
static const double SHORT_STEP = 0.05; /* of a vertex, in mean edges */
static const double SHIFT = 0.1, STIFFEN_MOST = 10, AWAY = 2;
static const double WORTH_LEAVING = 2e-7; /* of the energy: what a step away from a saddle must bring */
/* While a level is worked on that is not the last, quadrature may be this much coarser than what is wanted of the
 * figures at the end: the step check above needs a resolved energy, not an accurate one. */
static const double WORKING_FACTOR = 10;
static const double DEFECT_GROWTH = 4, DEFECT_FLOOR = 1e-3; /* radians of total curvature */

static int is_fixed(const co_level *l) {
    return l->hold.freedom != NULL;
}

/* -------------------------------------------------------------------------------------------- the function -- */

static double value_at(co_level *l, const double *z, double *gradient) {
    const co_assembly *a = &l->assembly;
    co_request request = {.is_normalized = 1, .gradient = gradient ? l->gx : NULL};
    double radius = 1;
    if (!is_fixed(l))
        radius = co_dof_map_normalize(&l->reduction, z, l->normalized);
    const double *at = is_fixed(l) ? z : l->normalized;
    co_dof_map_expand_some(&l->reduction, a->active, a->n_active_cage, at, l->x);
    co_assembly_evaluate(&l->assembly, l->x, &request, &l->last);
    if (!gradient)
        return l->last.objective + co_penalty_value(&l->pull, z, NULL);
    co_dof_map_gradient_of(&l->reduction, a->active, a->n_active_cage, l->gx, gradient);
    if (!is_fixed(l))
        co_dof_map_normalized_gradient(&l->reduction, at, radius, gradient);
    return l->last.objective + co_penalty_value(&l->pull, z, gradient);
}

/* The same for the optimizer, which finds no way on when the run is to end. */
static double evaluate(void *context, const double *z, double *gradient) {
    co_level *l = context;
    return co_run_context_is_cancelled(l->frame) ? INFINITY : value_at(l, z, gradient);
}

/* Longest vertex displacement in mean edges. */
static double step_length(void *context, const double *d) {
    const co_level *l = context;
    return co_dof_map_longest(&l->reduction, d) / l->edge;
}

/* Back to centroid 0 and radius 1, where the function is the same and the gradient scales. l->x becomes the cage. */
static void hold_placement(co_level *l, co_iterate *now) {
    size_t n = (size_t)l->reduction.n_variables;
    if (!is_fixed(l)) {
        double radius = co_dof_map_normalize(&l->reduction, now->x, l->normalized);
        memcpy(now->x, l->normalized, n * sizeof *now->x);
        for (size_t k = 0; k < n; k++)
            now->gradient[k] *= radius;
    }
    co_dof_map_expand(&l->reduction, now->x, l->x);
}

/* Longest displacement of a vertex between two points, in mean edges. */
static double distance(co_level *l, const double *from, const double *to) {
    for (int32_t k = 0; k < l->reduction.n_variables; k++)
        l->step[k] = to[k] - from[k];
    return step_length(l, l->step);
}

/* Back to the last iterate that is known to be resolved: those in between were not looked at. */
static co_step_verdict step_back(co_level *l, co_iterate *now, co_step_verdict verdict) {
    memcpy(now->x, l->safe, sizeof(double) * (size_t)l->reduction.n_variables);
    now->value = value_at(l, now->x, now->gradient);
    return verdict;
}

co_step_verdict co_level_check(co_level *l, co_iterate *now) {
    curvopt_energies energies;
    int resolved, changed;
    co_dof_map_expand(&l->reduction, now->x, l->x);
    l->failed = co_adaptive_quadrature_resolve(&l->assembly, l->x,
                                               &(co_quadrature_goal){l->working_tolerance, CO_TERMS_OBJECTIVE, 1},
                                               &energies, &resolved, &changed, l->error);
    if (l->failed != CURVOPT_OK)
        return step_back(l, now, CO_STEP_STOP);
    if (!resolved)
        return step_back(l, now, CO_STEP_REJECT);
    l->defect = energies.gauss_bonnet_defect;
    if (changed) {
        double value_before = value_at(l, l->safe, now->gradient);
        now->value = value_at(l, now->x, now->gradient);
        if (!(now->value <= value_before))
            return step_back(l, now, CO_STEP_REJECT);
    }
    memcpy(l->safe, now->x, sizeof(double) * (size_t)l->reduction.n_variables);
    if (!changed) {
        l->failed = co_adaptive_quadrature_coarsen(&l->assembly, l->working_tolerance, &changed, l->error);
        now->value = l->failed != CURVOPT_OK || !changed ? now->value : value_at(l, now->x, now->gradient);
    }
    return l->failed != CURVOPT_OK ? CO_STEP_STOP : changed ? CO_STEP_CHANGED : CO_STEP_KEEP;
}

static co_step_verdict settle(void *context, const co_iterate *before, co_iterate *now, int iteration) {
    co_level *l = context;
    if (l->failed != CURVOPT_OK || co_run_context_is_cancelled(l->frame)) /* in between, where nobody could be told */
        return step_back(l, now, CO_STEP_STOP);
    int suspicious =
        !(co_assembly_defect(&l->assembly, &l->last) <= DEFECT_GROWTH * l->defect + DEFECT_FLOOR); /* of `now` */
    /* a long step into unknown country is looked at more closely than one of many short ones */
    int due = iteration % (l->has_model ? RESOLVE_STRONG : RESOLVE_EVERY) == 0 ||
              (l->has_model && distance(l, before->x, now->x) > SHORT_STEP);
    hold_placement(l, now);
    l->edge = co_mesh_mean_edge(l->mesh, l->x);
    if (l->frame->options->as_report || (!due && !suspicious))
        return CO_STEP_KEEP;
    return co_level_check(l, now);
}

static int report(void *context, const co_iterate *now, int iteration, int evaluations) {
    co_level *l = context;
    return l->failed != CURVOPT_OK ||
           (l->report && l->report(l, now, l->iterations + iteration, l->evaluations + evaluations, l->user));
}

/* ---------------------------------------------------------------------------------------- preconditioning -- */

static int32_t create_model(co_level *l, curvopt_error *error) {
    int32_t status = co_newton_system_create(&l->assembly, &l->reduction, &l->model, error);
    l->has_model = status == CURVOPT_OK;
    return status;
}

/* The model becomes that of `now`, with the pull's matrix. kind.before [n_variables]: as co_objective's assemble. */
static int32_t assemble_model(co_level *l, const co_iterate *now, co_second_kind kind, co_gauge gauge,
                              curvopt_error *error) {
    int32_t status = l->has_model ? CURVOPT_OK : create_model(l, error);
    const double *before = kind.before;
    kind.before = before ? l->gx : NULL;
    co_dof_map_expand(&l->reduction, now->x, l->x);
    if (before)
        co_dof_map_expand(&l->reduction, before, l->gx);
    if (status == CURVOPT_OK)
        status = co_newton_system_assemble(&l->model, l->x, &kind, gauge, error);
    if (status == CURVOPT_OK)
        co_penalty_add_hessian(&l->pull, &l->model.hessian);
    return status;
}

/* The Hessian of a level that is not the last may be by coarser rules: it only leads to where the next one begins. */
static co_second_kind leading_kind(const co_level *l, const double *before) {
    int last = l->number == l->frame->options->levels;
    return (co_second_kind){.exact = 1, .rules = last ? CO_SECOND_OWN : CO_SECOND_COARSER, .before = before};
}

static double least_shift(const co_level *l, double value) {
    return SHIFT * fabs(value) / l->mesh->info.n_vertices;
}

/* The model that was assembled, with this shift, or with so much more that it is positive definite. */
static int32_t factorize_shifted(co_level *l, double shift, curvopt_error *error) {
    double stiffest = co_newton_system_mean_diagonal(&l->model);
    int32_t status = CURVOPT_OK;
    int positive = 0;
    for (l->shift = shift; !positive && status == CURVOPT_OK && l->shift <= stiffest; l->shift *= positive ? 1 : 4)
        status = co_newton_system_factorize(&l->model, l->shift, &positive, error);
    l->has_factor = positive && status == CURVOPT_OK;
    return status;
}

/* A shift just above what the most negative direction needs makes that direction all but infinitely soft, and of
 * rounding a step. */
static void keep_away(co_level *l) {
    int positive;
    l->shift *= AWAY;
    l->failed = co_newton_system_factorize(&l->model, l->shift, &positive, l->error);
    l->has_factor = l->failed == CURVOPT_OK && positive;
}

/* The matrix of `now`, shifted (Levenberg 1944, Marquardt 1963): so little that what the matrix does not see (sliding
 * in the surface, rigid motion) is not infinitely soft, a displacement of all vertices by the surface's size costing at
 * least SHIFT times the energy; and as much more as keeps steps near the cap. Cutting a long step back to the cap
 * instead needs ten times as many on the curved valley floor of MVS. */
static void renew(void *context, const co_iterate *now, double overshoot) {
    co_level *l = context;
    l->has_factor = 0; /* factorizing spoils the old one, even if it fails */
    if (l->failed != CURVOPT_OK || co_run_context_is_cancelled(l->frame))
        return;
    double least = least_shift(l, now->value);
    double change = overshoot > 4 ? fmin(overshoot, STIFFEN_MOST) : overshoot > 1.5 ? 2 : overshoot > 0.7 ? 1 : 1.0 / 3;
    l->failed = assemble_model(l, now, (co_second_kind){.exact = l->exact}, co_gauge_exact(l->gauge), l->error);
    if (l->failed != CURVOPT_OK || co_run_context_is_cancelled(l->frame))
        return;
    l->failed = factorize_shifted(l, fmax(l->shift * change, least), l->error);
    if (l->failed == CURVOPT_OK && l->exact && l->has_factor && l->shift > least)
        keep_away(l);
}

static int assemble(void *context, const co_iterate *now, const double *before) {
    co_level *l = context;
    if (l->failed == CURVOPT_OK && !co_run_context_is_cancelled(l->frame))
        l->failed = assemble_model(l, now, leading_kind(l, before), co_gauge_exact(l->gauge), l->error);
    l->has_factor = l->has_gauss_newton = 0;
    l->assembled = now->x;
    return l->failed != CURVOPT_OK || co_run_context_is_cancelled(l->frame);
}

/* The model's matrix becomes the Hessian with so much of the Gauss-Newton matrix, which is assembled when first asked
 * for. */
static int32_t mix_model(co_level *l, double mix) {
    if (mix == l->model.mix)
        return CURVOPT_OK;
    if (!l->has_gauss_newton) {
        co_dof_map_expand(&l->reduction, l->assembled, l->x);
        int32_t status = co_newton_system_begin_gauss_newton(&l->model, l->x, l->error);
        if (status != CURVOPT_OK)
            return status;
        co_penalty_add_hessian(&l->pull, &l->model.hessian);
        co_newton_system_end_gauss_newton(&l->model);
        l->has_gauss_newton = 1;
    }
    co_newton_system_mix(&l->model, mix);
    return CURVOPT_OK;
}

static int factorize(void *context, const co_damping *damping, int *positive) {
    co_level *l = context;
    *positive = 0;
    if (co_run_context_is_cancelled(l->frame))
        return 1;
    l->shift = damping->shift;
    l->failed = mix_model(l, damping->mix);
    if (l->failed == CURVOPT_OK)
        l->failed = co_newton_system_factorize(&l->model, damping->shift, positive, l->error);
    l->has_factor = l->failed == CURVOPT_OK && *positive;
    return l->failed != CURVOPT_OK;
}

static double least_shift_at(void *context, const co_iterate *now) {
    return least_shift(context, now->value);
}

static int precondition(void *context, const double *in, double *out) {
    co_level *l = context;
    if (!l->has_factor)
        return 1;
    int32_t status = co_newton_system_solve(&l->model, in, out, l->error);
    if (status != CURVOPT_OK)
        l->failed = status;
    return status != CURVOPT_OK;
}

/* The direction in which the Hessian is most negative, by inverse iteration with its factor, which is shifted. The
 * shift is more than the least one only if something is negative. */
static int most_negative(co_level *l, const co_iterate *now, double *d) {
    size_t n = (size_t)l->reduction.n_variables;
    double curvature = 0, least = least_shift(l, now->value);
    if (l->failed != CURVOPT_OK || !l->has_factor || l->shift <= least)
        return 0;
    for (size_t i = 0; i < n; i++) /* some vector without symmetries: the golden section's multiples are well spread */
        d[i] = fmod(0.6180339887498949 * (double)(i + 1), 1) - 0.5;
    for (int step = 0; step < INVERSE_ITERATIONS; step++) {
        double norm = co_vector_norm(n, d);
        for (size_t i = 0; i < n; i++)
            d[i] /= norm;
        memcpy(l->gx, d, n * sizeof *d);
        if (precondition(l, d, d))
            return 0;
        curvature = 1 / co_vector_dot(n, l->gx, d) - l->shift;
    }
    if (co_vector_dot(n, d, now->gradient) > 0)
        for (size_t i = 0; i < n; i++)
            d[i] = -d[i];
    return curvature < -least;
}

static int negative_curvature(void *context, const co_iterate *now, double *d) {
    co_level *l = context;
    l->failed = mix_model(l, 0);
    if (l->failed == CURVOPT_OK)
        l->failed = factorize_shifted(l, least_shift(l, now->value), l->error);
    return most_negative(l, now, d);
}

co_objective co_level_objective(co_level *l) {
    return (co_objective){.context = l,
                          .n = (size_t)l->reduction.n_variables,
                          .evaluate = evaluate,
                          .step_length = step_length,
                          .review_step = settle,
                          .precondition = l->has_model ? precondition : NULL,
                          .update_preconditioner = l->has_model ? renew : NULL,
                          .assemble = l->has_model ? assemble : NULL,
                          .factorize = l->has_model ? factorize : NULL,
                          .least_shift = l->has_model ? least_shift_at : NULL,
                          .negative_curvature = l->has_model ? negative_curvature : NULL,
                          .report = report};
}

/* ------------------------------------------------------------------------------------------------ the level -- */

static int32_t create_parts(co_level *l, const co_symmetry *symmetry, double *z, curvopt_error *error) {
    const co_run_context *f = l->frame;
    size_t n = (size_t)l->mesh->info.n_vertices;
    double centroid[3], radius = co_similarity_frame(n, l->start, centroid), *face_weight = NULL;
    const double *origin = is_fixed(l) ? f->centroid : centroid;
    double unit = is_fixed(l) ? f->radius : radius;
    for (size_t i = 0; i < 3 * n; i++)
        l->x[i] = (l->start[i] - origin[i % 3]) / unit;
    l->edge = co_mesh_mean_edge(l->mesh, l->x);
    int32_t status = co_dof_map_create(l->mesh, symmetry, &l->hold, l->x, &l->reduction, error);
    if (status == CURVOPT_OK)
        co_dof_map_variables(&l->reduction, l->x, z);
    if (status == CURVOPT_OK)
        status = co_penalty_create(&l->hold.springs, &l->reduction, origin, unit,
                                   co_penalty_stiffness(f->options->weights), &l->pull, error);
    if (status == CURVOPT_OK && symmetry->order > 1)
        status = co_dof_map_face_weights(l->mesh, symmetry, &face_weight, error);
    if (status == CURVOPT_OK)
        status = co_assembly_create(l->mesh, f->options, f->tables, face_weight, &l->assembly, error);
    free(face_weight);
    if (status == CURVOPT_OK && f->options->method != CURVOPT_METHOD_LMVM && l->reduction.n_variables)
        status = create_model(l, error);
    return status;
}

int32_t co_level_create(const co_run_context *frame, const curvopt_mesh *mesh, const co_symmetry *symmetry,
                        const co_constraints *constraints, const double *start, int32_t number, co_level *l, double *z,
                        curvopt_error *error) {
    size_t n = (size_t)mesh->info.n_vertices;
    const curvopt_options *o = frame->options;
    *l = (co_level){.frame = frame,
                    .mesh = mesh,
                    .start = start,
                    .number = number,
                    .error = error,
                    .x = CO_NEW(double, 3 * n),
                    .gx = CO_NEW(double, 3 * n),
                    .step = CO_NEW(double, 3 * n),
                    .normalized = CO_NEW(double, 3 * n),
                    .first = CO_NEW(double, 3 * n),
                    .safe = CO_NEW(double, 3 * n)};
    l->tolerance = o->as_report ? (double)INFINITY : o->tolerance;
    l->working_tolerance = number < o->levels ? WORKING_FACTOR * l->tolerance : l->tolerance;
    int32_t status =
        l->x && l->gx && l->step && l->normalized && l->first && l->safe ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = co_constraints_all(mesh, constraints, o->boundary, &l->hold, error);
    l->gauge = co_gauge_of(o->weights, &l->hold);
    if (status == CURVOPT_OK)
        status = create_parts(l, symmetry, z, error);
    if (status != CURVOPT_OK)
        co_level_free(l);
    return status;
}

void co_level_free(co_level *l) {
    co_newton_system_free(&l->model);
    co_assembly_free(&l->assembly);
    co_dof_map_free(&l->reduction);
    co_penalty_free(&l->pull);
    co_constraints_free(&l->hold);
    free(l->x);
    free(l->gx);
    free(l->step);
    free(l->normalized);
    free(l->first);
    free(l->safe);
    *l = (co_level){0};
}

int32_t co_level_begin(co_level *l, co_iterate *now, curvopt_error *error) {
    curvopt_energies energies;
    int resolved, changed;
    co_dof_map_expand(&l->reduction, now->x, l->x);
    int32_t status = co_adaptive_quadrature_resolve(&l->assembly, l->x,
                                                    &(co_quadrature_goal){l->working_tolerance, CO_TERMS_OBJECTIVE, 1},
                                                    &energies, &resolved, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    l->defect = energies.gauss_bonnet_defect;
    memcpy(l->first, now->x, sizeof(double) * (size_t)l->reduction.n_variables);
    memcpy(l->safe, now->x, sizeof(double) * (size_t)l->reduction.n_variables);
    now->value = value_at(l, now->x, now->gradient);
    if (!isfinite(now->value) || !isfinite(co_vector_norm((size_t)l->reduction.n_variables, now->gradient)))
        return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, l->last.worst_face,
                              "the energy is not finite: the surface is degenerate at face %d", l->last.worst_face);
    return CURVOPT_OK;
}

void co_level_to_user(const co_level *l, const double *z, double normalized_area, double *xyz) {
    size_t n = (size_t)l->mesh->info.n_vertices;
    co_dof_map_expand(&l->reduction, z, xyz);
    if (is_fixed(l)) {
        for (size_t i = 0; i < 3 * n; i++)
            xyz[i] = l->hold.freedom[i / 3] == CO_FREEDOM_NONE ? l->start[i]
                                                               : l->frame->centroid[i % 3] + l->frame->radius * xyz[i];
        return;
    }
    double scale = sqrt(l->frame->area / normalized_area);
    for (size_t i = 0; i < 3 * n; i++)
        xyz[i] *= scale;
    co_similarity_align(n, l->start, xyz);
}

int32_t co_level_finish(co_level *l, const co_iterate *now, double *xyz, curvopt_energies *energies, int *resolved,
                        curvopt_error *error) {
    int changed;
    co_dof_map_expand(&l->reduction, now->x, l->x);
    int32_t status =
        co_adaptive_quadrature_resolve(&l->assembly, l->x, &(co_quadrature_goal){l->tolerance, CO_TERMS_REPORT, 1},
                                       energies, resolved, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    co_level_to_user(l, now->x, energies->area, xyz);
    double unit = is_fixed(l) ? l->frame->radius * l->frame->radius : l->frame->area / energies->area;
    energies->area_error *= unit;
    energies->area = is_fixed(l) ? unit * energies->area : l->frame->area;
    return CURVOPT_OK;
}

double co_level_evaluate(co_level *l, const double *z, double *gradient) {
    return value_at(l, z, gradient);
}

int32_t co_level_factorize(co_level *l, const co_iterate *now, int exact, int *positive, curvopt_error *error) {
    int32_t status = assemble_model(l, now, (co_second_kind){.exact = exact}, co_gauge_exact(l->gauge), error);
    return status == CURVOPT_OK ? co_newton_system_factorize(&l->model, least_shift(l, now->value), positive, error)
                                : status;
}

/* A step of a level's longest, or shorter by halves, either way along d; 1, and `now` is there, if one brings a
 * decrease worth the name. trial [n_variables], d is spoilt */
static int step_down(co_level *l, double *d, double *trial, co_iterate *now) {
    size_t n = (size_t)l->reduction.n_variables;
    double least = WORTH_LEAVING * fabs(now->value);
    double scale = l->frame->options->max_step / step_length(l, d);
    for (int halving = 0; halving < 2 * SADDLE_HALVINGS; halving++, scale *= halving % 2 ? -0.5 : -1) {
        memcpy(trial, now->x, n * sizeof *trial);
        co_vector_add(n, scale, d, trial);
        if (value_at(l, trial, NULL) < now->value - least) {
            memcpy(now->x, trial, n * sizeof *trial);
            now->value = value_at(l, now->x, now->gradient);
            return 1;
        }
    }
    return 0;
}

int32_t co_level_leave_saddle(co_level *l, co_iterate *now, int *left, curvopt_error *error) {
    size_t n = (size_t)l->reduction.n_variables;
    double *d = CO_NEW(double, 2 * n);
    *left = 0;
    int32_t status =
        d ? assemble_model(l, now, (co_second_kind){.exact = 1}, l->gauge, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = factorize_shifted(l, least_shift(l, now->value), error);
    if (status == CURVOPT_OK && most_negative(l, now, d))
        *left = step_down(l, d, d + n, now);
    if (status == CURVOPT_OK)
        status = l->failed;
    free(d);
    return status;
}

int32_t co_level_count_negative(co_level *l, const co_iterate *now, int32_t *n_negative, curvopt_error *error) {
    *n_negative = l->reduction.n_variables > LARGEST_COUNT ? -1 : 0;
    if (l->reduction.n_variables == 0 || *n_negative < 0)
        return CURVOPT_OK;
    int32_t status = assemble_model(l, now, (co_second_kind){.exact = 1}, l->gauge, error);
    return status == CURVOPT_OK
               ? co_newton_system_count_negative(&l->model, least_shift(l, now->value), n_negative, error)
               : status;
}
