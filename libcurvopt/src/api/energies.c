/* Exported functions that evaluate a surface. SPDX-License-Identifier: GPL-3.0-or-later */
#include "api/api.h"
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

int32_t co_api_create_problem(const curvopt_mesh *mesh, const double *xyz, const double *face_weight,
                              const curvopt_options *options, curvopt_problem **out, curvopt_error *error) {
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
    double *own_weight = NULL;
    status = face_weight ? CURVOPT_OK : weigh_faces(mesh, xyz, &own, &own_weight, error);
    if (status != CURVOPT_OK)
        return status;
    curvopt_problem *p = CO_NEW(curvopt_problem, 1);
    if (!p) {
        free(own_weight);
        return co_status_no_memory(error);
    }
    p->is_part = face_weight != NULL;
    p->tolerance = own.joshi_sequin ? (double)INFINITY : own.tolerance;
    p->n_faces = mesh->info.n_faces;
    status =
        co_assembly_create(mesh, xyz, NULL, &own, NULL, face_weight ? face_weight : own_weight, &p->assembly, error);
    p->assembly.leaves_out = own_weight != NULL;
    free(own_weight);
    if (status != CURVOPT_OK) {
        free(p);
        return status;
    }
    *out = p;
    return CURVOPT_OK;
}

int32_t curvopt_problem_create(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                               curvopt_problem **out, curvopt_error *error) {
    return co_api_create_problem(mesh, xyz, NULL, options, out, error);
}

void curvopt_problem_destroy(curvopt_problem *problem) {
    if (!problem)
        return;
    co_assembly_free(&problem->assembly);
    free(problem);
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

int32_t curvopt_problem_evaluate(curvopt_problem *problem, const double *xyz, curvopt_energies *out, size_t size,
                                 double *gradient, curvopt_error *error) {
    curvopt_energies energies;
    int resolved, changed;
    if (!problem || !xyz || !out)
        return co_api_null(error, !problem ? "problem" : !xyz ? "xyz" : "out");
    co_assembly *a = &problem->assembly;
    if (problem->is_part)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1,
                              "curvopt_problem_evaluate takes no part of a surface; use curvopt_problem_sum");
    int32_t status = co_similarity_check(a->patches.n_cage, xyz, error);
    if (status == CURVOPT_OK)
        status = co_adaptive_quadrature_resolve(a, xyz, &(co_quadrature_goal){problem->tolerance, CO_TERMS_ALL, 0},
                                                &energies, &resolved, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    status = isinf(problem->tolerance) ? CURVOPT_OK : co_adaptive_quadrature_check(a, &energies, error);
    if (status != CURVOPT_OK)
        return status;
    if (gradient)
        status = evaluate_gradient(a, xyz, gradient, error);
    if (status != CURVOPT_OK)
        return status;
    co_api_copy_out(out, size, &energies, sizeof energies);
    return CURVOPT_OK;
}

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
