/* How a level of a run is solved. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/run.h"

#include "base/clock.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void co_level_result_free(co_level_result *at) {
    co_symmetry_free(&at->symmetry);
    free(at->start);
    free(at->xyz);
    *at = (co_level_result){0};
}

/* L-BFGS does not know that of its preconditioner. */
static double shift_of(const co_level *l, const co_step_record *record) {
    if (record->method == CO_METHOD_LBFGS)
        return l->hessian.has_factor ? l->hessian.shift : (double)NAN;
    return record->shift;
}

static int report(const co_level *l, const co_step_record *record, void *user) {
    co_run *r = user;
    const co_level_objective *o = &l->objective;
    if (co_run_context_is_cancelled(&r->context))
        return 1;
    if (!r->progress)
        return 0;
    co_level_objective_to_user(o, l->now.x, l->now.found[CO_FOUND_AREA], r->at.xyz);
    const curvopt_progress progress = {.struct_size = (int32_t)sizeof progress,
                                       .predicted = record->predicted,
                                       .gain_ratio = record->gain_ratio,
                                       .step = record->length,
                                       .shift = shift_of(l, record),
                                       .samples = (int32_t)o->assembly.batches.n_samples,
                                       .method = (int32_t)record->method,
                                       .rejected = record->rejected,
                                       .energy = co_level_objective_energy(o, &l->now),
                                       .start_energy = r->start_energy,
                                       .gradient_norm = co_level_objective_relative_gradient(o, &l->now),
                                       .seconds = co_clock_seconds() - r->started,
                                       .xyz = r->at.xyz,
                                       .mesh = o->mesh,
                                       .level = l->number,
                                       .levels = r->context.options->levels,
                                       .iteration = record->iteration,
                                       .evaluations = record->evaluations + 1, /* the level's first */
                                       .n_vertices = o->mesh->info.n_vertices};
    return r->progress(&progress, r->user) != 0;
}

/* Energies at the level's end, and its cage. */
static int32_t end_level(co_run *r, co_level *l, const co_outcome *outcome, double started, curvopt_error *error) {
    int resolved;
    co_level_result *at = &r->at;
    int32_t status = co_level_finish(l, at->xyz, &at->energies, &resolved, error);
    if (status != CURVOPT_OK)
        return status;
    at->penalty = co_penalty_value(&l->objective.penalty, l->now.x, NULL);
    at->report = (curvopt_level_report){.energy = at->energies.objective,
                                        .gradient_norm = co_level_objective_relative_gradient(&l->objective, &l->now),
                                        .level = l->number,
                                        .n_vertices = l->objective.mesh->info.n_vertices,
                                        .iterations = outcome->iterations,
                                        .evaluations = outcome->evaluations + 1,
                                        .stop = resolved ? outcome->stop : CURVOPT_STOP_UNRESOLVED,
                                        .seconds = co_clock_seconds() - started};
    return CURVOPT_OK;
}

/* The level's result where the run was cancelled in the middle of something: the last iterate that stood a review, or
 * `x` if the level was solved; its first cage and the figures of before if it had not begun. */
static void end_cancelled(co_run *r, co_level *l, int32_t number, const double *x, const co_outcome *outcome,
                          double started) {
    co_level_result *at = &r->at;
    at->report = (curvopt_level_report){.energy = (double)NAN,
                                        .gradient_norm = (double)NAN,
                                        .level = number,
                                        .n_vertices = r->result->mesh->info.n_vertices,
                                        .stop = CURVOPT_STOP_CANCELLED,
                                        .seconds = co_clock_seconds() - started};
    curvopt_energies before = at->energies.area > 0 ? at->energies : r->result->start;
    if (!x || !co_level_finish_cancelled(l, x, at->xyz, &at->energies, &at->penalty)) {
        memcpy(at->xyz, at->start, 3 * sizeof *at->xyz * (size_t)r->result->mesh->info.n_vertices);
        at->energies = before;
        return;
    }
    at->report.energy = at->energies.objective;
    at->report.iterations = outcome->iterations;
    at->report.evaluations = outcome->evaluations + 1;
}

int co_run_stopped_early(const co_run *r) {
    int32_t stop = r->at.report.stop;
    return stop == CURVOPT_STOP_CANCELLED || stop == CURVOPT_STOP_UNRESOLVED;
}

int32_t co_run_solve(co_run *r, int32_t number, co_level **out, curvopt_error *error) {
    double started = co_clock_seconds();
    co_outcome outcome = {0};
    co_level *l = NULL;
    const double *reached = NULL;
    int32_t status =
        co_level_create(&r->context, r->result->mesh, &r->at.symmetry, &r->constraints, r->at.start, number, &l, error);
    if (status == CURVOPT_OK) {
        l->report = report;
        l->user = r;
        status = co_level_begin(l, error);
    }
    if (status == CURVOPT_OK) {
        reached = l->review.safe;
        status = co_level_solve(l, &r->prospect, &outcome, error);
    }
    if (status == CURVOPT_OK) {
        reached = l->now.x;
        status = end_level(r, l, &outcome, started, error);
    }
    if (status == CO_CANCELLED) {
        end_cancelled(r, l, number, reached, &outcome, started);
        status = CURVOPT_OK;
    }
    if (status != CURVOPT_OK) {
        co_level_destroy(l);
        l = NULL;
    }
    *out = l;
    return status;
}
