/* Optimize, subdivide, repeat (the report, section 3.2), on an energy that is kept resolved.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "hierarchy.h"

#include "escape.h"
#include "memory.h"
#include "mirror.h"
#include "placement.h"
#include "refine.h"
#include "stages.h"
#include "verify.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { LARGEST_CERTIFIED = 50000, LARGEST_ESCAPE = 5000 };
/* Vertices of levels on which symmetries may be given up. Ways down on coarser ones are of their few lines, not of the
 * shape: what begins without symmetries there falls in a long valley on the fine levels, and is not done in it. */
enum { SMALLEST_LOOSENED = 100, LARGEST_LOOSENED = 2000 };
static const double STATIONARY = 1e-6; /* decrement, of the energy */
/* Half of the symmetries is twice the work: it must bring this much of the energy. Going on with the same ones, this.
 */
static const double WORTH_HALF = 0.06, WORTH_SAME = 0.01;

/* The whole run. */
typedef struct run {
    co_frame frame;
    curvopt_progress_fn progress;
    void *user;
    double started;
    double start_energy;
    double pull; /* what springs add to the objective of the result */
    curvopt_result *result;
    co_symmetry symmetry; /* of the present level's mesh, which is the result's */
    co_hold constraints;
    co_table_cache tables;
    double *xyz;         /* of the present level, in the user's units */
    double *level_start; /* what the level began with */
} run;

