/* How a solver that stays solves.
 *
 * With an even spacing what is minimized over everything is the objective E and c E / S of the spacing's sum S, with
 * E / S taken where a stage begins. Stages follow each other until E / S stands: then the gradient of E S^c is 0, and
 * the result does not depend on the way there.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/live_solve.h"

#include "constraints/given_constraints.h"
#include "mesh/similarity.h"
#include "solve/level_figures.h"
#include "solve/level_response.h"
#include "solve/run_start.h"
#include "solve/verdict.h"

#include <math.h>
#include <string.h>

/* Stages at the end, and the relative change of E / S from which on there is another one. */
enum { MOST_STAGES = 6 };
static const double SAME_WEIGHT = 1e-5;

static size_t n_xyz(const curvopt_solver *s) {
    return 3 * (size_t)s->mesh->info.n_vertices;
}

void co_live_forget_levels(curvopt_solver *s) {
    co_level_destroy(s->level);
    co_level_destroy(s->normals);
    s->level = s->normals = NULL;
    if (s->run)
        s->run->shown_beside = NULL;
}

/* A level from the cage that has been put into level_start. */
static int32_t make_level(curvopt_solver *s, curvopt_error *error) {
    co_run *r = s->run;
    co_live_forget_levels(s);
    s->is_elsewhere = 0;
    int32_t status = co_level_create(&r->context, s->mesh, &r->at.symmetry, &r->constraints, CO_MOTION_ALL,
                                     s->level_start, 1, &s->level, error);
    if (status == CURVOPT_OK)
        co_run_watch(r, s->level);
    return status;
}

/* Counts what a stage took. */
static void count(co_run *r, co_level *l, const co_outcome *o) {
    r->at.report.iterations += o->iterations;
    r->at.report.evaluations += o->evaluations;
    l->spent = r->at.report.iterations;
}

static int stands(const co_outcome *o) {
    return o->stop == CURVOPT_STOP_CONVERGED || o->stop == CURVOPT_STOP_SETTLED || o->stop == CURVOPT_STOP_STALLED;
}

/* The level is made, and begins, at a cage with what is held at its places. */
static int32_t begin_at(curvopt_solver *s, const double *xyz, curvopt_error *error) {
    memcpy(s->level_start, xyz, n_xyz(s) * sizeof *xyz);
    int32_t status =
        co_given_constraints_place(s->mesh, &s->run->constraints, s->options.boundary, s->level_start, error);
    if (status == CURVOPT_OK)
        status = make_level(s, error);
    return status == CURVOPT_OK ? co_level_begin(s->level, error) : status;
}

/* From anywhere: the first stage of a new level. Where new springs or places leave none where the solver stands, it
 * goes back to its first cage. */
static int32_t come_from_afar(curvopt_solver *s, co_outcome *outcome, curvopt_error *error) {
    const co_level_prospect prospect = {.stops_short = 1, .is_passing = 1};
    int32_t status = begin_at(s, s->xyz, error);
    if (status == CURVOPT_ERROR_GEOMETRY)
        status = begin_at(s, s->first, error);
    if (status == CURVOPT_OK)
        status = co_level_solve(s->level, &prospect, outcome, error);
    if (status == CURVOPT_OK)
        count(s->run, s->level, outcome);
    return status;
}

static double size_now(const co_level *l) {
    return l->now.found[CO_FOUND_SIZE];
}

/* The level goes to its targets; it has not begun there. It is made anew where what is kept does not fit. */
static int32_t come_to_targets(curvopt_solver *s, curvopt_error *error) {
    co_run *r = s->run;
    co_level *l = s->level;
    int fits = 1;
    co_run_watch(r, l);
    l->error = error;
    if (!s->is_elsewhere) {
        l->reached = l->now.x;
        co_level_objective_evaluate(&l->objective, &l->now);
        return CURVOPT_OK;
    }
    co_level_objective_to_user(&l->objective, l->now.x, size_now(l), s->normals_start); /* as work space */
    int32_t status = co_given_constraints_place(s->mesh, &r->constraints, s->options.boundary, s->normals_start, error);
    if (status != CURVOPT_OK)
        return status;
    memcpy(s->level_start, s->normals_start, n_xyz(s) * sizeof *s->level_start);
    status = co_level_response(l, &r->at.symmetry, &r->constraints, s->level_start, &fits, error);
    s->is_elsewhere = 0;
    if (status == CURVOPT_OK && !fits)
        status = make_level(s, error);
    return status == CURVOPT_OK && !fits ? co_level_begin(s->level, error) : status;
}

/* L-BFGS by the factor that there is, to this decrement. */
static int32_t run_stage(curvopt_solver *s, double decrement, co_outcome *outcome, curvopt_error *error) {
    const co_level_prospect prospect = {.is_near = 1, .stops_short = 1, .is_passing = 1, .decrement = decrement};
    int32_t status = co_level_solve(s->level, &prospect, outcome, error);
    if (status == CURVOPT_OK)
        count(s->run, s->level, outcome);
    return status;
}

