/* Minimizing through the API: reports, progress, cancelling. SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/cancel.h"
#include "cages.h"
#include "check.h"

#include <pthread.h>
#include <stdlib.h>

typedef struct watcher {
    curvopt_cancel *cancel;
    pthread_t thread;
    double last_energy, last_seconds, asked, ended; /* asked: when the flag was raised; by the library's clock */
    double *last_xyz;
    int32_t calls, cancel_at, last_level, last_iteration, last_evaluations, last_vertices;
} watcher;

typedef struct outcome {
    cage c;
    curvopt_options options;
    curvopt_result *result;
    curvopt_summary summary;
    curvopt_energies start, end;
    watcher w;
} outcome;

static outcome torus_outcome(int32_t levels) {
    outcome o = {.c = cage_torus(6, 4, 1, 0.45)};
    cage_perturb(&o.c, 0.05, 12);
    curvopt_options_init(&o.options, sizeof o.options);
    o.options.levels = levels;
    o.options.max_iterations = 15;
    o.options.method = CURVOPT_METHOD_LMVM; /* takes that many steps, which is what is wanted here */
    o.options.threads = 2;
    o.options.tolerance = 1e-3;
    return o;
}

static int32_t watch(const curvopt_progress *p, void *user) {
    watcher *w = user;
    curvopt_mesh_info info;
    curvopt_mesh_get_info(p->mesh, &info, sizeof info);
    CHECK_INT(p->n_vertices, info.n_vertices);
    CHECK_INT(p->reserved, 0);
    CHECK_BETWEEN(p->level, 1, p->levels);
    CHECK_TRUE(p->energy > 0 && p->start_energy > 0 && p->gradient_norm > 0 && isfinite(p->gradient_norm));
    CHECK_TRUE(p->seconds >= w->last_seconds);
    if (w->calls > 0 && p->level == w->last_level) {
        CHECK_INT(p->iteration, w->last_iteration + 1);
        CHECK_TRUE(p->evaluations >= w->last_evaluations + (w->last_iteration > 0));
        CHECK_TRUE(p->energy <= w->last_energy * (1 + 1e-3)); /* rules may change between */
    } else {
        CHECK_INT(p->iteration, 0);
        CHECK_INT(p->level, w->last_level + 1);
    }
    for (int32_t i = 0; i < 3 * p->n_vertices; i++)
        CHECK_TRUE(isfinite(p->xyz[i]));
    free(w->last_xyz);
    w->last_xyz = malloc(sizeof(double) * 3 * (size_t)p->n_vertices);
    CHECK_TRUE(w->last_xyz != NULL);
    memcpy(w->last_xyz, p->xyz, sizeof(double) * 3 * (size_t)p->n_vertices);
    w->last_energy = p->energy;
    w->last_seconds = p->seconds;
    w->last_level = p->level;
    w->last_iteration = p->iteration;
    w->last_evaluations = p->evaluations;
    w->last_vertices = p->n_vertices;
    return ++w->calls == w->cancel_at ? -1 : 0; /* any nonzero cancels */
}

static void run(outcome *o, curvopt_progress_fn progress) {
    curvopt_mesh *mesh = cage_mesh(&o->c);
    curvopt_error error;
    CHECK_OK(curvopt_minimize(mesh, o->c.xyz, &o->options, progress, &o->w, o->w.cancel, &o->result, &error), &error);
    o->w.ended = co_clock_seconds();
    curvopt_mesh_destroy(mesh); /* the result has its own */
    curvopt_result_get_summary(o->result, &o->summary, sizeof o->summary);
    curvopt_result_get_energies(o->result, &o->start, &o->end, sizeof o->end);
}

static void outcome_free(outcome *o) {
    curvopt_result_destroy(o->result);
    curvopt_cancel_destroy(o->w.cancel);
    free(o->w.last_xyz);
    cage_free(&o->c);
}

