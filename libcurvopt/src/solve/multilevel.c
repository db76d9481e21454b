/* Optimize, subdivide, repeat (the report, section 3.2), on an energy that is kept resolved.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/multilevel.h"

#include "base/memory.h"
#include "constraints/mirror_planes.h"
#include "mesh/similarity.h"
#include "mesh/subdivide.h"
#include "mesh/submesh.h"
#include "solve/certificate.h"
#include "solve/symmetry_reduction.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LARGEST_CERTIFIED = 50000 };
static const double STATIONARY = 1e-6; /* decrement, of the energy */

/* Figures of the input cage, with an assembly of their own: what they need of quadrature, the optimization does not. */
static int32_t report_start(co_run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    co_assembly assembly;
    int resolved, changed;
    curvopt_energies *start = &r->result->summary.start;
    double tolerance = r->frame.options->as_report ? (double)INFINITY : r->frame.options->tolerance;
    int32_t status = co_assembly_create(mesh, r->frame.options, r->frame.tables, NULL, &assembly, error);
    if (status != CURVOPT_OK)
        return status;
    status = co_adaptive_quadrature_resolve(&assembly, r->xyz, &(co_quadrature_goal){tolerance, CO_TERMS_REPORT, 0},
                                            start, &resolved, &changed, error);
    if (status == CURVOPT_OK && !r->frame.options->as_report)
        status = co_adaptive_quadrature_check(&assembly, start, error);
    r->start_energy = start->objective;
    r->frame.area = start->area;
    co_assembly_free(&assembly);
    return status;
}

static int is_stationary(const co_run *r, double decrement) {
    return decrement <= STATIONARY * fabs(r->result->summary.end.objective + r->pull);
}

/* What is asked for besides: the shape without its symmetries, everything without them. */
static int32_t verify_without_symmetry(co_run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    co_symmetry none = {0};
    co_certificate_shape shape;
    int32_t status = co_symmetry_none(mesh, &none, error);
    if (status == CURVOPT_OK)
        status = co_certificate_check_shape(&r->frame, mesh, &none, &r->constraints, r->xyz, NULL, 0, &shape, error);
    co_symmetry_free(&none);
    if (status != CURVOPT_OK)
        return status;
    summary->free_negative_directions = shape.negative_directions;
    return co_certificate_count_negative(&r->frame, mesh, &r->constraints, r->xyz, &summary->all_negative_directions,
                                         error);
}

/* The verdict on where the run ended. */
static int32_t certify(co_run *r, co_level *l, co_iterate *now, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    co_certificate_shape shape;
    int verify = r->frame.options->verify;
    int32_t status = co_certificate_decrement(l, now, &summary->newton_decrement, error);
    if (status == CURVOPT_OK && co_run_context_is_cancelled(&r->frame)) /* what was found stands; there is no verdict */
        return CURVOPT_OK;
    if (status == CURVOPT_OK)
        status = co_certificate_check_shape(&r->frame, l->mesh, &r->symmetry, &r->constraints, r->xyz, l, verify,
                                            &shape, error);
    if (status != CURVOPT_OK)
        return status;
    summary->shape_decrement = shape.decrement;
    summary->difference_decrement = shape.difference_decrement;
    summary->negative_directions = shape.negative_directions;
    if (shape.negative_directions < 0 || isnan(summary->newton_decrement))
        summary->verdict = CURVOPT_VERDICT_UNKNOWN;
    else if (!is_stationary(r, summary->newton_decrement))
        summary->verdict = CURVOPT_VERDICT_NOT_STATIONARY;
    else if (shape.negative_directions > 0)
        summary->verdict = CURVOPT_VERDICT_SADDLE;
    else
        summary->verdict = is_stationary(r, shape.decrement) ? CURVOPT_VERDICT_MINIMUM : CURVOPT_VERDICT_NOT_STATIONARY;
    return verify ? verify_without_symmetry(r, l->mesh, error) : CURVOPT_OK;
}

/* Whether the level was the run's last, and one to look at more closely. */
static int wants_certificate(const co_run *r, int32_t number) {
    return !r->frame.options->as_report && r->result->level[number - 1].stop != CURVOPT_STOP_CANCELLED &&
           r->result->mesh->info.n_vertices <= LARGEST_CERTIFIED;
}

static int ends_run(const co_run *r, int32_t number) {
    return number == r->frame.options->levels || co_run_stopped_early(r, number);
}

static int32_t solve_level(co_run *r, int32_t number, curvopt_error *error) {
    co_symmetry_reduction d = {0};
    int32_t status = co_symmetry_reduction_solve(r, number, &d, error);
    if (status == CURVOPT_OK && ends_run(r, number) && wants_certificate(r, number))
        status = certify(r, &d.now->level, &d.now->now, error);
    co_symmetry_reduction_free(&d);
    return status;
}

/* The next level's cage: r->result->mesh, r->xyz and what goes with them, subdivided. */
static int32_t subdivide(co_run *r, curvopt_error *error) {
    curvopt_mesh *fine = NULL;
    co_sparse_rows rows = {0};
    double *xyz = NULL, *start = NULL;
    int32_t status = co_subdivide(r->result->mesh, &fine, &rows, error);
    if (status == CURVOPT_OK) {
        xyz = CO_NEW(double, 3 * (size_t)rows.n_rows);
        start = CO_NEW(double, 3 * (size_t)rows.n_rows);
        status = xyz && start ? CURVOPT_OK : co_status_no_memory(error);
    }
    if (status == CURVOPT_OK) {
        co_sparse_rows_apply(&rows, r->xyz, xyz);
        status = co_constraints_subdivide(r->result->mesh, fine, &rows, xyz, &r->constraints, error);
    }
    if (status == CURVOPT_OK)
        status = co_symmetry_subdivide(&r->symmetry, error);
    if (status != CURVOPT_OK) {
        free(xyz);
        free(start);
        co_mesh_destroy(fine);
    } else {
        memcpy(start, xyz, sizeof(double) * 3 * (size_t)rows.n_rows);
        free(r->xyz);
        free(r->level_start);
        co_mesh_destroy(r->result->mesh);
        r->xyz = xyz;
        r->level_start = start;
        r->result->mesh = fine;
    }
    co_sparse_rows_free(&rows);
    return status;
}

