/* Exported functions that evaluate a surface. SPDX-License-Identifier: GPL-3.0-or-later */
#include "api/api.h"
#include "base/clock.h"
#include "base/memory.h"
#include "energy/adaptive_quadrature.h"
#include "energy/admissibility.h"
#include "mesh/similarity.h"
#include "surface/evaluate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The weights of a whole cage's faces: 0 where they are left out; NULL if none is. */
static int32_t weigh_faces(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options, double **weight,
                           curvopt_error *error) {
    co_exceptions found;
    *weight = NULL;
    int32_t status = co_exceptions_of_run(mesh, xyz, options, &found, error);
    if (status == CURVOPT_OK && found.n_left_out) {
        *weight = CO_NEW(double, mesh->info.n_faces);
        status = *weight ? CURVOPT_OK : co_status_no_memory(error);
    }
    for (int32_t f = 0; *weight && f < mesh->info.n_faces; f++)
        (*weight)[f] = found.face[f] < 0;
    co_exceptions_free(&found);
    return status;
}

/* ---------------------------------------------------------------------------------- what a call is watched by -- */

static void tell(curvopt_problem *p) {
    p->told.seconds = co_clock_seconds() - p->started;
    if (p->watch.progress && p->watch.progress(&p->told, p->watch.user) != 0)
        p->cancel.flag = &p->stopped;
}

static void tell_of_table(void *user) {
    tell(user);
}

static void tell_of_evaluation(void *user, const co_values *values) {
    curvopt_problem *p = user;
    p->told.evaluations = ++p->told.iteration;
    p->told.energy = values->objective;
    p->told.samples = p->assembly.batches.n_samples > INT32_MAX ? INT32_MAX : (int32_t)p->assembly.batches.n_samples;
    tell(p);
}

/* A call begins, about n_vertices vertices, at xyz, which may be NULL. */
static void watch_begin(curvopt_problem *p, const co_watch *watch, int32_t n_vertices, const double *xyz) {
    const double unknown = (double)NAN;
    p->watch = *watch;
    p->started = co_clock_seconds();
    p->told = (curvopt_progress){.struct_size = (int32_t)sizeof p->told,
                                 .level = 1,
                                 .levels = 1,
                                 .n_vertices = n_vertices,
                                 .xyz = xyz,
                                 .energy = unknown,
                                 .start_energy = unknown,
                                 .gradient_norm = unknown,
                                 .predicted = unknown,
                                 .shift = unknown,
                                 .gain_ratio = unknown,
                                 .step = unknown};
    co_cancel_start_at_once(&p->cancel, watch->cancel);
    p->tables.made = watch->progress ? tell_of_table : NULL;
    p->tables.user = p;
}

/* It ends. What it was told by may be gone when the next one begins. The callback may have ended it at its last call,
 * after which nobody looked at the flag. */
static int32_t watch_end(curvopt_problem *p, int32_t status, curvopt_error *error) {
    if (status == CURVOPT_OK && p->cancel.flag == &p->stopped)
        status = CO_CANCELLED;
    p->cancel.flag = NULL;
    p->tables.made = NULL;
    p->watch = (co_watch){.progress = NULL};
    return status == CO_CANCELLED ? co_status_fail(error, CURVOPT_ERROR_CANCELLED, -1, "it was cancelled") : status;
}

/* -------------------------------------------------------------------------------------------------- problems -- */

/* The assembly, with tables and threads that are the problem's. */
static int32_t assemble(curvopt_problem *p, const curvopt_mesh *mesh, const double *xyz, const double *face_weight,
                        const curvopt_options *options, curvopt_error *error) {
    double *own_weight = NULL;
    int32_t status = co_thread_pool_create(options->threads, &p->threads, error);
    if (status == CURVOPT_OK && !face_weight)
        status = weigh_faces(mesh, xyz, options, &own_weight, error);
    p->tables.threads = p->threads;
    if (status == CURVOPT_OK)
        status = co_assembly_create(mesh, xyz, NULL, options, &p->tables, face_weight ? face_weight : own_weight,
                                    &p->assembly, error);
    p->assembly.leaves_out = own_weight != NULL;
    free(own_weight);
    return status;
}

