/* One level's function: its gradient against differences, its invariances, what it finds on the way against sums made
 * directly, and the way back to the user's frame. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "linalg/vector.h"
#include "mesh/similarity.h"
#include "solve/level_objective.h"

/* A setting's function, and room for points. */
typedef struct function {
    solve_setting *s;
    co_level_objective o;
    double *z, *g, *other, *work; /* [3 n_vertices] each; z: where the input cage is */
    size_t n;
} function;

static void function_along(cage c, const curvopt_options *options, co_motion motion, function *f) {
    curvopt_error error;
    size_t n = 3 * (size_t)c.n_vertices;
    f->s = solve_setting_of(c, options);
    f->z = calloc(4 * n, sizeof(double));
    CHECK_TRUE(f->z != NULL);
    f->g = f->z + n;
    f->other = f->z + 2 * n;
    f->work = f->z + 3 * n;
    CHECK_OK(co_level_objective_create(&f->s->run, f->s->mesh, &f->s->symmetry, &f->s->constraints, motion, f->s->c.xyz,
                                       &f->o, f->z, &error),
             &error);
    f->n = co_level_objective_n(&f->o);
}

static void function_of(cage c, const curvopt_options *options, function *f) {
    function_along(c, options, CO_MOTION_ALL, f);
}

static void function_free(function *f) {
    co_level_objective_free(&f->o);
    solve_setting_free(f->s);
    free(f->z);
}

static void move(function *f, double amount, uint64_t seed) {
    for (size_t i = 0; i < f->n; i++)
        f->z[i] += amount * check_random(&seed);
}

static co_iterate evaluated(function *f, double *z, double *g) {
    co_iterate at = {.x = z, .gradient = g};
    co_level_objective_evaluate(&f->o, &at);
    return at;
}

/* Slope of the function along d [n]. */
static double slope_along(function *f, const double *d) {
    static const double at[4] = {-2, -1, 1, 2}, weight[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
    const double h = 1e-4;
    double slope = 0;
    for (int k = 0; k < 4; k++) {
        memcpy(f->work, f->z, f->n * sizeof *f->work);
        co_vector_add(f->n, at[k] * h, d, f->work);
        slope += weight[k] / h * co_level_objective_value(&f->o, f->work);
    }
    return slope;
}

/* What tests hold: a vertex firmly, one on a line, one in a plane, one by a spring. */
static const int32_t pin_vertex[4] = {3, 7, 12, 9}, pin_freedom[4] = {0, 1, 2, 0};
static const double pin_direction[12] = {0, 0, 0, 1, 2, 3, 0, 1, -1}, pin_weight[4] = {1, 1, 1, 0.75};
static const curvopt_constraints pins = {
    .vertices = pin_vertex, .freedom = pin_freedom, .directions = pin_direction, .n = 4, .weights = pin_weight};

/* --------------------------------------------------------------------------------------------- gradient -- */

/* Central differences of fourth order, at the cage and at two random points. */
static void check_gradient(cage c, curvopt_options options) {
    static const double at[4] = {-2, -1, 1, 2}, weight[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
    const double h = 1e-4;
    function f;
    function_of(c, &options, &f);
    if (options.spacing == CURVOPT_SPACING_EVEN) {
        co_iterate now = evaluated(&f, f.z, f.g);
        co_level_objective_weigh_spacing(&f.o, 0.5 * now.value, &now);
    }
    for (int point = 0; point < 3; point++) {
        evaluated(&f, f.z, f.g);
        double largest = 0, worst = 0;
        for (size_t i = 0; i < f.n; i++) {
            double slope = 0, z = f.z[i];
            for (int k = 0; k < 4; k++) {
                f.z[i] = z + at[k] * h;
                slope += weight[k] / h * co_level_objective_value(&f.o, f.z);
            }
            f.z[i] = z;
            largest = fmax(largest, fabs(slope));
            worst = fmax(worst, fabs(slope - f.g[i]));
        }
        CHECK_BETWEEN(worst / largest, 0, 1e-7);
        move(&f, 0.02, (uint64_t)point + 1);
    }
    function_free(&f);
}

static void test_gradient_where_nothing_is_held(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE),
                    mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS),
                    blended = solve_options(CURVOPT_SURFACE_POLYNOMIAL, CURVOPT_TERM_MVS), area = w;
    area.weights[CURVOPT_TERM_AREA] = 1;
    check_gradient(cage_shaken(cage_torus(4, 4, 1, 0.4), 0.05), w);
    check_gradient(cage_shaken(cage_torus(4, 4, 1, 0.4), 0.05), mvs);
    check_gradient(cage_shaken(cage_torus(4, 4, 1, 0.4), 0.05), area); /* which sees the size, but for normalization */
    check_gradient(cage_shaken(cage_cube(), 0.1), blended);
}

