/* Optimize, subdivide, repeat (the report, section 3.2), on an energy that is kept resolved.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/multilevel.h"

#include "base/clock.h"
#include "base/memory.h"
#include "constraints/given_constraints.h"
#include "constraints/mirror_planes.h"
#include "energy/admissibility.h"
#include "mesh/ring.h"
#include "mesh/similarity.h"
#include "mesh/subdivide.h"
#include "mesh/submesh.h"
#include "solve/certificate.h"
#include "solve/held_scalars.h"
#include "solve/moving_level.h"
#include "solve/newton_decrement.h"
#include "solve/slide.h"
#include "solve/strength.h"
#include "solve/symmetry_reduction.h"
#include "surface/blend_disc_half.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LARGEST_CERTIFIED = CURVOPT_MAX_CERTIFIED_VERTICES }; /* vertices */

/* The numbers that are held, and the size of the result, from the input cage's. */
static int32_t hold_scalars(co_run *r, const curvopt_mesh *mesh, co_assembly *assembly, curvopt_error *error) {
    co_constraints all = {0};
    co_values values;
    int32_t status = co_constraints_all(mesh, &r->constraints, r->context.options->boundary, &all, error);
    const int is_framed = all.freedom != NULL;
    co_constraints_free(&all);
    if (status != CURVOPT_OK)
        return status;
    co_assembly_evaluate(assembly, r->at.xyz, &(co_request){.volume = 1}, &values);
    status =
        co_held_scalars_create(r->context.options, assembly, &values, is_framed, &r->held, &r->context.size, error);
    r->context.wanted = r->held;
    r->context.held = r->held.n ? &r->held : NULL;
    return status;
}

/* Figures of the present cage, with an assembly of their own: what they need of quadrature, the optimization does not.
 * At the start springs are weighed by it. */
static int32_t report_cage(co_run *r, const curvopt_mesh *mesh, int is_start, curvopt_energies *out,
                           curvopt_error *error) {
    co_assembly assembly;
    int resolved, changed;
    double tolerance = r->context.options->joshi_sequin ? (double)INFINITY : r->context.options->tolerance;
    const uint8_t *left_out = r->constraints.left_out;
    double *weight = left_out ? CO_NEW(double, mesh->info.n_faces) : NULL;
    if (left_out && !weight)
        return co_status_no_memory(error);
    for (int32_t f = 0; left_out && f < mesh->info.n_faces; f++)
        weight[f] = !left_out[f];
    int32_t status =
        co_assembly_create(mesh, r->at.xyz, NULL, r->context.options, r->context.tables, weight, &assembly, error);
    free(weight);
    if (status != CURVOPT_OK)
        return status;
    assembly.leaves_out = left_out != NULL;
    status = co_adaptive_quadrature_resolve(&assembly, r->at.xyz, &(co_quadrature_goal){tolerance, CO_TERMS_REPORT, 0},
                                            out, &resolved, &changed, error);
    if (status == CURVOPT_OK && !isfinite(out->objective) && co_run_context_is_cancelled(&r->context))
        status = CO_CANCELLED;
    if (status == CURVOPT_OK && is_start && !r->context.options->joshi_sequin)
        status = co_adaptive_quadrature_check(&assembly, out, error);
    if (status == CURVOPT_OK && is_start)
        status = co_strength_hold(&r->context, mesh, r->at.xyz, &assembly, &r->constraints, error);
    if (status == CURVOPT_OK && is_start)
        status = hold_scalars(r, mesh, &assembly, error);
    co_assembly_free(&assembly);
    return status;
}

static int32_t report_start(co_run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_energies *start = &r->result->start;
    int32_t status = report_cage(r, mesh, 1, start, error);
    r->start_energy = start->objective;
    return status;
}

/* Where the result's half discs (blend_disc_half.h) are not those that the level began with, its figures are taken
 * again: they are to be those of the cage that the caller gets. */
static int32_t report_end(co_run *r, const co_level *l, curvopt_error *error) {
    const curvopt_mesh *mesh = r->result->mesh;
    const curvopt_options *o = r->context.options;
    co_patches patches;
    if (o->surface != CURVOPT_SURFACE_POLYNOMIAL || o->blend_width == 1 || !co_ring_has_phantoms(mesh) ||
        co_run_stopped_early(r))
        return CURVOPT_OK;
    int32_t status = co_patches_create(mesh, r->at.xyz, NULL, o->surface, o->blend_width, &patches, error);
    if (status != CURVOPT_OK)
        return status;
    const int same = co_blend_disc_half_are_same(&patches.wide, &l->objective.assembly.patches.wide);
    co_patches_free(&patches);
    if (same)
        return CURVOPT_OK;
    curvopt_energies found = {0};
    status = report_cage(r, mesh, 0, &found, error);
    if (status == CURVOPT_OK) {
        r->at.energies = found;
        r->at.report.energy = found.objective;
    }
    return status;
}

