/* Optimize, subdivide, repeat (the report, section 3.2), on an energy that is kept resolved.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/multilevel.h"

#include "base/clock.h"
#include "base/memory.h"
#include "constraints/given_constraints.h"
#include "mesh/subdivide.h"
#include "solve/held_scalars.h"
#include "solve/run_start.h"
#include "solve/slide.h"
#include "solve/symmetry_reduction.h"
#include "solve/verdict.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int ends_run(const co_run *r, int32_t number) {
    return co_run_context_is_last(&r->context, number) || co_run_stopped_early(r);
}

/* What holds the result, where no crossings are wanted. */
static int32_t note_touching(co_run *r, co_level *l, curvopt_error *error) {
    const co_run_context *run = &r->context;
    co_level_objective *o = &l->objective;
    curvopt_summary *summary = &r->result->summary;
    if (!o->repulsion.mesh)
        return CURVOPT_OK;
    free(r->result->touching);
    co_level_objective_place(o, l->now.x);
    int32_t status = co_no_crossings_touching(&o->repulsion, o->positions, &r->result->touching, &summary->n_touching,
                                              &summary->clearance, error);
    summary->clearance *= o->is_framed ? run->radius : co_run_size_unit(&run->size, l->now.found[CO_FOUND_SIZE]);
    return status;
}

static int32_t solve_level(co_run *r, int32_t number, curvopt_error *error) {
    co_level *level = NULL;
    int32_t status = co_run_take_shape(r, error);
    if (status == CURVOPT_OK)
        status = co_slide_level(r, number, error);
    if (status == CURVOPT_OK) /* which that may have moved */
        status = co_run_take_shape(r, error);
    if (number == 1)
        r->result->summary.n_sliding = r->sliding.n_sliding;
    if (status == CURVOPT_OK && !r->is_asked_to_stop)
        status = co_symmetry_reduction_solve(r, number, &level, error);
    co_sliding_measure(&r->sliding, r->at.xyz);
    if (status == CURVOPT_OK && level && ends_run(r, number))
        status = co_run_report_end(r, level, error);
    if (status == CURVOPT_OK && level && ends_run(r, number))
        status = note_touching(r, level, error);
    r->result->level[number - 1] = r->at.report;
    if (status == CURVOPT_OK && level && ends_run(r, number) && co_run_wants_verdict(r))
        status = co_run_certify(r, level, NULL, error);
    if (status == CO_CANCELLED) /* there is no verdict */
        status = CURVOPT_OK;
    if (status == CURVOPT_OK && r->no_crossings.exceptions.failed != CURVOPT_OK)
        status = co_status_no_memory(error);
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
    if (status == CURVOPT_OK && co_chains_hold_any(&r->constraints.chains))
        status = co_given_constraints_place(fine, &r->constraints, r->context.options->boundary, xyz, error);
    if (status == CURVOPT_OK)
        status = co_symmetry_subdivide(&r->at.symmetry, error);
    if (status == CURVOPT_OK)
        status = co_sliding_subdivide(r->result->mesh, &r->sliding, error);
    if (status == CURVOPT_OK && r->context.options->no_crossings)
        status = co_no_crossings_subdivide(r->result->mesh, fine, xyz, r->threads, r->context.cancel, &r->no_crossings,
                                           error);
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
    co_run_summarize(r);
    return CURVOPT_OK;
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
        status = co_run_start(&r, mesh, xyz, error);
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
    co_run_free_parts(&r);
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
    free(result->touching);
    free(result);
}
