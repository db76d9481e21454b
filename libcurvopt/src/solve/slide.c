/* Sliding along curves, in turns. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/slide.h"

#include "base/clock.h"
#include "base/memory.h"
#include "solve/level_figures.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A turn on the tangents of the places where it begins. */
typedef struct turn {
    co_level *level;
    double slid; /* longest slide, in parts of the distance to the next vertex */
    double gain; /* by which the objective fell, relative to itself; not positive: the turn was taken back */
    int is_cancelled;
} turn;

/* Most turns of a level. */
enum { MOST_TURNS = 12 };
/* Turns end where none slides by more than this part of the distance to the next vertex, or the objective falls by no
 * more than this part of itself: as much as L-BFGS takes for settled. */
static const double STANDS = 1e-2, SETTLED = 1e-3;

static int32_t begin_turn(co_run *r, int32_t number, const co_level *before, co_level **out, curvopt_error *error) {
    int32_t n = r->result->mesh->info.n_vertices;
    double *tangent = CO_NEW(double, 3 * (size_t)n);
    if (!tangent)
        return co_status_no_memory(error);
    co_sliding_tangents(&r->sliding, n, tangent);
    r->constraints.tangent = tangent;
    int32_t status = co_level_create(&r->context, r->result->mesh, &r->at.symmetry, &r->constraints, CO_MOTION_SLIDE,
                                     r->at.start, number, out, error);
    r->constraints.tangent = NULL;
    free(tangent);
    if (status == CURVOPT_OK)
        status = before ? co_level_begin_by_rules_of(*out, before, error) : co_level_begin(*out, error);
    return status;
}

/* r->at.xyz becomes the start, and the places there are kept. */
static void keep(co_run *r) {
    co_sliding_accept(&r->sliding);
    memcpy(r->at.start, r->at.xyz, 3 * (size_t)r->result->mesh->info.n_vertices * sizeof(double));
}

static int32_t make_turn(co_run *r, int32_t number, const co_level *before, turn *t, curvopt_error *error) {
    const co_level_prospect none = {.expects_plateau = 0};
    co_outcome outcome = {.iterations = 0};
    int32_t status = begin_turn(r, number, before, &t->level, error);
    if (status != CURVOPT_OK)
        return status;
    co_run_watch(r, t->level);
    status = co_level_solve(t->level, &none, &outcome, error);
    if (status != CURVOPT_OK)
        return status;
    r->at.report.iterations += outcome.iterations;
    r->at.report.evaluations += outcome.evaluations + 1;
    co_level_objective *o = &t->level->objective;
    co_level_objective_to_user(o, t->level->now.x, t->level->now.found[CO_FOUND_SIZE], r->at.xyz);
    t->slid = co_sliding_put_back(&r->sliding, r->at.xyz);
    t->is_cancelled = r->is_asked_to_stop;
    double first = co_level_objective_value_of(o, r->at.start), last = co_level_objective_value_of(o, r->at.xyz);
    t->gain = (first - last) / fabs(first);
    if (t->gain > 0 || t->is_cancelled)
        keep(r);
    return CURVOPT_OK;
}

/* The level's result where the callback cancelled the run. */
static void end_cancelled(co_run *r, co_level *l, double started) {
    co_level_result *at = &r->at;
    at->penalty = at->springs = co_penalty_value(&l->objective.penalty, l->now.x, NULL);
    at->report.stop = CURVOPT_STOP_CANCELLED;
    at->report.energy = at->energies.objective;
    at->report.gradient_norm = (double)NAN;
    at->report.seconds = co_clock_seconds() - started;
}

static int32_t make_turns(co_run *r, int32_t number, turn *t, curvopt_error *error) {
    int32_t status = CURVOPT_OK, most = r->context.options->max_iterations;
    for (int k = 0; k < MOST_TURNS && status == CURVOPT_OK && !t->is_cancelled; k++) {
        co_level *before = t->level;
        t->level = NULL;
        status = make_turn(r, number, before, t, error);
        co_level_destroy(before);
        if (!(t->slid > STANDS && t->gain > SETTLED) || r->at.report.iterations >= most)
            break;
    }
    return status;
}

int32_t co_slide_level(co_run *r, int32_t number, curvopt_error *error) {
    double started = co_clock_seconds();
    turn t = {.level = NULL};
    r->spent = (co_run_work){0};
    int32_t status = co_sliding_begin_level(r->result->mesh, &r->constraints, r->context.options->boundary, &r->sliding,
                                            r->at.start, error);
    size_t n = 3 * (size_t)r->result->mesh->info.n_vertices;
    memcpy(r->at.xyz, r->at.start, n * sizeof(double));
    if (status != CURVOPT_OK || r->sliding.n_sliding == 0 || number > 1)
        return status;
    r->at.report = (curvopt_level_report){.level = number, .n_vertices = r->result->mesh->info.n_vertices};
    status = make_turns(r, number, &t, error);
    memcpy(r->at.xyz, r->at.start, n * sizeof(double));
    if (t.level) { /* so that a run that is cancelled before the level begins has the figures of its cage */
        curvopt_energies energies;
        if (co_level_glance(t.level, r->at.start, &energies))
            r->at.energies = energies;
    }
    if (status == CURVOPT_OK && t.is_cancelled)
        end_cancelled(r, t.level, started);
    r->spent = (co_run_work){r->at.report.iterations, r->at.report.evaluations, co_clock_seconds() - started};
    co_level_destroy(t.level);
    return status == CO_CANCELLED ? CURVOPT_OK : status;
}
