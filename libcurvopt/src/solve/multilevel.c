/* Optimize, subdivide, repeat (the report, section 3.2), on an energy that is kept resolved.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/multilevel.h"

#include "base/clock.h"
#include "base/memory.h"
#include "constraints/given_constraints.h"
#include "constraints/look_ahead.h"
#include "mesh/subdivide.h"
#include "mesh/submesh.h"
#include "solve/component_options.h"
#include "solve/component_runs.h"
#include "solve/run_level.h"
#include "solve/run_start.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
    co_run_summarize(r);
}

/* The last level that ended below the input, with a surface that can be resolved: the result where a later one is lost.
 */
typedef struct kept_level {
    curvopt_mesh *mesh; /* NULL: there is none */
    double *xyz;        /* [3 n_vertices] */
    co_constraints out; /* faces that are left out, and nothing else */
    curvopt_energies energies;
    double springs, curve_deviation; /* as in the summary */
    int32_t number;
} kept_level;

static void kept_level_free(kept_level *kept) {
    co_mesh_destroy(kept->mesh);
    co_constraints_free(&kept->out);
    free(kept->xyz);
    *kept = (kept_level){0};
}

static int32_t keep_level(const co_run *r, int32_t number, kept_level *kept, curvopt_error *error) {
    const size_t n = 3 * (size_t)r->result->mesh->info.n_vertices;
    if (!(r->at.energies.objective <= r->result->start.objective) || !r->at.is_resolved ||
        !co_adaptive_quadrature_closes(&r->at.energies))
        return CURVOPT_OK;
    kept_level_free(kept);
    int32_t status = co_submesh_copy(r->result->mesh, &kept->mesh, error);
    if (status == CURVOPT_OK)
        status = co_constraints_copy_left_out(r->result->mesh, &r->constraints, &kept->out, error);
    if (status == CURVOPT_OK && !(kept->xyz = CO_NEW(double, n)))
        status = co_status_no_memory(error);
    if (status != CURVOPT_OK)
        return status;
    memcpy(kept->xyz, r->at.xyz, n * sizeof *kept->xyz);
    kept->energies = r->at.energies;
    kept->springs = r->at.springs;
    kept->curve_deviation = co_sliding_deviation(&r->sliding);
    kept->number = number;
    return CURVOPT_OK;
}

static int32_t run_levels(co_run *r, kept_level *kept, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    for (int32_t number = 1; number <= r->context.options->levels; number++) {
        int32_t status = number > 1 ? co_run_level_subdivide(r, error) : CURVOPT_OK;
        if (status == CURVOPT_OK)
            status = co_run_level_solve(r, number, error);
        if (status != CURVOPT_OK)
            return status;
        summary->n_levels = number;
        if (co_run_level_ends_run(r, number))
            break;
        status = keep_level(r, number, kept, error);
        if (status != CURVOPT_OK)
            return status;
    }
    co_run_summarize(r);
    return CURVOPT_OK;
}

/* Whether a run that could not be resolved ended above its start, which nothing moves to another place. */
static int has_lost(const co_run *r) {
    const curvopt_result *result = r->result;
    const curvopt_options *o = r->context.options;
    const int moves = o->through || co_given_constraints_have_places(o->constraints) || r->held.n;
    return result->summary.stop == CURVOPT_STOP_UNRESOLVED && !moves &&
           !(result->end.objective <= result->start.objective);
}

/* What the summary says of where the run ended is not known of another place. */
static void forget_end(curvopt_summary *summary) {
    co_run_forget_verdict(summary);
    summary->discretization_error = (double)NAN;
    summary->clearance = (double)NAN;
    summary->n_touching = 0;
}

/* The result's mesh and cage, and the faces that are left out, become `times` finer. */
static int32_t subdivide(co_run *r, int32_t times, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    for (int32_t k = 0; status == CURVOPT_OK && k < times; k++) {
        curvopt_mesh *fine = NULL;
        co_sparse_rows rows = {0};
        double *xyz = NULL;
        status = co_subdivide_cage(r->result->mesh, r->at.xyz, &fine, &rows, &xyz, error);
        co_sparse_rows_free(&rows);
        if (status == CURVOPT_OK)
            status = co_constraints_subdivide_left_out(r->result->mesh, &r->constraints, error);
        if (status != CURVOPT_OK) {
            co_mesh_destroy(fine);
            free(xyz);
        } else {
            co_mesh_destroy(r->result->mesh);
            free(r->at.xyz);
            r->result->mesh = fine;
            r->at.xyz = xyz;
        }
    }
    return status;
}

/* The result becomes the input, subdivided as often. */
static int32_t take_back(co_run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    curvopt_result *result = r->result;
    curvopt_summary *summary = &result->summary;
    curvopt_mesh *first = NULL;
    double *at = CO_NEW(double, 3 * (size_t)mesh->info.n_vertices);
    int32_t status = at ? co_submesh_copy(mesh, &first, error) : co_status_no_memory(error);
    if (status != CURVOPT_OK) {
        free(at);
        return status;
    }
    memcpy(at, xyz, 3 * sizeof *at * (size_t)mesh->info.n_vertices);
    co_mesh_destroy(result->mesh);
    co_constraints_free(&r->constraints);
    free(r->at.xyz);
    result->mesh = first;
    r->at.xyz = at;
    status = subdivide(r, summary->n_levels - 1, error);
    result->end = result->start;
    forget_end(summary);
    summary->n_unfolded = 0;
    summary->spring_energy = summary->curve_deviation = 0;
    return status;
}