static void free_problem(curvopt_problem *p) {
    co_assembly_free(&p->assembly);
    co_basis_table_cache_free(&p->tables);
    co_thread_pool_destroy(p->threads);
    free(p);
}

int32_t co_api_create_problem(const curvopt_mesh *mesh, const double *xyz, const double *face_weight,
                              const curvopt_options *options, const co_watch *watch, curvopt_problem **out,
                              curvopt_error *error) {
    if (!out)
        return co_api_null(error, "out");
    *out = NULL;
    if (!mesh)
        return co_api_null(error, "mesh");
    curvopt_options own;
    int32_t status = co_api_take_options(options, &own, error);
    if (status == CURVOPT_OK && xyz)
        status = co_similarity_check(mesh->info.n_vertices, xyz, error);
    if (status != CURVOPT_OK)
        return status;
    if (face_weight && own.surface == CURVOPT_SURFACE_POLYNOMIAL && own.blend_width != 1)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1,
                              "blend_width is %d; for a part it must be 1: a part does not show how far it is to the "
                              "next vertex that is not regular",
                              own.blend_width);
    if (face_weight && own.spontaneous_curvature != 0)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1,
                              "spontaneous_curvature is %g; for a part it must be 0: a part does not know the numbers "
                              "of the whole surface",
                              own.spontaneous_curvature);
    curvopt_problem *p = CO_NEW(curvopt_problem, 1);
    if (!p)
        return co_status_no_memory(error);
    atomic_store(&p->stopped.requested, 1);
    p->is_part = face_weight != NULL;
    p->tolerance = own.joshi_sequin ? (double)INFINITY : own.tolerance;
    p->n_faces = mesh->info.n_faces;
    co_basis_table_cache_create(own.surface, &p->tables);
    p->tables.cancel = &p->cancel;
    watch_begin(p, watch, mesh->info.n_vertices, xyz);
    status = watch_end(p, assemble(p, mesh, xyz, face_weight, &own, error), error);
    if (status == CURVOPT_OK)
        *out = p;
    else
        free_problem(p);
    return status;
}

int32_t curvopt_problem_create(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                               curvopt_problem **out, curvopt_error *error) {
    return co_api_create_problem(mesh, xyz, NULL, options, &(co_watch){.progress = NULL}, out, error);
}

int32_t curvopt_problem_create_interruptible(const curvopt_mesh *mesh, const double *xyz,
                                             const curvopt_options *options, curvopt_progress_fn progress, void *user,
                                             const curvopt_cancel *cancel, curvopt_problem **out,
                                             curvopt_error *error) {
    return co_api_create_problem(mesh, xyz, NULL, options, &(co_watch){progress, user, cancel}, out, error);
}

void curvopt_problem_destroy(curvopt_problem *problem) {
    if (problem)
        free_problem(problem);
}

/* The gradient at xyz into gradient [3 n_vertices], which is written only if it is finite. */
static int32_t evaluate_gradient(co_assembly *a, const double *xyz, double *gradient, curvopt_error *error) {
    const size_t n = 3 * (size_t)a->patches.n_cage;
    double *own = CO_NEW(double, n);
    co_values values;
    int32_t status = CURVOPT_OK;
    if (!own)
        return co_status_no_memory(error);
    co_assembly_evaluate(a, xyz, &(co_request){.gradient = own}, &values);
    if (co_cancel_is_due(a->cancel)) /* something may be missing */
        status = CO_CANCELLED;
    for (size_t i = 0; i < n && status == CURVOPT_OK; i++)
        if (!isfinite(own[i]))
            status = co_status_fail(error, CURVOPT_ERROR_GEOMETRY, (int32_t)(i / 3),
                                    "the energy's gradient is not finite at vertex %d: the surface is degenerate there",
                                    (int32_t)(i / 3));
    if (status == CURVOPT_OK)
        memcpy(gradient, own, n * sizeof *own);
    free(own);
    return status;
}

