/* One level of a run. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/run.h"

#include "base/memory.h"
#include "optimize/step_control.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

double co_now_seconds(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int report(const co_level *l, const co_iterate *now, int iteration, int evaluations, void *user) {
    co_run *r = user;
    if (co_run_context_is_cancelled(&r->frame))
        return 1;
    if (!r->progress)
        return 0;
    co_level_to_user(l, now->x, l->last.integral[CO_INT_AREA], r->xyz);
    curvopt_progress progress = {.struct_size = (int32_t)sizeof progress,
                                 .decrement = (double)NAN,
                                 .shift = (double)NAN,
                                 .gain_ratio = (double)NAN,
                                 .step = (double)NAN,
                                 .energy = co_level_energy(l, now),
                                 .start_energy = r->start_energy,
                                 .gradient_norm = co_level_relative_gradient(l, now),
                                 .seconds = co_now_seconds() - r->started,
                                 .xyz = r->xyz,
                                 .mesh = l->mesh,
                                 .level = l->number,
                                 .levels = r->frame.options->levels,
                                 .iteration = iteration,
                                 .evaluations = evaluations + 1, /* the level's first */
                                 .n_vertices = l->mesh->info.n_vertices};
    return r->progress(&progress, r->user) != 0;
}

/* Energies at the level's end, and its cage into r->xyz. */
static int32_t end_level(co_run *r, co_level *l, const co_iterate *now, const co_outcome *solved, double started,
                         curvopt_error *error) {
    int resolved;
    curvopt_energies *end = &r->result->summary.end;
    int32_t status = co_level_finish(l, now, r->xyz, end, &resolved, error);
    if (status != CURVOPT_OK)
        return status;
    r->pull = co_penalty_value(&l->pull, now->x, NULL);
    r->result->summary.n_levels = l->number;
    r->result->level[l->number - 1] = (curvopt_level_report){.energy = end->objective,
                                                             .gradient_norm = co_level_relative_gradient(l, now),
                                                             .level = l->number,
                                                             .n_vertices = l->mesh->info.n_vertices,
                                                             .iterations = solved->iterations,
                                                             .evaluations = solved->evaluations + 1,
                                                             .stop = resolved ? solved->stop : CURVOPT_STOP_UNRESOLVED,
                                                             .seconds = co_now_seconds() - started};
    return CURVOPT_OK;
}

int co_run_stopped_early(const co_run *r, int32_t number) {
    int32_t stop = r->result->level[number - 1].stop;
    return stop == CURVOPT_STOP_CANCELLED || stop == CURVOPT_STOP_UNRESOLVED;
}

void co_attempt_free(co_attempt *a) {
    co_level_free(&a->level);
    free(a->now.x);
    free(a->now.gradient);
    *a = (co_attempt){0};
}

int32_t co_run_solve(co_run *r, int32_t number, const double *start, co_attempt *a, curvopt_error *error) {
    const curvopt_mesh *mesh = r->result->mesh;
    size_t n = 3 * (size_t)mesh->info.n_vertices;
    double started = co_now_seconds();
    co_outcome solved;
    *a = (co_attempt){.now = {.x = CO_NEW(double, n), .gradient = CO_NEW(double, n)}};
    int32_t status = a->now.x && a->now.gradient ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status =
            co_level_create(&r->frame, mesh, &r->symmetry, &r->constraints, start, number, &a->level, a->now.x, error);
    a->level.report = report;
    a->level.user = r;
    if (status == CURVOPT_OK)
        status = co_level_begin(&a->level, &a->now, error);
    if (status == CURVOPT_OK)
        status = co_level_schedule_solve(&a->level, &a->now, &solved, error);
    if (status == CURVOPT_OK)
        status = end_level(r, &a->level, &a->now, &solved, started, error);
    if (status != CURVOPT_OK)
        co_attempt_free(a);
    return status;
}
