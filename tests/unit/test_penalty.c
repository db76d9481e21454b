/* Springs against their definition, summed vertex by vertex. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "variables_setting.h"

#include "hessian/penalty.h"
#include "mesh/subdivide.h"

enum { N_PINS = 6 };

/* On an 8 x 4 torus: a patch of three with one held exactly in it, a line, a plane, all soft but the one. */
static const int32_t pin_vertex[N_PINS] = {0, 1, 5, 4, 14, 19}, pin_freedom[N_PINS] = {0, 0, 0, 0, 1, 2};
static const double pin_direction[3 * N_PINS] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 0, 1, -1};
static const double pin_weight[N_PINS] = {0.2, 0.5, 0.9, 1, 0.25, 0.75};
/* max w / sum w over 0, 1, 5, 4 is 1 / 2.6 */
static const double pin_stiffness[N_PINS] = {0.25 / 2.6, 1 / 2.6, 9 / 2.6, 0, 1.0 / 3, 3};

typedef struct setting {
    variables_setting v;
    co_penalty pull;
} setting;

static const double SCALE = 7;

static void setting_of(setting *s, cage c, const curvopt_constraints *pins, int symmetric) {
    curvopt_error error;
    s->v = variables_setting_of(c, pins, symmetric);
    CHECK_OK(co_penalty_create(&s->v.held.springs, &s->v.dofs, s->v.centroid, s->v.radius, SCALE, &s->pull, &error),
             &error);
}

static void setting_free(setting *s) {
    co_penalty_free(&s->pull);
    variables_setting_free(&s->v);
}

static void move(setting *s, uint64_t seed, double amount) {
    for (int32_t i = 0; i < s->v.dofs.n_variables; i++)
        s->v.z[i] += amount * check_random(&seed);
    co_dof_map_expand(&s->v.dofs, s->v.z, s->v.x);
}

/* K / (2 R^2) sum k |Q (x - a)|^2 of pins, in the user's units. */
static double definition(const setting *s, const curvopt_constraints *pins, const double *stiffness) {
    double sum = 0;
    for (int32_t i = 0; i < pins->n; i++) {
        const double *d = pins->directions + 3 * i;
        double off[3], square = 0, along = 0, norm = 0;
        for (int c = 0; c < 3; c++) {
            int32_t at = 3 * pins->vertices[i] + c;
            off[c] = s->v.radius * s->v.x[at] + s->v.centroid[c] - s->v.c.xyz[at];
            square += off[c] * off[c];
            along += off[c] * d[c];
            norm += d[c] * d[c];
        }
        if (pins->freedom[i] == 1)
            square -= along * along / norm;
        if (pins->freedom[i] == 2)
            square = along * along / norm;
        sum += SCALE / 2 * stiffness[i] * square / (s->v.radius * s->v.radius);
    }
    return sum;
}

static const curvopt_constraints all_pins = {
    .vertices = pin_vertex, .freedom = pin_freedom, .directions = pin_direction, .n = N_PINS, .weights = pin_weight};

static cage crooked_torus(void) {
    cage c = cage_torus(8, 4, 3, 1.2);
    cage_perturb(&c, 0.2, 5);
    for (int32_t v = 0; v < c.n_vertices; v++)
        c.xyz[3 * v] += 11;
    return c;
}

static void test_value_is_its_definition(void **state) {
    (void)state;
    setting s;
    setting_of(&s, crooked_torus(), &all_pins, 0);
    CHECK_INT(s.v.held.freedom[4], CO_FREEDOM_NONE);
    CHECK_INT(s.v.held.freedom[5], CO_FREEDOM_ALL);
    CHECK_NEAR(co_penalty_value(&s.pull, s.v.z, NULL), 0, 1e-15);
    for (uint64_t k = 1; k < 5; k++) {
        move(&s, k, 0.3);
        CHECK_NEAR(co_penalty_value(&s.pull, s.v.z, NULL), definition(&s, &all_pins, pin_stiffness), 1e-12);
    }
    setting_free(&s);
}

/* Symmetric pins on a symmetric cage: sums over orbits, one node each. */
static void test_value_with_symmetries_is_its_definition(void **state) {
    (void)state;
    const int32_t vertices[4] = {0, 16, 5, 21}, freedom[4] = {0, 0, 2, 2};
    const double directions[12] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1}, weights[4] = {0.5, 0.5, 0.9, 0.9},
                 stiffness[4] = {1, 1, 9, 9};
    const curvopt_constraints pins = {
        .vertices = vertices, .freedom = freedom, .directions = directions, .n = 4, .weights = weights};
    setting s;
    setting_of(&s, cage_torus(8, 4, 3, 1.2), &pins, 1);
    CHECK_BETWEEN(s.v.symmetry.order, 2, 31);
    move(&s, 3, 0.3);
    CHECK_BETWEEN(definition(&s, &pins, stiffness), 1e-3, 1e3);
    CHECK_NEAR(co_penalty_value(&s.pull, s.v.z, NULL), definition(&s, &pins, stiffness), 1e-12);
    setting_free(&s);
}

