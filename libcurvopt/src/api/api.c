/* The exported functions: arguments are checked here, work is done elsewhere. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "base/memory.h"
#include "hessian/subdomain.h"
#include "mesh/similarity.h"
#include "mesh/subdivide.h"
#include "solve/multilevel.h"
#include "surface/evaluate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STRING_(x) #x
#define STRING(x)  STRING_(x)

struct curvopt_problem {
    co_assembly assembly;
    double tolerance;
    int32_t n_faces;
};

struct curvopt_hessian {
    co_dof_map reduction;
    co_sparse_hessian hessian;
    curvopt_problem *problem;
};

static int32_t null_argument(curvopt_error *error, const char *name) {
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "%s is NULL", name);
}

const char *curvopt_status_text(int32_t status) {
    switch (status) {
#define STATUS_CASE(name, value, text)                                                                                 \
    case value:                                                                                                        \
        return text;
        CURVOPT_STATUS_LIST(STATUS_CASE)
#undef STATUS_CASE
    default:
        return "unknown status";
    }
}

const char *curvopt_stop_text(int32_t stop) {
    static const char *const text[] = {"converged", "stalled", "limit", "cancelled", "unresolved", "settled"};
    return stop >= 0 && stop < (int32_t)(sizeof text / sizeof *text) ? text[stop] : "unknown";
}

const char *curvopt_verdict_text(int32_t verdict) {
    static const char *const text[] = {"unknown", "minimum", "saddle", "not stationary"};
    return verdict >= 0 && verdict < (int32_t)(sizeof text / sizeof *text) ? text[verdict] : "unknown";
}

const char *curvopt_version(void) {
    return STRING(CURVOPT_VERSION_MAJOR) "." STRING(CURVOPT_VERSION_MINOR) "." STRING(CURVOPT_VERSION_PATCH);
}

/* ------------------------------------------------------------------------------------------------- meshes -- */

int32_t curvopt_mesh_create(int32_t n_vertices, int32_t n_faces, const int32_t *face_sizes,
                            const int32_t *face_vertices, curvopt_mesh **out, curvopt_error *error) {
    return co_mesh_create(n_vertices, n_faces, face_sizes, face_vertices, out, error);
}

void curvopt_mesh_destroy(curvopt_mesh *mesh) {
    co_mesh_destroy(mesh);
}

void curvopt_mesh_get_info(const curvopt_mesh *mesh, curvopt_mesh_info *info) {
    *info = mesh->info;
}

void curvopt_mesh_get_faces(const curvopt_mesh *mesh, int32_t *face_sizes, int32_t *face_vertices) {
    for (int32_t f = 0; f < mesh->info.n_faces; f++)
        face_sizes[f] = co_mesh_face_size(mesh, f);
    memcpy(face_vertices, mesh->corner_vertex, sizeof(int32_t) * (size_t)mesh->info.n_corners);
}

int32_t curvopt_mesh_refine(const curvopt_mesh *mesh, const double *xyz, curvopt_mesh **out, double *fine_xyz,
                            curvopt_error *error) {
    co_sparse_rows rows = {0};
    if (!out)
        return null_argument(error, "out");
    *out = NULL;
    if (!mesh)
        return null_argument(error, "mesh");
    if (!xyz != !fine_xyz)
        return null_argument(error, xyz ? "fine_xyz" : "xyz");
    int32_t status = co_subdivide(mesh, out, xyz ? &rows : NULL, error);
    if (status == CURVOPT_OK && xyz)
        co_sparse_rows_apply(&rows, xyz, fine_xyz);
    co_sparse_rows_free(&rows);
    return status;
}

/* ------------------------------------------------------------------------------------------------ options -- */

void curvopt_options_init(curvopt_options *options) {
    memset(options, 0, sizeof *options);
    options->struct_size = (int32_t)sizeof *options;
    options->levels = 4;
    options->max_iterations = 3000;
    options->weights[CURVOPT_TERM_WILLMORE] = 1;
    options->tolerance = 1e-4;
    options->gradient_tolerance = 1e-6;
    options->decrement_tolerance = 2e-7;
    options->max_step = 0.5;
    options->blend_width = CO_BLEND_DISC_LARGEST;
}

static int32_t check_integer(const char *name, int32_t value, int32_t low, int32_t high, curvopt_error *error) {
    if (value >= low && value <= high)
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "%s is %d; it must be %d to %d", name, value, low, high);
}

static int32_t check_real(const char *name, double value, double low, double high, curvopt_error *error) {
    if (value >= low && value <= high)
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "%s is %g; it must be %g to %g", name, value, low, high);
}

