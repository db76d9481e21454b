/* What a run begins with: symmetries that are asked for, mirror planes that become exact, figures of the input, what is
 * held and left out, and what is not known before a verdict. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

/* A run's end. */
typedef struct finished {
    curvopt_summary summary;
    curvopt_energies start, end;
    double xyz[3 * 48];
} finished;

static finished run(const cage *c, const curvopt_options *o) {
    finished f;
    curvopt_mesh *mesh = cage_mesh(c);
    curvopt_result *result;
    curvopt_error error;
    CHECK_BETWEEN(c->n_vertices, 1, 48);
    CHECK_OK(curvopt_minimize(mesh, c->xyz, o, NULL, NULL, NULL, &result, &error), &error);
    curvopt_result_get_summary(result, &f.summary, sizeof f.summary);
    curvopt_result_get_energies(result, &f.start, &f.end, sizeof f.end);
    curvopt_result_get_positions(result, f.xyz);
    curvopt_result_destroy(result);
    curvopt_mesh_destroy(mesh);
    return f;
}

static curvopt_options options_of(void) {
    curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    o.max_iterations = 2;
    return o;
}

/* A torus of 8 x 4 vertices has the 16 symmetries of its circle of 8, times the reflection across its plane. */
static void test_symmetries_that_are_asked_for(void **state) {
    (void)state;
    static const struct {
        int32_t symmetry, order;
    } of[] = {{CURVOPT_SYMMETRY_KEEP, 32}, {CURVOPT_SYMMETRY_ROTATIONS, 16}, {CURVOPT_SYMMETRY_NONE, 1}};
    cage c = cage_torus(8, 4, 1, 0.45);
    curvopt_options o = options_of();
    for (size_t k = 0; k < sizeof of / sizeof *of; k++) {
        o.symmetry = of[k].symmetry;
        CHECK_INT(run(&c, &o).summary.symmetry_order, of[k].order);
    }
    o.symmetry = CURVOPT_SYMMETRY_KEEP;
    o.joshi_sequin = 1;
    o.method = CURVOPT_METHOD_LMVM;
    CHECK_INT(run(&c, &o).summary.symmetry_order, 1);
    cage_free(&c);
}

/* How far each vertex' reflection across the middle in x is from a vertex. */
static double asymmetry(const double *xyz, int32_t n) {
    double most = 0, middle = 0;
    for (int32_t v = 0; v < n; v++)
        middle += xyz[3 * v] / n;
    for (int32_t v = 0; v < n; v++) {
        double least = INFINITY;
        for (int32_t w = 0; w < n; w++)
            least = fmin(least, hypot(hypot(xyz[3 * v] + xyz[3 * w] - 2 * middle, xyz[3 * v + 1] - xyz[3 * w + 1]),
                                      xyz[3 * v + 2] - xyz[3 * w + 2]));
        most = fmax(most, least);
    }
    return most;
}

/* Planes that are chosen are kept, and no others; a cage that nearly has them gets them. */
static void test_chosen_planes_become_exact(void **state) {
    (void)state;
    cage c = cage_torus(8, 4, 1, 0.45);
    curvopt_options o = options_of();
    o.symmetry = CURVOPT_SYMMETRY_PLANES;
    o.symmetry_planes = CURVOPT_PLANE_X;
    cage_perturb(&c, 1e-6, 3);
    CHECK_BETWEEN(asymmetry(c.xyz, c.n_vertices), 1e-7, 1e-5);
    for (o.max_iterations = 0; o.max_iterations < 4; o.max_iterations += 3) {
        const finished f = run(&c, &o);
        CHECK_INT(f.summary.symmetry_order, 2);
        CHECK_BETWEEN(asymmetry(f.xyz, c.n_vertices), 0, 1e-12);
        for (int32_t i = 0; i < 3 * c.n_vertices && o.max_iterations == 0; i++)
            CHECK_NEAR(f.xyz[i], c.xyz[i], 1e-5);
    }
    cage_free(&c);
}

