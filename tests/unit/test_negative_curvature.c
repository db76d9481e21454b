/* Directions of negative curvature and the decrement by conjugate gradients, of matrices whose eigenvectors are known.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "curvopt.h"

#include "solve/conjugate_decrement.h"
#include "solve/negative_curvature.h"

enum { N = 12 };

/* H = sum lambda_k q_k q_k^T, q_k the orthonormal basis of the discrete sine transform. */
typedef struct matrix {
    double lambda[N], shift;
    int solves, fails_at;
} matrix;

static double basis(int k, int i) {
    return sqrt(2.0 / (N + 1)) * sin(acos(-1) * (k + 1) * (i + 1) / (N + 1));
}

/* out = g(H) in, g given on the eigenvalues. */
static void apply(const double *g, const double *in, double *out) {
    double c[N] = {0}, copy[N];
    memcpy(copy, in, sizeof copy);
    for (int k = 0; k < N; k++)
        for (int i = 0; i < N; i++)
            c[k] += basis(k, i) * copy[i];
    for (int i = 0; i < N; i++) {
        out[i] = 0;
        for (int k = 0; k < N; k++)
            out[i] += g[k] * c[k] * basis(k, i);
    }
}

static int32_t solve(void *context, const double *in, double *out, curvopt_error *error) {
    matrix *m = context;
    double g[N];
    if (++m->solves == m->fails_at)
        return co_status_no_memory(error);
    for (int k = 0; k < N; k++)
        g[k] = 1 / (m->lambda[k] + m->shift);
    apply(g, in, out);
    return CURVOPT_OK;
}

static matrix with_lowest(double lowest) {
    matrix m = {.shift = 2};
    for (int k = 0; k < N; k++)
        m.lambda[k] = 1 + k;
    m.lambda[4] = lowest;
    return m;
}

static void test_direction_is_the_lowest_eigenvector(void **state) {
    (void)state;
    matrix m = with_lowest(-1.5);
    const co_shifted_inverse inverse = {.context = &m, .n = N, .shift = m.shift, .least = 0.01, .solve = solve};
    for (int sign = -1; sign <= 1; sign += 2) {
        double gradient[N], d[N], work[N], dot = 0, norm = 0, slope = 0;
        curvopt_error error;
        int found;
        for (int i = 0; i < N; i++)
            gradient[i] = sign * basis(4, i) + 0.1;
        CHECK_OK(co_negative_curvature_direction(&inverse, &co_tuning_defaults, gradient, d, work, &found, &error),
                 &error);
        CHECK_INT(found, 1);
        for (int i = 0; i < N; i++) {
            dot += d[i] * basis(4, i);
            norm += d[i] * d[i];
            slope += d[i] * gradient[i];
        }
        CHECK_NEAR(fabs(dot) / sqrt(norm), 1, 1e-12);
        CHECK_TRUE(slope <= 0);
    }
}

/* Curvature above minus the least shift is none. */
static void test_threshold(void **state) {
    (void)state;
    const double lowest[] = {-0.011, -0.009, 0, 0.5};
    for (int k = 0; k < 4; k++) {
        matrix m = with_lowest(lowest[k]);
        const co_shifted_inverse inverse = {.context = &m, .n = N, .shift = m.shift, .least = 0.01, .solve = solve};
        double gradient[N] = {0}, d[N], work[N];
        curvopt_error error;
        int found;
        co_tuning tuning = co_tuning_defaults;
        tuning.inverse_iterations = 200;
        CHECK_OK(co_negative_curvature_direction(&inverse, &tuning, gradient, d, work, &found, &error), &error);
        CHECK_INT(found, k == 0);
    }
}

static void test_failure_is_handed_on(void **state) {
    (void)state;
    matrix m = with_lowest(-1);
    m.fails_at = 3;
    const co_shifted_inverse inverse = {.context = &m, .n = N, .shift = m.shift, .least = 0.01, .solve = solve};
    double gradient[N] = {0}, d[N], work[N];
    curvopt_error error;
    int found = 1;
    CHECK_INT(co_negative_curvature_direction(&inverse, &co_tuning_defaults, gradient, d, work, &found, &error),
              CURVOPT_ERROR_MEMORY);
    CHECK_INT(found, 0);
}

/* ----- steps along a direction ----- */

/* 1 + x^4/4 - x^2/2 + tilt x: stationary near 0, minima near -1 and 1. `left_only`: rises for x > 0. */
typedef struct well {
    double tilt;
    int left_only;
} well;