/* What is asked for besides: the shape without its symmetries, everything without them. */
static int32_t verify_without_symmetry(co_run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    int32_t status = co_certificate_count_negative(&r->context, mesh, &r->constraints, CO_MOTION_NORMALS, r->at.xyz,
                                                   &summary->free_negative_directions, error);
    return status == CURVOPT_OK ? co_certificate_count_negative(&r->context, mesh, &r->constraints, CO_MOTION_ALL,
                                                                r->at.xyz, &summary->all_negative_directions, error)
                                : status;
}

/* What can be said of the shape: by the level itself where that moves along normals, else by another one. */
static int32_t check_shape(co_run *r, co_level *l, co_certificate_shape *shape, curvopt_error *error) {
    co_level *other = NULL;
    int32_t status = CURVOPT_OK;
    if (l->motion != CO_MOTION_NORMALS)
        status = co_certificate_level(&r->context, l->objective.mesh, &r->at.symmetry, &r->constraints, r->at.xyz, l,
                                      &other, error);
    if (status == CURVOPT_OK)
        status = co_certificate_check_shape(other ? other : l, r->context.options->verify, shape, error);
    co_level_destroy(other);
    return status;
}

/* Relative distance of a held number from what it is to be that is none. */
static const double HELD = 1e-8;

/* Whether the run has not come to the numbers that are held. */
static int misses_numbers(const co_run *r) {
    int misses = 0;
    for (int s = 0; s < CURVOPT_N_SCALARS; s++)
        misses |= !(fabs(r->at.residual[s]) <= HELD);
    return misses;
}

/* The verdict on where the run ended. */
static int32_t certify(co_run *r, co_level *l, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    co_certificate_shape shape;
    if (r->context.held) /* a level that was tried and left may have had others */
        *r->context.held = l->objective.numbers.numbers;
    co_level_objective_evaluate(&l->objective, &l->now); /* by the rules that co_level_finish() has settled on */
    int32_t status = check_shape(r, l, &shape, error);
    if (status != CURVOPT_OK || co_run_context_is_cancelled(&r->context)) /* what was found stands; no verdict */
        return status;
    summary->newton_decrement = shape.decrement;
    if (l->motion != CO_MOTION_NORMALS || isnan(shape.decrement))
        status = co_newton_decrement(&l->hessian, &l->now, &summary->newton_decrement, error);
    if (status != CURVOPT_OK)
        return status;
    summary->shape_decrement = shape.decrement;
    summary->difference_decrement = shape.difference_decrement;
    summary->negative_directions = shape.negative_directions;
    summary->verdict = co_certificate_verdict(r->context.tuning, r->at.energies.objective + r->at.penalty,
                                              summary->newton_decrement, &shape);
    if (misses_numbers(r))
        summary->verdict = CURVOPT_VERDICT_NOT_STATIONARY;
    return r->context.options->verify ? verify_without_symmetry(r, l->objective.mesh, error) : CURVOPT_OK;
}

/* Whether the level was the run's last, and one to look at more closely. */
static int wants_certificate(const co_run *r) {
    return !r->context.options->joshi_sequin && r->at.report.stop != CURVOPT_STOP_CANCELLED &&
           r->result->mesh->info.n_vertices <= LARGEST_CERTIFIED;
}

static int ends_run(const co_run *r, int32_t number) {
    return co_run_context_is_last(&r->context, number) || co_run_stopped_early(r);
}

/* Takes the present cage as that by which half discs are chosen. */
static int32_t take_shape(co_run *r, curvopt_error *error) {
    const size_t n = 3 * (size_t)r->result->mesh->info.n_vertices;
    free(r->shape);
    r->context.shape = r->shape = CO_NEW(double, n);
    if (!r->shape)
        return co_status_no_memory(error);
    memcpy(r->shape, r->at.start, n * sizeof *r->shape);
    return CURVOPT_OK;
}

static int32_t solve_level(co_run *r, int32_t number, curvopt_error *error) {
    co_level *level = NULL;
    int32_t status = take_shape(r, error);
    if (status == CURVOPT_OK)
        status = co_slide_level(r, number, error);
    if (status == CURVOPT_OK) /* which that may have moved */
        status = take_shape(r, error);
    if (number == 1)
        r->result->summary.n_sliding = r->sliding.n_sliding;
    if (status == CURVOPT_OK && !r->is_asked_to_stop)
        status = co_symmetry_reduction_solve(r, number, &level, error);
    co_sliding_measure(&r->sliding, r->at.xyz);
    if (status == CURVOPT_OK && level && ends_run(r, number))
        status = report_end(r, level, error);
    r->result->level[number - 1] = r->at.report;
    if (status == CURVOPT_OK && level && ends_run(r, number) && wants_certificate(r))
        status = certify(r, level, error);
    if (status == CO_CANCELLED) /* there is no verdict */
        status = CURVOPT_OK;
    co_level_destroy(level);
    return status;
}

