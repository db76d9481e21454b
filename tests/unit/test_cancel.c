/* Cancelling: tables, evaluations, and runs at any moment. SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 199309L /* NOLINT: for nanosleep */
#include "check.h"
#include "cpu_time.h"
#include "mesh/mesh.h"
#include "surface/basis_table_cache.h"

#include <pthread.h>
#include <stdlib.h>
#include <time.h>

enum { RINGS = 3 };

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum {
    SLOWER = 20,
    LARGEST = 48,
    EACH = 3
}; /* times that sanitizers may take longer; each third moment is enough there */
#elif defined(IN_QEMU)
enum { SLOWER = 100, LARGEST = 96, EACH = 2 }; /* 50 to 100 were seen */
#else
enum { SLOWER = 1, LARGEST = 96, EACH = 2 };
#endif

/* Of the moments of a list only each so-many-th is tried, or all. */
static size_t stride(void) {
    return long_tests() ? 1 : EACH;
}

/* A double cone with `n` triangles at each pole and quads between. */
static curvopt_mesh *spindle(int32_t n, double *xyz) {
    int32_t sizes[(RINGS + 1) * LARGEST], corners[4 * (RINGS + 1) * LARGEST], n_faces = 0, at = 0;
    const int32_t top = RINGS * n, bottom = top + 1;
    for (int32_t r = 0; r < RINGS; r++)
        for (int32_t k = 0; k < n; k++) {
            const double angle = 2 * acos(-1) * k / n, height = 1 - (r + 1) * 2.0 / (RINGS + 1);
            const double p[3] = {(1 - fabs(height)) * cos(angle), (1 - fabs(height)) * sin(angle), height};
            memcpy(xyz + 3 * (r * n + k), p, sizeof p);
        }
    memcpy(xyz + 3 * top, (double[6]){0, 0, 1, 0, 0, -1}, 6 * sizeof *xyz);
    for (int32_t r = -1; r < RINGS; r++)
        for (int32_t k = 0; k < n; k++) {
            const int32_t next = (k + 1) % n;
            sizes[n_faces++] = r >= 0 && r < RINGS - 1 ? 4 : 3;
            corners[at++] = r < 0 ? top : r * n + k;
            if (r < RINGS - 1)
                corners[at++] = (r + 1) * n + k;
            corners[at++] = r < RINGS - 1 ? (r + 1) * n + next : bottom;
            if (r >= 0)
                corners[at++] = r * n + next;
        }
    curvopt_mesh *mesh;
    curvopt_error error;
    CHECK_OK(curvopt_mesh_create(bottom + 1, n_faces, sizes, corners, &mesh, &error), &error);
    return mesh;
}

/* A run's flag that was seen so long ago that the grace is over. */
static void test_tables_that_are_there_outlive_the_flag(void **state) {
    (void)state;
    co_basis_table_cache cache;
    const co_basis_table *table, *again;
    co_cancel cancel = {0};
    curvopt_cancel *flag;
    curvopt_error error;
    CHECK_OK(curvopt_cancel_create(&flag, &error), &error);
    cancel.flag = flag;
    co_basis_table_cache_create(CURVOPT_SURFACE_POLYNOMIAL, &cache);
    cache.cancel = &cancel;
    CHECK_OK(co_basis_table_cache_get(&cache, 7, 0, &table, &error), &error);
    curvopt_cancel_request(flag);
    atomic_store(&cancel.seen, INT64_MAX); /* within the grace, however long the next line takes */
    CHECK_OK(co_basis_table_cache_get(&cache, 5, 0, &again, &error), &error);
    atomic_store(&cancel.seen, 1);
    CHECK_OK(co_basis_table_cache_get(&cache, 7, 0, &again, &error), &error);
    CHECK_TRUE(again == table);
    CHECK_INT(co_basis_table_cache_get(&cache, 7, 1, &again, &error), CO_CANCELLED);
    CHECK_TRUE(again == NULL);
    CHECK_INT(cache.n_tables, 2);
    co_basis_table_cache_free(&cache);
    curvopt_cancel_destroy(flag);
}