static void test_gradient_with_symmetry(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE),
                    mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS);
    w.symmetry = CURVOPT_SYMMETRY_KEEP;
    mvs.symmetry = CURVOPT_SYMMETRY_KEEP;
    check_gradient(cage_torus(6, 4, 1, 0.4), w);
    check_gradient(cage_torus(6, 4, 1, 0.4), mvs);
    check_gradient(cage_trapezohedron(5), w);
}

static void test_gradient_where_vertices_are_held(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE),
                    mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS);
    w.constraints = mvs.constraints = &pins;
    check_gradient(cage_shaken(cage_torus(4, 4, 1, 0.4), 0.05), w);
    check_gradient(cage_shaken(cage_torus(4, 4, 1, 0.4), 0.05), mvs);
    check_gradient(cage_shaken(cage_band(5, 3, 1, 1.2, 1), 0.05), w); /* its boundary is held, too */
    w.boundary = CURVOPT_BOUNDARY_FREE;
    w.constraints = NULL;
    w.weights[CURVOPT_TERM_AREA] = 1;
    check_gradient(cage_shaken(cage_band(5, 3, 1, 1.2, 1), 0.05), w);
}

/* A frame at a vertex and a point inside a face that moves on a line with a normal, beside pins; half of the value is
 * an even spacing, of the cage. */
static const int32_t through_vertex[2] = {15, -1}, through_face[2] = {0, 26}, through_freedom[2] = {0, 1};
static const double through_uv[4] = {0, 0, 0.25, 0.5}, through_normal[6] = {0.2, 0.1, 1, 0, 1, 0.3},
                    through_direction[6] = {0, 0, 0, 1, 2, 0};
static const curvopt_through through = {.struct_size = sizeof through,
                                        .n = 2,
                                        .vertices = through_vertex,
                                        .faces = through_face,
                                        .uv = through_uv,
                                        .freedom = through_freedom,
                                        .directions = through_direction,
                                        .normals = through_normal};

static void test_gradient_where_the_surface_is_held(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE),
                    mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS);
    w.through = mvs.through = &through;
    w.constraints = &pins;
    check_gradient(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), w);
    check_gradient(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), mvs);
    w.spacing = mvs.spacing = CURVOPT_SPACING_EVEN;
    check_gradient(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), w);
    check_gradient(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), mvs);
}

/* -------------------------------------------------------------------------------------------- invariance -- */

/* The function does not see size and place; its gradient is that much smaller where the cage is larger. */
static void test_scaling_and_translation_change_nothing(void **state) {
    (void)state;
    curvopt_options options[3] = {solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE),
                                  solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS),
                                  solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_AREA)};
    for (int k = 0; k < 3; k++) {
        function f;
        function_of(cage_shaken(cage_torus(4, 4, 1, 0.4), 0.05), &options[k], &f);
        move(&f, 0.02, 3);
        co_iterate at = evaluated(&f, f.z, f.g);
        double largest = 0;
        for (size_t i = 0; i < f.n; i++) {
            f.other[i] = 1000 * f.z[i] + 50 * f.o.reduction.translation[i] - 9 * f.o.reduction.translation[f.n + i];
            largest = fmax(largest, fabs(f.g[i]));
        }
        co_iterate there = evaluated(&f, f.other, f.work);
        CHECK_NEAR(there.value, at.value, 1e-12 * at.value);
        for (int j = 0; j < CO_N_FINDINGS; j++)
            CHECK_NEAR(there.found[j], at.found[j], 1e-10);
        for (size_t i = 0; i < f.n; i++)
            CHECK_NEAR(1000 * f.work[i], f.g[i], 1e-9 * largest);
        function_free(&f);
    }
}

/* Back to centroid 0 and radius 1: the function is the same, its gradient is the gradient there, lengths are in edges
 * of that cage. */