/* The result becomes that of the kept level, which is given away. */
static void go_back(co_run *r, kept_level *kept) {
    curvopt_result *result = r->result;
    curvopt_summary *summary = &result->summary;
    co_mesh_destroy(result->mesh);
    co_constraints_free(&r->constraints);
    free(r->at.xyz);
    result->mesh = kept->mesh;
    r->at.xyz = kept->xyz;
    r->constraints = kept->out;
    result->end = kept->energies;
    summary->n_levels = kept->number;
    summary->n_vertices = kept->mesh->info.n_vertices;
    summary->n_faces = kept->mesh->info.n_faces;
    summary->spring_energy = kept->springs;
    summary->curve_deviation = kept->curve_deviation;
    forget_end(summary);
    *kept = (kept_level){0};
}

/* A run that ends before its last level, where coarse cages hold vertices of the last one: the same surface by that
 * cage, but for blends at corners of boundaries, which become smaller. So it has figures of its own, unless it was
 * cancelled. */
static int32_t finish(co_run *r, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    const int32_t times = r->context.options->levels - summary->n_levels;
    curvopt_energies found = {0};
    int32_t status = subdivide(r, times, error);
    summary->n_vertices = r->result->mesh->info.n_vertices;
    summary->n_faces = r->result->mesh->info.n_faces;
    if (status != CURVOPT_OK || times == 0 || summary->stop == CURVOPT_STOP_CANCELLED)
        return status;
    status = co_run_evaluate(r, &found, error);
    if (status == CURVOPT_OK)
        r->result->end = found;
    return status == CO_CANCELLED ? CURVOPT_OK : status;
}

/* *lost: whether it has no result, for its first level was lost, and held vertices of the last level's cage. */
static int32_t run(co_run *r, const curvopt_mesh *mesh, const double *xyz, int *lost, curvopt_error *error) {
    kept_level kept = {.mesh = NULL};
    int has_run = 0;
    int32_t status = co_run_start(r, mesh, xyz, error);
    const int looks_ahead = status == CURVOPT_OK && co_looks_ahead(mesh, &r->constraints);
    if (status == CURVOPT_OK && co_component_options_fit(r->context.options))
        status = co_component_runs_minimize(r, xyz, &has_run, error);
    if (status == CURVOPT_OK && !has_run)
        status = run_levels(r, &kept, error);
    if (status == CURVOPT_OK && !has_run && has_lost(r)) {
        *lost = looks_ahead && !kept.mesh;
        if (kept.mesh)
            go_back(r, &kept);
        else if (!*lost)
            status = take_back(r, mesh, xyz, error);
    }
    if (status == CO_CANCELLED) {
        end_at_start(r);
        status = CURVOPT_OK;
    } else if (status == CURVOPT_OK && looks_ahead && !*lost) {
        status = finish(r, error);
    }
    kept_level_free(&kept);
    return status;
}

/* A run as `asked`; *out is NULL where it is lost. */
static int32_t try_run(const co_run *asked, const curvopt_mesh *mesh, const double *xyz, curvopt_result **out,
                       curvopt_error *error) {
    co_run r = *asked;
    int lost = 0;
    r.cancel = (co_cancel){.flag = r.context.cancel};
    co_basis_table_cache_create(r.context.options->surface, &r.tables);
    r.tables.cancel = &r.cancel;
    r.context.tables = &r.tables;
    int32_t status = co_thread_pool_create(r.context.options->threads, &r.threads, error);
    r.tables.threads = r.threads;
    if (status == CURVOPT_OK)
        status = run(&r, mesh, xyz, &lost, error);
    if (status == CURVOPT_OK && !lost) {
        r.result->xyz = r.at.xyz;
        r.at.xyz = NULL;
        *out = r.result;
    } else {
        co_run_result_destroy(r.result);
    }
    co_run_free_parts(&r);
    co_basis_table_cache_free(&r.tables);
    co_thread_pool_destroy(r.threads);
    return status;
}

int32_t co_multilevel_minimize(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                               const co_tuning *tuning, curvopt_progress_fn progress, void *user,
                               const curvopt_cancel *cancel, curvopt_result **out, curvopt_error *error) {
    co_run asked = {.context = {.options = options, .tuning = tuning, .cancel = cancel},
                    .progress = progress,
                    .user = user,
                    .started = co_clock_seconds(),
                    .looks_ahead = 1};
    curvopt_result *result = NULL;
    int32_t status = try_run(&asked, mesh, xyz, &result, error);
    asked.looks_ahead = 0;
    if (status == CURVOPT_OK && !result)
        status = try_run(&asked, mesh, xyz, &result, error);
    if (status == CURVOPT_OK)
        *out = result;
    return status;
}
