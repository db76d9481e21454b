/* Energies and gradients through the API. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include <stdlib.h>

static const double pi = 3.14159265358979323846;

static curvopt_options options_for(int32_t surface, int32_t term) {
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    o.surface = surface;
    o.weights[CURVOPT_TERM_WILLMORE] = 0;
    o.weights[term] = 1;
    o.threads = 2;
    o.tolerance = 1e-2;
    return o;
}

static curvopt_problem *problem_of(const cage *c, const curvopt_options *options) {
    curvopt_mesh *mesh = cage_mesh(c);
    curvopt_problem *problem = NULL;
    curvopt_error error;
    CHECK_OK(curvopt_problem_create(mesh, NULL, options, &problem, &error), &error);
    curvopt_mesh_destroy(mesh); /* the problem keeps its own copy */
    return problem;
}

static curvopt_energies energies_of(curvopt_problem *problem, const double *xyz, double *gradient) {
    curvopt_energies e;
    curvopt_error error;
    memset(&e, 0xff, sizeof e);
    CHECK_OK(curvopt_problem_evaluate(problem, xyz, &e, sizeof e, gradient, &error), &error);
    return e;
}

/* Slope by central differences in a few coordinates. */
static void check_gradient(cage c, curvopt_options o) {
    double *gradient = calloc(3 * (size_t)c.n_vertices, sizeof *gradient), scale = 0;
    const double h = 1e-5;
    CHECK_TRUE(gradient != NULL);
    o.tolerance = 0.5; /* no rule changes between the evaluations */
    curvopt_problem *problem = problem_of(&c, &o);
    curvopt_energies e = energies_of(problem, c.xyz, gradient);
    for (int32_t i = 0; i < 3 * c.n_vertices; i++)
        scale = fmax(scale, fabs(gradient[i]));
    CHECK_TRUE(scale > 1e-3 * e.objective);
    for (int32_t k = 0; k < 12; k++) {
        int32_t i = k * 37 % (3 * c.n_vertices);
        double x = c.xyz[i];
        c.xyz[i] = x + h;
        double plus = energies_of(problem, c.xyz, NULL).objective;
        c.xyz[i] = x - h;
        double minus = energies_of(problem, c.xyz, NULL).objective;
        c.xyz[i] = x;
        CHECK_NEAR(gradient[i], (plus - minus) / (2 * h), 2e-6 * scale);
    }
    curvopt_problem_destroy(problem);
    free(gradient);
    cage_free(&c);
}

static cage bumpy_torus(void) {
    cage c = cage_torus(7, 5, 1, 0.4);
    cage_perturb(&c, 0.05, 3);
    return c;
}

static cage bumpy_kites(void) {
    cage c = cage_trapezohedron(5);
    cage_perturb(&c, 0.05, 4);
    return c;
}

static void test_gradients_agree_with_differences_on_a_torus(void **state) {
    (void)state;
    for (int32_t term = 0; term < CURVOPT_N_TERMS; term++)
        check_gradient(bumpy_torus(), options_for(CURVOPT_SURFACE_LIMIT, term));
}

static void test_gradients_agree_with_differences_near_extraordinary_vertices(void **state) {
    (void)state;
    check_gradient(bumpy_kites(), options_for(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE));
    check_gradient(bumpy_kites(), options_for(CURVOPT_SURFACE_PLANE, CURVOPT_TERM_MVS));
    check_gradient(bumpy_kites(), options_for(CURVOPT_SURFACE_POLYNOMIAL, CURVOPT_TERM_MVS_CROSS));
}

static void test_gradient_of_a_mix_of_terms(void **state) {
    (void)state;
    curvopt_options o = options_for(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        o.weights[t] = 1.0 / (t + 2);
    check_gradient(bumpy_torus(), o);
}

static void test_gradient_is_blind_to_translation_rotation_and_scale(void **state) {
    (void)state;
    cage c = bumpy_kites();
    curvopt_options o = options_for(CURVOPT_SURFACE_PLANE, CURVOPT_TERM_MVS);
    curvopt_problem *problem = problem_of(&c, &o);
    double gradient[36], shift[3] = {0}, turn[3] = {0}, scale = 0, size = 0;
    energies_of(problem, c.xyz, gradient);
    for (int v = 0; v < c.n_vertices; v++)
        for (int i = 0; i < 3; i++) {
            const double *x = c.xyz + 3 * v, *g = gradient + 3 * v;
            int j = (i + 1) % 3, k = (i + 2) % 3;
            shift[i] += g[i];
            turn[i] += x[j] * g[k] - x[k] * g[j];
            scale += x[i] * g[i];
            size += fabs(g[i]);
        }
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(shift[i], 0, 1e-12 * size);
        CHECK_NEAR(turn[i], 0, 1e-10 * size);
    }
    CHECK_NEAR(scale, 0, 1e-12 * size);
    curvopt_problem_destroy(problem);
    cage_free(&c);
}