static void test_normalizing_keeps_the_function(void **state) {
    (void)state;
    curvopt_options options = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    function f;
    function_of(cage_shaken(cage_torus(4, 4, 1, 0.4), 0.05), &options, &f);
    double centroid[3], relative;
    for (size_t i = 0; i < f.n; i++)
        f.z[i] = 3 * f.z[i] + 0.1 * (double)(i % 3);
    co_iterate at = evaluated(&f, f.z, f.g);
    for (size_t i = 0; i < f.n; i++)
        f.other[i] = f.z[i] * (i % 3 ? 2 : 0.5);
    co_level_objective_value(&f.o, f.other); /* whatever was looked at since */
    co_level_objective_normalize(&f.o, &at);
    CHECK_NEAR(co_similarity_frame(f.n / 3, f.o.positions, centroid), 1, 1e-14);
    for (size_t i = 0; i < f.n; i++)
        CHECK_NEAR(f.o.positions[i], at.x[i], 1e-14);
    CHECK_NEAR(fabs(centroid[0]) + fabs(centroid[1]) + fabs(centroid[2]), 0, 1e-14);
    CHECK_NEAR(f.o.edge, co_mesh_mean_edge(f.s->mesh, NULL, f.o.positions), 0);
    CHECK_NEAR(co_level_objective_value(&f.o, at.x), at.value, 1e-12 * at.value);
    evaluated(&f, at.x, f.work);
    relative = co_vector_norm(f.n, f.work);
    for (size_t i = 0; i < f.n; i++)
        CHECK_NEAR(at.gradient[i], f.work[i], 1e-10 * relative);
    CHECK_NEAR(co_level_objective_relative_gradient(&f.o, &at), relative / at.value, 1e-10 * relative / at.value);
    function_free(&f);
}

static void test_lengths_are_in_mean_edges(void **state) {
    (void)state;
    curvopt_options options = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    function f;
    function_of(cage_shaken(cage_torus(4, 4, 1, 0.4), 0.05), &options, &f);
    double edge = co_mesh_mean_edge(f.s->mesh, NULL, f.s->c.xyz) / f.s->run.radius;
    CHECK_NEAR(f.o.edge, edge, 1e-14);
    memset(f.work, 0, f.n * sizeof *f.work);
    f.work[9] = 0.03;
    f.work[10] = -0.04;
    f.work[20] = 0.02;
    CHECK_NEAR(co_level_objective_length(&f.o, f.work), 0.05 / edge, 1e-14);
    for (size_t i = 0; i < f.n; i++)
        f.other[i] = f.z[i] + f.work[i];
    CHECK_NEAR(co_level_objective_distance(&f.o, f.z, f.other), 0.05 / edge, 1e-13);
    function_free(&f);
}

/* ---------------------------------------------------------------------------------------------- findings -- */

/* Sums over all faces of the same positions, by an assembly that knows of no variables, symmetry or constraints. */
static void check_findings(cage c, curvopt_options options, double amount) {
    function f;
    co_assembly direct;
    co_values values;
    curvopt_error error;
    function_of(c, &options, &f);
    move(&f, amount, 8);
    co_iterate at = evaluated(&f, f.z, NULL);
    co_level_objective_place(&f.o, f.z);
    double centroid[3], radius = co_similarity_frame((size_t)f.s->c.n_vertices, f.o.positions, centroid);
    int held = f.s->constraints.freedom || f.s->mesh->info.n_boundary_edges;
    CHECK_OK(co_assembly_create(f.s->mesh, NULL, NULL, &f.s->options, f.s->run.tables, NULL, &direct, &error), &error);
    co_assembly_evaluate(&direct, f.o.positions, &(co_request){0}, &values);
    double unit = held ? radius : 1; /* integrals of the direct sum are normalized by what the cage is now */
    CHECK_NEAR(values.radius, radius, 1e-12);
    CHECK_NEAR(at.found[CO_FOUND_SIZE], unit * unit * values.integral[CO_INT_AREA], 1e-11);
    CHECK_NEAR(at.found[CO_FOUND_DEFECT], co_assembly_defect(&direct, &values), 1e-10);
    CHECK_NEAR(at.found[CO_FOUND_MIN_JACOBIAN], values.min_jacobian, 1e-11); /* over its face's mean: of no unit */
    CHECK_NEAR(co_level_objective_energy(&f.o, &at), values.objective, 1e-11 * values.objective);
    if (options.symmetry == CURVOPT_SYMMETRY_NONE)
        CHECK_INT(f.o.assembly.worst_face, values.worst_face);
    co_assembly_free(&direct);
    function_free(&f);
}