static int32_t check_weights(const double *weights, curvopt_error *error) {
    double sum = 0;
    for (int t = 0; t < 8; t++) {
        if (!(weights[t] >= 0) || !isfinite(weights[t]) || (t >= CURVOPT_N_TERMS && weights[t] != 0))
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, t, "weights[%d] is %g; it must be %s", t, weights[t],
                                  t >= CURVOPT_N_TERMS ? "0: there is no such term" : "finite and not negative");
        sum += weights[t];
    }
    if (!(sum > 0) || !isfinite(sum))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "weights add up to %g: nothing to minimize", sum);
    return CURVOPT_OK;
}

static int32_t check_planes(const curvopt_options *o, curvopt_error *error) {
    int chosen = o->symmetry == CURVOPT_SYMMETRY_PLANES;
    int32_t status = check_integer("symmetry_planes", o->symmetry_planes, chosen, chosen ? 7 : 0, error);
    if (status == CURVOPT_OK && chosen && o->as_report)
        status =
            co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "as_report keeps no symmetries: there are no planes");
    return status;
}

int32_t curvopt_options_validate(const curvopt_options *o, curvopt_error *error) {
    if (!o)
        return null_argument(error, "options");
    int32_t status = check_integer("struct_size", o->struct_size, sizeof *o, sizeof *o, error);
    if (status == CURVOPT_OK)
        status = check_integer("surface", o->surface, CURVOPT_SURFACE_AUTO, CURVOPT_SURFACE_POLYNOMIAL, error);
    if (status == CURVOPT_OK)
        status = check_integer("method", o->method, CURVOPT_METHOD_AUTO, CURVOPT_METHOD_GAUSS_NEWTON, error);
    if (status == CURVOPT_OK)
        status = check_integer("levels", o->levels, 1, 12, error);
    if (status == CURVOPT_OK)
        status = check_integer("max_iterations", o->max_iterations, 0, INT32_MAX, error);
    if (status == CURVOPT_OK)
        status = check_integer("threads", o->threads, 0, 1024, error);
    if (status == CURVOPT_OK)
        status = check_integer("as_report", o->as_report, 0, 1, error);
    if (status == CURVOPT_OK)
        status = check_integer("boundary", o->boundary, CURVOPT_BOUNDARY_POSITION, CURVOPT_BOUNDARY_FREE, error);
    if (status == CURVOPT_OK)
        status = check_weights(o->weights, error);
    if (status == CURVOPT_OK)
        status = check_real("tolerance", o->tolerance, 1e-12, 0.5, error);
    if (status == CURVOPT_OK)
        status = check_real("gradient_tolerance", o->gradient_tolerance, 1e-15, 1, error);
    if (status == CURVOPT_OK)
        status = check_real("decrement_tolerance", o->decrement_tolerance, 1e-15, 1, error);
    if (status == CURVOPT_OK)
        status = check_real("max_step", o->max_step, 1e-6, 100, error);
    if (status == CURVOPT_OK)
        status = check_integer("symmetry", o->symmetry, CURVOPT_SYMMETRY_AUTO, CURVOPT_SYMMETRY_PLANES, error);
    if (status == CURVOPT_OK)
        status = check_integer("verify", o->verify, 0, 1, error);
    if (status == CURVOPT_OK)
        status = check_integer("escape", o->escape, 0, 1, error);
    if (status == CURVOPT_OK)
        status = check_integer("blend_width", o->blend_width, 1, CO_BLEND_DISC_LARGEST, error);
    if (status == CURVOPT_OK)
        status = check_integer("reserved", o->reserved, 0, 0, error);
    if (status == CURVOPT_OK)
        status = check_planes(o, error);
    return status;
}

/* Options with AUTO resolved for this mesh. */
static curvopt_options settle_options(const curvopt_options *options) {
    curvopt_options o = *options;
    int third = co_functional_of_weights(o.weights).has_third;
    if (o.surface == CURVOPT_SURFACE_AUTO)
        o.surface = !third ? CURVOPT_SURFACE_LIMIT : o.as_report ? CURVOPT_SURFACE_PLANE : CURVOPT_SURFACE_POLYNOMIAL;
    if (o.method == CURVOPT_METHOD_AUTO)
        o.method = o.as_report ? CURVOPT_METHOD_LMVM : CURVOPT_METHOD_GAUSS_NEWTON;
    if (o.method == CURVOPT_METHOD_LMVM && o.symmetry == CURVOPT_SYMMETRY_AUTO)
        o.symmetry = CURVOPT_SYMMETRY_NONE;
    return o;
}