/* The first answer to moved targets, and the first stage from there. A factor that takes long is made anew. */
static int32_t come_near(curvopt_solver *s, co_outcome *outcome, curvopt_error *error) {
    *outcome = (co_outcome){.stop = CURVOPT_STOP_CANCELLED};
    int32_t status = come_to_targets(s, error);
    if (status != CURVOPT_OK || co_level_tell(s->level))
        return status;
    status = co_level_begin(s->level, error);
    if (status == CURVOPT_OK && s->level->hessian.exists && !s->level->hessian.has_factor)
        status = co_level_refresh_factor(s->level, error);
    if (status == CURVOPT_OK)
        status = run_stage(s, s->tuning->near_passing, outcome, error);
    if (status == CURVOPT_OK && stands(outcome) && s->level->hessian.exists &&
        outcome->iterations > s->tuning->near_steps)
        status = co_level_refresh_factor(s->level, error);
    return status;
}

/* Until the weight of the spacing is that of where the level stands. */
static int32_t settle_spacing(curvopt_solver *s, co_outcome *outcome, curvopt_error *error) {
    const co_spacing *spacing = &s->level->objective.spacing;
    int32_t status = CURVOPT_OK;
    for (int k = 0; k < MOST_STAGES && status == CURVOPT_OK && stands(outcome); k++) {
        const double before = spacing->weight;
        status = run_stage(s, s->tuning->near_settled, outcome, error);
        if (k > 0 && fabs(spacing->weight - before) <= SAME_WEIGHT * before)
            break;
    }
    return status;
}

/* The level along the normals of the cage in normals_start, by its own pattern and rules if it has been there before.
 */
static int32_t bring_normals(curvopt_solver *s, int by_rules_of_level, curvopt_error *error) {
    co_run *r = s->run;
    int fits = 0;
    int32_t status = CURVOPT_OK;
    if (s->normals)
        status = co_level_move(s->normals, &r->at.symmetry, &r->constraints, s->normals_start, &fits, error);
    if (status != CURVOPT_OK || !fits) {
        co_level_destroy(s->normals);
        s->normals = NULL;
    }
    if (status == CURVOPT_OK && !s->normals)
        status = co_level_create(&r->context, s->mesh, &r->at.symmetry, &r->constraints, CO_MOTION_NORMALS,
                                 s->normals_start, 1, &s->normals, error);
    if (status != CURVOPT_OK)
        return status;
    s->normals->objective.likeness = s->first;
    co_run_watch(r, s->normals);
    return by_rules_of_level ? co_level_begin_by_rules_of(s->normals, s->level, error)
                             : co_level_begin(s->normals, error);
}

/* Whether what is found on the level is the result: the spacing is free, or nothing can be differentiated. */
static int is_result(const co_level *l) {
    return l->is_final || !l->hessian.exists;
}

/* How the optimum is found from near it, one after the other as long as it is not: by the factor that there is, to what
 * that says; by Newton's method; by the same as co_run_solve_on. */
typedef enum co_live_way { BY_FACTOR, BY_NEWTON, CLOSELY } co_live_way;

/* Solves a level that has begun. */
static int32_t finish(curvopt_solver *s, co_level *l, co_live_way way, double started, curvopt_error *error) {
    co_run *r = s->run;
    r->prospect = (co_level_prospect){.is_near = 1,
                                      .stops_short = way == BY_FACTOR && l->hessian.has_factor,
                                      .closely = way == CLOSELY,
                                      .decrement = s->tuning->near_finished * s->options.decrement_tolerance};
    int32_t status = co_run_solve_level(r, l, started, error);
    r->prospect = (co_level_prospect){0};
    l->spent = r->at.report.iterations;
    return status;
}

/* From the cage in normals_start along normals, until these stay what they are. */
static int32_t settle_shape(curvopt_solver *s, co_live_way way, double started, curvopt_error *error) {
    co_run *r = s->run;
    double moved = INFINITY;
    int32_t status = CURVOPT_OK;
    for (int turn = 0; turn < CO_RUN_MOST_TURNS && moved > CO_RUN_SAME_NORMALS && status == CURVOPT_OK; turn++) {
        if (turn > 0)
            memcpy(s->normals_start, r->at.xyz, n_xyz(s) * sizeof *s->normals_start);
        status = bring_normals(s, 0, error);
        if (status == CURVOPT_OK)
            status = finish(s, s->normals, way, started, error);
        if (status != CURVOPT_OK || co_run_stopped_early(r))
            return status;
        moved = co_level_moved(s->normals);
    }
    return status;
}

/* The optimum from near it, its figures, and the verdict. */
static int32_t finish_all(curvopt_solver *s, co_live_way way, double started, curvopt_error *error) {
    co_run *r = s->run;
    const int is_final = is_result(s->level);
    int32_t status = is_final ? finish(s, s->level, way, started, error) : settle_shape(s, way, started, error);
    co_level *end = is_final ? s->level : s->normals;
    if (status == CURVOPT_OK)
        status = co_run_report_end(r, end, error);
    if (status != CURVOPT_OK || !co_run_wants_verdict(r))
        return status;
    if (is_final) {
        memcpy(s->normals_start, r->at.xyz, n_xyz(s) * sizeof *s->normals_start);
        status = bring_normals(s, 1, error);
    }
    if (status == CURVOPT_OK)
        status = co_run_certify(r, end, s->normals, error);
    if (status == CURVOPT_OK && is_final && end->hessian.exists && !isnan(r->result->summary.newton_decrement))
        end->hessian.has_factor = 1; /* that of the decrement, which the next solution begins by */
    return status;
}