static void test_results_do_not_depend_on_the_number_of_threads(void **state) {
    (void)state;
    cage c = cage_both(bumpy_torus(), bumpy_kites(), 4);
    double *gradient[3];
    curvopt_energies e[3];
    for (int n = 0; n < 3; n++) {
        curvopt_options o = options_for(CURVOPT_SURFACE_PLANE, CURVOPT_TERM_MVS_CROSS);
        o.threads = 1 + 3 * n;
        curvopt_problem *problem = problem_of(&c, &o);
        gradient[n] = calloc(3 * (size_t)c.n_vertices, sizeof(double));
        CHECK_TRUE(gradient[n] != NULL);
        e[n] = energies_of(problem, c.xyz, gradient[n]);
        curvopt_problem_destroy(problem);
        assert_memory_equal(&e[n], &e[0], sizeof e[n]); /* to the last bit */
        assert_memory_equal(gradient[n], gradient[0], 3 * sizeof(double) * (size_t)c.n_vertices);
    }
    for (int n = 0; n < 3; n++)
        free(gradient[n]);
    cage_free(&c);
}

static void test_energies_are_consistent_with_each_other(void **state) {
    (void)state;
    cage c = cage_both(bumpy_torus(), bumpy_kites(), 4);
    curvopt_options o = options_for(CURVOPT_SURFACE_PLANE, CURVOPT_TERM_MVS);
    o.weights[CURVOPT_TERM_WILLMORE] = 0.25;
    curvopt_problem *problem = problem_of(&c, &o);
    curvopt_energies e = energies_of(problem, c.xyz, NULL);
    CHECK_NEAR(e.objective, e.term[CURVOPT_TERM_MVS] + 0.25 * e.term[CURVOPT_TERM_WILLMORE], 1e-12 * e.objective);
    CHECK_NEAR(3 * e.term[CURVOPT_TERM_MVS_CROSS], e.term[CURVOPT_TERM_VARIATION] + 2 * e.term[CURVOPT_TERM_MVS],
               1e-12 * e.term[CURVOPT_TERM_VARIATION]);
    CHECK_NEAR(4 * e.h2, e.term[CURVOPT_TERM_WILLMORE] + 2 * e.gauss, 1e-12 * e.h2);
    CHECK_NEAR(e.gauss, 4 * pi, 0.05); /* a torus and a sphere */
    CHECK_NEAR(e.gauss_bonnet_defect, fabs(e.gauss - 4 * pi), 1e-12);
    CHECK_BETWEEN(e.min_jacobian, 1e-3, 1);
    CHECK_INT(e.surface, CURVOPT_SURFACE_PLANE);
    CHECK_TRUE(e.n_samples > c.n_faces && e.area > 0);
    for (int t = CURVOPT_N_TERMS; t < 8; t++)
        CHECK_TRUE(isnan(e.term[t]));
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        CHECK_BETWEEN(e.term_error[t], 0, 0.1 * e.term[t]);
    curvopt_problem_destroy(problem);
    cage_free(&c);
}

