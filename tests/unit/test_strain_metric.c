/* What steps strain edges by, against its definition. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "variables_setting.h"

#include "hessian/strain_metric.h"

#include <math.h>
#include <string.h>

static const double EDGE = 0.7;

/* The metric of s' cage; the caller frees it. */
static double *metric_of(const variables_setting *s, co_sparse_hessian *hessian) {
    const co_cage_edges edges = {.mesh = s->mesh, .dofs = &s->dofs};
    double *metric = calloc((size_t)hessian->pattern.n_entries, sizeof *metric);
    CHECK_TRUE(metric);
    CHECK_INT(co_strain_metric(&edges, s->x, EDGE, hessian, metric, NULL), CURVOPT_OK);
    return metric;
}

/* d . metric d. */
static double square_of(co_sparse_hessian *hessian, double *metric, const double *d) {
    const int32_t n = hessian->dofs->n_variables;
    double *own = hessian->value, *out = calloc((size_t)n, sizeof *out), sum = 0;
    CHECK_TRUE(out);
    hessian->value = metric;
    co_sparse_hessian_multiply(hessian, d, out);
    hessian->value = own;
    for (int32_t i = 0; i < n; i++)
        sum += d[i] * out[i];
    free(out);
    return sum;
}

/* The same by the definition, each edge from both sides; edges shorter than 1e-3 EDGE count as so long. */
static double defined(const variables_setting *s, const double *moved) {
    double twice = 0;
    for (int32_t f = 0, h = 0; f < s->c.n_faces; h += s->c.sizes[f++])
        for (int32_t k = 0; k < s->c.sizes[f]; k++) {
            const int32_t v = s->c.vertices[h + k], w = s->c.vertices[h + (k + 1) % s->c.sizes[f]];
            double length = 0, change = 0;
            for (int c = 0; c < 3; c++) {
                const double along = s->x[3 * v + c] - s->x[3 * w + c];
                const double now = moved[3 * v + c] - moved[3 * w + c];
                length += along * along;
                change += (now - along) * (now - along);
            }
            twice += change / fmax(length, 1e-6 * EDGE * EDGE);
        }
    return EDGE * EDGE / 4 * twice / 2;
}

static void check_definition(variables_setting *s) {
    const size_t n = (size_t)s->dofs.n_variables, n_x = 3 * (size_t)s->c.n_vertices;
    double *d = calloc(n, sizeof *d), *z = calloc(n, sizeof *z), *moved = calloc(n_x, sizeof *moved);
    co_sparse_hessian hessian = variables_hessian(s);
    CHECK_TRUE(d && z && moved);
    for (size_t e = 0; e < hessian.pattern.n_entries; e++)
        hessian.value[e] = (double)e;
    double *metric = metric_of(s, &hessian);
    for (int turn = 0; turn < 3; turn++) {
        for (size_t i = 0; i < n; i++) {
            d[i] = sin(1 + (double)(i * i) + 2.5 * turn);
            z[i] = s->z[i] + d[i];
        }
        co_dof_map_expand(&s->dofs, z, moved);
        const double expected = defined(s, moved);
        CHECK_NEAR(square_of(&hessian, metric, d), expected, 1e-11 * expected);
    }
    for (size_t e = 0; e < hessian.pattern.n_entries; e++)
        CHECK_TRUE(hessian.value[e] == (double)e); /* the Hessian's own stay */
    co_sparse_hessian_free(&hessian);
    free(metric);
    free(moved);
    free(z);
    free(d);
}

static void test_is_the_sum_of_strains(void **state) {
    (void)state;
    static const int32_t some[3] = {0, 9, 14}, freedom[3] = {0, 1, 2};
    static const double direction[9] = {0, 0, 0, 1, 2, 3, 0, 1, -1};
    const curvopt_constraints pins = {.vertices = some, .n = 3, .freedom = freedom, .directions = direction};
    for (int k = 0; k < 3; k++) { /* plain; held; with nodes of several vertices */
        cage c = k == 2 ? cage_torus(8, 4, 3, 1.2) : cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1);
        variables_setting s = variables_setting_of(c, k == 1 ? &pins : NULL, k == 2);
        check_definition(&s);
        variables_setting_free(&s);
    }
}

/* An edge without a length has a metric that is finite. */
static void test_edge_of_no_length(void **state) {
    (void)state;
    cage c = cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1);
    memcpy(c.xyz + 3, c.xyz, 3 * sizeof *c.xyz);
    variables_setting s = variables_setting_of(c, NULL, 0);
    check_definition(&s);
    variables_setting_free(&s);
}

/* What moves together costs nothing, however short its edges are. */
static void test_moving_together_is_free(void **state) {
    (void)state;
    variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), NULL, 0);
    const size_t n = (size_t)s.dofs.n_variables, n_x = 3 * (size_t)s.c.n_vertices;
    double *d = calloc(n, sizeof *d), *gradient = calloc(n_x, sizeof *gradient);
    co_sparse_hessian hessian = variables_hessian(&s);
    CHECK_TRUE(d && gradient);
    double *metric = metric_of(&s, &hessian);
    for (size_t i = 0; i < n_x; i++)
        gradient[i] = i % 3 == 1;
    co_dof_map_gradient(&s.dofs, gradient, d); /* orthonormal variables: a translation */
    CHECK_TRUE(square_of(&hessian, metric, d) < 1e-13);
    d[0] += 1;
    CHECK_TRUE(square_of(&hessian, metric, d) > 0.1);
    co_sparse_hessian_free(&hessian);
    free(metric);
    free(gradient);
    free(d);
    variables_setting_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_is_the_sum_of_strains),
        cmocka_unit_test(test_edge_of_no_length),
        cmocka_unit_test(test_moving_together_is_free),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