/* The next level's cage: r->result->mesh, r->at.xyz and what goes with them, subdivided. */
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
        co_sparse_rows_apply(&rows, r->at.xyz, xyz);
        status = co_constraints_subdivide(r->result->mesh, fine, &rows, xyz, &r->constraints, error);
    }
    if (status == CURVOPT_OK)
        status = co_symmetry_subdivide(&r->at.symmetry, error);
    if (status == CURVOPT_OK)
        status = co_sliding_subdivide(r->result->mesh, &r->sliding, error);
    if (status != CURVOPT_OK) {
        free(xyz);
        free(start);
        co_mesh_destroy(fine);
    } else {
        memcpy(start, xyz, sizeof(double) * 3 * (size_t)rows.n_rows);
        free(r->at.xyz);
        free(r->at.start);
        free(r->at.turn);
        r->at.turn = NULL;
        co_mesh_destroy(r->result->mesh);
        r->at.xyz = xyz;
        r->at.start = start;
        r->result->mesh = fine;
    }
    co_sparse_rows_free(&rows);
    return status;
}

/* What the run has come to. */
static void end_run(co_run *r) {
    curvopt_summary *summary = &r->result->summary;
    r->result->end = r->at.energies;
    summary->stop = r->at.report.stop;
    summary->seconds = co_clock_seconds() - r->started;
    summary->n_vertices = r->result->mesh->info.n_vertices;
    summary->n_faces = r->result->mesh->info.n_faces;
    summary->method = r->context.options->method;
    summary->symmetry_order = r->at.symmetry.order;
    summary->curve_deviation = co_sliding_deviation(&r->sliding);
    memcpy(summary->multiplier, r->at.multiplier, sizeof r->at.multiplier);
    memcpy(summary->scalar_residual, r->at.residual, sizeof r->at.residual);
}

/* A run that was cancelled before the figures of the input cage were known has that cage as its result. */
static void end_at_start(co_run *r) {
    co_adaptive_quadrature_leave_unknown(&r->result->start);
    r->at.energies = r->result->start;
    r->at.report = (curvopt_level_report){.energy = (double)NAN,
                                          .gradient_norm = (double)NAN,
                                          .level = 1,
                                          .n_vertices = r->result->mesh->info.n_vertices,
                                          .stop = CURVOPT_STOP_CANCELLED,
                                          .seconds = co_clock_seconds() - r->started};
    r->result->level[0] = r->at.report;
    r->result->summary.n_levels = 1;
    end_run(r);
}

static int32_t run_levels(co_run *r, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    for (int32_t number = 1; number <= r->context.options->levels; number++) {
        int32_t status = number > 1 ? subdivide(r, error) : CURVOPT_OK;
        if (status == CURVOPT_OK)
            status = solve_level(r, number, error);
        if (status != CURVOPT_OK)
            return status;
        summary->n_levels = number;
        if (ends_run(r, number))
            break;
    }
    end_run(r);
    return CURVOPT_OK;
}

/* The mirror planes that were chosen; where nothing is held, the first level starts from a cage that has them exactly.
 */
static int32_t hold_planes(co_run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    const curvopt_options *o = r->context.options;
    co_constraints all = {0};
    int32_t status = co_mirror_planes_create(mesh, xyz, &r->constraints, o->symmetry_planes, &r->at.symmetry, error);
    if (status == CURVOPT_OK)
        status = co_constraints_all(mesh, &r->constraints, o->boundary, &all, error);
    if (status == CURVOPT_OK && !all.freedom)
        status = co_mirror_planes_symmetrize(mesh, &r->at.symmetry, r->at.start, error);
    co_constraints_free(&all);
    return status;
}

/* What is held and left out of the energy. */
static int32_t find_exceptions(co_run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    co_exceptions found;
    int32_t status = co_exceptions_of_run(mesh, r->at.xyz, r->context.options, &found, error);
    if (status == CURVOPT_OK && found.n_left_out)
        status = co_constraints_leave_out(mesh, found.face, &r->constraints, error);
    r->result->summary.n_held = found.n_held;
    r->result->summary.n_left_out = found.n_left_out;
    co_exceptions_free(&found);
    return status;
}

/* Boundary, creases and exceptions may hold a whole cage on the first of several levels: inside its faces others can
 * move. */