/* What every result must be, however it ended. */
static void check_result(const outcome *o) {
    const curvopt_mesh *mesh = curvopt_result_mesh(o->result);
    curvopt_mesh_info info;
    curvopt_problem *problem;
    curvopt_energies e;
    curvopt_error error;
    curvopt_mesh_get_info(mesh, &info, sizeof info);
    CHECK_INT(o->summary.n_vertices, info.n_vertices);
    CHECK_INT(o->summary.n_faces, info.n_faces);
    double *xyz = malloc(sizeof(double) * 3 * (size_t)info.n_vertices);
    CHECK_TRUE(xyz != NULL);
    curvopt_result_get_positions(o->result, xyz);
    CHECK_OK(curvopt_problem_create(mesh, NULL, &o->options, &problem, &error), &error);
    CHECK_OK(curvopt_problem_evaluate(problem, xyz, &e, sizeof e, NULL, &error), &error);
    const curvopt_energies *end = &o->end;
    CHECK_NEAR(e.objective, end->objective, 3 * (e.objective_error + end->objective_error)); /* rules may differ */
    CHECK_NEAR(e.area, end->area, 3 * (e.area_error + end->area_error));
    CHECK_TRUE(end->objective_error < 1e-2 * end->objective);
    CHECK_TRUE(o->end.objective <= o->start.objective * (1 + 1e-3));
    CHECK_TRUE(o->summary.seconds >= 0);
    curvopt_problem_destroy(problem);
    free(xyz);
}

/* What a run's result must be whose flag was raised. On a busy machine a run may not have its figures within the grace
 * that it has on the clock; it is then cut off, rightly, and figures may be missing. */
static void check_flagged(const outcome *o) {
    double xyz[3 * 24];
    curvopt_level_report level;
    curvopt_error error;
    CHECK_OK(curvopt_result_get_level(o->result, 0, &level, sizeof level, &error), &error);
    CHECK_INT(level.level, 1);
    CHECK_INT(level.n_vertices, 24);
    CHECK_INT(level.stop, CURVOPT_STOP_CANCELLED);
    CHECK_BETWEEN(level.seconds, 0, o->summary.seconds);
    CHECK_INT(o->summary.stop, CURVOPT_STOP_CANCELLED);
    CHECK_INT(o->summary.n_levels, 1);
    CHECK_INT(o->summary.n_vertices, 24);
    if (o->w.ended - o->w.asked < CO_CANCEL_GRACE) {
        check_result(o);
        return;
    }
    curvopt_result_get_positions(o->result, xyz);
    for (int i = 0; i < 3 * 24; i++)
        CHECK_TRUE(isfinite(xyz[i]));
    CHECK_TRUE(!(o->end.objective > o->start.objective * (1 + 1e-3)));
}

static void test_levels_are_reported_one_by_one(void **state) {
    (void)state;
    outcome o = torus_outcome(3);
    curvopt_level_report r;
    curvopt_error error;
    double seconds = 0;
    run(&o, watch);
    check_result(&o);
    CHECK_INT(o.summary.n_levels, 3);
    for (int32_t i = 0; i < 3; i++) {
        CHECK_OK(curvopt_result_get_level(o.result, i, &r, sizeof r, &error), &error);
        CHECK_INT(r.level, i + 1);
        CHECK_INT(r.n_vertices, 24 << 2 * i);
        CHECK_BETWEEN(r.iterations, 1, 15);
        CHECK_TRUE(r.evaluations >= r.iterations && r.energy > 0 && r.gradient_norm > 0);
        CHECK_INT(r.stop, CURVOPT_STOP_LIMIT);
        CHECK_INT(r.reserved, 0);
        seconds += r.seconds;
    }
    CHECK_NEAR(r.energy, o.end.objective, 0);
    CHECK_INT(o.summary.stop, r.stop);
    CHECK_INT(o.w.calls, 3 * 16);
    CHECK_INT(o.w.last_level, 3);
    CHECK_BETWEEN(seconds, 0, o.summary.seconds * 1.001);
    CHECK_TRUE(o.end.objective < 0.99 * o.start.objective);
    outcome_free(&o);
}