/* Energies, and unless it is NULL the gradient, once positions have been checked. Cancelled, it leaves batches that fit
 * the rules: tables of finer rules are made for an estimate before any rule is raised. */
static int32_t evaluate(curvopt_problem *p, const double *xyz, curvopt_energies *energies, double *gradient,
                        curvopt_error *error) {
    co_assembly *a = &p->assembly;
    const co_quadrature_goal goal = {
        .tolerance = p->tolerance, .terms = CO_TERMS_ALL, .evaluated = tell_of_evaluation, .user = p};
    int resolved, changed;
    int32_t status = co_adaptive_quadrature_resolve(a, xyz, &goal, energies, &resolved, &changed, error);
    if (status == CURVOPT_OK && !isinf(p->tolerance))
        status = co_adaptive_quadrature_check(a, energies, error);
    if (status == CURVOPT_OK && gradient)
        status = evaluate_gradient(a, xyz, gradient, error);
    return status;
}

static int32_t evaluate_watched(curvopt_problem *problem, const double *xyz, const co_watch *watch,
                                curvopt_energies *out, size_t size, double *gradient, curvopt_error *error) {
    curvopt_energies energies;
    if (!problem || !xyz || !out)
        return co_api_null(error, !problem ? "problem" : !xyz ? "xyz" : "out");
    if (problem->is_part)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1,
                              "curvopt_problem_evaluate takes no part of a surface; use curvopt_problem_sum");
    int32_t status = co_similarity_check(problem->assembly.patches.n_cage, xyz, error);
    if (status != CURVOPT_OK)
        return status;
    watch_begin(problem, watch, problem->assembly.patches.n_cage, xyz);
    status = watch_end(problem, evaluate(problem, xyz, &energies, gradient, error), error);
    if (status == CURVOPT_OK)
        co_api_copy_out(out, size, &energies, sizeof energies);
    return status;
}

int32_t curvopt_problem_evaluate(curvopt_problem *problem, const double *xyz, curvopt_energies *out, size_t size,
                                 double *gradient, curvopt_error *error) {
    return evaluate_watched(problem, xyz, &(co_watch){.progress = NULL}, out, size, gradient, error);
}

int32_t curvopt_problem_evaluate_interruptible(curvopt_problem *problem, const double *xyz,
                                               curvopt_progress_fn progress, void *user, const curvopt_cancel *cancel,
                                               curvopt_energies *out, size_t size, double *gradient,
                                               curvopt_error *error) {
    return evaluate_watched(problem, xyz, &(co_watch){progress, user, cancel}, out, size, gradient, error);
}

/* -------------------------------------------------------------------------------------------------- samplers -- */

struct curvopt_sampler {
    co_sampler sampler;
};

int32_t curvopt_sampler_create(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                               curvopt_sampler **out, curvopt_error *error) {
    if (!out)
        return co_api_null(error, "out");
    *out = NULL;
    curvopt_options own;
    int32_t status = co_api_take_cage(mesh, xyz, options, &own, error);
    if (status != CURVOPT_OK)
        return status;
    curvopt_sampler *s = CO_NEW(curvopt_sampler, 1);
    if (!s)
        return co_status_no_memory(error);
    status = co_sampler_create(mesh, xyz, own.surface, own.blend_width, &s->sampler, error);
    if (status == CURVOPT_OK)
        *out = s;
    else
        free(s);
    return status;
}

void curvopt_sampler_destroy(curvopt_sampler *sampler) {
    if (!sampler)
        return;
    co_sampler_free(&sampler->sampler);
    free(sampler);
}

int32_t curvopt_sampler_jets(curvopt_sampler *sampler, int32_t n, const int32_t *face, const int32_t *corner,
                             const double *uv, double *jets, curvopt_error *error) {
    if (!sampler || !face || !corner || !uv || !jets)
        return co_api_null(error, !sampler ? "sampler" : !face ? "face" : !corner ? "corner" : !uv ? "uv" : "jets");
    if (n < 0)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "n is %d; it must not be negative", n);
    return co_sampler_jets(&sampler->sampler, n, face, corner, uv, jets, error);
}