static void test_symmetries_are_those_of_the_weights(void **state) {
    (void)state;
    const int32_t vertices[2] = {0, 16};
    double weights[2] = {0.5, 0.5};
    const curvopt_constraints pins = {.vertices = vertices, .n = 2, .weights = weights};
    setting s;
    setting_of(&s, cage_torus(8, 4, 3, 1.2), &pins, 1);
    int32_t alike = s.v.symmetry.order;
    setting_free(&s);
    weights[1] = 0.25;
    setting_of(&s, cage_torus(8, 4, 3, 1.2), &pins, 1);
    CHECK_INT(2 * s.v.symmetry.order, alike);
    setting_free(&s);
}

/* Springs at all vertices that end at .2, with symmetries and without: -most ln(1 - |d|^2 / reach^2) vertex by vertex,
 * its differences, and no value beyond the end of one. */
static void test_springs_end(void **state) {
    (void)state;
    const double reach = 0.2;
    double stiffness[32];
    for (int v = 0; v < 32; v++)
        stiffness[v] = 1;
    for (int symmetric = 0; symmetric < 2; symmetric++) {
        setting s = {.v = variables_setting_of(cage_torus(8, 4, 3, 1.2), NULL, symmetric)};
        curvopt_error error;
        CHECK_OK(co_constraints_pull_back(s.v.mesh, s.v.c.xyz, stiffness, reach, &s.v.held, &error), &error);
        CHECK_OK(co_penalty_create(&s.v.held.springs, &s.v.dofs, s.v.centroid, s.v.radius, SCALE, &s.pull, &error),
                 &error);
        int n = s.v.dofs.n_variables;
        double *g = calloc(4 * (size_t)n, sizeof *g), *up = g + n, *down = g + 2 * n, *column = g + 3 * n, sum = 0;
        co_sparse_hessian hessian = variables_hessian(&s.v);
        CHECK_TRUE(g);
        move(&s, 3, 0.02);
        s.pull.weight = symmetric ? 0.37 : 1;
        for (int v = 0; v < 32; v++) {
            double square = 0;
            for (int c = 0; c < 3; c++) {
                double off = s.v.radius * s.v.x[3 * v + c] + s.v.centroid[c] - s.v.c.xyz[3 * v + c];
                square += off * off;
            }
            sum -= s.pull.weight * SCALE / 2 * reach * reach / (s.v.radius * s.v.radius) *
                   log(1 - square / (reach * reach));
        }
        CHECK_NEAR(co_penalty_value(&s.pull, s.v.z, g), sum, 1e-12);
        co_penalty_add_hessian(&s.pull, s.v.z, 1, &hessian);
        for (int i = 0; i < n; i++) {
            const double at = s.v.z[i], h = 1e-6;
            double value[2];
            memset(up, 0, 3 * (size_t)n * sizeof *up);
            s.v.z[i] = at + h;
            value[0] = co_penalty_value(&s.pull, s.v.z, up);
            s.v.z[i] = at - h;
            value[1] = co_penalty_value(&s.pull, s.v.z, down);
            s.v.z[i] = at;
            CHECK_NEAR(g[i], (value[0] - value[1]) / (2 * h), 1e-7);
            variables_hessian_column(&hessian, i, column);
            for (int j = 0; j < n; j++)
                CHECK_NEAR(column[j], (up[j] - down[j]) / (2 * h), 1e-6);
        }
        move(&s, 4, 2);
        assert_true(isinf(co_penalty_value(&s.pull, s.v.z, NULL)));
        co_sparse_hessian_free(&hessian);
        free(g);
        setting_free(&s);
    }
}

/* The function is quadratic: central differences are exact but for rounding. */
static void test_gradient_and_hessian_are_its_differences(void **state) {
    (void)state;
    for (int symmetric = 0; symmetric < 2; symmetric++) {
        const curvopt_constraints pins = {.vertices = pin_vertex, .n = 4, .weights = pin_weight};
        setting s;
        setting_of(&s, symmetric ? cage_torus(8, 4, 3, 1.2) : crooked_torus(), symmetric ? &pins : &all_pins,
                   symmetric);
        int n = s.v.dofs.n_variables;
        double *g = calloc(4 * (size_t)n, sizeof *g), *up = g + n, *down = g + 2 * n, *column = g + 3 * n;
        co_sparse_hessian hessian = variables_hessian(&s.v);
        CHECK_TRUE(g);
        co_penalty_add_hessian(&s.pull, s.v.z, 1, &hessian);
        move(&s, 9, 0.2);
        co_penalty_value(&s.pull, s.v.z, g);
        for (int i = 0; i < n; i++) {
            double at = s.v.z[i], value[2];
            memset(up, 0, 3 * (size_t)n * sizeof *up);
            s.v.z[i] = at + 0.5;
            value[0] = co_penalty_value(&s.pull, s.v.z, up);
            s.v.z[i] = at - 0.5;
            value[1] = co_penalty_value(&s.pull, s.v.z, down);
            s.v.z[i] = at;
            CHECK_NEAR(g[i], value[0] - value[1], 1e-11);
            variables_hessian_column(&hessian, i, column);
            for (int j = 0; j < n; j++)
                CHECK_NEAR(column[j], up[j] - down[j], 1e-11);
        }
        co_sparse_hessian_free(&hessian);
        free(g);
        setting_free(&s);
    }
}