static void test_level_outside_is_refused(void **state) {
    (void)state;
    outcome o = torus_outcome(1);
    curvopt_level_report r;
    curvopt_error error;
    run(&o, NULL);
    CHECK_REFUSED(curvopt_result_get_level(o.result, 1, &r, sizeof r, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "level 1");
    CHECK_REFUSED(curvopt_result_get_level(o.result, -1, &r, sizeof r, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "level -1");
    outcome_free(&o);
}

static void test_start_and_input_are_as_given(void **state) {
    (void)state;
    outcome o = torus_outcome(1);
    cage before = torus_outcome(1).c;
    curvopt_energies e;
    curvopt_error error;
    run(&o, watch);
    assert_memory_equal(o.c.xyz, before.xyz, sizeof(double) * 72); /* the caller's cage is left alone */
    curvopt_mesh *mesh = cage_mesh(&before);
    curvopt_problem *problem;
    CHECK_OK(curvopt_problem_create(mesh, NULL, &o.options, &problem, &error), &error);
    CHECK_OK(curvopt_problem_evaluate(problem, before.xyz, &e, sizeof e, NULL, &error), &error);
    CHECK_NEAR(o.start.objective / e.objective, 1, 1e-3);
    CHECK_NEAR(o.start.area / e.area, 1, 1e-3);
    curvopt_problem_destroy(problem);
    curvopt_mesh_destroy(mesh);
    cage_free(&before);
    outcome_free(&o);
}

static void test_limit_of_no_iterations_returns_the_cage(void **state) {
    (void)state;
    outcome o = torus_outcome(1);
    double xyz[72];
    o.options.max_iterations = 0;
    run(&o, watch);
    CHECK_INT(o.summary.stop, CURVOPT_STOP_LIMIT);
    CHECK_INT(o.w.calls, 1);
    curvopt_result_get_positions(o.result, xyz);
    for (int i = 0; i < 72; i++)
        CHECK_NEAR(xyz[i], o.c.xyz[i], 1e-6);
    outcome_free(&o);
}

static void test_loose_gradient_tolerance_converges(void **state) {
    (void)state;
    outcome o = torus_outcome(2);
    o.options.gradient_tolerance = 1;
    run(&o, NULL);
    CHECK_INT(o.summary.stop, CURVOPT_STOP_CONVERGED);
    check_result(&o);
    outcome_free(&o);
}

/* A run on a thread of the caller's, without checks, which belong to the main thread. */
typedef struct side_run {
    const curvopt_mesh *mesh;
    const outcome *o;
    curvopt_result *result;
    curvopt_error error;
    pthread_t thread;
    int32_t status;
} side_run;

static void *minimize_beside(void *context) {
    side_run *r = context;
    r->status = curvopt_minimize(r->mesh, r->o->c.xyz, &r->o->options, NULL, NULL, NULL, &r->result, &r->error);
    return NULL;
}

/* Four runs of one mesh at once, each with three threads, give the bits of a run alone with one. */
static void test_runs_at_once_give_the_same_bits(void **state) {
    (void)state;
    side_run r[4] = {{0}};
    outcome o = torus_outcome(2);
    o.options.threads = 1;
    run(&o, NULL);
    double *alone = malloc(sizeof(double) * 3 * (size_t)o.summary.n_vertices),
           *xyz = malloc(sizeof(double) * 3 * (size_t)o.summary.n_vertices);
    CHECK_TRUE(alone && xyz);
    curvopt_result_get_positions(o.result, alone);
    o.options.threads = 3;
    curvopt_mesh *mesh = cage_mesh(&o.c);
    for (int k = 0; k < 4; k++) {
        r[k] = (side_run){.mesh = mesh, .o = &o};
        CHECK_INT(pthread_create(&r[k].thread, NULL, minimize_beside, &r[k]), 0);
    }
    for (int k = 0; k < 4; k++)
        CHECK_INT(pthread_join(r[k].thread, NULL), 0);
    for (int k = 0; k < 4; k++) {
        CHECK_OK(r[k].status, &r[k].error);
        curvopt_result_get_positions(r[k].result, xyz);
        assert_memory_equal(xyz, alone, sizeof(double) * 3 * (size_t)o.summary.n_vertices);
        curvopt_result_destroy(r[k].result);
    }
    curvopt_mesh_destroy(mesh);
    free(alone);
    free(xyz);
    outcome_free(&o);
}

static void test_callback_cancels_at_once(void **state) {
    (void)state;
    outcome o = torus_outcome(3);
    o.w.cancel_at = 1;
    run(&o, watch);
    CHECK_INT(o.w.calls, 1);
    CHECK_INT(o.summary.stop, CURVOPT_STOP_CANCELLED);
    CHECK_INT(o.summary.n_levels, 1);
    CHECK_INT(o.summary.n_vertices, 24);
    check_result(&o);
    outcome_free(&o);
}

static void test_callback_cancels_later_and_keeps_the_iterate(void **state) {
    (void)state;
    outcome o = torus_outcome(3);
    curvopt_level_report r;
    double xyz[3 * 96];
    o.w.cancel_at = 16 + 5; /* in the second level */
    run(&o, watch);
    CHECK_INT(o.w.calls, 21);
    CHECK_INT(o.summary.stop, CURVOPT_STOP_CANCELLED);
    CHECK_INT(o.summary.n_levels, 2);
    CHECK_INT(o.summary.n_vertices, 96);
    CHECK_INT(curvopt_result_get_level(o.result, 1, &r, sizeof r, NULL), CURVOPT_OK);
    CHECK_INT(r.stop, CURVOPT_STOP_CANCELLED);
    CHECK_INT(r.iterations, 4);
    check_result(&o);
    curvopt_result_get_positions(o.result, xyz);
    for (int i = 0; i < 3 * 96; i++) /* the last iterate that was shown, up to its placement */
        CHECK_NEAR(xyz[i], o.w.last_xyz[i], 0.2);
    outcome_free(&o);
}

static void test_cancel_raised_before_the_start_stops_it(void **state) {
    (void)state;
    outcome o = torus_outcome(3);
    curvopt_error error;
    CHECK_OK(curvopt_cancel_create(&o.w.cancel, &error), &error);
    o.w.asked = co_clock_seconds();
    curvopt_cancel_request(o.w.cancel);
    run(&o, watch);
    CHECK_INT(o.w.calls, 0);
    check_flagged(&o);
    outcome_free(&o);
}

static void *request(void *cancel) {
    curvopt_cancel_request(cancel);
    return NULL;
}

/* On the third call another thread raises the flag; it must be seen by the next step. */
static int32_t watch_and_request(const curvopt_progress *p, void *user) {
    watcher *w = user;
    int32_t result = watch(p, user);
    if (w->calls == 3) {
        w->asked = co_clock_seconds();
        CHECK_INT(pthread_create(&w->thread, NULL, request, w->cancel), 0);
        CHECK_INT(pthread_join(w->thread, NULL), 0);
    }
    return result;
}

static void test_cancel_from_another_thread_stops_at_the_next_step(void **state) {
    (void)state;
    outcome o = torus_outcome(3);
    curvopt_error error;
    CHECK_OK(curvopt_cancel_create(&o.w.cancel, &error), &error);
    run(&o, watch_and_request);
    CHECK_INT(o.w.calls, 3);
    check_flagged(&o);
    outcome_free(&o);
}

static void test_result_does_not_depend_on_the_number_of_threads(void **state) {
    (void)state;
    outcome o[2] = {torus_outcome(2), torus_outcome(2)};
    double xyz[2][3 * 96];
    for (int n = 0; n < 2; n++) {
        o[n].options.threads = 1 + 2 * n;
        run(&o[n], NULL);
        CHECK_INT(o[n].summary.n_vertices, 96);
        curvopt_result_get_positions(o[n].result, xyz[n]);
    }
    assert_memory_equal(xyz[0], xyz[1], sizeof xyz[0]); /* to the last bit */
    outcome_free(&o[0]);
    outcome_free(&o[1]);
}

static void check_moving_level(const curvopt_mesh *mesh, const cage *c, const curvopt_options *o, int32_t expected) {
    curvopt_error error;
    curvopt_result *result = NULL;
    int32_t level = -1;
    CHECK_OK(curvopt_find_moving_level(mesh, c->xyz, o, &level, &error), &error);
    CHECK_INT(level, expected);
    if (expected)
        CHECK_OK(curvopt_minimize(mesh, c->xyz, o, NULL, NULL, NULL, &result, &error), &error);
    else
        CHECK_REFUSED(curvopt_minimize(mesh, c->xyz, o, NULL, NULL, NULL, &result, &error), &error,
                      CURVOPT_ERROR_ARGUMENT, -1, "nothing may move: all 4 vertices are held");
    curvopt_result_destroy(result);
}

/* One quad, whose vertices are all on the boundary. */
static void test_the_first_level_at_which_a_vertex_may_move(void **state) {
    (void)state;
    const int32_t size = 4, vertices[4] = {0, 1, 2, 3};
    const double xyz[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0.2, 0, 1, 0};
    const curvopt_constraints pins = {.vertices = vertices, .n = 4};
    cage c = cage_of(4, 1, &size, vertices, xyz);
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    o.max_iterations = 1;
    o.threads = 2;
    o.tolerance = 0.1; /* what moves does not depend on it */
    for (o.levels = 1; o.levels <= 4; o.levels++) {
        o.boundary = CURVOPT_BOUNDARY_FREE;
        check_moving_level(mesh, &c, &o, 1);
        o.boundary = CURVOPT_BOUNDARY_POSITION;
        check_moving_level(mesh, &c, &o, o.levels >= 2 ? 2 : 0);
        o.boundary = CURVOPT_BOUNDARY_TANGENT;
        check_moving_level(mesh, &c, &o, o.levels >= 3 ? 3 : 0);
        o.boundary = CURVOPT_BOUNDARY_CURVATURE;
        check_moving_level(mesh, &c, &o, o.levels >= 4 ? 4 : 0);
        o.boundary = CURVOPT_BOUNDARY_FREE;
        o.constraints = &pins; /* a face whose vertices are all pinned stays itself */
        check_moving_level(mesh, &c, &o, 0);
        o.constraints = NULL;
    }
    o.levels = CURVOPT_MAX_LEVELS; /* nothing is subdivided that often to see it */
    o.constraints = &pins;
    check_moving_level(mesh, &c, &o, 0);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_null_and_bad_arguments_are_refused_by_name(void **state) {
    (void)state;
    outcome o = torus_outcome(1);
    curvopt_mesh *mesh = cage_mesh(&o.c);
    curvopt_result *r = (curvopt_result *)(void *)mesh;
    curvopt_error error;
    const int32_t code = CURVOPT_ERROR_ARGUMENT;
    CHECK_REFUSED(curvopt_minimize(NULL, o.c.xyz, &o.options, NULL, NULL, NULL, &r, &error), &error, code, -1,
                  "mesh is NULL");
    CHECK_TRUE(r == NULL);
    CHECK_REFUSED(curvopt_minimize(mesh, NULL, &o.options, NULL, NULL, NULL, &r, &error), &error, code, -1,
                  "xyz is NULL");
    CHECK_REFUSED(curvopt_find_moving_level(mesh, o.c.xyz, &o.options, NULL, &error), &error, code, -1,
                  "level is NULL");
    CHECK_REFUSED(curvopt_minimize(mesh, o.c.xyz, NULL, NULL, NULL, NULL, &r, &error), &error, code, -1,
                  "options is NULL");
    CHECK_REFUSED(curvopt_minimize(mesh, o.c.xyz, &o.options, NULL, NULL, NULL, NULL, &error), &error, code, -1,
                  "out is NULL");
    CHECK_REFUSED(curvopt_cancel_create(NULL, &error), &error, code, -1, "out is NULL");
    o.options.max_step = 1000;
    CHECK_REFUSED(curvopt_minimize(mesh, o.c.xyz, &o.options, NULL, NULL, NULL, &r, &error), &error, code, -1,
                  "max_step is 1000");
    curvopt_mesh_destroy(mesh);
    outcome_free(&o);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_levels_are_reported_one_by_one),
        cmocka_unit_test(test_level_outside_is_refused),
        cmocka_unit_test(test_start_and_input_are_as_given),
        cmocka_unit_test(test_limit_of_no_iterations_returns_the_cage),
        cmocka_unit_test(test_loose_gradient_tolerance_converges),
        cmocka_unit_test(test_runs_at_once_give_the_same_bits),
        cmocka_unit_test(test_callback_cancels_at_once),
        cmocka_unit_test(test_callback_cancels_later_and_keeps_the_iterate),
        cmocka_unit_test(test_cancel_raised_before_the_start_stops_it),
        cmocka_unit_test(test_cancel_from_another_thread_stops_at_the_next_step),
        cmocka_unit_test(test_result_does_not_depend_on_the_number_of_threads),
        cmocka_unit_test(test_the_first_level_at_which_a_vertex_may_move),
        cmocka_unit_test(test_null_and_bad_arguments_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