/* Where something is held nothing is made exact that is not: what is held stays. */
static void test_held_vertices_stay_beside_planes(void **state) {
    (void)state;
    static const int32_t vertex[2] = {0, 16}; /* on opposite sides of the plane */
    const curvopt_constraints pins = {.vertices = vertex, .n = 2};
    cage c = cage_torus(8, 4, 1, 0.45);
    curvopt_options o = options_of();
    o.symmetry = CURVOPT_SYMMETRY_PLANES;
    o.symmetry_planes = CURVOPT_PLANE_X;
    o.constraints = &pins;
    cage_perturb(&c, 1e-8, 3);
    const finished f = run(&c, &o);
    CHECK_INT(f.summary.symmetry_order, 2);
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 3; i++)
            CHECK_NEAR(f.xyz[3 * vertex[k] + i], c.xyz[3 * vertex[k] + i], 1e-7);
    cage_free(&c);
}

/* The input's figures are those of an evaluation, and they are in the result. */
static void test_figures_of_the_start(void **state) {
    (void)state;
    cage c = cage_shaken(cage_torus(8, 4, 1, 0.45), 0.05);
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_problem *problem;
    curvopt_energies e;
    curvopt_error error;
    curvopt_options o = options_of();
    o.tolerance = 1e-8;
    CHECK_OK(curvopt_problem_create(mesh, NULL, &o, &problem, &error), &error);
    CHECK_OK(curvopt_problem_evaluate(problem, c.xyz, &e, sizeof e, NULL, &error), &error);
    const finished f = run(&c, &o);
    CHECK_NEAR(f.start.objective, e.objective, 1e-7 * e.objective);
    CHECK_NEAR(f.start.area, e.area, 1e-7 * e.area);
    CHECK_NEAR(f.start.volume, e.volume, 1e-7 * e.volume);
    CHECK_NEAR(f.start.total_mean_curvature, e.total_mean_curvature, 1e-7 * e.total_mean_curvature);
    CHECK_BETWEEN(f.start.objective_error, 0, 1e-7 * e.objective);
    CHECK_TRUE(f.end.objective < f.start.objective);
    curvopt_problem_destroy(problem);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Nobody has looked: no decrements, and no directions, not even none. */
static void test_what_is_not_known(void **state) {
    (void)state;
    cage c = cage_shaken(cage_torus(8, 4, 1, 0.45), 0.05);
    curvopt_options o = options_of();
    o.joshi_sequin = 1;
    o.method = CURVOPT_METHOD_LMVM;
    o.max_iterations = 0;
    const curvopt_summary s = run(&c, &o).summary;
    CHECK_INT(s.verdict, CURVOPT_VERDICT_UNKNOWN);
    CHECK_TRUE(isnan(s.newton_decrement) && isnan(s.shape_decrement) && isnan(s.difference_decrement));
    CHECK_TRUE(isnan(s.clearance) && isnan(s.discretization_error));
    CHECK_INT(s.negative_directions, -1);
    CHECK_INT(s.free_negative_directions, -1);
    CHECK_INT(s.all_negative_directions, -1);
    CHECK_INT(s.n_held + s.n_left_out + s.n_sliding + s.n_touching + s.n_crossing_before + s.n_refused, 0);
    cage_free(&c);
}

/* An edge of three faces: it is held as it is, and what meets there is left out of the energy. */
static void test_exceptions_are_counted(void **state) {
    (void)state;
    static const int32_t sizes[3] = {4, 4, 4}, corner[12] = {0, 1, 2, 3, 1, 0, 4, 5, 0, 1, 6, 7};
    static const double xyz[24] = {0, 0, 0, 0, 1, 0, 1, 1, 0.1, 1, 0, 0, -1, 0, 0.2, -1, 1, 0, 0, 1, 1, 0, 0, 1};
    cage c = cage_of(8, 3, sizes, corner, xyz), fine = cage_refined(c, 1);
    curvopt_options o = options_of();
    o.boundary = CURVOPT_BOUNDARY_FREE;
    const finished f = run(&fine, &o);
    CHECK_TRUE(f.summary.n_held > 0);
    CHECK_BETWEEN(f.summary.n_left_out, 0, fine.n_faces - 1);
    for (int i = 0; i < 6; i++) /* its two ends */
        CHECK_NEAR(f.xyz[i], fine.xyz[i], 1e-12);
    cage_free(&fine);
}

static int32_t check_first(const curvopt_progress *p, void *user) {
    (void)user;
    if (p->level == 1 && p->iteration == 0)
        CHECK_NEAR(p->energy, p->start_energy, 1e-3 * p->start_energy);
    return 0;
}

/* Wide blends at poles of a boundary are chosen by where a cage's points lie: a level has those of its cage, as the
 * figures of the start do. Narrow ones would have another energy. */
static void test_levels_have_the_blends_of_their_cage(void **state) {
    (void)state;
    double energy[2];
    for (int wide = 0; wide < 2; wide++) {
        cage c = cage_half_star(3, 8);
        curvopt_mesh *mesh = cage_mesh(&c);
        curvopt_result *result;
        curvopt_energies start, end;
        curvopt_level_report level;
        curvopt_error error;
        curvopt_options o = solve_options(CURVOPT_SURFACE_POLYNOMIAL, CURVOPT_TERM_MVS);
        o.blend_width = wide ? CURVOPT_MAX_BLEND_WIDTH : 1;
        o.max_iterations = 1;
        o.tolerance = 3e-6; /* a level begins by coarser rules */
        CHECK_OK(curvopt_minimize(mesh, c.xyz, &o, check_first, NULL, NULL, &result, &error), &error);
        curvopt_result_get_energies(result, &start, &end, sizeof start);
        CHECK_OK(curvopt_result_get_level(result, 0, &level, sizeof level, &error), &error);
        CHECK_NEAR(level.energy, end.objective, 0);
        energy[wide] = start.objective;
        curvopt_result_destroy(result);
        curvopt_mesh_destroy(mesh);
        cage_free(&c);
    }
    CHECK_TRUE(fabs(energy[0] - energy[1]) > 1e-2 * energy[0]);
}

/* A level keeps the blends of its cage; where they are wider at the end, the report is of the surface that is there. */
static void test_report_is_of_the_surface_at_the_end(void **state) {
    (void)state;
    cage c = cage_shaken(cage_half_star(5, 8), 0.03);
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_result *result;
    curvopt_energies end;
    curvopt_level_report level;
    curvopt_error error;
    curvopt_options o = solve_options(CURVOPT_SURFACE_POLYNOMIAL, CURVOPT_TERM_MVS);
    o.max_iterations = 15;
    o.tolerance = 1e-2;
    CHECK_OK(curvopt_minimize(mesh, c.xyz, &o, NULL, NULL, NULL, &result, &error), &error);
    curvopt_result_get_energies(result, NULL, &end, sizeof end);
    CHECK_OK(curvopt_result_get_level(result, 0, &level, sizeof level, &error), &error);
    CHECK_NEAR(level.energy, end.objective, 0);
    curvopt_result_destroy(result);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_symmetries_that_are_asked_for),
        cmocka_unit_test(test_chosen_planes_become_exact),
        cmocka_unit_test(test_held_vertices_stay_beside_planes),
        cmocka_unit_test(test_figures_of_the_start),
        cmocka_unit_test(test_what_is_not_known),
        cmocka_unit_test(test_exceptions_are_counted),
        cmocka_unit_test(test_levels_have_the_blends_of_their_cage),
        cmocka_unit_test(test_report_is_of_the_surface_at_the_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