/* ----------------------------------------------------------------------------------------------- energies -- */

static int32_t create_problem(const curvopt_mesh *mesh, const double *face_weight, const curvopt_options *options,
                              curvopt_problem **out, curvopt_error *error) {
    if (!out)
        return null_argument(error, "out");
    *out = NULL;
    if (!mesh)
        return null_argument(error, "mesh");
    int32_t status = curvopt_options_validate(options, error);
    if (status != CURVOPT_OK)
        return status;
    curvopt_options settled = settle_options(options);
    if (face_weight && settled.surface == CURVOPT_SURFACE_POLYNOMIAL && settled.blend_width != 1)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1,
                              "blend_width is %d; for a part it must be 1: a part does not show how far it is to the "
                              "next vertex that is not regular",
                              settled.blend_width);
    curvopt_problem *p = CO_NEW(curvopt_problem, 1);
    if (!p)
        return co_status_no_memory(error);
    p->tolerance = settled.as_report ? (double)INFINITY : settled.tolerance;
    p->n_faces = mesh->info.n_faces;
    status = co_assembly_create(mesh, &settled, NULL, face_weight, &p->assembly, error);
    if (status != CURVOPT_OK) {
        free(p);
        return status;
    }
    *out = p;
    return CURVOPT_OK;
}

int32_t curvopt_problem_create(const curvopt_mesh *mesh, const curvopt_options *options, curvopt_problem **out,
                               curvopt_error *error) {
    return create_problem(mesh, NULL, options, out, error);
}

void curvopt_problem_destroy(curvopt_problem *problem) {
    if (!problem)
        return;
    co_assembly_free(&problem->assembly);
    free(problem);
}

int32_t curvopt_problem_evaluate(curvopt_problem *problem, const double *xyz, curvopt_energies *out, double *gradient,
                                 curvopt_error *error) {
    curvopt_energies energies;
    int resolved, changed;
    if (!problem || !xyz || !out)
        return null_argument(error, !problem ? "problem" : !xyz ? "xyz" : "out");
    co_assembly *a = &problem->assembly;
    if (a->weight)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "the problem is of a part: curvopt_problem_sum");
    int32_t status = co_similarity_check(a->patches.n_cage, xyz, error);
    if (status == CURVOPT_OK)
        status = co_adaptive_quadrature_resolve(a, xyz, &(co_quadrature_goal){problem->tolerance, CO_TERMS_ALL, 0},
                                                &energies, &resolved, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    status = isinf(problem->tolerance) ? CURVOPT_OK : co_adaptive_quadrature_check(a, &energies, error);
    if (status != CURVOPT_OK)
        return status;
    if (gradient) {
        co_values values;
        co_assembly_evaluate(a, xyz, &(co_request){.gradient = gradient}, &values);
    }
    *out = energies;
    return CURVOPT_OK;
}

int32_t curvopt_surface_jets(const curvopt_mesh *mesh, const double *xyz, int32_t surface, int32_t n,
                             const int32_t *face, const int32_t *corner, const double *uv, double *jets,
                             curvopt_error *error) {
    if (!mesh || !xyz || !face || !corner || !uv || !jets)
        return null_argument(error, "an array");
    int32_t status = check_integer("surface", surface, CURVOPT_SURFACE_LIMIT, CURVOPT_SURFACE_POLYNOMIAL, error);
    if (status != CURVOPT_OK)
        return status;
    if (n < 0)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "n is %d", n);
    status = co_similarity_check(mesh->info.n_vertices, xyz, error);
    return status == CURVOPT_OK ? co_evaluate_jets(mesh, xyz, surface, n, face, corner, uv, jets, error) : status;
}

/* --------------------------------------------------------------------------------------------- minimizing -- */

int32_t curvopt_cancel_create(curvopt_cancel **out, curvopt_error *error) {
    if (!out)
        return null_argument(error, "out");
    *out = CO_NEW(curvopt_cancel, 1);
    return *out ? CURVOPT_OK : co_status_no_memory(error);
}

void curvopt_cancel_request(curvopt_cancel *cancel) {
    atomic_store_explicit(&cancel->requested, 1, memory_order_relaxed);
}

void curvopt_cancel_destroy(curvopt_cancel *cancel) {
    free(cancel);
}