static void test_total_curvature_is_that_of_the_topology(void **state) {
    (void)state;
    cage c = cage_both(bumpy_torus(), bumpy_kites(), 4);
    curvopt_options o = options_for(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    o.tolerance = 1e-6;
    curvopt_problem *problem = problem_of(&c, &o);
    curvopt_energies e = energies_of(problem, c.xyz, NULL);
    CHECK_NEAR(e.gauss, 4 * pi, 1e-4);
    CHECK_TRUE(e.gauss_bonnet_defect < 1e-4);
    curvopt_problem_destroy(problem);
    cage_free(&c);
}

static void test_area_scales_and_energies_do_not(void **state) {
    (void)state;
    cage c = bumpy_kites();
    curvopt_options o = options_for(CURVOPT_SURFACE_PLANE, CURVOPT_TERM_MVS);
    curvopt_problem *problem = problem_of(&c, &o);
    curvopt_energies before = energies_of(problem, c.xyz, NULL);
    for (int i = 0; i < 36; i++)
        c.xyz[i] = 1000 * c.xyz[i] + 5e4;
    curvopt_energies after = energies_of(problem, c.xyz, NULL);
    CHECK_NEAR(after.area / before.area, 1e6, 1e-4);
    CHECK_NEAR(after.area_error / before.area_error, 1e6, 10);
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        CHECK_NEAR(after.term[t] / before.term[t], 1, 1e-9);
    curvopt_problem_destroy(problem);
    cage_free(&c);
}

static void test_limit_gives_no_third_order_at_extraordinary_vertices(void **state) {
    (void)state;
    cage c = bumpy_kites();
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_options o = options_for(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS);
    curvopt_problem *problem = (curvopt_problem *)(void *)mesh;
    curvopt_error error;
    CHECK_REFUSED(curvopt_problem_create(mesh, NULL, &o, &problem, &error), &error, CURVOPT_ERROR_SURFACE, 0,
                  "`limit` surface has no finite third-order energy");
    CHECK_TRUE(problem == NULL);
    o = options_for(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    problem = problem_of(&c, &o);
    curvopt_energies e = energies_of(problem, c.xyz, NULL);
    CHECK_TRUE(isfinite(e.term[CURVOPT_TERM_WILLMORE]) && isnan(e.term[CURVOPT_TERM_MVS]));
    CHECK_TRUE(isnan(e.term_error[CURVOPT_TERM_MVS]));
    curvopt_problem_destroy(problem);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_auto_surface_is_never_reported(void **state) {
    (void)state;
    cage c = bumpy_kites();
    curvopt_options o = options_for(CURVOPT_SURFACE_AUTO, CURVOPT_TERM_WILLMORE);
    curvopt_problem *problem = problem_of(&c, &o);
    CHECK_INT(energies_of(problem, c.xyz, NULL).surface, CURVOPT_SURFACE_LIMIT);
    curvopt_problem_destroy(problem);
    o = options_for(CURVOPT_SURFACE_AUTO, CURVOPT_TERM_MVS);
    o.joshi_sequin = 1;
    problem = problem_of(&c, &o);
    CHECK_INT(energies_of(problem, c.xyz, NULL).surface, CURVOPT_SURFACE_PLANE);
    curvopt_problem_destroy(problem);
    o.joshi_sequin = 0;
    problem = problem_of(&c, &o);
    CHECK_BETWEEN(energies_of(problem, c.xyz, NULL).surface, CURVOPT_SURFACE_PLANE, CURVOPT_SURFACE_POLYNOMIAL);
    curvopt_problem_destroy(problem);
    cage_free(&c);
}

static void test_tighter_tolerance_costs_samples_and_lowers_the_error(void **state) {
    (void)state;
    cage c = bumpy_torus();
    curvopt_energies e[2];
    for (int n = 0; n < 2; n++) {
        curvopt_options o = options_for(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
        o.tolerance = n ? 1e-7 : 1e-2;
        curvopt_problem *problem = problem_of(&c, &o);
        e[n] = energies_of(problem, c.xyz, NULL);
        CHECK_TRUE(e[n].objective_error <= o.tolerance * e[n].objective);
        curvopt_problem_destroy(problem);
    }
    CHECK_TRUE(e[1].n_samples > e[0].n_samples);
    CHECK_TRUE(fabs(e[0].objective - e[1].objective) <= 2 * e[0].objective_error);
    cage_free(&c);
}

static void test_null_arguments_are_refused_by_name(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_options o = options_for(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    curvopt_problem *problem;
    curvopt_energies e;
    curvopt_error error;
    const int32_t code = CURVOPT_ERROR_ARGUMENT;
    CHECK_REFUSED(curvopt_problem_create(NULL, NULL, &o, &problem, &error), &error, code, -1, "mesh is NULL");
    CHECK_REFUSED(curvopt_problem_create(mesh, NULL, NULL, &problem, &error), &error, code, -1, "options is NULL");
    CHECK_REFUSED(curvopt_problem_create(mesh, NULL, &o, NULL, &error), &error, code, -1, "out is NULL");
    o.levels = 0;
    CHECK_REFUSED(curvopt_problem_create(mesh, NULL, &o, &problem, &error), &error, code, -1, "levels is 0");
    o.levels = 1;
    problem = problem_of(&c, &o);
    CHECK_REFUSED(curvopt_problem_evaluate(NULL, c.xyz, &e, sizeof e, NULL, &error), &error, code, -1,
                  "problem is NULL");
    CHECK_REFUSED(curvopt_problem_evaluate(problem, NULL, &e, sizeof e, NULL, &error), &error, code, -1, "xyz is NULL");
    CHECK_REFUSED(curvopt_problem_evaluate(problem, c.xyz, NULL, sizeof(curvopt_energies), NULL, &error), &error, code,
                  -1, "out is NULL");
    CHECK_INT(curvopt_problem_evaluate(problem, c.xyz, &e, sizeof e, NULL, NULL), CURVOPT_OK); /* no message wanted */
    curvopt_problem_destroy(problem);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gradients_agree_with_differences_on_a_torus),
        cmocka_unit_test(test_gradients_agree_with_differences_near_extraordinary_vertices),
        cmocka_unit_test(test_gradient_of_a_mix_of_terms),
        cmocka_unit_test(test_gradient_is_blind_to_translation_rotation_and_scale),
        cmocka_unit_test(test_results_do_not_depend_on_the_number_of_threads),
        cmocka_unit_test(test_energies_are_consistent_with_each_other),
        cmocka_unit_test(test_total_curvature_is_that_of_the_topology),
        cmocka_unit_test(test_area_scales_and_energies_do_not),
        cmocka_unit_test(test_limit_gives_no_third_order_at_extraordinary_vertices),
        cmocka_unit_test(test_auto_surface_is_never_reported),
        cmocka_unit_test(test_tighter_tolerance_costs_samples_and_lowers_the_error),
        cmocka_unit_test(test_null_arguments_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
