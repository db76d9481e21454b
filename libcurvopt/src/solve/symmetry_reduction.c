/* Down from saddles that symmetry hides. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/symmetry_reduction.h"

#include "base/memory.h"
#include "solve/saddle_escape.h"

#include <math.h>
#include <stdlib.h>

double co_symmetry_reduction_worth(const co_tuning *t, int32_t order, int32_t left) {
    double worth = order == left ? t->loosen_same : 0;
    for (; order > left; order = (order + 1) / 2)
        worth += t->loosen_half;
    return worth;
}

/* Whether ways down from a level's result are looked for among these motions: among all where symmetries may be given
 * up at a price, along normals where the user asks for an escape. */
static int wants_way(const co_run *r, const co_level *l, co_motion among) {
    const int32_t n = r->result->mesh->info.n_vertices, stop = r->at.report.stop;
    const int may = among == CO_MOTION_ALL ? co_run_may_loosen(r, l)
                                           : r->context.options->escape && n <= r->context.tuning->escape_vertices;
    return may && l->hessian.exists && (stop == CURVOPT_STOP_CONVERGED || stop == CURVOPT_STOP_SETTLED);
}

/* The level has its new figures; what led to them counts. */
static void add_work(curvopt_level_report *level, const curvopt_level_report *before) {
    level->iterations += before->iterations;
    level->evaluations += before->evaluations;
    level->seconds += before->seconds;
}

typedef enum worth { NOT_WORTH_IT, PERHAPS, WORTH_IT } worth;

/* Whether going down from there to here was worth it. A step that brings half of what it should may be the first of
 * two: of a torus of 8 x 4 vertices the first brings 10 % and the second 69 %. */
static worth worth_of(const co_run *r, const co_level_result *from, co_motion among) {
    const co_level_result *at = &r->at;
    const co_tuning *t = r->context.tuning;
    double least =
        among == CO_MOTION_ALL ? co_symmetry_reduction_worth(t, from->symmetry.order, at->symmetry.order) : 0;
    const double whole = from->report.energy + co_run_context_reference(&r->context);
    double gain = (from->report.energy + from->penalty - at->report.energy - at->penalty) / fabs(whole);
    if (at->report.stop == CURVOPT_STOP_UNRESOLVED ||
        at->report.stop == CURVOPT_STOP_GROWN) /* that would end the run */
        return NOT_WORTH_IT;
    if (at->report.stop == CURVOPT_STOP_CANCELLED)
        return gain > 0 ? WORTH_IT : NOT_WORTH_IT;
    return gain > least ? WORTH_IT : gain > t->loosen_perhaps * least ? PERHAPS : NOT_WORTH_IT;
}

/* A level's way down. */
typedef struct descent {
    co_level *now;    /* what run->at is of */
    co_level *before; /* NULL, or the level to go back to if the next step does not make the last one worth it */
    co_level_result fallback; /* what that level has come to */
} descent;

static void forget_fallback(descent *d) {
    co_level_destroy(d->before);
    d->before = NULL;
    co_level_result_free(&d->fallback);
}

/* The run is again where it was before, and what it was at since is gone. A run that was cancelled since stays so. */
static void go_back(co_run *r, co_level_result *before) {
    int32_t stop = r->at.report.stop;
    co_level_result_free(&r->at);
    r->at = *before;
    *before = (co_level_result){0};
    if (stop == CURVOPT_STOP_CANCELLED)
        r->at.report.stop = stop;
}

/* Solves the level again from some way along; what it was at before moves into *before. */
static int32_t solve_along(co_run *r, int32_t number, co_way_down *way, co_level_result *before, co_level **next,
                           curvopt_error *error) {
    *before = r->at;
    r->at = (co_level_result){.symmetry = way->symmetry,
                              .start = way->xyz,
                              .xyz = CO_NEW(double, 3 * (size_t)r->result->mesh->info.n_vertices)};
    *way = (co_way_down){0};
    r->prospect = (co_level_prospect){.expects_plateau = 1};
    int32_t status = r->at.xyz ? co_run_solve(r, number, next, error) : co_status_no_memory(error);
    r->prospect = (co_level_prospect){0};
    if (status == CURVOPT_OK)
        add_work(&r->at.report, &before->report);
    return status;
}

/* A step down, if there is a way that is worth going; *on: whether another may be looked for. */
static int32_t step_down(co_run *r, int32_t number, co_motion among, descent *d, int *on, curvopt_error *error) {
    co_way_down way;
    *on = 0;
    int32_t status = co_saddle_escape_find(&r->context, r->result->mesh, &r->at.symmetry, &r->constraints, r->at.xyz,
                                           number, among, &way, error);
    if (status == CURVOPT_OK && way.found) {
        co_level *next = NULL;
        co_level_result last;
        status = solve_along(r, number, &way, &last, &next, error);
        worth worth = status == CURVOPT_OK ? worth_of(r, d->before ? &d->fallback : &last, among) : NOT_WORTH_IT;
        *on = worth == WORTH_IT || (worth == PERHAPS && !d->before);
        if (!*on) {
            go_back(r, &last);
            co_level_destroy(next);
        } else if (worth == PERHAPS) {
            d->before = d->now;
            d->fallback = last;
            d->now = next;
        } else {
            forget_fallback(d);
            co_level_result_free(&last);
            co_level_destroy(d->now);
            d->now = next;
        }
    }
    co_saddle_escape_free(&way);
    return status;
}

/* Down among these motions, as far as that is worth it. */
static int32_t go_down(co_run *r, int32_t number, co_motion among, descent *d, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    for (int on = 1; status == CURVOPT_OK && on && !co_run_stopped_early(r) && wants_way(r, d->now, among);)
        status = step_down(r, number, among, d, &on, error);
    if (d->before) {
        go_back(r, &d->fallback);
        co_level_destroy(d->now);
        d->now = d->before;
        d->before = NULL;
    }
    return status;
}

int32_t co_symmetry_reduction_solve(co_run *r, int32_t number, co_level **level, curvopt_error *error) {
    static const co_motion among[] = {CO_MOTION_ALL, CO_MOTION_NORMALS};
    descent d = {0};
    int32_t status = co_run_solve(r, number, &d.now, error);
    for (size_t k = 0; status == CURVOPT_OK && k < sizeof among / sizeof *among; k++)
        status = go_down(r, number, among[k], &d, error);
    if (status == CO_CANCELLED) { /* while a way down was looked for: what was found before stands */
        r->at.report.stop = CURVOPT_STOP_CANCELLED;
        status = CURVOPT_OK;
    }
    *level = d.now;
    return status;
}
