/* Coordinates that make no surface, and coordinates at the ends of the range. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "cages.h"
#include "check.h"

#include <stdlib.h>

static curvopt_options usual(int32_t surface, int32_t term) {
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    o.surface = surface;
    o.weights[CURVOPT_TERM_WILLMORE] = 0;
    o.weights[term] = 1;
    o.levels = 1;
    o.max_iterations = 3;
    o.tolerance = 1e-2;
    o.threads = 1;
    return o;
}

static int32_t evaluate(const cage *c, const curvopt_options *o, curvopt_energies *e, curvopt_error *error) {
    curvopt_mesh *mesh = cage_mesh(c);
    curvopt_problem *problem;
    CHECK_OK(curvopt_problem_create(mesh, NULL, o, &problem, error), error);
    int32_t status = curvopt_problem_evaluate(problem, c->xyz, e, sizeof(curvopt_energies), NULL, error);
    curvopt_problem_destroy(problem);
    curvopt_mesh_destroy(mesh);
    return status;
}

/* Refused alike by evaluating and minimizing, and nothing is written. */
static void check_geometry_refused(const cage *c, int32_t element, const char *part) {
    curvopt_options o = usual(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    curvopt_energies e, before;
    curvopt_error error;
    memset(&e, 0x77, sizeof e);
    before = e;
    CHECK_REFUSED(evaluate(c, &o, &e, &error), &error, CURVOPT_ERROR_GEOMETRY, element, part);
    assert_memory_equal(&e, &before, sizeof e);
    curvopt_mesh *mesh = cage_mesh(c);
    curvopt_result *result = (curvopt_result *)(void *)mesh;
    CHECK_REFUSED(curvopt_minimize(mesh, c->xyz, &o, NULL, NULL, NULL, &result, &error), &error, CURVOPT_ERROR_GEOMETRY,
                  element, part);
    CHECK_TRUE(result == NULL);
    curvopt_mesh_destroy(mesh);
}

static void test_coordinates_that_are_not_finite_name_their_vertex(void **state) {
    (void)state;
    static const struct {
        double x;
        const char *part;
    } bad[] = {{(double)NAN, "nan"}, {INFINITY, "inf"}, {-INFINITY, "-inf"}, {1e101, "1e+101"}, {-1e308, "-1e+308"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        for (int coordinate = 0; coordinate < 3; coordinate++) {
            cage c = cage_cube();
            char text[64];
            c.xyz[3 * 5 + coordinate] = bad[i].x;
            snprintf(text, sizeof text, "vertex 5 has coordinate %c = %s", "xyz"[coordinate], bad[i].part);
            check_geometry_refused(&c, 5, text);
            cage_free(&c);
        }
}

static void test_all_points_equal_have_zero_area(void **state) {
    (void)state;
    static const double places[] = {0, 1, -1e50, 1e-95};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        cage c = cage_torus(5, 4, 1, 0.4);
        for (int k = 0; k < 60; k++)
            c.xyz[k] = places[i];
        check_geometry_refused(&c, -1, "zero area");
        cage_free(&c);
    }
}

static void test_extent_below_rounding_has_zero_area(void **state) {
    (void)state;
    cage c = cage_cube();
    for (int k = 0; k < 24; k++)
        c.xyz[k] = 1e6 + 1e-9 * c.xyz[k];
    check_geometry_refused(&c, -1, "zero area");
    cage_free(&c);
}

/* Collinear cages and flat ones with folds have points without a normal. */
static void check_degenerate(cage c) {
    curvopt_options o = usual(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    curvopt_energies e;
    curvopt_error error;
    int32_t status = evaluate(&c, &o, &e, &error);
    CHECK_INT(status, CURVOPT_ERROR_GEOMETRY);
    CHECK_TRUE(strlen(error.message) > 10);
    CHECK_BETWEEN(error.element, -1, c.n_faces - 1);
    cage_free(&c);
}

static void test_collinear_cages_are_refused(void **state) {
    (void)state;
    cage cube = cage_cube(), torus = cage_torus(5, 4, 1, 0.4);
    for (int v = 0; v < 8; v++)
        cube.xyz[3 * v + 1] = cube.xyz[3 * v + 2] = 2 * cube.xyz[3 * v];
    for (int v = 0; v < 20; v++) {
        torus.xyz[3 * v] = v;
        torus.xyz[3 * v + 1] = torus.xyz[3 * v + 2] = 0;
    }
    check_degenerate(cube);
    check_degenerate(torus);
}

/* A ring of faces whose vertices all coincide, in an otherwise good torus. */
static void test_torus_pinched_to_a_point_is_refused(void **state) {
    (void)state;
    cage c = cage_torus(8, 4, 1, 0.4);
    for (int v = 0; v < 16; v++)
        for (int k = 0; k < 3; k++)
            c.xyz[3 * v + k] = k == 0;
    check_degenerate(c);
}

static void test_one_face_without_area_is_evaluated(void **state) {
    (void)state;
    cage c = cage_torus(8, 6, 1, 0.4);
    curvopt_options o = usual(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    curvopt_energies e;
    curvopt_error error;
    for (int k = 0; k < 3; k++)
        c.xyz[3 * 7 + k] = c.xyz[3 * 8 + k]; /* an edge of the cage has no length; its limit surface is still smooth */
    CHECK_OK(evaluate(&c, &o, &e, &error), &error);
    CHECK_TRUE(e.objective > 50 && isfinite(e.objective));
    cage_free(&c);
}

/* The same cage at all sizes that are allowed: the same energies. */
static void test_huge_and_tiny_cages_have_the_same_energy(void **state) {
    (void)state;
    static const double sizes[] = {1, 1e99 / 1.5, 1e-90, 3e40, 1e-30};
    curvopt_options o = usual(CURVOPT_SURFACE_PLANE, CURVOPT_TERM_MVS);
    curvopt_energies first, e;
    curvopt_error error;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        cage c = cage_trapezohedron(5);
        for (int k = 0; k < 3 * c.n_vertices; k++)
            c.xyz[k] *= sizes[i];
        CHECK_OK(evaluate(&c, &o, &e, &error), &error);
        if (i == 0)
            first = e;
        for (int t = 0; t < CURVOPT_N_TERMS; t++)
            CHECK_NEAR(e.term[t] / first.term[t], 1, 1e-12);
        CHECK_NEAR(e.area / first.area / sizes[i] / sizes[i], 1, 1e-12);
        cage_free(&c);
    }
}

static void test_huge_and_tiny_cages_are_minimized_in_place(void **state) {
    (void)state;
    static const double sizes[] = {1, 1e98, 1e-90};
    double first = 0;
    for (int i = 0; i < 3; i++) {
        cage c = cage_torus(6, 4, 1, 0.45);
        curvopt_options o = usual(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
        curvopt_result *result;
        curvopt_summary summary;
        curvopt_energies start, end;
        curvopt_error error;
        double xyz[72], largest = 0;
        for (int k = 0; k < 72; k++)
            c.xyz[k] *= sizes[i];
        curvopt_mesh *mesh = cage_mesh(&c);
        CHECK_OK(curvopt_minimize(mesh, c.xyz, &o, NULL, NULL, NULL, &result, &error), &error);
        curvopt_result_get_summary(result, &summary, sizeof summary);
        curvopt_result_get_energies(result, &start, &end, sizeof end);
        curvopt_result_get_positions(result, xyz);
        first = i == 0 ? end.objective : first;
        CHECK_NEAR(end.objective / first, 1, 1e-9);
        CHECK_TRUE(end.objective < start.objective);
        for (int k = 0; k < 72; k++)
            largest = fmax(largest, fabs(xyz[k]));
        CHECK_BETWEEN(largest / sizes[i], 1, 2);
        curvopt_result_destroy(result);
        curvopt_mesh_destroy(mesh);
        cage_free(&c);
    }
}

static void test_pole_of_high_valence_is_evaluated(void **state) {
    (void)state;
    cage c = cage_trapezohedron(40);
    curvopt_options o = usual(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    curvopt_energies e;
    curvopt_error error;
    o.tolerance = 0.5;
    CHECK_OK(evaluate(&c, &o, &e, &error), &error);
    CHECK_TRUE(isfinite(e.objective) && e.objective > 25); /* 8 pi is the least of any closed surface */
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_coordinates_that_are_not_finite_name_their_vertex),
        cmocka_unit_test(test_all_points_equal_have_zero_area),
        cmocka_unit_test(test_extent_below_rounding_has_zero_area),
        cmocka_unit_test(test_collinear_cages_are_refused),
        cmocka_unit_test(test_torus_pinched_to_a_point_is_refused),
        cmocka_unit_test(test_one_face_without_area_is_evaluated),
        cmocka_unit_test(test_huge_and_tiny_cages_have_the_same_energy),
        cmocka_unit_test(test_huge_and_tiny_cages_are_minimized_in_place),
        cmocka_unit_test(test_pole_of_high_valence_is_evaluated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
