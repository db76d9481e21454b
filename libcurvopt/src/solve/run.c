/* How a level of a run is solved. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/run.h"

#include "base/clock.h"
#include "base/memory.h"
#include "constraints/given_constraints.h"
#include "linalg/vector.h"
#include "mesh/similarity.h"
#include "solve/discretization_error.h"
#include "solve/held_scalars.h"
#include "solve/level_figures.h"
#include "solve/standing_start.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void co_level_result_free(co_level_result *at) {
    co_symmetry_free(&at->symmetry);
    free(at->start);
    free(at->turn);
    free(at->xyz);
    *at = (co_level_result){0};
}

/* L-BFGS does not know that of its preconditioner. */
static double shift_of(const co_level *l, const co_step_record *record) {
    if (record->method == CO_METHOD_LBFGS)
        return l->hessian.has_factor ? l->hessian.shift : (double)NAN;
    return record->shift;
}

/* The callback is told of a step; r->at.xyz is the cage. */
static int tell(co_run *r, const co_level *l, const co_step_record *record) {
    const co_level_objective *o = &l->objective;
    const curvopt_level_report *before = &r->at.report; /* of earlier turns */
    if (!r->progress || (record->method == CO_METHOD_NONE && before->iterations > 0))
        return 0;
    const curvopt_progress progress = {.struct_size = (int32_t)sizeof progress,
                                       .predicted = record->predicted,
                                       .gain_ratio = record->gain_ratio,
                                       .step = record->length,
                                       .shift = shift_of(l, record),
                                       .samples = (int32_t)o->assembly.batches.n_samples,
                                       .method = (int32_t)record->method,
                                       .rejected = r->at.rejected + record->rejected,
                                       .energy = co_level_objective_energy(o, &l->now) -
                                                 co_run_context_reference(&r->context),
                                       .start_energy = r->start_energy,
                                       .gradient_norm = co_level_objective_relative_gradient(o, &l->now),
                                       .seconds = co_clock_seconds() - r->started,
                                       .xyz = r->at.xyz,
                                       .mesh = o->mesh,
                                       .level = l->number,
                                       .levels = r->context.options->levels,
                                       .iteration = before->iterations + record->iteration,
                                       .evaluations = before->evaluations + record->evaluations + 1, /* the first */
                                       .n_vertices = o->mesh->info.n_vertices};
    r->is_asked_to_stop = r->progress(&progress, r->user) != 0;
    return r->is_asked_to_stop;
}

/* Longest slide of a turn, in parts of the distance to the next vertex. */
static const double FARTHEST_SLIDE = 0.5;

void co_run_show(co_run *r, const co_level *l) {
    const size_t n = 3 * (size_t)l->objective.mesh->info.n_vertices;
    co_level_objective_to_user(&l->objective, l->now.x, l->now.found[CO_FOUND_SIZE], r->at.xyz);
    for (size_t i = 0; i < n && r->shown_beside && l->motion == CO_MOTION_ALL && l->objective.is_framed; i++)
        r->at.xyz[i] += r->shown_beside[i];
}

/* Times the size of the cage that the level began with, from which on an open surface grows without end
 * (libcurvopt/notes/69-surfaces-that-grow.md). */
static const double GROWN = 10;

/* Whether nothing holds the surface's size: an open one whose boundary is free, some of whose vertices are held.
 * Springs may pull it far. */
static int may_grow(const co_run *r, const co_level *l) {
    const co_level_objective *o = &l->objective;
    return o->is_framed && !r->is_live && r->context.options->boundary == CURVOPT_BOUNDARY_FREE &&
           o->mesh->info.n_boundary_edges > 0 && l->motion != CO_MOTION_SLIDE && !o->penalty.n && !o->penalty.surface.n;
}

/* What is shown has grown. */
static int has_grown(const co_run *r, const co_level *l) {
    double centroid[3];
    const double first = co_similarity_mesh_frame(l->objective.mesh, r->at.start, centroid);
    return co_similarity_mesh_frame(l->objective.mesh, r->at.xyz, centroid) > GROWN * fmax(first, r->context.radius);
}