static int32_t check_motion(const co_run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    const curvopt_options *o = r->context.options;
    int32_t level,
        status = co_moving_level_find(mesh, r->at.xyz, &r->constraints, o->boundary, o->levels, &level, error);
    if (status == CURVOPT_OK && level == 0)
        return co_constraints_refuse(mesh, error);
    return status;
}

/* Constraints, exceptions and symmetries of the input cage. */
static int32_t find_structure(co_run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    const curvopt_options *o = r->context.options;
    int32_t status = co_given_constraints_create(mesh, xyz, o->constraints, &r->constraints, error);
    if (status == CURVOPT_OK)
        status = co_given_constraints_check_strength(o->constraints, o, error);
    if (status == CURVOPT_OK && o->constraints && o->constraints->has_places)
        status = co_given_constraints_place(mesh, &r->constraints, r->at.start, error);
    if (status == CURVOPT_OK)
        status = find_exceptions(r, mesh, error);
    if (status == CURVOPT_OK)
        status = check_motion(r, mesh, error);
    if (status != CURVOPT_OK)
        return status;
    if (o->symmetry == CURVOPT_SYMMETRY_PLANES)
        return hold_planes(r, mesh, r->at.start, error);
    if (o->joshi_sequin || o->symmetry == CURVOPT_SYMMETRY_NONE)
        return co_symmetry_none(mesh, &r->at.symmetry, error);
    return co_symmetry_create(mesh, r->at.start, &r->constraints, o->symmetry != CURVOPT_SYMMETRY_ROTATIONS,
                              &r->at.symmetry, error);
}

static int32_t start_run(co_run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    size_t n = 3 * (size_t)mesh->info.n_vertices;
    r->result = CO_NEW(curvopt_result, 1);
    r->at.xyz = CO_NEW(double, n);
    r->at.start = CO_NEW(double, n);
    if (!r->result || !r->at.xyz || !r->at.start)
        return co_status_no_memory(error);
    r->result->summary.newton_decrement = (double)NAN;
    r->result->summary.shape_decrement = (double)NAN;
    r->result->summary.difference_decrement = (double)NAN;
    r->result->summary.negative_directions = -1;
    r->result->summary.all_negative_directions = -1;
    r->result->summary.free_negative_directions = -1;
    r->result->level = CO_NEW(curvopt_level_report, r->context.options->levels);
    if (!r->result->level)
        return co_status_no_memory(error);
    memcpy(r->at.xyz, xyz, n * sizeof(double));
    memcpy(r->at.start, xyz, n * sizeof(double));
    r->context.radius = co_similarity_mesh_frame(mesh, xyz, r->context.centroid);
    int32_t status = co_submesh_copy(mesh, &r->result->mesh, error);
    if (status == CURVOPT_OK)
        status = find_structure(r, mesh, xyz, error);
    if (status == CURVOPT_OK && r->context.options->slide)
        status = co_sliding_create(mesh, xyz, &r->sliding, error);
    return status == CURVOPT_OK ? report_start(r, mesh, error) : status;
}

int32_t co_multilevel_minimize(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                               const co_tuning *tuning, curvopt_progress_fn progress, void *user,
                               const curvopt_cancel *cancel, curvopt_result **out, curvopt_error *error) {
    co_run r = {.context = {.options = options, .tuning = tuning, .cancel = cancel},
                .progress = progress,
                .user = user,
                .started = co_clock_seconds(),
                .cancel = {.flag = cancel}};
    co_basis_table_cache_create(options->surface, &r.tables);
    r.tables.cancel = &r.cancel;
    r.context.tables = &r.tables;
    int32_t status = co_thread_pool_create(options->threads, &r.threads, error);
    r.tables.threads = r.threads;
    if (status == CURVOPT_OK)
        status = start_run(&r, mesh, xyz, error);
    if (status == CURVOPT_OK)
        status = run_levels(&r, error);
    if (status == CO_CANCELLED) {
        end_at_start(&r);
        status = CURVOPT_OK;
    }
    if (status == CURVOPT_OK) {
        r.result->xyz = r.at.xyz;
        r.at.xyz = NULL;
        *out = r.result;
    } else {
        co_multilevel_result_destroy(r.result);
    }
    co_level_result_free(&r.at);
    co_constraints_free(&r.constraints);
    co_sliding_free(&r.sliding);
    free(r.shape);
    co_basis_table_cache_free(&r.tables);
    co_thread_pool_destroy(r.threads);
    return status;
}

void co_multilevel_result_destroy(curvopt_result *result) {
    if (!result)
        return;
    co_mesh_destroy(result->mesh);
    free(result->xyz);
    free(result->level);
    free(result);
}
