/* Motions that leave an objective as it is. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "variables_setting.h"

#include "hessian/gauge.h"
#include "linalg/vector.h"

static void test_invariances_are_those_of_weights_and_constraints(void **state) {
    (void)state;
    uint8_t freedom[1] = {0};
    const co_constraints none = {0}, some = {.freedom = freedom};
    for (int t = 0; t < CURVOPT_N_TERMS; t++) {
        double weights[CURVOPT_N_TERMS] = {0};
        weights[t] = 1;
        int is_willmore = t == CURVOPT_TERM_WILLMORE || t == CURVOPT_TERM_MEAN;
        CHECK_INT(co_gauge_of(weights, &none, 0), is_willmore ? CO_GAUGE_MOEBIUS : CO_GAUGE_SIMILARITY);
        CHECK_INT(co_gauge_of(weights, &none, 1), CO_GAUGE_SIMILARITY);
        CHECK_INT(co_gauge_of(weights, &some, 0), CO_GAUGE_NONE);
        CHECK_INT(co_gauge_exact(co_gauge_of(weights, &none, 0)), CO_GAUGE_SIMILARITY);
    }
    CHECK_INT(co_gauge_exact(CO_GAUGE_NONE), CO_GAUGE_NONE);
}

typedef struct columns {
    variables_setting v;
    size_t n;
    double *full, *q; /* [3 n_vertices], [CO_GAUGE_MOTIONS + 1][n] */
    int count;
} columns;

static void columns_of(columns *a, cage c, co_gauge gauge, int symmetric) {
    a->v = variables_setting_of(c, NULL, symmetric);
    a->n = (size_t)a->v.dofs.n_variables;
    a->full = calloc(3 * (size_t)c.n_vertices, sizeof *a->full);
    a->q = calloc((CO_GAUGE_MOTIONS + 1) * a->n, sizeof *a->q);
    CHECK_TRUE(a->full && a->q);
    a->count = co_gauge_columns(&a->v.dofs, a->v.x, gauge, a->full, a->q);
}

static void columns_free(columns *a) {
    variables_setting_free(&a->v);
    free(a->full);
    free(a->q);
}

/* What is left of full [3 n_vertices] beside the columns, over its length. */
static double left_of(columns *a, const double *full) {
    double *rest = calloc(a->n, sizeof *rest);
    CHECK_TRUE(rest);
    co_dof_map_gradient(&a->v.dofs, full, rest);
    double whole = co_vector_norm(a->n, rest);
    co_vector_remove(a->n, (size_t)a->count, a->q, rest);
    double left = co_vector_norm(a->n, rest) / whole;
    free(rest);
    return left;
}

static void test_columns_are_orthonormal_and_span_the_motions(void **state) {
    (void)state;
    static const int expected[] = {[CO_GAUGE_NONE] = 0, [CO_GAUGE_SIMILARITY] = 7, [CO_GAUGE_MOEBIUS] = 10};
    for (co_gauge gauge = CO_GAUGE_NONE; gauge <= CO_GAUGE_MOEBIUS; gauge++) {
        columns a;
        columns_of(&a, cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), gauge, 0);
        CHECK_INT(a.count, expected[gauge]);
        for (int i = 0; i < a.count; i++)
            for (int j = 0; j <= i; j++)
                CHECK_NEAR(co_vector_dot(a.n, a.q + (size_t)i * a.n, a.q + (size_t)j * a.n), i == j, 1e-12);
        for (int v = 0; v < a.v.c.n_vertices; v++) { /* a screw that swells, and |x|^2 b - 2 (b.x) x for b = e_z */
            const double *x = a.v.x + 3 * v;
            double square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2], conformal = gauge == CO_GAUGE_MOEBIUS ? 0.7 : 0;
            for (int c = 0; c < 3; c++)
                a.full[3 * v + c] = 0.3 * x[c] + 2 * (c == 0) +
                                    5 * (c == 0   ? -x[1]
                                         : c == 1 ? x[0]
                                                  : 0) +
                                    conformal * ((c == 2) * square - 2 * x[2] * x[c]);
        }
        CHECK_BETWEEN(left_of(&a, a.full), gauge == CO_GAUGE_NONE ? 1 : 0, gauge == CO_GAUGE_NONE ? 1 : 1e-12);
        for (int v = 0; v < a.v.c.n_vertices; v++) /* stretching is none of them */
            for (int c = 0; c < 3; c++)
                a.full[3 * v + c] = c == 0 ? a.v.x[3 * v] : 0;
        CHECK_BETWEEN(left_of(&a, a.full), 0.3, 1);
        columns_free(&a);
    }
}

/* Of a torus with all its symmetries only scaling is left. */
static void test_motions_that_break_the_symmetry_do_not_count(void **state) {
    (void)state;
    columns a;
    columns_of(&a, cage_torus(8, 4, 3, 1.2), CO_GAUGE_MOEBIUS, 1);
    CHECK_INT(a.count, 1);
    CHECK_BETWEEN(left_of(&a, a.v.x), 0, 1e-12);
    columns_free(&a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_invariances_are_those_of_weights_and_constraints),
        cmocka_unit_test(test_columns_are_orthonormal_and_span_the_motions),
        cmocka_unit_test(test_motions_that_break_the_symmetry_do_not_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