static int report(const co_level *l, const co_step_record *record, void *user) {
    co_run *r = user;
    const int watches_size = may_grow(r, l);
    double slid = 0;
    if (co_run_context_is_cancelled(&r->context))
        return 1;
    if (!r->progress && l->motion != CO_MOTION_SLIDE && !watches_size)
        return 0;
    co_run_show(r, l);
    if (l->motion == CO_MOTION_SLIDE)
        slid = co_sliding_put_back(&r->sliding, r->at.xyz);
    r->has_grown = watches_size && has_grown(r, l);
    return tell(r, l, record) || r->has_grown || slid > FARTHEST_SLIDE;
}

void co_run_watch(co_run *r, co_level *l) {
    l->report = report;
    l->user = r;
    l->spent = r->at.report.iterations - r->lost_steps;
}

/* The multiplier of the number that gives the size, where the user said so. */
static void note_size(co_level_result *at, const co_level *l) {
    const co_run_context *run = l->objective.run;
    const co_held_level *numbers = &l->objective.numbers;
    if (!l->objective.is_framed && run->options->scalar_rule[run->size.measure] != CURVOPT_SCALAR_RULE_FREE)
        at->multiplier[run->size.measure] = co_held_scalars_multiplier_of_size(
            run, &numbers->numbers, numbers->newton.multiplier, at->energies.area, at->energies.total_mean_curvature);
}

/* Multipliers and distances of held numbers, where the level ended. */
static void note_held(co_level_result *at, co_level *l) {
    co_held_level *numbers = &l->objective.numbers;
    const co_held_numbers *wanted = &l->objective.run->wanted;
    co_iterate now = {.x = l->now.x, .gradient = numbers->work};
    double residual[CURVOPT_N_SCALARS];
    if (!numbers->numbers.n) {
        note_size(at, l);
        return;
    }
    co_level_objective_evaluate(&l->objective, &now);
    co_held_level_residuals(numbers, l->now.x, residual);
    for (int k = 0; k < numbers->numbers.n; k++) {
        const co_held_number *h = &numbers->numbers.held[k];
        at->multiplier[h->scalar] = -numbers->newton.multiplier[k] * h->rate / h->unit;
        at->residual[h->scalar] = residual[k] + (h->target - wanted->held[k].target) / h->unit;
    }
    note_size(at, l);
}

static int was_cancelled(const co_run *r) {
    return r->is_asked_to_stop || co_run_context_is_cancelled(&r->context);
}

/* Energies at the level's end, and its cage. The report has the counts already. */
static int32_t end_level(co_run *r, co_level *l, int stop, double started, curvopt_error *error) {
    int resolved;
    co_level_result *at = &r->at;
    int32_t status = co_level_finish(l, at->xyz, &at->energies, &resolved, error);
    if (status != CURVOPT_OK)
        return status;
    at->is_resolved = resolved;
    at->springs = co_penalty_value(&l->objective.penalty, l->now.x, NULL);
    at->penalty = at->springs + l->now.found[CO_FOUND_REPULSION] + co_run_context_reference(&r->context);
    note_held(at, l);
    at->report.energy = at->energies.objective;
    at->report.gradient_norm = co_level_objective_relative_gradient(&l->objective, &l->now);
    at->report.stop = resolved || !l->is_final ? stop : CURVOPT_STOP_UNRESOLVED;
    if (stop == CURVOPT_STOP_CANCELLED && r->has_grown && !was_cancelled(r))
        at->report.stop = CURVOPT_STOP_GROWN;
    at->report.seconds = co_clock_seconds() - started;
    return CURVOPT_OK;
}

void co_run_end_cancelled(co_run *r, co_level *l, double started) {
    co_level_result *at = &r->at;
    curvopt_energies before = at->energies.area > 0 ? at->energies : r->result->start;
    at->report.stop = CURVOPT_STOP_CANCELLED;
    at->report.seconds = co_clock_seconds() - started;
    at->report.energy = at->report.gradient_norm = (double)NAN;
    if (l && co_level_finish_cancelled(l, at->xyz, &at->energies, &at->springs)) {
        at->penalty = at->springs + co_run_context_reference(&r->context);
        at->report.energy = at->energies.objective;
        note_held(at, l);
        return;
    }
    at->energies = before;
    if (at->turn) { /* what was found before this turn along normals stays */
        at->report.energy = before.objective;
        return;
    }
    memcpy(at->xyz, at->start, 3 * sizeof *at->xyz * (size_t)r->result->mesh->info.n_vertices);
    at->report.iterations = at->report.evaluations = 0;
}