/* Whether the end is not what a factor of elsewhere, or after that Newton's method took it for. */
static int is_unfinished(const curvopt_solver *s, co_live_way way) {
    const co_run *r = s->run;
    const curvopt_summary *found = &r->result->summary;
    const double most = s->tuning->stationary * s->options.decrement_tolerance;
    if (!co_run_wants_verdict(r) || co_run_stopped_early(r) || co_run_context_is_cancelled(&r->context))
        return 0;
    if (way != BY_FACTOR)
        return co_run_is_unfinished(r, is_result(s->level) ? s->level : s->normals);
    return found->verdict == CURVOPT_VERDICT_SADDLE || found->verdict == CURVOPT_VERDICT_NOT_STATIONARY ||
           found->newton_decrement > most * fabs(r->at.report.energy + r->at.penalty);
}

/* Takes what motion along normals has added to the level's cage. */
static void take_beside(curvopt_solver *s) {
    const co_level *l = s->level;
    if (is_result(l) || !l->objective.is_framed)
        return;
    co_level_objective_to_user(&l->objective, l->now.x, size_now(l), s->beside);
    for (size_t i = 0; i < n_xyz(s); i++)
        s->beside[i] = s->run->at.xyz[i] - s->beside[i];
    s->run->shown_beside = s->beside;
}

static int32_t settle(curvopt_solver *s, co_outcome *outcome, double started, curvopt_error *error) {
    co_level *l = s->level;
    int32_t status = is_result(l) ? CURVOPT_OK : settle_spacing(s, outcome, error);
    if (status != CURVOPT_OK || !stands(outcome))
        return status;
    co_level_objective_to_user(&l->objective, l->now.x, size_now(l), s->normals_start);
    status = finish_all(s, BY_FACTOR, started, error);
    for (int way = BY_FACTOR; way < CLOSELY && status == CURVOPT_OK && is_unfinished(s, (co_live_way)way); way++) {
        if (!is_result(l))
            memcpy(s->normals_start, s->run->at.xyz, n_xyz(s) * sizeof *s->normals_start);
        status = finish_all(s, (co_live_way)(way + 1), started, error);
    }
    if (status == CURVOPT_OK && !co_run_stopped_early(s->run))
        take_beside(s);
    return status;
}

/* Figures of a state that passes, by the rules that there are. */
static void end_passing(curvopt_solver *s, int stop, double started) {
    co_run *r = s->run;
    curvopt_energies shown;
    co_run_end_cancelled(r, s->level, started);
    r->at.report.stop = stop;
    if (!s->level || !r->shown_beside || isnan(r->at.report.energy))
        return;
    for (size_t i = 0; i < n_xyz(s); i++)
        r->at.xyz[i] += r->shown_beside[i];
    if (co_level_glance(s->level, r->at.xyz, &shown)) {
        r->at.energies = shown;
        r->at.report.energy = shown.objective;
    }
}

/* Cut off in the middle of something, which cannot go on. */
static void end_cut_off(curvopt_solver *s, double started) {
    if (isnan(s->run->at.report.energy)) /* else the verdict alone is missing */
        end_passing(s, CURVOPT_STOP_CANCELLED, started);
    co_live_forget_levels(s);
}

/* Of the first cage's size; less is no surface. Energies that have no size are small for small ones, too. */
static const double LEAST_SIZE = 1e-6;

static int32_t check_size(const curvopt_solver *s, curvopt_error *error) {
    double centroid[3];
    const double now = co_similarity_mesh_frame(s->mesh, s->run->at.xyz, centroid);
    if (!(now < LEAST_SIZE * co_similarity_mesh_frame(s->mesh, s->first, centroid)))
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, -1,
                          "the surface shrinks to a point at %.6g %.6g %.6g: hold places that are apart",
                          s->run->at.xyz[0], s->run->at.xyz[1], s->run->at.xyz[2]);
}

int32_t co_live_solve_level(curvopt_solver *s, int wants_end, double started, curvopt_error *error) {
    co_outcome outcome = {.stop = CURVOPT_STOP_CANCELLED};
    const int is_cold = !s->level;
    int32_t status = is_cold ? come_from_afar(s, &outcome, error) : come_near(s, &outcome, error);
    if (status == CURVOPT_OK && is_cold && stands(&outcome) && s->level->hessian.exists)
        status = co_level_refresh_factor(s->level, error);
    if (status == CURVOPT_OK && wants_end && stands(&outcome))
        status = settle(s, &outcome, started, error);
    if (status == CURVOPT_OK && isnan(s->run->at.report.energy))
        end_passing(s, outcome.stop, started);
    if (status == CO_CANCELLED) {
        end_cut_off(s, started);
        return CURVOPT_OK;
    }
    return status == CURVOPT_OK ? check_size(s, error) : status;
}
