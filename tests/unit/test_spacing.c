/* What an even spacing is worth, against its definition and its differences. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "check.h"
#include "variables_setting.h"

#include "hessian/spacing.h"

static const double WORTH = 3;

/* Worth that where it is made. */
static co_spacing spacing_of(const variables_setting *s) {
    co_spacing spacing;
    curvopt_error error;
    CHECK_OK(co_spacing_create(s->mesh, &s->dofs, &spacing, &error), &error);
    co_spacing_weigh(&spacing, s->x, WORTH);
    CHECK_NEAR(co_spacing_value(&spacing, s->x, NULL), WORTH, 1e-14);
    return spacing;
}

/* The spacing of the variables s->z, and with g [n_variables] its gradient with respect to them. */
static double value(variables_setting *s, const co_spacing *spacing, double *g) {
    co_dof_map_expand(&s->dofs, s->z, s->x);
    if (!g)
        return co_spacing_value(spacing, s->x, NULL);
    double *gradient = calloc(3 * (size_t)s->c.n_vertices, sizeof *gradient);
    CHECK_TRUE(gradient);
    double v = co_spacing_value(spacing, s->x, gradient);
    co_dof_map_gradient(&s->dofs, gradient, g);
    free(gradient);
    return v;
}

/* A torus net's vertex (u, v), 8 x 4, and its four neighbours by their numbers: the square of its offset from their
 * middle, over the mean square of the edges at `before`. */
static double term(const double *x, const double *before, int u, int v) {
    const int at = 4 * u + v;
    const int neighbour[4] = {4 * ((u + 1) % 8) + v, 4 * ((u + 7) % 8) + v, 4 * u + (v + 1) % 4, 4 * u + (v + 3) % 4};
    double off = 0, edges = 0;
    for (int c = 0; c < 3; c++) {
        double middle = 0;
        for (int k = 0; k < 4; k++) {
            middle += x[3 * neighbour[k] + c] / 4;
            edges += pow(before[3 * neighbour[k] + c] - before[3 * at + c], 2) / 4;
        }
        off += pow(x[3 * at + c] - middle, 2);
    }
    return off / edges;
}

static double sum_of_terms(const double *x, const double *before) {
    double sum = 0;
    for (int u = 0; u < 8; u++)
        for (int v = 0; v < 4; v++)
            sum += term(x, before, u, v);
    return sum;
}

static void test_value_is_the_sum_of_offsets(void **state) {
    (void)state;
    variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), NULL, 0);
    co_spacing spacing = spacing_of(&s);
    double *before = calloc(3 * (size_t)s.c.n_vertices, sizeof *before);
    CHECK_TRUE(before);
    memcpy(before, s.x, 3 * (size_t)s.c.n_vertices * sizeof *before);
    for (int i = 0; i < s.dofs.n_variables; i++)
        s.z[i] += 0.1 * sin(3 * i);
    double now = value(&s, &spacing, NULL), wanted = WORTH * sum_of_terms(s.x, before) / sum_of_terms(before, before);
    CHECK_NEAR(now, wanted, 1e-12 * wanted);
    free(before);
    co_spacing_free(&spacing);
    variables_setting_free(&s);
}

static void check_differences(variables_setting *s) {
    int n = s->dofs.n_variables;
    const double step = 1e-3;
    double *g = calloc(4 * (size_t)n, sizeof *g), *up = g + n, *down = g + 2 * n, *column = g + 3 * n;
    co_sparse_hessian hessian = variables_hessian(s);
    CHECK_TRUE(g);
    co_spacing spacing = spacing_of(s);
    double whole = value(s, &spacing, g);
    co_spacing_add_hessian(&spacing, &hessian);
    for (int i = 0; i < n; i++) {
        double at = s->z[i];
        s->z[i] = at + step;
        double above = value(s, &spacing, up);
        s->z[i] = at - step;
        double below = value(s, &spacing, down);
        s->z[i] = at;
        CHECK_NEAR(g[i], (above - below) / (2 * step), 1e-4 * whole);
        variables_hessian_column(&hessian, i, column);
        for (int j = 0; j < n; j++)
            CHECK_NEAR(column[j], (up[j] - down[j]) / (2 * step), 1e-4 * whole);
    }
    co_spacing_free(&spacing);
    co_sparse_hessian_free(&hessian);
    free(g);
}

static void test_gradient_and_hessian_are_its_differences(void **state) {
    (void)state;
    static const int32_t some[3] = {0, 9, 14}, freedom[3] = {0, 1, 2};
    static const double direction[9] = {0, 0, 0, 1, 2, 3, 0, 1, -1};
    const curvopt_constraints pins = {.vertices = some, .n = 3, .freedom = freedom, .directions = direction};
    variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), NULL, 0);
    check_differences(&s);
    variables_setting_free(&s);
    s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), &pins, 0);
    check_differences(&s);
    variables_setting_free(&s);
    s = variables_setting_of(cage_torus(8, 4, 3, 1.2), NULL, 1); /* edges within one orbit, too */
    CHECK_TRUE(s.symmetry.order > 8);
    check_differences(&s);
    variables_setting_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_value_is_the_sum_of_offsets),
        cmocka_unit_test(test_gradient_and_hessian_are_its_differences),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
