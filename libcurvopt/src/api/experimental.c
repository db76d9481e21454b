/* The functions of curvopt_experimental.h. SPDX-License-Identifier: GPL-3.0-or-later */
#include "curvopt_experimental.h"

#include "api/api.h"
#include "base/memory.h"
#include "hessian/subdomain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct curvopt_hessian {
    co_dof_map reduction;
    co_sparse_hessian hessian;
    curvopt_problem *problem;
};

int32_t curvopt_mesh_part(const curvopt_mesh *mesh, const double *face_weight, curvopt_mesh **out, int32_t *vertex_of,
                          int32_t *face_of, curvopt_error *error) {
    if (!out)
        return co_api_null(error, "out");
    *out = NULL;
    if (!mesh || !face_weight || !vertex_of || !face_of)
        return co_api_null(error, !mesh ? "mesh" : "an array");
    return co_subdomain_extract(mesh, face_weight, out, vertex_of, face_of, error);
}

static int32_t check_face_weights(const double *weight, int32_t n_faces, curvopt_error *error) {
    int any = 0;
    for (int32_t f = 0; f < n_faces; f++) {
        if (!(weight[f] >= 0) || !isfinite(weight[f]))
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, f,
                                  "face_weight[%d] is %g; it must be finite and not negative", f, weight[f]);
        any |= weight[f] > 0;
    }
    return any ? CURVOPT_OK : co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "no face counts: all weights are 0");
}

int32_t curvopt_problem_create_part(const curvopt_mesh *mesh, const double *face_weight, const curvopt_options *options,
                                    curvopt_problem **out, curvopt_error *error) {
    if (!out)
        return co_api_null(error, "out");
    *out = NULL;
    if (!mesh || !face_weight)
        return co_api_null(error, mesh ? "face_weight" : "mesh");
    int32_t status = check_face_weights(face_weight, mesh->info.n_faces, error);
    return status == CURVOPT_OK
               ? co_api_create_problem(mesh, NULL, face_weight, options, &(co_watch){.progress = NULL}, out, error)
               : status;
}

int32_t curvopt_problem_sum(curvopt_problem *problem, const double *xyz, int32_t all_terms, double *gradients,
                            curvopt_sums *out, curvopt_error *error) {
    if (!problem || !xyz || !out)
        return co_api_null(error, !problem ? "problem" : !xyz ? "xyz" : "out");
    co_subdomain_sum(&problem->assembly, xyz, all_terms, gradients, out);
    return CURVOPT_OK;
}

void curvopt_problem_get_rules(const curvopt_problem *problem, int32_t *rules) {
    co_subdomain_get_rules(&problem->assembly, problem->n_faces, rules);
}

int32_t curvopt_problem_set_rules(curvopt_problem *problem, const int32_t *rules, curvopt_error *error) {
    if (!problem || !rules)
        return co_api_null(error, problem ? "rules" : "problem");
    return co_subdomain_set_rules(&problem->assembly, rules, error);
}

int32_t curvopt_problem_face_errors(curvopt_problem *problem, const double *xyz, double area, double third,
                                    double *errors, curvopt_error *error) {
    if (!problem || !xyz || !errors)
        return co_api_null(error, !problem ? "problem" : !xyz ? "xyz" : "errors");
    memset(errors, 0, sizeof *errors * (size_t)problem->n_faces);
    return co_subdomain_errors(&problem->assembly, xyz, &(co_whole){area, third}, errors, error);
}

int32_t curvopt_hessian_create(curvopt_problem *problem, curvopt_hessian **out, curvopt_error *error) {
    if (!out)
        return co_api_null(error, "out");
    *out = NULL;
    if (!problem)
        return co_api_null(error, "problem");
    curvopt_hessian *h = CO_NEW(curvopt_hessian, 1);
    if (!h)
        return co_status_no_memory(error);
    h->problem = problem;
    int32_t status = co_dof_map_identity(problem->assembly.patches.n_cage, &h->reduction, error);
    if (status == CURVOPT_OK)
        status = co_sparse_hessian_create(&problem->assembly, &h->reduction, NULL, &h->hessian, error);
    if (status != CURVOPT_OK)
        curvopt_hessian_destroy(h);
    else
        *out = h;
    return status;
}

void curvopt_hessian_destroy(curvopt_hessian *hessian) {
    if (!hessian)
        return;
    co_sparse_hessian_free(&hessian->hessian);
    co_dof_map_free(&hessian->reduction);
    free(hessian);
}

void curvopt_hessian_get(const curvopt_hessian *hessian, curvopt_matrix *out) {
    const co_sparse_hessian *h = &hessian->hessian;
    *out = (curvopt_matrix){.column_start = h->pattern.column_start,
                            .row = h->pattern.row,
                            .value = h->value,
                            .n = hessian->reduction.n_variables};
}

int32_t curvopt_hessian_assemble(curvopt_hessian *hessian, const double *xyz, int32_t exact, double area, double third,
                                 curvopt_error *error) {
    if (!hessian || !xyz)
        return co_api_null(error, hessian ? "xyz" : "hessian");
    co_assembly *a = &hessian->problem->assembly;
    const co_second_kind kind = {
        .exact = exact, .whole = &(co_whole){area, third}, .coarser = exact ? 0 : CO_COARSEST_RULES};
    return co_sparse_hessian_assemble(a, xyz, &kind, &hessian->hessian, error);
}