static double now_seconds(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int report(const co_level *l, const co_iterate *now, int iteration, int evaluations, void *user) {
    run *r = user;
    if (co_frame_is_cancelled(&r->frame))
        return 1;
    if (!r->progress)
        return 0;
    co_level_to_user(l, now->x, l->last.integral[CO_INT_AREA], r->xyz);
    curvopt_progress progress = {.energy = co_level_energy(l, now),
                                 .start_energy = r->start_energy,
                                 .gradient_norm = co_level_relative_gradient(l, now),
                                 .seconds = now_seconds() - r->started,
                                 .xyz = r->xyz,
                                 .mesh = l->mesh,
                                 .level = l->number,
                                 .levels = r->frame.options->levels,
                                 .iteration = iteration,
                                 .evaluations = evaluations + 1, /* the level's first */
                                 .n_vertices = l->mesh->info.n_vertices};
    return r->progress(&progress, r->user) != 0;
}

/* Figures of the input cage, with an assembly of their own: what they need of quadrature, the optimization does not. */
static int32_t report_start(run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    co_assembly assembly;
    int resolved, changed;
    curvopt_energies *start = &r->result->summary.start;
    double tolerance = r->frame.options->as_report ? (double)INFINITY : r->frame.options->tolerance;
    int32_t status = co_assembly_create(mesh, r->frame.options, r->frame.tables, NULL, &assembly, error);
    if (status != CURVOPT_OK)
        return status;
    status = co_assembly_resolve(&assembly, r->xyz, tolerance, CO_TERMS_REPORT, start, &resolved, &changed, error);
    if (status == CURVOPT_OK && !r->frame.options->as_report)
        status = co_assembly_check_energies(&assembly, start, error);
    r->start_energy = start->objective;
    r->frame.area = start->area;
    co_assembly_free(&assembly);
    return status;
}

/* Energies at the level's end, and its cage into r->xyz. */
static int32_t end_level(run *r, co_level *l, const co_iterate *now, const co_outcome *solved, double started,
                         curvopt_error *error) {
    int resolved;
    curvopt_energies *end = &r->result->summary.end;
    int32_t status = co_level_finish(l, now, r->xyz, end, &resolved, error);
    if (status != CURVOPT_OK)
        return status;
    r->pull = co_pull_value(&l->pull, now->x, NULL);
    r->result->summary.n_levels = l->number;
    r->result->level[l->number - 1] = (curvopt_level_report){.energy = end->objective,
                                                             .gradient_norm = co_level_relative_gradient(l, now),
                                                             .level = l->number,
                                                             .n_vertices = l->mesh->info.n_vertices,
                                                             .iterations = solved->iterations,
                                                             .evaluations = solved->evaluations + 1,
                                                             .stop = resolved ? solved->stop : CURVOPT_STOP_UNRESOLVED,
                                                             .seconds = now_seconds() - started};
    return CURVOPT_OK;
}

static int is_stationary(const run *r, double decrement) {
    return decrement <= STATIONARY * fabs(r->result->summary.end.objective + r->pull);
}

/* What is asked for besides: the shape without its symmetries, everything without them. */
static int32_t verify_without_symmetry(run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    co_symmetry none = {0};
    co_shape_check shape;
    int32_t status = co_symmetry_none(mesh, &none, error);
    if (status == CURVOPT_OK)
        status = co_verify_shape(&r->frame, mesh, &none, &r->constraints, r->xyz, NULL, 0, &shape, error);
    co_symmetry_free(&none);
    if (status != CURVOPT_OK)
        return status;
    summary->free_negative_directions = shape.negative_directions;
    return co_verify_count(&r->frame, mesh, &r->constraints, r->xyz, &summary->all_negative_directions, error);
}

/* The verdict on where the run ended. */
static int32_t certify(run *r, co_level *l, co_iterate *now, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    co_shape_check shape;
    int verify = r->frame.options->verify;
    int32_t status = co_verify_decrement(l, now, &summary->newton_decrement, error);
    if (status == CURVOPT_OK && co_frame_is_cancelled(&r->frame)) /* what was found stands; there is no verdict */
        return CURVOPT_OK;
    if (status == CURVOPT_OK)
        status = co_verify_shape(&r->frame, l->mesh, &r->symmetry, &r->constraints, r->xyz, l, verify, &shape, error);
    if (status != CURVOPT_OK)
        return status;
    summary->shape_decrement = shape.decrement;
    summary->difference_decrement = shape.difference_decrement;
    summary->negative_directions = shape.negative_directions;
    if (shape.negative_directions < 0 || isnan(summary->newton_decrement))
        summary->verdict = CURVOPT_VERDICT_UNKNOWN;
    else if (!is_stationary(r, summary->newton_decrement))
        summary->verdict = CURVOPT_VERDICT_NOT_STATIONARY;
    else if (shape.negative_directions > 0)
        summary->verdict = CURVOPT_VERDICT_SADDLE;
    else
        summary->verdict = is_stationary(r, shape.decrement) ? CURVOPT_VERDICT_MINIMUM : CURVOPT_VERDICT_NOT_STATIONARY;
    return verify ? verify_without_symmetry(r, l->mesh, error) : CURVOPT_OK;
}

/* Whether the level was the run's last, and one to look at more closely. */
static int wants_certificate(const run *r, int32_t number) {
    return !r->frame.options->as_report && r->result->level[number - 1].stop != CURVOPT_STOP_CANCELLED &&
           r->result->mesh->info.n_vertices <= LARGEST_CERTIFIED;
}

static int stopped_early(const run *r, int32_t number) {
    int32_t stop = r->result->level[number - 1].stop;
    return stop == CURVOPT_STOP_CANCELLED || stop == CURVOPT_STOP_UNRESOLVED;
}

static int ends_run(const run *r, int32_t number) {
    return number == r->frame.options->levels || stopped_early(r, number);
}

/* One solution of a level's problem, and what it was solved with. */
typedef struct attempt {
    co_level level;
    co_iterate now;
} attempt;

static void attempt_free(attempt *a) {
    co_level_free(&a->level);
    free(a->now.x);
    free(a->now.gradient);
    *a = (attempt){0};
}

/* The present mesh from `start`, with the symmetry that is kept; figures and positions into r. */
static int32_t solve(run *r, int32_t number, const double *start, attempt *a, curvopt_error *error) {
    const curvopt_mesh *mesh = r->result->mesh;
    size_t n = 3 * (size_t)mesh->info.n_vertices;
    double started = now_seconds();
    co_outcome solved;
    *a = (attempt){.now = {.x = CO_NEW(double, n), .gradient = CO_NEW(double, n)}};
    int32_t status = a->now.x && a->now.gradient ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status =
            co_level_create(&r->frame, mesh, &r->symmetry, &r->constraints, start, number, &a->level, a->now.x, error);
    a->level.report = report;
    a->level.user = r;
    if (status == CURVOPT_OK)
        status = co_level_begin(&a->level, &a->now, error);
    if (status == CURVOPT_OK)
        status = co_stages_solve(&a->level, &a->now, &solved, error);
    if (status == CURVOPT_OK)
        status = end_level(r, &a->level, &a->now, &solved, started, error);
    if (status != CURVOPT_OK)
        attempt_free(a);
    return status;
}

/* Among what ways down from a level's result are looked for; 0: they are not. */
static int wants_escape(const run *r, const attempt *a, int32_t number, co_escape_among *among) {
    const curvopt_options *o = r->frame.options;
    int32_t n = r->result->mesh->info.n_vertices;
    int loosen = o->symmetry == CURVOPT_SYMMETRY_AUTO && r->symmetry.order > 1 &&
                 a->level.assembly.functional.has_third && n >= SMALLEST_LOOSENED && n <= LARGEST_LOOSENED;
    *among = loosen ? CO_ESCAPE_ALL : CO_ESCAPE_NORMALS;
    int32_t stop = r->result->level[number - 1].stop;
    return a->level.has_model && (stop == CURVOPT_STOP_CONVERGED || stop == CURVOPT_STOP_SETTLED) &&
           (loosen || (o->escape && n <= LARGEST_ESCAPE));
}

/* What a level has come to, to go back to. */
typedef struct record {
    curvopt_energies end;
    curvopt_level_report level;
    double pull;
    double *xyz;
    co_symmetry symmetry;
    double *start;
} record;

/* What giving up symmetries must bring, of the energy. */
static double worth_of(int32_t order, int32_t left) {
    double worth = order == left ? WORTH_SAME : 0;
    for (; order > left; order = (order + 1) / 2)
        worth += WORTH_HALF;
    return worth;
}

static record record_of(const run *r, int32_t number) {
    return (record){r->result->summary.end, r->result->level[number - 1], r->pull, r->xyz, r->symmetry, r->level_start};
}

static void record_free(record *to) {
    free(to->xyz);
    free(to->start);
    co_symmetry_free(&to->symmetry);
}

/* To what the level had come to with the symmetry that it has. */
static void take_back(run *r, int32_t number, const record *to) {
    free(r->xyz);
    r->xyz = to->xyz;
    r->pull = to->pull;
    r->result->summary.end = to->end;
    r->result->level[number - 1] = to->level;
}

/* The same with the symmetry that it had, and what it had begun with. A run that was cancelled since stays so. */
static void go_back(run *r, int32_t number, const record *to) {
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
static int32_t go_down(run *r, int32_t number, co_way_down *way, attempt *next, curvopt_error *error) {
    curvopt_level_report before = r->result->level[number - 1];
    r->xyz = CO_NEW(double, 3 * (size_t)r->result->mesh->info.n_vertices);
    r->symmetry = way->symmetry;
    r->level_start = way->xyz;
    *way = (co_way_down){0};
    r->frame.keeps_still = 0;
    r->frame.is_patient = 1;
    int32_t status = r->xyz ? solve(r, number, r->level_start, next, error) : co_status_no_memory(error);
    add_work(&r->result->level[number - 1], &before);
    return status;
}

typedef enum opinion { NOT_WORTH_IT, PERHAPS, WORTH_IT } opinion;

/* Of going down from there to here. What brings half of what is asked for may be the first of two steps. */
static opinion opinion_of(const run *r, int32_t number, const record *from, co_escape_among among) {
    const curvopt_level_report *level = &r->result->level[number - 1];
    double worth = among == CO_ESCAPE_ALL ? worth_of(from->symmetry.order, r->symmetry.order) : 0;
    double gain = (from->level.energy + from->pull - level->energy - r->pull) / fabs(from->level.energy);
    if (level->stop == CURVOPT_STOP_UNRESOLVED) /* that would end the run */
        return NOT_WORTH_IT;
    if (level->stop == CURVOPT_STOP_CANCELLED)
        return gain > 0 ? WORTH_IT : NOT_WORTH_IT;
    return gain > worth ? WORTH_IT : gain > worth / 2 ? PERHAPS : NOT_WORTH_IT;
}

/* A last level on which no way down was found: what it comes to where none is looked for, as `next`; *changed: not if
 * that was cancelled before it got as far. */
static int32_t solve_as_ever(run *r, int32_t number, attempt *next, int *changed, curvopt_error *error) {
    curvopt_level_report *level = &r->result->level[number - 1];
    record before = record_of(r, number);
    r->frame.keeps_still = 0;
    r->xyz = CO_NEW(double, 3 * (size_t)r->result->mesh->info.n_vertices);
    int32_t status = r->xyz ? solve(r, number, r->level_start, next, error) : co_status_no_memory(error);
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

/* A level's way down. */
typedef struct descent {
    attempt slot[3];
    attempt *now;  /* what the run shows */
    attempt *sure; /* NULL, or where the last step began, for that is gone back to if the next one does not make it
                      worth while, */
    record before; /* and what the run showed there */
} descent;

static attempt *spare_of(descent *d) {
    attempt *spare = d->slot;
    while (spare == d->now || spare == d->sure)
        spare++;
    return spare;
}

static void give_way(attempt **old, attempt *next) {
    attempt_free(*old);
    *old = next;
}

/* A step down, if there is a way; *on: whether to look for another. */
static int32_t step_down(run *r, int32_t number, co_escape_among among, descent *d, int *on, curvopt_error *error) {
    co_way_down way = {0};
    *on = 0;
    int32_t status =
        co_escape_find(&r->frame, r->result->mesh, &r->symmetry, &r->constraints, r->xyz, number, among, &way, error);
    if (status == CURVOPT_OK && way.found) {
        attempt *next = spare_of(d);
        record last = record_of(r, number);
        status = go_down(r, number, &way, next, error);
        opinion worth =
            status == CURVOPT_OK ? opinion_of(r, number, d->sure ? &d->before : &last, among) : NOT_WORTH_IT;
        *on = worth == WORTH_IT || (worth == PERHAPS && !d->sure);
        if (!*on) {
            go_back(r, number, &last);
            attempt_free(next);
        } else if (worth == PERHAPS) {
            d->sure = d->now;
            d->before = last;
            d->now = next;
        } else {
            give_way(&d->now, next);
            record_free(&last);
            if (d->sure) {
                attempt_free(d->sure);
                d->sure = NULL;
                record_free(&d->before);
            }
        }
    }
    co_escape_free(&way);
    return status;
}

/* The level's minimum, and further down as long as symmetries are worth giving up. */
static int32_t solve_and_descend(run *r, int32_t number, descent *d, curvopt_error *error) {
    co_escape_among among;
    int on = 1;
    d->now = d->slot;
    int32_t status = solve(r, number, r->level_start, d->now, error);
    while (status == CURVOPT_OK && on && wants_escape(r, d->now, number, &among))
        status = step_down(r, number, among, d, &on, error);
    if (d->sure) {
        go_back(r, number, &d->before);
        give_way(&d->now, d->sure);
        d->sure = NULL;
    }
    if (status == CURVOPT_OK && r->frame.keeps_still && number == r->frame.options->levels &&
        !d->now->level.assembly.functional.has_third && !stopped_early(r, number)) {
        attempt *next = spare_of(d);
        status = solve_as_ever(r, number, next, &on, error);
        if (on)
            give_way(&d->now, next);
        else
            attempt_free(next);
    }
    return status;
}

static int32_t solve_level(run *r, int32_t number, curvopt_error *error) {
    descent d = {0};
    int32_t status = solve_and_descend(r, number, &d, error);
    if (status == CURVOPT_OK && ends_run(r, number) && wants_certificate(r, number))
        status = certify(r, &d.now->level, &d.now->now, error);
    for (int k = 0; k < 3; k++)
        attempt_free(&d.slot[k]);
    return status;
}

/* The next level's cage: r->result->mesh, r->xyz and what goes with them, subdivided. */
static int32_t subdivide(run *r, curvopt_error *error) {
    curvopt_mesh *fine = NULL;
    co_rows rows = {0};
    double *xyz = NULL, *start = NULL;
    int32_t status = co_refine(r->result->mesh, &fine, &rows, error);
    if (status == CURVOPT_OK) {
        xyz = CO_NEW(double, 3 * (size_t)rows.n_rows);
        start = CO_NEW(double, 3 * (size_t)rows.n_rows);
        status = xyz && start ? CURVOPT_OK : co_status_no_memory(error);
    }
    if (status == CURVOPT_OK) {
        co_rows_apply(&rows, r->xyz, xyz);
        status = co_hold_refine(r->result->mesh, fine, &rows, xyz, &r->constraints, error);
    }
    if (status == CURVOPT_OK)
        status = co_symmetry_refine(&r->symmetry, error);
    if (status != CURVOPT_OK) {
        free(xyz);
        free(start);
        co_mesh_destroy(fine);
    } else {
        memcpy(start, xyz, sizeof(double) * 3 * (size_t)rows.n_rows);
        free(r->xyz);
        free(r->level_start);
        co_mesh_destroy(r->result->mesh);
        r->xyz = xyz;
        r->level_start = start;
        r->result->mesh = fine;
    }
    co_rows_free(&rows);
    return status;
}

static int32_t run_levels(run *r, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    for (int32_t number = 1; number <= r->frame.options->levels; number++) {
        int32_t status = number > 1 ? subdivide(r, error) : CURVOPT_OK;
        if (status == CURVOPT_OK)
            status = solve_level(r, number, error);
        if (status != CURVOPT_OK)
            return status;
        summary->stop = r->result->level[number - 1].stop;
        if (ends_run(r, number))
            break;
    }
    summary->seconds = now_seconds() - r->started;
    summary->n_vertices = r->result->mesh->info.n_vertices;
    summary->n_faces = r->result->mesh->info.n_faces;
    summary->method = r->frame.options->method;
    summary->symmetry_order = r->symmetry.order;
    return CURVOPT_OK;
}

/* The mirror planes that were chosen; where nothing is held, the first level starts from a cage that has them exactly.
 */
static int32_t hold_planes(run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    const curvopt_options *o = r->frame.options;
    co_hold all = {0};
    int32_t status = co_mirror_create(mesh, xyz, &r->constraints, o->symmetry_planes, &r->symmetry, error);
    if (status == CURVOPT_OK)
        status = co_hold_all(mesh, &r->constraints, o->boundary, &all, error);
    if (status == CURVOPT_OK && !all.freedom)
        status = co_mirror_even_out(mesh, &r->symmetry, r->level_start, error);
    co_hold_free(&all);
    return status;
}

/* Constraints and symmetries of the input cage. */
static int32_t find_structure(run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    const curvopt_options *o = r->frame.options;
    int32_t status = co_hold_create(mesh, xyz, o->constraints, &r->constraints, error);
    if (status != CURVOPT_OK)
        return status;
    if (r->constraints.freedom) {
        co_hold all = {0};
        status = co_hold_all(mesh, &r->constraints, o->boundary, &all, error);
        if (status == CURVOPT_OK)
            status = co_hold_check(mesh, &all, error);
        co_hold_free(&all);
    }
    if (status != CURVOPT_OK)
        return status;
    if (o->symmetry == CURVOPT_SYMMETRY_PLANES)
        return hold_planes(r, mesh, xyz, error);
    if (o->as_report || o->symmetry == CURVOPT_SYMMETRY_NONE)
        return co_symmetry_none(mesh, &r->symmetry, error);
    return co_symmetry_create(mesh, xyz, &r->constraints, o->symmetry != CURVOPT_SYMMETRY_ROTATIONS, &r->symmetry,
                              error);
}

static int32_t start_run(run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    size_t n = 3 * (size_t)mesh->info.n_vertices;
    r->result = CO_NEW(curvopt_result, 1);
    r->xyz = CO_NEW(double, n);
    r->level_start = CO_NEW(double, n);
    if (!r->result || !r->xyz || !r->level_start)
        return co_status_no_memory(error);
    r->result->summary.newton_decrement = (double)NAN;
    r->result->summary.shape_decrement = (double)NAN;
    r->result->summary.difference_decrement = (double)NAN;
    r->result->summary.negative_directions = -1;
    r->result->summary.all_negative_directions = -1;
    r->result->summary.free_negative_directions = -1;
    r->result->level = CO_NEW(curvopt_level_report, r->frame.options->levels);
    if (!r->result->level)
        return co_status_no_memory(error);
    memcpy(r->xyz, xyz, n * sizeof(double));
    memcpy(r->level_start, xyz, n * sizeof(double));
    r->frame.radius = co_placement_frame(n / 3, xyz, r->frame.centroid);
    int32_t status = co_mesh_copy(mesh, &r->result->mesh, error);
    if (status == CURVOPT_OK)
        status = find_structure(r, mesh, xyz, error);
    return status == CURVOPT_OK ? report_start(r, mesh, error) : status;
}

int32_t co_hierarchy_minimize(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                              curvopt_progress_fn progress, void *user, const curvopt_cancel *cancel,
                              curvopt_result **out, curvopt_error *error) {
    run r = {.frame = {.options = options, .cancel = cancel, .keeps_still = options->escape},
             .progress = progress,
             .user = user,
             .started = now_seconds()};
    co_table_cache_create(options->surface, &r.tables);
    r.frame.tables = &r.tables;
    int32_t status = start_run(&r, mesh, xyz, error);
    if (status == CURVOPT_OK)
        status = run_levels(&r, error);
    free(r.level_start);
    co_hold_free(&r.constraints);
    co_symmetry_free(&r.symmetry);
    co_table_cache_free(&r.tables);
    if (status != CURVOPT_OK) {
        free(r.xyz);
        co_hierarchy_result_destroy(r.result);
        return status;
    }
    r.result->xyz = r.xyz;
    *out = r.result;
    return CURVOPT_OK;
}

void co_hierarchy_result_destroy(curvopt_result *result) {
    if (!result)
        return;
    co_mesh_destroy(result->mesh);
    free(result->xyz);
    free(result->level);
    free(result);
}