static void test_threads_do_not_change_a_table(void **state) {
    (void)state;
    co_basis_table_cache one, two;
    const co_basis_table *a, *b;
    curvopt_error error;
    co_basis_table_cache_create(CURVOPT_SURFACE_POLYNOMIAL, &one);
    co_basis_table_cache_create(CURVOPT_SURFACE_POLYNOMIAL, &two);
    CHECK_OK(co_thread_pool_create(2, &two.threads, &error), &error);
    CHECK_OK(co_basis_table_cache_get(&one, 20, 1, &a, &error), &error);
    CHECK_OK(co_basis_table_cache_get(&two, 20, 1, &b, &error), &error);
    CHECK_INT(memcmp(a->rows, b->rows, sizeof *a->rows * (size_t)a->n_samples * (size_t)a->n_points * CO_JET), 0);
    CHECK_INT(memcmp(a->weight, b->weight, sizeof *a->weight * (size_t)a->n_samples), 0);
    co_basis_table_cache_free(&one);
    co_thread_pool_destroy(two.threads);
    co_basis_table_cache_free(&two);
}

/* A thread that raises the flag when the process has used so much CPU time. On a busy machine it may be put aside
 * just before that or just after it, while the run goes on. */
typedef struct alarm_clock {
    curvopt_cancel *cancel;
    double at, raised; /* CPU seconds; raised: just after it */
    atomic_int done;
} alarm_clock;

static void *ring(void *of) {
    alarm_clock *clock = of;
    while (!atomic_load(&clock->done) && cpu_seconds() < clock->at)
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    curvopt_cancel_request(clock->cancel);
    clock->raised = cpu_seconds();
    return NULL;
}

/* CPU seconds at the end of a run in which it no longer looks at the flag. */
static const double LAST_STRETCH = 0.1;

/* A run that is cancelled after so many CPU seconds has a result, no worse than its start as far as rules tell, and
 * soon. */
static void check_run(const curvopt_mesh *mesh, const double *xyz, int term, double seconds) {
    curvopt_options options;
    curvopt_error error;
    curvopt_result *result;
    curvopt_summary summary;
    curvopt_energies start, end;
    pthread_t thread;
    double positions[3 * (RINGS * LARGEST + 2)];
    alarm_clock clock = {.at = cpu_seconds() + seconds};
    curvopt_options_init(&options, sizeof options);
    options.weights[CURVOPT_TERM_WILLMORE] = term == CURVOPT_TERM_WILLMORE;
    options.weights[term] = 1;
    options.levels = 1;
    options.threads = 1;
    CHECK_OK(curvopt_cancel_create(&clock.cancel, &error), &error);
    if (seconds <= 0)
        curvopt_cancel_request(clock.cancel);
    CHECK_INT(pthread_create(&thread, NULL, ring, &clock), 0);
    CHECK_OK(curvopt_minimize(mesh, xyz, &options, NULL, NULL, clock.cancel, &result, &error), &error);
    double end_time = cpu_seconds();
    atomic_store(&clock.done, 1);
    pthread_join(thread, NULL);
    curvopt_result_get_summary(result, &summary, sizeof summary);
    curvopt_result_get_energies(result, &start, &end, sizeof end);
    curvopt_result_get_positions(result, positions);
    for (int32_t i = 0; i < 3 * curvopt_result_mesh(result)->info.n_vertices; i++)
        CHECK_TRUE(isfinite(positions[i]));
    CHECK_INT(summary.n_levels, 1);
    if (seconds <= 0 || end_time > clock.raised + LAST_STRETCH * SLOWER)
        CHECK_INT(summary.stop, CURVOPT_STOP_CANCELLED);
    if (summary.stop == CURVOPT_STOP_CANCELLED) {
        CHECK_INT(summary.verdict, CURVOPT_VERDICT_UNKNOWN);
        /* Figures of the input are by finer rules than those of a level that was left. */
        CHECK_TRUE(!(end.objective > start.objective * (1 + 1e-10) + start.objective_error + end.objective_error));
        CHECK_TRUE(end_time - clock.raised < 0.3 * SLOWER);
    }
    curvopt_result_destroy(result);
    curvopt_cancel_destroy(clock.cancel);
}