/* Faces of a painted patch pass its stiffness on, all of it; a guide keeps its own. */
static void test_subdivision_keeps_what_a_patch_resists(void **state) {
    (void)state;
    const int32_t vertices[7] = {0, 1, 4, 5, 8, 9, 22};
    const double weights[7] = {0.5, 0.5, 0.5, 0.5, 0.2, 0.2, 0.75};
    const curvopt_constraints pins = {.vertices = vertices, .n = 7, .weights = weights};
    setting s;
    setting_of(&s, crooked_torus(), &pins, 0);
    const co_soft_constraints *k = &s.v.held.springs;
    curvopt_mesh *fine;
    curvopt_error error;
    co_sparse_rows rows;
    double patch = 0, before = 0, *xyz = calloc(3 * 128, sizeof *xyz), *subdivided = calloc(3 * 128, sizeof *xyz);
    CHECK_TRUE(xyz && subdivided);
    for (int i = 0; i < 6; i++)
        before += k->stiffness[vertices[i]];
    CHECK_NEAR(before, 0.5 / 2.4 * (4 + 2 * 0.25), 1e-14);
    CHECK_NEAR(k->stiffness[22], 3, 1e-14);
    CHECK_OK(co_subdivide(s.v.mesh, &fine, &rows, &error), &error);
    CHECK_INT(fine->info.n_vertices, 128);
    co_sparse_rows_apply(&rows, s.v.c.xyz, subdivided);
    memcpy(xyz, subdivided, 3 * 128 * sizeof *xyz);
    CHECK_OK(co_constraints_subdivide(s.v.mesh, fine, &rows, xyz, &s.v.held, &error), &error);
    int n_held = 0;
    for (int32_t v = 0; v < 128; v++) {
        n_held += k->stiffness[v] > 0;
        patch += v == 22 ? 0 : k->stiffness[v];
        for (int c = 0; c < 3 && k->stiffness[v] > 0; c++)
            CHECK_NEAR(k->anchor[3 * v + c], v == 22 ? s.v.c.xyz[3 * v + c] : subdivided[3 * v + c], 1e-14);
    }
    CHECK_INT(n_held, 15 + 1); /* two faces in a row are 3 x 5 vertices */
    CHECK_NEAR(patch, before, 1e-14);
    CHECK_NEAR(k->stiffness[22], 3, 1e-14);
    co_sparse_rows_free(&rows);
    curvopt_mesh_destroy(fine);
    free(xyz);
    free(subdivided);
    setting_free(&s);
}

static void test_weights_of_0_hold_nothing(void **state) {
    (void)state;
    const double none[N_PINS] = {0};
    curvopt_constraints pins = all_pins;
    pins.weights = none;
    setting s;
    setting_of(&s, crooked_torus(), &pins, 0);
    CHECK_TRUE(!s.v.held.freedom && !s.v.held.springs.stiffness);
    setting_free(&s);
}

/* The sums of penalty.h, slowly. The tail of terms ~ l^-3 behind the last is below 1 / l^2. */
static void test_stiffness_is_that_of_a_sphere(void **state) {
    (void)state;
    const double pi = 3.14159265358979323846;
    static const double third[CURVOPT_N_TERMS][2] = {{0, 0}, {1, 1}, {10.0 / 9, 2}, {4.0 / 3, 4}, {1, 1}};
    for (int t = 0; t < CURVOPT_N_TERMS; t++) {
        double weights[CURVOPT_N_TERMS] = {0}, compliance = 0, n = t == CURVOPT_TERM_AREA ? 2 : 100000;
        for (double l = 2; l <= n; l++) {
            double L = l * (l + 1), q = 4 * pi * third[t][0] * 9 / 8 * L * (L - 2) * (L - 2) +
                                        4 * pi * third[t][1] * L * (L - 2) * (L - 6) / 8;
            q = t == CURVOPT_TERM_WILLMORE ? 2 * L * (L - 2)
                : t == CURVOPT_TERM_MEAN   ? L * (L - 2) / 2
                : t == CURVOPT_TERM_AREA   ? L
                                           : q;
            compliance += (2 * l + 1) / (4 * pi * q);
        }
        weights[t] = 2;
        CHECK_NEAR(co_penalty_stiffness(weights) * compliance, 2, 1e-8);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_value_is_its_definition),
        cmocka_unit_test(test_value_with_symmetries_is_its_definition),
        cmocka_unit_test(test_symmetries_are_those_of_the_weights),
        cmocka_unit_test(test_springs_end),
        cmocka_unit_test(test_gradient_and_hessian_are_its_differences),
        cmocka_unit_test(test_subdivision_keeps_what_a_patch_resists),
        cmocka_unit_test(test_weights_of_0_hold_nothing),
        cmocka_unit_test(test_stiffness_is_that_of_a_sphere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
