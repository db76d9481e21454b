/* Vertices that slide along a boundary: they get more evenly spaced, the curve stays, the energy falls; what cancelling
 * leaves. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "solve/multilevel.h"

enum { N_U = 12, N_V = 3 };

static const double pi = 3.14159265358979323846;

/* A cylinder's cage, open, with vertices of both circles up to 0.6 of their distance from even places. */
static cage uneven_band(void) {
    cage c = cage_band(N_U, N_V, 1, 1, 1.5);
    for (int32_t v = 0; v < c.n_vertices; v++) {
        const double u = 2 * pi * (v / (N_V + 1)) / N_U, angle = u + 0.3 * sin(u);
        const int inner = v % (N_V + 1) % N_V != 0;
        c.xyz[3 * v] = (inner ? 0.9 : 1) * cos(angle);
        c.xyz[3 * v + 1] = (inner ? 0.9 : 1) * sin(angle);
    }
    return c;
}

/* What is told, and when the run is asked to end: at this call, 0: never. */
typedef struct watcher {
    int32_t calls, cancel_at, iteration;
    double xyz[3 * N_U * (N_V + 1)];
} watcher;

static int32_t watch(const curvopt_progress *p, void *user) {
    watcher *w = user;
    CHECK_INT(p->iteration, w->calls == 0 ? 0 : w->iteration + 1);
    CHECK_INT(p->level, 1);
    w->iteration = p->iteration;
    memcpy(w->xyz, p->xyz, sizeof w->xyz);
    return ++w->calls == w->cancel_at;
}

/* A run of one level of such a cage. */
typedef struct finished {
    curvopt_summary summary;
    curvopt_level_report level;
    curvopt_energies end;
    double first[3 * N_U * (N_V + 1)], xyz[3 * N_U * (N_V + 1)];
    watcher w;
} finished;

static finished run(int slide, int32_t cancel_at) {
    curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    finished f = {.w = {.cancel_at = cancel_at}};
    curvopt_result *result;
    curvopt_error error;
    o.slide = slide;
    solve_setting *s = solve_setting_of(uneven_band(), &o);
    CHECK_OK(co_multilevel_minimize(s->mesh, s->c.xyz, &s->options, &s->tuning, watch, &f.w, NULL, &result, &error),
             &error);
    curvopt_result_get_summary(result, &f.summary, sizeof f.summary);
    curvopt_result_get_positions(result, f.xyz);
    curvopt_result_get_energies(result, NULL, &f.end, sizeof f.end);
    CHECK_OK(curvopt_result_get_level(result, 0, &f.level, sizeof f.level, &error), &error);
    memcpy(f.first, s->c.xyz, sizeof f.first);
    curvopt_result_destroy(result);
    solve_setting_free(s);
    return f;
}

/* The longest edge of a circle of vertices over the shortest one; all of them must lie on it, as far as they know it.
 */
static double unevenness(const double *xyz, int j, double *off) {
    double longest = 0, shortest = INFINITY;
    *off = 0;
    for (int i = 0; i < N_U; i++) {
        const double *a = xyz + 3 * (i * (N_V + 1) + j), *b = xyz + 3 * ((i + 1) % N_U * (N_V + 1) + j);
        const double edge = hypot(a[0] - b[0], a[1] - b[1]);
        longest = fmax(longest, edge);
        shortest = fmin(shortest, edge);
        *off = fmax(*off, fabs(hypot(a[0], a[1]) - 1));
        CHECK_NEAR(a[2], j ? 1.5 : 0, 1e-12);
    }
    return longest / shortest;
}

static void test_boundaries_get_more_even_and_stay(void **state) {
    (void)state;
    const finished still = run(0, 0), f = run(1, 0);
    double off;
    CHECK_INT(still.summary.n_sliding, 0);
    CHECK_INT(f.summary.n_sliding, 2 * N_U);
    for (int j = 0; j <= N_V; j += N_V) {
        CHECK_BETWEEN(unevenness(f.first, j, &off), 1.75, 1.8);
        CHECK_BETWEEN(unevenness(f.xyz, j, &off), 1, 1.7);
        CHECK_BETWEEN(off, 1e-9, 0.01);
        for (int i = 0; i < N_U; i++)
            for (int c = 0; c < 3; c++)
                CHECK_NEAR(still.xyz[3 * (i * (N_V + 1) + j) + c], still.first[3 * (i * (N_V + 1) + j) + c], 1e-14);
    }
    CHECK_BETWEEN(f.summary.curve_deviation, 1e-9, 0.01);
    CHECK_TRUE(f.end.objective < still.end.objective);
    CHECK_INT(f.summary.verdict, CURVOPT_VERDICT_MINIMUM);
    CHECK_INT(f.level.iterations, f.w.iteration); /* of turns and of what follows, all told of */
    CHECK_TRUE(f.level.evaluations > f.level.iterations);
}

/* Cancelled before the first step, in a turn or after the turns the run ends where the last report stood, to where
 * places can be put back. */
static void test_cancelled_in_a_turn(void **state) {
    (void)state;
    for (int32_t at = 1; at < 12; at += 5) {
        const finished f = run(1, at);
        CHECK_INT(f.w.calls, at);
        CHECK_INT(f.summary.stop, CURVOPT_STOP_CANCELLED);
        CHECK_INT(f.level.stop, CURVOPT_STOP_CANCELLED);
        CHECK_INT(f.level.iterations, at - 1);
        CHECK_BETWEEN(f.level.seconds, 0, f.summary.seconds);
        CHECK_TRUE(f.end.area > 0);
        CHECK_NEAR(f.level.energy, f.end.objective, 0);
        for (int i = 0; i < 3 * N_U * (N_V + 1); i++)
            CHECK_NEAR(f.xyz[i], f.w.xyz[i], 1e-12);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_boundaries_get_more_even_and_stay),
        cmocka_unit_test(test_cancelled_in_a_turn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