int co_run_stopped_early(const co_run *r) {
    int32_t stop = r->at.report.stop;
    return stop == CURVOPT_STOP_CANCELLED || stop == CURVOPT_STOP_UNRESOLVED || stop == CURVOPT_STOP_GROWN;
}

int32_t co_run_solve_level(co_run *r, co_level *l, double started, curvopt_error *error) {
    co_outcome outcome = {.iterations = 0};
    int32_t status = co_level_solve(l, &r->prospect, &outcome, error);
    r->at.report.iterations += outcome.iterations;
    r->at.rejected += outcome.rejected;
    r->at.report.evaluations += outcome.evaluations + 1;
    return status == CURVOPT_OK ? end_level(r, l, outcome.stop, started, error) : status;
}

int co_run_may_loosen(const co_run *r, const co_level *l) {
    const co_tuning *t = r->context.tuning;
    int32_t n = r->result->mesh->info.n_vertices;
    return r->context.options->symmetry == CURVOPT_SYMMETRY_AUTO && r->at.symmetry.order > 1 &&
           l->objective.assembly.functional.has_third && n >= t->loosen_least_vertices && n <= t->loosen_most_vertices;
}

/* A level of the mesh of the run, along the normals of `start`, which it borrows; begun by the rules of `before`, or
 * NULL. */
static int32_t begin_turn(co_run *r, int32_t number, const co_level *before, const double *start, co_level **out,
                          curvopt_error *error) {
    int32_t status = co_level_create(&r->context, r->result->mesh, &r->at.symmetry, &r->constraints, CO_MOTION_NORMALS,
                                     start, number, out, error);
    if (status != CURVOPT_OK)
        return status;
    co_run_watch(r, *out);
    (*out)->objective.likeness = r->at.start;
    status = before ? co_level_begin_by_rules_of(*out, before, error) : co_level_begin(*out, error);
    if (status != CURVOPT_OK) {
        co_level_destroy(*out);
        *out = NULL;
    }
    return status;
}

/* From r->at.xyz along normals, until these stay what they are; *level, which may be NULL, is exchanged. Ends after
 * `farthest` mean edges in all: *moved. */
static int32_t settle_shape(co_run *r, int32_t number, double farthest, co_level **level, double *moved, double started,
                            curvopt_error *error) {
    size_t n = 3 * (size_t)r->result->mesh->info.n_vertices;
    double last = INFINITY;
    int32_t status = CURVOPT_OK;
    *moved = 0;
    for (int turn = 0; turn < CO_RUN_MOST_TURNS && last > CO_RUN_SAME_NORMALS && *moved <= farthest; turn++) {
        co_level *next;
        double *start = CO_NEW(double, n);
        if (!start)
            return co_status_no_memory(error);
        memcpy(start, r->at.xyz, n * sizeof *start);
        status = begin_turn(r, number, *level, start, &next, error);
        if (status != CURVOPT_OK) {
            free(start);
            return status;
        }
        co_level_destroy(*level);
        *level = next;
        free(r->at.turn);
        r->at.turn = start;
        status = co_run_solve_level(r, next, started, error);
        if (status != CURVOPT_OK || co_run_stopped_early(r))
            return status;
        last = co_level_moved(next);
        *moved += last;
    }
    return status;
}

/* A symmetric cage has what entries hold but for the tolerance by which these are symmetric; the result has it exactly.
 */
static int32_t meet_entries(co_run *r, curvopt_error *error) {
    if (r->at.symmetry.order == 1 || !r->constraints.values.n)
        return CURVOPT_OK;
    return co_given_constraints_place(r->result->mesh, &r->constraints, r->context.options->boundary, r->at.xyz, error);
}

static double gradient_norm(const co_level *l) {
    return co_vector_norm(co_level_objective_n(&l->objective), l->now.gradient);
}

/* A level over everything, at its start. Its shape forms by a matrix as stiff as the level before needed: how far the
 * quadratic model holds is a matter of the shape (libcurvopt/notes/51-steps-that-are-too-long.md). */