static void test_findings_are_those_of_the_whole_surface(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE), kept = w, pinned = w;
    check_findings(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), w, 0.02);
    check_findings(cage_shaken(cage_cube(), 0.1), w, 0.02);
    check_findings(cage_shaken(cage_band(5, 3, 1, 1.2, 1), 0.05), w, 0.02);
    kept.symmetry = CURVOPT_SYMMETRY_KEEP;
    check_findings(cage_torus(6, 4, 1, 0.4), kept, 0.02);
    check_findings(cage_prism(5), kept, 0.02);
    pinned.constraints = &pins;
    check_findings(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), pinned, 0.02);
}

/* value = energy + K w / (1 - w) |x - a|^2 / 2, of one vertex with a spring. */
static void test_springs_are_the_rest_of_the_value(void **state) {
    (void)state;
    const int32_t vertex = 6;
    const double weight = 0.75;
    const curvopt_constraints spring = {.vertices = &vertex, .n = 1, .weights = &weight};
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    w.constraints = &spring;
    function f;
    function_of(cage_shaken(cage_torus(4, 4, 3, 1), 0.05), &w, &f);
    move(&f, 0.05, 2);
    co_iterate at = evaluated(&f, f.z, NULL);
    co_level_objective_place(&f.o, f.z);
    double square = 0, stiffness = 24 * 3.14159265358979323846 * 3; /* Willmore's is 24 pi */
    for (int k = 0; k < 3; k++) {
        double a = (f.s->c.xyz[3 * vertex + k] - f.s->run.centroid[k]) / f.s->run.radius;
        square += (f.o.positions[3 * vertex + k] - a) * (f.o.positions[3 * vertex + k] - a);
    }
    CHECK_BETWEEN(square, 1e-5, 1e-1);
    CHECK_NEAR(at.value - co_level_objective_energy(&f.o, &at), stiffness * square / 2, 1e-10);
    function_free(&f);
}

/* --------------------------------------------------------------------------------------- the user's frame -- */

/* Held vertices are the input's to the last bit, vertices on lines and in planes stay there. */
static void test_held_vertices_come_back_exactly(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    w.constraints = &pins;
    function f;
    cage c = cage_shaken(cage_band(5, 4, 3, 4, 5), 0.1);
    for (int32_t i = 0; i < 3 * c.n_vertices; i++)
        c.xyz[i] += 0.3; /* little: the sum with a far centroid would round what was lost away */
    function_of(c, &w, &f);
    move(&f, 0.05, 6);
    co_iterate at = evaluated(&f, f.z, NULL);
    co_level_objective_to_user(&f.o, f.z, at.found[CO_FOUND_SIZE], f.work);
    const double *xyz = f.s->c.xyz;
    int n_held = 0;
    for (int32_t v = 0; v < c.n_vertices; v++)
        if (v % 5 == 0 || v % 5 == 4 || v == 3) {
            assert_memory_equal(f.work + 3 * v, xyz + 3 * v, 3 * sizeof(double));
            n_held++;
        }
    CHECK_INT(n_held, 11);
    double d[3], e[3];
    for (int k = 0; k < 3; k++) {
        d[k] = f.work[3 * 7 + k] - xyz[3 * 7 + k];
        e[k] = f.work[3 * 12 + k] - xyz[3 * 12 + k];
    }
    CHECK_BETWEEN(co_vector_norm(3, d), 1e-3, 1);
    CHECK_NEAR(d[1] - 2 * d[0], 0, 1e-13);
    CHECK_NEAR(d[2] - 3 * d[0], 0, 1e-13);
    CHECK_BETWEEN(co_vector_norm(3, e), 1e-3, 1);
    CHECK_NEAR(e[1] - e[2], 0, 1e-13);
    CHECK_NEAR(solve_area(f.s, f.work), f.s->run.radius * f.s->run.radius * at.found[CO_FOUND_SIZE], 1e-10);
    function_free(&f);
}