static int32_t run_levels(co_run *r, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    for (int32_t number = 1; number <= r->frame.options->levels; number++) {
        int32_t status = number > 1 ? subdivide(r, error) : CURVOPT_OK;
        if (status == CURVOPT_OK)
            status = solve_level(r, number, error);
        if (status != CURVOPT_OK)
            return status;
        summary->stop = r->result->level[number - 1].stop;
        if (ends_run(r, number))
            break;
    }
    summary->seconds = co_now_seconds() - r->started;
    summary->n_vertices = r->result->mesh->info.n_vertices;
    summary->n_faces = r->result->mesh->info.n_faces;
    summary->method = r->frame.options->method;
    summary->symmetry_order = r->symmetry.order;
    return CURVOPT_OK;
}

/* The mirror planes that were chosen; where nothing is held, the first level starts from a cage that has them exactly.
 */
static int32_t hold_planes(co_run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    const curvopt_options *o = r->frame.options;
    co_constraints all = {0};
    int32_t status = co_mirror_planes_create(mesh, xyz, &r->constraints, o->symmetry_planes, &r->symmetry, error);
    if (status == CURVOPT_OK)
        status = co_constraints_all(mesh, &r->constraints, o->boundary, &all, error);
    if (status == CURVOPT_OK && !all.freedom)
        status = co_mirror_planes_symmetrize(mesh, &r->symmetry, r->level_start, error);
    co_constraints_free(&all);
    return status;
}

/* Constraints and symmetries of the input cage. */
static int32_t find_structure(co_run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    const curvopt_options *o = r->frame.options;
    int32_t status = co_constraints_create(mesh, xyz, o->constraints, &r->constraints, error);
    if (status != CURVOPT_OK)
        return status;
    if (r->constraints.freedom) {
        co_constraints all = {0};
        status = co_constraints_all(mesh, &r->constraints, o->boundary, &all, error);
        if (status == CURVOPT_OK)
            status = co_constraints_check(mesh, &all, error);
        co_constraints_free(&all);
    }
    if (status != CURVOPT_OK)
        return status;
    if (o->symmetry == CURVOPT_SYMMETRY_PLANES)
        return hold_planes(r, mesh, xyz, error);
    if (o->as_report || o->symmetry == CURVOPT_SYMMETRY_NONE)
        return co_symmetry_none(mesh, &r->symmetry, error);
    return co_symmetry_create(mesh, xyz, &r->constraints, o->symmetry != CURVOPT_SYMMETRY_ROTATIONS, &r->symmetry,
                              error);
}

static int32_t start_run(co_run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    size_t n = 3 * (size_t)mesh->info.n_vertices;
    r->result = CO_NEW(curvopt_result, 1);
    r->xyz = CO_NEW(double, n);
    r->level_start = CO_NEW(double, n);
    if (!r->result || !r->xyz || !r->level_start)
        return co_status_no_memory(error);
    r->result->summary.newton_decrement = (double)NAN;
    r->result->summary.shape_decrement = (double)NAN;
    r->result->summary.difference_decrement = (double)NAN;
    r->result->summary.negative_directions = -1;
    r->result->summary.all_negative_directions = -1;
    r->result->summary.free_negative_directions = -1;
    r->result->level = CO_NEW(curvopt_level_report, r->frame.options->levels);
    if (!r->result->level)
        return co_status_no_memory(error);
    memcpy(r->xyz, xyz, n * sizeof(double));
    memcpy(r->level_start, xyz, n * sizeof(double));
    r->frame.radius = co_similarity_frame(n / 3, xyz, r->frame.centroid);
    int32_t status = co_submesh_copy(mesh, &r->result->mesh, error);
    if (status == CURVOPT_OK)
        status = find_structure(r, mesh, xyz, error);
    return status == CURVOPT_OK ? report_start(r, mesh, error) : status;
}

int32_t co_multilevel_minimize(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                               curvopt_progress_fn progress, void *user, const curvopt_cancel *cancel,
                               curvopt_result **out, curvopt_error *error) {
    co_run r = {.frame = {.options = options, .cancel = cancel, .keeps_still = options->escape},
                .progress = progress,
                .user = user,
                .started = co_now_seconds()};
    co_basis_table_cache_create(options->surface, &r.tables);
    r.frame.tables = &r.tables;
    int32_t status = start_run(&r, mesh, xyz, error);
    if (status == CURVOPT_OK)
        status = run_levels(&r, error);
    free(r.level_start);
    co_constraints_free(&r.constraints);
    co_symmetry_free(&r.symmetry);
    co_basis_table_cache_free(&r.tables);
    if (status != CURVOPT_OK) {
        free(r.xyz);
        co_multilevel_result_destroy(r.result);
        return status;
    }
    r.result->xyz = r.xyz;
    *out = r.result;
    return CURVOPT_OK;
}

void co_multilevel_result_destroy(curvopt_result *result) {
    if (!result)
        return;
    co_mesh_destroy(result->mesh);
    free(result->xyz);
    free(result->level);
    free(result);
}