static void test_runs_end_soon_wherever_they_are_cancelled(void **state) {
    (void)state;
    static const double seconds[] = {0, 0.01, 0.05, 0.15, 0.3, 0.6, 1};
    double xyz[3 * (RINGS * LARGEST + 2)];
    curvopt_mesh *mesh = spindle(LARGEST, xyz);
    for (size_t k = 0; k < sizeof seconds / sizeof *seconds; k += stride()) {
        check_run(mesh, xyz, CURVOPT_TERM_WILLMORE, seconds[k]);
        check_run(mesh, xyz, CURVOPT_TERM_MVS, seconds[k]);
    }
    curvopt_mesh_destroy(mesh);
}

/* Deviation and crossings, each cancelled after so many CPU seconds, end soon, with what holds so far. */
static void check_measures(const curvopt_mesh *mesh, const double *xyz, double seconds) {
    double other[3 * (RINGS * LARGEST + 2)];
    for (int32_t i = 0; i < 3 * mesh->info.n_vertices; i++)
        other[i] = 1.01 * xyz[i];
    for (int which = 0; which < 2; which++) {
        alarm_clock clock = {.at = cpu_seconds() + seconds};
        curvopt_error error;
        curvopt_crossings c;
        curvopt_deviation d = {.bound = INFINITY};
        pthread_t thread;
        CHECK_OK(curvopt_cancel_create(&clock.cancel, &error), &error);
        CHECK_INT(pthread_create(&thread, NULL, ring, &clock), 0);
        if (which)
            CHECK_OK(curvopt_find_crossings(mesh, xyz, 1, clock.cancel, 0, NULL, &c, sizeof c, &error), &error);
        else
            CHECK_OK(curvopt_measure_deviation(mesh, xyz, mesh, other, 1, clock.cancel, &d, sizeof d, NULL, &error),
                     &error);
        const double end = cpu_seconds();
        atomic_store(&clock.done, 1);
        pthread_join(thread, NULL);
        CHECK_TRUE(end - clock.raised < 0.3 * SLOWER);
        CHECK_TRUE(which || (d.bound >= d.max && isfinite(d.bound)));
        curvopt_cancel_destroy(clock.cancel);
    }
}

static void test_measurements_end_soon_wherever_they_are_cancelled(void **state) {
    (void)state;
    static const double seconds[] = {0, 0.01, 0.03, 0.1, 0.3, 0.6, 1};
    double xyz[3 * (RINGS * LARGEST + 2)];
    curvopt_mesh *mesh = spindle(LARGEST, xyz);
    for (size_t k = 0; k < sizeof seconds / sizeof *seconds; k += stride())
        check_measures(mesh, xyz, seconds[k]);
    curvopt_mesh_destroy(mesh);
}

/* ------------------------------------------------------------------------------------------------ evaluations -- */

/* Energies and gradient of one evaluation. */
typedef struct figures {
    curvopt_energies energies;
    double gradient[3 * (RINGS * LARGEST + 2)];
} figures;

static void check_same_figures(const figures *a, const figures *b) {
    CHECK_INT(memcmp(&a->energies, &b->energies, sizeof a->energies), 0);
    CHECK_INT(memcmp(a->gradient, b->gradient, sizeof a->gradient), 0);
}

static curvopt_options options_of(int term) {
    curvopt_options options;
    curvopt_options_init(&options, sizeof options);
    options.weights[CURVOPT_TERM_WILLMORE] = term == CURVOPT_TERM_WILLMORE;
    options.weights[term] = 1;
    options.threads = 2;
    return options;
}