static void evaluate(void *context, co_iterate *at) {
    const well *w = context;
    double x = at->x[0];
    at->value = w->left_only && x > 0 ? 1 + x : 1 + x * x * x * x / 4 - x * x / 2 + w->tilt * x;
    if (at->gradient)
        at->gradient[0] = x * x * x - x + w->tilt;
}

static double length_of(void *context, const double *d) {
    (void)context;
    return fabs(d[0]);
}

static int step_from_zero(well w, double longest, double *x, double *value) {
    double g, d = 5, trial;
    const co_objective f = {.context = &w, .n = 1, .evaluate = evaluate, .step_length = length_of};
    co_iterate now = {.x = x, .gradient = &g, .value = 1};
    *x = 0;
    int left = co_negative_curvature_step(&f, &(co_negative_curvature_options){&co_tuning_defaults, longest, 2e-7}, &d,
                                          &trial, &now);
    *value = now.value;
    return left;
}

static void test_step_leaves_the_saddle(void **state) {
    (void)state;
    double x, value;
    CHECK_INT(step_from_zero((well){0}, 1, &x, &value), 1);
    CHECK_NEAR(x, 1, 0); /* the longest is good at once */
    CHECK_NEAR(value, 0.75, 1e-15);
    CHECK_INT(step_from_zero((well){0}, 8, &x, &value), 1); /* 8, 4 and 2 are not */
    CHECK_NEAR(fabs(x), 1, 0);
    CHECK_INT(step_from_zero((well){.left_only = 1}, 1, &x, &value), 1); /* the other way */
    CHECK_NEAR(x, -1, 0);
}

/* A bowl: no step brings anything, and the iterate stays. */
static void bowl(void *context, co_iterate *at) {
    (void)context;
    at->value = 1 + at->x[0] * at->x[0];
}

static void test_no_step_from_a_minimum(void **state) {
    (void)state;
    double x = 0, g = 0, d = 1, trial;
    const co_objective f = {.n = 1, .evaluate = bowl, .step_length = length_of};
    co_iterate now = {.x = &x, .gradient = &g, .value = 1};
    CHECK_INT(co_negative_curvature_step(&f, &(co_negative_curvature_options){&co_tuning_defaults, 1, 2e-7}, &d, &trial,
                                         &now),
              0);
    CHECK_NEAR(x, 0, 0);
    CHECK_NEAR(now.value, 1, 0);
}

/* ----- the decrement ----- */

static void multiply(void *context, const double *v, double *out) {
    const matrix *m = context;
    apply(m->lambda, v, out);
}

static int32_t identity(void *context, const double *in, double *out, curvopt_error *error) {
    matrix *m = context;
    if (++m->solves == m->fails_at)
        return co_status_no_memory(error);
    memcpy(out, in, N * sizeof *out);
    return CURVOPT_OK;
}

static void test_decrement(void **state) {
    (void)state;
    matrix m = with_lowest(0.25);
    const co_linear_system system = {.context = &m, .n = N, .multiply = multiply, .precondition = identity};
    double gradient[N], inverse[N], x[N], exact = 0, decrement;
    curvopt_error error;
    for (int i = 0; i < N; i++) {
        gradient[i] = sin(3.0 * i + 1);
        inverse[i] = 1 / m.lambda[i];
    }
    apply(inverse, gradient, x);
    for (int i = 0; i < N; i++)
        exact += 0.5 * gradient[i] * x[i];
    CHECK_OK(co_conjugate_decrement(&system, gradient, &decrement, &error), &error);
    CHECK_NEAR(decrement, exact, 1e-5 * exact); /* the error is of the order of the residual's square */
    CHECK_TRUE(decrement <= exact * (1 + 1e-12));
    m.lambda[4] = -0.25;
    CHECK_OK(co_conjugate_decrement(&system, gradient, &decrement, &error), &error);
    CHECK_TRUE(isnan(decrement));
    m.solves = 0;
    m.fails_at = 2;
    m.lambda[4] = 1;
    CHECK_INT(co_conjugate_decrement(&system, gradient, &decrement, &error), CURVOPT_ERROR_MEMORY);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_direction_is_the_lowest_eigenvector),
        cmocka_unit_test(test_threshold),
        cmocka_unit_test(test_failure_is_handed_on),
        cmocka_unit_test(test_step_leaves_the_saddle),
        cmocka_unit_test(test_no_step_from_a_minimum),
        cmocka_unit_test(test_decrement),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