/* The area is the input's, the centroid the first cage's; a cage that was only moved comes back to where it was. */
static void test_free_cages_get_the_area_and_the_place_of_the_input(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    function f;
    cage c = cage_shaken(cage_torus(5, 4, 30, 10), 1);
    for (int32_t i = 0; i < 3 * c.n_vertices; i++)
        c.xyz[i] += 7;
    function_of(c, &w, &f);
    const double *xyz = f.s->c.xyz;
    for (size_t v = 0; v < f.n / 3; v++) { /* turned about z, and larger */
        f.other[3 * v] = 2 * (0.6 * f.z[3 * v] - 0.8 * f.z[3 * v + 1]) + 1;
        f.other[3 * v + 1] = 2 * (0.8 * f.z[3 * v] + 0.6 * f.z[3 * v + 1]);
        f.other[3 * v + 2] = 2 * f.z[3 * v + 2] - 3;
    }
    co_iterate at = {.x = f.other, .gradient = f.g};
    co_level_objective_evaluate(&f.o, &at);
    co_level_objective_normalize(&f.o, &at);
    co_level_objective_to_user(&f.o, at.x, at.found[CO_FOUND_SIZE], f.work);
    for (size_t i = 0; i < f.n; i++)
        CHECK_NEAR(f.work[i], xyz[i], 1e-11);
    move(&f, 0.05, 6);
    at = evaluated(&f, f.z, f.g);
    co_level_objective_normalize(&f.o, &at);
    co_level_objective_to_user(&f.o, at.x, at.found[CO_FOUND_SIZE], f.work);
    CHECK_NEAR(solve_area(f.s, f.work), f.s->run.size.value, 1e-11 * f.s->run.size.value);
    double before[3], after[3];
    co_similarity_frame(f.n / 3, xyz, before);
    co_similarity_frame(f.n / 3, f.work, after);
    for (int k = 0; k < 3; k++)
        CHECK_NEAR(after[k], before[k], 1e-11);
    function_free(&f);
}

/* On normals what is left of similarities slides: the function has a slope there, the gradient nothing; along what is
 * restricted the gradient is the slope. */
static void test_normals_leave_out_what_slides(void **state) {
    (void)state;
    curvopt_options o = solve_options(CURVOPT_SURFACE_POLYNOMIAL, CURVOPT_TERM_MVS);
    o.symmetry = CURVOPT_SYMMETRY_NONE;
    function f;
    function_along(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), &o, CO_MOTION_NORMALS, &f);
    CHECK_BETWEEN(f.o.n_sliding, 6, 7);
    co_iterate at = evaluated(&f, f.z, f.g);
    double steepest = 0;
    for (int k = 0; k < f.o.n_sliding; k++) {
        const double *q = f.o.sliding + (size_t)k * f.n;
        CHECK_NEAR(co_vector_dot(f.n, q, f.g), 0, 1e-12 * co_vector_norm(f.n, f.g));
        steepest = fmax(steepest, fabs(slope_along(&f, q)));
    }
    CHECK_BETWEEN(steepest / at.value, 1e-3, 10);
    uint64_t seed = 3;
    for (size_t i = 0; i < f.n; i++)
        f.other[i] = check_random(&seed);
    co_level_objective_restrict(&f.o, f.other);
    double along = co_vector_dot(f.n, f.other, f.g);
    CHECK_BETWEEN(fabs(along) / at.value, 1e-2, 1e3);
    CHECK_NEAR(slope_along(&f, f.other), along, 1e-6 * fabs(along));
    function_free(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_normals_leave_out_what_slides),
        cmocka_unit_test(test_gradient_where_nothing_is_held),
        cmocka_unit_test(test_gradient_with_symmetry),
        cmocka_unit_test(test_gradient_where_vertices_are_held),
        cmocka_unit_test(test_gradient_where_the_surface_is_held),
        cmocka_unit_test(test_scaling_and_translation_change_nothing),
        cmocka_unit_test(test_normalizing_keeps_the_function),
        cmocka_unit_test(test_lengths_are_in_mean_edges),
        cmocka_unit_test(test_findings_are_those_of_the_whole_surface),
        cmocka_unit_test(test_springs_are_the_rest_of_the_value),
        cmocka_unit_test(test_held_vertices_come_back_exactly),
        cmocka_unit_test(test_free_cages_get_the_area_and_the_place_of_the_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