static int32_t begin_all(co_run *r, int32_t number, co_level **level, curvopt_error *error) {
    int32_t status = co_level_create(&r->context, r->result->mesh, &r->at.symmetry, &r->constraints, CO_MOTION_ALL,
                                     r->at.start, number, level, error);
    if (status != CURVOPT_OK)
        return status;
    (*level)->hessian.shift = r->forming_shift;
    co_run_watch(r, *level);
    status = co_level_begin(*level, error);
    r->first_gradient = gradient_norm(*level);
    return status;
}

/* Over everything, and at the end along normals. */
static int32_t solve_all(co_run *r, int32_t number, co_level **level, double started, curvopt_error *error) {
    double moved;
    const int is_last = co_run_context_is_last(&r->context, number);
    int32_t status = co_run_solve_level(r, *level, started, error);
    if (!is_last) /* then a shape forms, and nothing else is done by a matrix */
        r->forming_shift = (*level)->hessian.shift;
    if (status == CURVOPT_OK && (*level)->is_lost && is_last && r->at.report.stop == CURVOPT_STOP_SETTLED)
        r->at.report.stop = CURVOPT_STOP_UNRESOLVED;
    if (status == CURVOPT_OK && !(*level)->is_final && !(*level)->is_lost && !co_run_stopped_early(r) &&
        (is_last || co_run_may_loosen(r, *level)))
        status = settle_shape(r, number, (double)INFINITY, level, &moved, started, error);
    return status;
}

/* Whether the gradient is many times what it was where the last level began: the cage has come to folds between
 * samples, and no minimum. */
static int has_steepened(const co_run *r, const co_level *l) {
    return co_run_context_is_last(&r->context, l->number) &&
           gradient_norm(l) > r->context.tuning->finer_gradient * r->first_gradient;
}

/* Whether finer rules may see in time what these did not: a fold on the way. One that the cage came with stays. */
static int wants_finer(const co_run *r, const co_level *l) {
    const curvopt_options *o = r->context.options;
    const curvopt_summary *s = &r->result->summary;
    const int is_lost = l->is_lost || r->at.report.stop == CURVOPT_STOP_UNRESOLVED || has_steepened(r, l);
    const int may = !r->is_live && !o->joshi_sequin && !o->no_crossings && (s->n_folded == 0 || s->n_unfolded > 0);
    return is_lost && may && r->context.n_finer < r->context.tuning->finer_tries && !was_cancelled(r);
}

/* The same; begun again by finer rules, with as many steps anew, where the surface could not be resolved. */
static int32_t solve_resolved(co_run *r, int32_t number, co_level **level, double started, curvopt_error *error) {
    int32_t status = solve_all(r, number, level, started, error);
    while (status == CURVOPT_OK && wants_finer(r, *level)) {
        co_level_destroy(*level);
        *level = NULL;
        r->context.n_finer++;
        r->lost_steps = r->at.report.iterations;
        free(r->at.turn);
        r->at.turn = NULL;
        status = begin_all(r, number, level, error);
        if (status == CURVOPT_OK)
            status = solve_all(r, number, level, started, error);
    }
    return status;
}

/* Whether the level's start may be the result of another run: none that this one has just made, nor one where something
 * is held, which may be elsewhere, or drawn. */
static int may_stand(const co_run *r, const co_level *l) {
    const curvopt_options *o = r->context.options;
    return l->number == 1 && o->spacing == CURVOPT_SPACING_EVEN && !r->constraints.freedom && !r->context.held &&
           !r->is_live && r->sliding.n_sliding == 0 && !r->prospect.expects_plateau && l->hessian.exists;
}

/* Along normals alone: *level, which has begun, is exchanged if the start stands. */
static int32_t solve_standing(co_run *r, int32_t number, co_level **level, int *stands, double started,
                              curvopt_error *error) {
    const double farthest = 2 * r->context.tuning->standing_step; /* in steps that may be larger than the first */
    co_level *normals = NULL;
    double moved;
    memcpy(r->at.xyz, r->at.start, 3 * sizeof *r->at.xyz * (size_t)r->result->mesh->info.n_vertices);
    int32_t status = settle_shape(r, number, farthest, &normals, &moved, started, error);
    const int stop = r->at.report.stop;
    *stands = status != CURVOPT_OK || stop == CURVOPT_STOP_CANCELLED || stop == CURVOPT_STOP_LIMIT ||
              (stop == CURVOPT_STOP_CONVERGED && moved <= farthest);
    if (*stands && normals) {
        co_level_destroy(*level);
        *level = normals;
        return status;
    }
    co_level_destroy(normals);
    free(r->at.turn);
    r->at.turn = NULL;
    return status;
}

