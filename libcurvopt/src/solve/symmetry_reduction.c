/* Down from saddles that symmetry hides, as far as that is worth its price. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "solve/symmetry_reduction.h"

#include "base/memory.h"
#include "solve/saddle_escape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LARGEST_ESCAPE = 5000 };
/* Vertices of levels on which symmetries may be given up. Ways down on coarser ones are of their few lines, not of the
 * shape: what begins without symmetries there falls in a long valley on the fine levels, and is not done in it. */
enum { SMALLEST_LOOSENED = 100, LARGEST_LOOSENED = 2000 };
/* Half of the symmetries is twice the work: it must bring this much of the energy. Going on with the same ones, this.
 */
static const double WORTH_HALF = 0.06, WORTH_SAME = 0.01;

/* Among what ways down from a level's result are looked for; 0: they are not. */
static int wants_escape(const co_run *r, const co_attempt *a, int32_t number, co_saddle_escape_among *among) {
    const curvopt_options *o = r->frame.options;
    int32_t n = r->result->mesh->info.n_vertices;
    int loosen = o->symmetry == CURVOPT_SYMMETRY_AUTO && r->symmetry.order > 1 && !r->keeps_symmetry &&
                 a->level.assembly.functional.has_third && n >= SMALLEST_LOOSENED && n <= LARGEST_LOOSENED;
    *among = loosen ? CO_SADDLE_ESCAPE_ALL : CO_SADDLE_ESCAPE_NORMALS;
    int32_t stop = r->result->level[number - 1].stop;
    return a->level.has_model && (stop == CURVOPT_STOP_CONVERGED || stop == CURVOPT_STOP_SETTLED) &&
           (loosen || (o->escape && n <= LARGEST_ESCAPE));
}

/* What giving up symmetries must bring, of the energy. */
static double worth_of(int32_t order, int32_t left) {
    double worth = order == left ? WORTH_SAME : 0;
    for (; order > left; order = (order + 1) / 2)
        worth += WORTH_HALF;
    return worth;
}

static co_record record_of(const co_run *r, int32_t number) {
    return (co_record){r->result->summary.end, r->result->level[number - 1], r->pull, r->xyz, r->symmetry,
                       r->level_start};
}

static void record_free(co_record *to) {
    free(to->xyz);
    free(to->start);
    co_symmetry_free(&to->symmetry);
}

/* To what the level had come to with the symmetry that it has. */
static void take_back(co_run *r, int32_t number, const co_record *to) {
    free(r->xyz);
    r->xyz = to->xyz;
    r->pull = to->pull;
    r->result->summary.end = to->end;
    r->result->level[number - 1] = to->level;
}

/* The same with the symmetry that it had, and what it had begun with. A run that was cancelled since stays so. */
static void go_back(co_run *r, int32_t number, const co_record *to) {
    int32_t stop = r->result->level[number - 1].stop;
    take_back(r, number, to);
    if (stop == CURVOPT_STOP_CANCELLED)
        r->result->level[number - 1].stop = stop;
    co_symmetry_free(&r->symmetry);
    free(r->level_start);
    r->symmetry = to->symmetry;
    r->level_start = to->start;
}

/* The level has its new figures; what led to them counts. */
static void add_work(curvopt_level_report *level, const curvopt_level_report *before) {
    level->iterations += before->iterations;
    level->evaluations += before->evaluations;
    level->seconds += before->seconds;
}

/* Goes on from some way along, with less symmetry, as `next`. What was there before is the caller's, who has a record
 * of it. */
static int32_t go_down(co_run *r, int32_t number, co_way_down *way, co_attempt *next, curvopt_error *error) {
    curvopt_level_report before = r->result->level[number - 1];
    r->xyz = CO_NEW(double, 3 * (size_t)r->result->mesh->info.n_vertices);
    r->symmetry = way->symmetry;
    r->level_start = way->xyz;
    *way = (co_way_down){0};
    r->frame.keeps_still = 0;
    r->frame.is_patient = 1;
    int32_t status = r->xyz ? co_run_solve(r, number, r->level_start, next, error) : co_status_no_memory(error);
    add_work(&r->result->level[number - 1], &before);
    return status;
}

typedef enum opinion { NOT_WORTH_IT, PERHAPS, WORTH_IT } opinion;

