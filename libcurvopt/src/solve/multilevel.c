/* Optimize, subdivide, repeat (the report, section 3.2), on an energy that is kept resolved.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/multilevel.h"

#include "base/clock.h"
#include "base/memory.h"
#include "solve/component_options.h"
#include "solve/component_runs.h"
#include "solve/run_level.h"
#include "solve/run_start.h"

#include <math.h>
#include <stdlib.h>

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
        int32_t status = number > 1 ? co_run_level_subdivide(r, error) : CURVOPT_OK;
        if (status == CURVOPT_OK)
            status = co_run_level_solve(r, number, error);
        if (status != CURVOPT_OK)
            return status;
        summary->n_levels = number;
        if (co_run_level_ends_run(r, number))
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
    int has_run = 0;
    co_basis_table_cache_create(options->surface, &r.tables);
    r.tables.cancel = &r.cancel;
    r.context.tables = &r.tables;
    int32_t status = co_thread_pool_create(options->threads, &r.threads, error);
    r.tables.threads = r.threads;
    if (status == CURVOPT_OK)
        status = co_run_start(&r, mesh, xyz, error);
    if (status == CURVOPT_OK && co_component_options_fit(options))
        status = co_component_runs_minimize(&r, xyz, &has_run, error);
    if (status == CURVOPT_OK && !has_run)
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
        co_run_result_destroy(r.result);
    }
    co_run_free_parts(&r);
    co_basis_table_cache_free(&r.tables);
    co_thread_pool_destroy(r.threads);
    return status;
}