int32_t curvopt_minimize(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                         curvopt_progress_fn progress, void *user, const curvopt_cancel *cancel, curvopt_result **out,
                         curvopt_error *error) {
    if (!out)
        return null_argument(error, "out");
    *out = NULL;
    if (!mesh || !xyz)
        return null_argument(error, mesh ? "xyz" : "mesh");
    int32_t status = curvopt_options_validate(options, error);
    if (status == CURVOPT_OK)
        status = co_similarity_check(mesh->info.n_vertices, xyz, error);
    if (status != CURVOPT_OK)
        return status;
    curvopt_options settled = settle_options(options);
    return co_multilevel_minimize(mesh, xyz, &settled, co_tuning_of_runs(), progress, user, cancel, out, error);
}

void curvopt_result_destroy(curvopt_result *result) {
    co_multilevel_result_destroy(result);
}

const curvopt_mesh *curvopt_result_mesh(const curvopt_result *result) {
    return result->mesh;
}

void curvopt_result_get_positions(const curvopt_result *result, double *xyz) {
    memcpy(xyz, result->xyz, sizeof(double) * 3 * (size_t)result->mesh->info.n_vertices);
}

void curvopt_result_get_summary(const curvopt_result *result, curvopt_summary *summary) {
    *summary = result->summary;
}

int32_t curvopt_result_get_level(const curvopt_result *result, int32_t index, curvopt_level_report *report,
                                 curvopt_error *error) {
    if (index < 0 || index >= result->summary.n_levels)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "level %d of %d", index, result->summary.n_levels);
    *report = result->level[index];
    return CURVOPT_OK;
}

/* ------------------------------------------------------------------------------------- parts of a surface -- */

int32_t curvopt_mesh_part(const curvopt_mesh *mesh, const double *face_weight, curvopt_mesh **out, int32_t *vertex_of,
                          int32_t *face_of, curvopt_error *error) {
    if (!out)
        return null_argument(error, "out");
    *out = NULL;
    if (!mesh || !face_weight || !vertex_of || !face_of)
        return null_argument(error, !mesh ? "mesh" : "an array");
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
        return null_argument(error, "out");
    *out = NULL;
    if (!mesh || !face_weight)
        return null_argument(error, mesh ? "face_weight" : "mesh");
    int32_t status = check_face_weights(face_weight, mesh->info.n_faces, error);
    return status == CURVOPT_OK ? create_problem(mesh, face_weight, options, out, error) : status;
}

int32_t curvopt_problem_sum(curvopt_problem *problem, const double *xyz, int32_t all_terms, double *gradients,
                            curvopt_sums *out, curvopt_error *error) {
    if (!problem || !xyz || !out)
        return null_argument(error, !problem ? "problem" : !xyz ? "xyz" : "out");
    co_subdomain_sum(&problem->assembly, xyz, all_terms, gradients, out);
    return CURVOPT_OK;
}

void curvopt_problem_get_rules(const curvopt_problem *problem, int32_t *rules) {
    co_subdomain_get_rules(&problem->assembly, problem->n_faces, rules);
}

int32_t curvopt_problem_set_rules(curvopt_problem *problem, const int32_t *rules, curvopt_error *error) {
    if (!problem || !rules)
        return null_argument(error, problem ? "rules" : "problem");
    return co_subdomain_set_rules(&problem->assembly, rules, error);
}

int32_t curvopt_problem_face_errors(curvopt_problem *problem, const double *xyz, double area, double third,
                                    double *errors, curvopt_error *error) {
    if (!problem || !xyz || !errors)
        return null_argument(error, !problem ? "problem" : !xyz ? "xyz" : "errors");
    memset(errors, 0, sizeof *errors * (size_t)problem->n_faces);
    return co_subdomain_errors(&problem->assembly, xyz, &(co_whole){area, third}, errors, error);
}

int32_t curvopt_hessian_create(curvopt_problem *problem, curvopt_hessian **out, curvopt_error *error) {
    if (!out)
        return null_argument(error, "out");
    *out = NULL;
    if (!problem)
        return null_argument(error, "problem");
    curvopt_hessian *h = CO_NEW(curvopt_hessian, 1);
    if (!h)
        return co_status_no_memory(error);
    h->problem = problem;
    int32_t status = co_dof_map_identity(problem->assembly.patches.n_cage, &h->reduction, error);
    if (status == CURVOPT_OK)
        status = co_sparse_hessian_create(&problem->assembly, &h->reduction, &h->hessian, error);
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
        return null_argument(error, hessian ? "xyz" : "hessian");
    co_assembly *a = &hessian->problem->assembly;
    return co_sparse_hessian_assemble(a, xyz, &(co_second_kind){.exact = exact, .whole = &(co_whole){area, third}},
                                      &hessian->hessian, error);
}