/* Of going down from there to here. What brings half of what is asked for may be the first of two steps. */
static opinion opinion_of(const co_run *r, int32_t number, const co_record *from, co_saddle_escape_among among) {
    const curvopt_level_report *level = &r->result->level[number - 1];
    double worth = among == CO_SADDLE_ESCAPE_ALL ? worth_of(from->symmetry.order, r->symmetry.order) : 0;
    double gain = (from->level.energy + from->pull - level->energy - r->pull) / fabs(from->level.energy);
    if (level->stop == CURVOPT_STOP_UNRESOLVED) /* that would end the run */
        return NOT_WORTH_IT;
    if (level->stop == CURVOPT_STOP_CANCELLED)
        return gain > 0 ? WORTH_IT : NOT_WORTH_IT;
    return gain > worth ? WORTH_IT : gain > worth / 2 ? PERHAPS : NOT_WORTH_IT;
}

/* A last level on which no way down was found: what it comes to where none is looked for, as `next`; *changed: not if
 * that was cancelled before it got as far. */
static int32_t solve_as_ever(co_run *r, int32_t number, co_attempt *next, int *changed, curvopt_error *error) {
    curvopt_level_report *level = &r->result->level[number - 1];
    co_record before = record_of(r, number);
    r->frame.keeps_still = 0;
    r->xyz = CO_NEW(double, 3 * (size_t)r->result->mesh->info.n_vertices);
    int32_t status = r->xyz ? co_run_solve(r, number, r->level_start, next, error) : co_status_no_memory(error);
    *changed = status == CURVOPT_OK &&
               (level->stop != CURVOPT_STOP_CANCELLED || level->energy + r->pull <= before.level.energy + before.pull);
    if (*changed) {
        free(before.xyz);
        add_work(level, &before.level);
    } else {
        int32_t stop = status == CURVOPT_OK ? CURVOPT_STOP_CANCELLED : before.level.stop;
        take_back(r, number, &before);
        level->stop = stop;
    }
    return status;
}

static co_attempt *spare_of(co_symmetry_reduction *d) {
    co_attempt *spare = d->slot;
    while (spare == d->now || spare == d->sure)
        spare++;
    return spare;
}

static void give_way(co_attempt **old, co_attempt *next) {
    co_attempt_free(*old);
    *old = next;
}

/* A step down, if there is a way; *on: whether to look for another. */
static int32_t step_down(co_run *r, int32_t number, co_saddle_escape_among among, co_symmetry_reduction *d, int *on,
                         curvopt_error *error) {
    co_way_down way = {0};
    *on = 0;
    int32_t status = co_saddle_escape_find(&r->frame, r->result->mesh, &r->symmetry, &r->constraints, r->xyz, number,
                                           among, &way, error);
    if (status == CURVOPT_OK && way.found) {
        co_attempt *next = spare_of(d);
        co_record last = record_of(r, number);
        status = go_down(r, number, &way, next, error);
        opinion worth =
            status == CURVOPT_OK ? opinion_of(r, number, d->sure ? &d->before : &last, among) : NOT_WORTH_IT;
        *on = worth == WORTH_IT || (worth == PERHAPS && !d->sure);
        if (!*on) {
            go_back(r, number, &last);
            co_attempt_free(next);
            r->keeps_symmetry |= among == CO_SADDLE_ESCAPE_ALL;
        } else if (worth == PERHAPS) {
            d->sure = d->now;
            d->before = last;
            d->now = next;
        } else {
            give_way(&d->now, next);
            record_free(&last);
            if (d->sure) {
                co_attempt_free(d->sure);
                d->sure = NULL;
                record_free(&d->before);
            }
        }
    }
    co_saddle_escape_free(&way);
    return status;
}

int32_t co_symmetry_reduction_solve(co_run *r, int32_t number, co_symmetry_reduction *d, curvopt_error *error) {
    co_saddle_escape_among among = CO_SADDLE_ESCAPE_NORMALS;
    int on = 1;
    d->now = d->slot;
    int32_t status = co_run_solve(r, number, r->level_start, d->now, error);
    while (status == CURVOPT_OK && on && wants_escape(r, d->now, number, &among))
        status = step_down(r, number, among, d, &on, error);
    if (d->sure) {
        go_back(r, number, &d->before);
        give_way(&d->now, d->sure);
        d->sure = NULL;
        r->keeps_symmetry |= among == CO_SADDLE_ESCAPE_ALL;
    }
    if (status == CURVOPT_OK && r->frame.keeps_still && number == r->frame.options->levels &&
        !d->now->level.assembly.functional.has_third && !co_run_stopped_early(r, number)) {
        co_attempt *next = spare_of(d);
        status = solve_as_ever(r, number, next, &on, error);
        if (on)
            give_way(&d->now, next);
        else
            co_attempt_free(next);
    }
    return status;
}

void co_symmetry_reduction_free(co_symmetry_reduction *d) {
    for (int k = 0; k < 3; k++)
        co_attempt_free(&d->slot[k]);
}