/* A flag that is raised after so many CPU seconds by another thread. */
static void start_clock(alarm_clock *clock, double seconds, pthread_t *thread) {
    curvopt_error error;
    *clock = (alarm_clock){.at = cpu_seconds() + seconds};
    CHECK_OK(curvopt_cancel_create(&clock->cancel, &error), &error);
    if (seconds <= 0)
        curvopt_cancel_request(clock->cancel);
    CHECK_INT(pthread_create(thread, NULL, ring, clock), 0);
}

/* What was cancelled ended soon and says so. */
static int stop_clock(alarm_clock *clock, pthread_t thread, int32_t status, const curvopt_error *error) {
    const double end = cpu_seconds();
    atomic_store(&clock->done, 1);
    pthread_join(thread, NULL);
    if (status == CURVOPT_OK)
        return 0;
    CHECK_INT(status, CURVOPT_ERROR_CANCELLED);
    CHECK_INT(error->code, CURVOPT_ERROR_CANCELLED);
    CHECK_INT(error->element, -1);
    assert_string_equal(error->message, "it was cancelled");
    CHECK_TRUE(end - clock->raised < 0.3 * SLOWER);
    return 1;
}

/* A problem is made and evaluated, each cancelled after so many CPU seconds; then evaluated to the end. Returns how
 * many of both were cancelled. */
static int check_evaluation(const curvopt_mesh *mesh, const double *xyz, int term, double seconds,
                            const figures *expected) {
    const curvopt_options options = options_of(term);
    curvopt_problem *problem;
    curvopt_error error;
    alarm_clock clock;
    pthread_t thread;
    figures found = {.energies = {.area = -1}}, untouched = found;
    start_clock(&clock, seconds, &thread);
    int32_t status =
        curvopt_problem_create_interruptible(mesh, xyz, &options, NULL, NULL, clock.cancel, &problem, &error);
    int n_cancelled = stop_clock(&clock, thread, status, &error);
    curvopt_cancel_destroy(clock.cancel);
    CHECK_TRUE((problem == NULL) == n_cancelled);
    if (!problem)
        CHECK_OK(curvopt_problem_create(mesh, xyz, &options, &problem, &error), &error);
    start_clock(&clock, seconds, &thread);
    status = curvopt_problem_evaluate_interruptible(problem, xyz, NULL, NULL, clock.cancel, &found.energies,
                                                    sizeof found.energies, found.gradient, &error);
    if (stop_clock(&clock, thread, status, &error)) {
        n_cancelled++;
        check_same_figures(&found, &untouched);
        CHECK_OK(curvopt_problem_evaluate(problem, xyz, &found.energies, sizeof found.energies, found.gradient, &error),
                 &error);
    }
    curvopt_cancel_destroy(clock.cancel);
    check_same_figures(&found, expected);
    curvopt_problem_destroy(problem);
    return n_cancelled;
}

static void test_evaluations_end_soon_wherever_they_are_cancelled(void **state) {
    (void)state;
    static const double seconds[] = {0, 0.01, 0.03, 0.1, 0.2, 0.4, 0.7, 1.1};
    static const int terms[] = {CURVOPT_TERM_WILLMORE, CURVOPT_TERM_MVS};
    double xyz[3 * (RINGS * LARGEST + 2)];
    curvopt_mesh *mesh = spindle(LARGEST / 4, xyz);
    for (int t = 0; t < 2; t++) {
        const curvopt_options options = options_of(terms[t]);
        figures expected = {.energies = {.area = 0}};
        curvopt_problem *problem;
        curvopt_error error;
        int n_cancelled = 0;
        CHECK_OK(curvopt_problem_create(mesh, xyz, &options, &problem, &error), &error);
        CHECK_OK(curvopt_problem_evaluate(problem, xyz, &expected.energies, sizeof expected.energies, expected.gradient,
                                          &error),
                 &error);
        curvopt_problem_destroy(problem);
        for (size_t k = 0; k < sizeof seconds / sizeof *seconds; k += stride())
            n_cancelled += check_evaluation(mesh, xyz, terms[t], seconds[k], &expected);
        CHECK_TRUE(n_cancelled >= 2); /* both that the flag of 0 seconds is for; others by how busy the machine is */
    }
    curvopt_mesh_destroy(mesh);
}

