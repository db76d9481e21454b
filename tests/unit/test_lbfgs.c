/* Limited-memory variable metric: what it finds, and its metric. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "curvopt.h"
#include "lbfgs_problem.h"

/* ------------------------------------------------------------------------------------------- what it finds -- */

static void test_quadratic_converges(void **state) {
    (void)state;
    problem p = {.shape = QUADRATIC, .n = 20, .condition = 1e3};
    run r = {.options = usual_options};
    r.options.gradient_tolerance = 1e-7;
    problem_minimize(&p, &r);
    CHECK_INT(r.result.stop, CURVOPT_STOP_CONVERGED);
    CHECK_BETWEEN(r.result.iterations, 5, 300);
    for (int i = 0; i < p.n; i++)
        CHECK_NEAR(r.x[i], i, 1e-7);
    CHECK_NEAR(r.now.value, 1, 1e-13);
}

/* On a quadratic of two variables the metric is exact after two steps, and so is what a step is predicted to gain. */
static void test_predicted_gains_come_true_on_a_quadratic(void **state) {
    (void)state;
    problem p = {.shape = QUADRATIC, .n = 2, .condition = 3};
    run r = {.options = usual_options};
    r.options.max_iterations = 3;
    problem_minimize(&p, &r);
    CHECK_INT(r.result.iterations, 3);
    CHECK_NEAR(p.promise, 1, 1e-6);
}

static void test_rosenbrock_converges(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK, .n = 10};
    run r = {.options = usual_options};
    problem_minimize(&p, &r);
    CHECK_INT(r.result.stop, CURVOPT_STOP_CONVERGED);
    CHECK_BETWEEN(r.result.iterations, 20, 200);
    for (int i = 0; i < p.n; i++)
        CHECK_NEAR(r.x[i], 1, 1e-9);
}

/* Where nothing is left to be gained it says so, instead of going on for ever or failing. */
static void test_gradient_tolerance_of_zero_ends_stalled(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK, .n = 10};
    run r = {.options = usual_options};
    r.options.gradient_tolerance = 0;
    r.options.max_iterations = 100000;
    problem_minimize(&p, &r);
    CHECK_TRUE(r.result.stop == CURVOPT_STOP_STALLED || r.result.stop == CURVOPT_STOP_CONVERGED);
    CHECK_BETWEEN(r.result.iterations, 20, 1000);
    CHECK_NEAR(r.now.value, 1e-3, 1e-17);
}

/* ------------------------------------------------------------------------- the metric, against dense formulas -- */

typedef struct metric {
    int n, n_pairs;
    double s[MOST][MOST], y[MOST][MOST], H[MOST][MOST];
} metric;

static double dot(int n, const double *a, const double *b) {
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

/* H <- (I - s y' / sy) H (I - y s' / sy) + s s' / sy */
static void dense_update(metric *m, const double *s, const double *y) {
    double sy = dot(m->n, s, y), hy[MOST], yhy;
    for (int i = 0; i < m->n; i++)
        hy[i] = dot(m->n, m->H[i], y);
    yhy = dot(m->n, y, hy);
    for (int i = 0; i < m->n; i++)
        for (int j = 0; j < m->n; j++)
            m->H[i][j] += (1 + yhy / sy) * s[i] * s[j] / sy - (hy[i] * s[j] + s[i] * hy[j]) / sy;
}

/* The BFGS matrix of the last `memory` pairs from the usual scaling of the identity. */
static void dense_metric(metric *m, int memory) {
    int first = m->n_pairs > memory ? m->n_pairs - memory : 0, last = m->n_pairs - 1;
    double scale = dot(m->n, m->s[last], m->y[last]) / dot(m->n, m->y[last], m->y[last]);
    for (int i = 0; i < m->n; i++)
        for (int j = 0; j < m->n; j++)
            m->H[i][j] = i == j ? scale : 0;
    for (int k = first; k <= last; k++)
        dense_update(m, m->s[k], m->y[k]);
}

/* The pair of iterate number k and the one before it, by running k steps. */
static void iterate_after(int k, int memory, problem *p, double *x, double *g) {
    *p = (problem){.shape = ROSENBROCK, .n = 6};
    run r = {.options = usual_options};
    r.options.memory = memory;
    r.options.max_iterations = k;
    r.options.max_step = 1e6;
    problem_minimize(p, &r);
    CHECK_INT(r.result.stop, CURVOPT_STOP_LIMIT);
    CHECK_INT(r.result.iterations, k);
    memcpy(x, r.x, sizeof r.x);
    memcpy(g, r.g, sizeof r.g);
}

static void test_directions_are_those_of_the_dense_metric(void **state) {
    (void)state;
    enum { STEPS = 9 };
    for (int memory = 1; memory <= 5; memory += 2) {
        static metric m;
        double x[2][MOST], g[2][MOST];
        problem p;
        m = (metric){.n = 6};
        iterate_after(0, memory, &p, x[0], g[0]);
        for (int k = 1; k <= STEPS; k++) {
            double *s = m.s[m.n_pairs], *y = m.y[m.n_pairs], hy[MOST], hg[MOST], d[MOST] = {0};
            iterate_after(k, memory, &p, x[1], g[1]);
            for (int i = 0; i < m.n; i++) {
                s[i] = x[1][i] - x[0][i];
                y[i] = g[1][i] - g[0][i];
            }
            m.n_pairs++;
            dense_metric(&m, memory);
            for (int i = 0; i < m.n; i++) {
                hy[i] = dot(m.n, m.H[i], y);
                hg[i] = dot(m.n, m.H[i], g[1]);
            }
            for (int i = 0; i < m.n; i++)
                CHECK_NEAR(hy[i], s[i], 1e-8 * sqrt(dot(m.n, s, s))); /* the secant equation */
            iterate_after(k + 1, memory, &p, x[0], g[0]);             /* its first trial is the full step -H g */
            memcpy(d, p.first_trial, sizeof d);
            for (int i = 0; i < m.n; i++)
                CHECK_NEAR(d[i], -hg[i], 1e-7 * sqrt(dot(m.n, hg, hg)));
            memcpy(x[0], x[1], sizeof x[0]);
            memcpy(g[0], g[1], sizeof g[0]);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quadratic_converges),
        cmocka_unit_test(test_predicted_gains_come_true_on_a_quadratic),
        cmocka_unit_test(test_rosenbrock_converges),
        cmocka_unit_test(test_gradient_tolerance_of_zero_ends_stalled),
        cmocka_unit_test(test_directions_are_those_of_the_dense_metric),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