/* A run that was cancelled before its first step has the figures of its input, to the last digit: sums of the same cage
 * by other rules, or in another order, are others. Held numbers may have been met before the first step. */
static void keep_start(co_run *r, int32_t number, const co_level *l) {
    co_level_result *at = &r->at;
    if (at->report.stop != CURVOPT_STOP_CANCELLED || r->is_live || number > 1 || at->report.iterations > 0 ||
        r->context.held || !(r->result->start.area > 0) || !l || !l->reached ||
        memcmp(l->reached, l->review.first, co_level_objective_n(&l->objective) * sizeof(double)) != 0)
        return;
    memcpy(at->xyz, at->start, 3 * sizeof *at->xyz * (size_t)r->result->mesh->info.n_vertices);
    at->energies = r->result->start;
    at->report.energy = at->energies.objective;
}

int32_t co_run_solve(co_run *r, int32_t number, co_level **out, curvopt_error *error) {
    double started = co_clock_seconds() - r->spent.seconds;
    co_level *l = NULL;
    int stands = 0;
    r->context.n_finer = r->lost_steps = r->at.rejected = 0;
    r->at.report = (curvopt_level_report){.level = number,
                                          .n_vertices = r->result->mesh->info.n_vertices,
                                          .iterations = r->spent.iterations,
                                          .evaluations = r->spent.evaluations};
    r->spent = (co_run_work){0};
    r->has_grown = 0;
    int32_t status = begin_all(r, number, &l, error);
    if (status == CURVOPT_OK && may_stand(r, l))
        status = co_standing_start_look(l, &r->at.symmetry, &r->constraints, r->at.start, &stands, error);
    if (status == CURVOPT_OK && stands)
        status = solve_standing(r, number, &l, &stands, started, error);
    if (status == CURVOPT_OK && !stands)
        status = solve_resolved(r, number, &l, started, error);
    if (status == CO_CANCELLED) {
        co_run_end_cancelled(r, l, started);
        status = CURVOPT_OK;
    }
    if (status == CURVOPT_OK)
        keep_start(r, number, l);
    if (status == CURVOPT_OK)
        status = meet_entries(r, error);
    if (status != CURVOPT_OK) {
        co_level_destroy(l);
        l = NULL;
    }
    *out = l;
    return status;
}

int32_t co_run_solve_on(co_run *r, co_level *l, curvopt_error *error) {
    const double started = co_clock_seconds() - r->at.report.seconds;
    l->spent = r->at.report.iterations - r->lost_steps;
    r->prospect = (co_level_prospect){.is_near = 1, .closely = 1};
    int32_t status = co_run_solve_level(r, l, started, error);
    r->prospect = (co_level_prospect){0};
    if (status == CO_CANCELLED) {
        co_run_end_cancelled(r, l, started);
        status = CURVOPT_OK;
    }
    return status == CURVOPT_OK ? meet_entries(r, error) : status;
}

void co_run_summarize(co_run *r) {
    curvopt_summary *summary = &r->result->summary;
    r->result->end = r->at.energies;
    summary->stop = r->at.report.stop;
    summary->seconds = co_clock_seconds() - r->started;
    summary->n_vertices = r->result->mesh->info.n_vertices;
    summary->n_faces = r->result->mesh->info.n_faces;
    summary->method = r->context.options->method;
    summary->symmetry_order = r->at.symmetry.order;
    summary->curve_deviation = co_sliding_deviation(&r->sliding);
    summary->spring_energy = r->at.springs;
    memcpy(summary->multiplier, r->at.multiplier, sizeof r->at.multiplier);
    memcpy(summary->scalar_residual, r->at.residual, sizeof r->at.residual);
    summary->discretization_error = co_discretization_error(r->result->level, summary->n_levels);
}

void co_run_result_destroy(curvopt_result *result) {
    if (!result)
        return;
    co_mesh_destroy(result->mesh);
    free(result->xyz);
    free(result->level);
    free(result->touching);
    free(result);
}