/* What a callback was told; it ends the call at its `last`-th call. */
typedef struct listener {
    curvopt_progress told;
    int calls, last, tables; /* tables: calls before the first evaluation */
} listener;

static int32_t record(const curvopt_progress *progress, void *user) {
    listener *l = user;
    CHECK_INT(progress->struct_size, sizeof *progress);
    CHECK_TRUE(progress->seconds >= l->told.seconds && progress->iteration >= l->told.iteration);
    CHECK_TRUE(!isnan(progress->energy) == (progress->iteration > 0)); /* isnan() is not 1 everywhere */
    CHECK_TRUE(progress->mesh == NULL && isnan(progress->step) && progress->evaluations == progress->iteration);
    l->told = *progress;
    l->tables += progress->iteration == 0;
    return ++l->calls == l->last;
}

/* A callback hears of tables and evaluations, and can end either call at any of its calls. */
static void test_callbacks_are_told_and_can_end_an_evaluation(void **state) {
    (void)state;
    double xyz[3 * (RINGS * LARGEST + 2)];
    curvopt_mesh *mesh = spindle(5, xyz);
    curvopt_options options = options_of(CURVOPT_TERM_WILLMORE);
    curvopt_problem *problem;
    curvopt_energies e;
    curvopt_error error;
    options.tolerance = SLOWER > 1 ? 1e-5 : 1e-7; /* sanitizers see as much in fewer calls */
    listener made = {.last = -1}, evaluated = {.last = -1};
    CHECK_OK(curvopt_problem_create_interruptible(mesh, xyz, &options, record, &made, NULL, &problem, &error), &error);
    CHECK_TRUE(made.calls >= 2 && made.tables == made.calls && made.told.xyz == xyz && made.told.n_vertices == 17);
    CHECK_OK(curvopt_problem_evaluate_interruptible(problem, xyz, record, &evaluated, NULL, &e, sizeof e, NULL, &error),
             &error);
    CHECK_TRUE(evaluated.told.iteration >= 2 && evaluated.tables > 0 && evaluated.told.samples == e.n_samples);
    CHECK_TRUE(evaluated.told.energy == e.objective && evaluated.told.xyz == xyz);
    curvopt_problem_destroy(problem);
    for (int last = 1; last <= made.calls + evaluated.calls; last++) {
        listener l = {.last = last};
        int32_t status = curvopt_problem_create_interruptible(mesh, xyz, &options, record, &l, NULL, &problem, &error);
        if (status == CURVOPT_OK) {
            l = (listener){.last = last - l.calls};
            status = curvopt_problem_evaluate_interruptible(problem, xyz, record, &l, NULL, &e, sizeof e, NULL, &error);
        }
        CHECK_INT(status, CURVOPT_ERROR_CANCELLED);
        CHECK_INT(l.calls, l.last);
        if (problem) { /* also where the rules had changed, and their tables were not made */
            curvopt_energies again = {0};
            CHECK_OK(curvopt_problem_evaluate(problem, xyz, &again, sizeof again, NULL, &error), &error);
            CHECK_INT(memcmp(&again, &e, sizeof e), 0);
        }
        curvopt_problem_destroy(problem);
    }
    curvopt_mesh_destroy(mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tables_that_are_there_outlive_the_flag),
        cmocka_unit_test(test_threads_do_not_change_a_table),
        cmocka_unit_test(test_runs_end_soon_wherever_they_are_cancelled),
        cmocka_unit_test(test_measurements_end_soon_wherever_they_are_cancelled),
        cmocka_unit_test(test_evaluations_end_soon_wherever_they_are_cancelled),
        cmocka_unit_test(test_callbacks_are_told_and_can_end_an_evaluation),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
