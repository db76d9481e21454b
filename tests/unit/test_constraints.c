/* Constraints: what is refused, what a subdivision inherits, what boundaries add.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "constraints/constraints.h"
#include "constraints/given_constraints.h"
#include "mesh/subdivide.h"

enum { SIDE = 3, N = (SIDE + 1) * (SIDE + 1) };

/* An open grid of 3 x 3 quads in the plane z = 0; vertex 4 i + j lies at (i, j, 0). */
static cage grid(void) {
    int32_t sizes[SIDE * SIDE], vertices[4 * SIDE * SIDE];
    double xyz[3 * N] = {0};
    for (int32_t f = 0; f < SIDE * SIDE; f++) {
        int32_t v = f / SIDE * (SIDE + 1) + f % SIDE, corner[4] = {v, v + SIDE + 1, v + SIDE + 2, v + 1};
        sizes[f] = 4;
        memcpy(vertices + 4 * f, corner, sizeof corner);
    }
    for (int32_t v = 0; v < N; v++) {
        xyz[3 * v] = v / (SIDE + 1);
        xyz[3 * v + 1] = v % (SIDE + 1);
    }
    return cage_of(N, SIDE * SIDE, sizes, vertices, xyz);
}

static void expect_refusal(const curvopt_constraints *constraints, int32_t element, const char *part) {
    cage c = grid();
    curvopt_mesh *mesh = cage_mesh(&c);
    co_constraints out;
    curvopt_error error;
    CHECK_REFUSED(co_given_constraints_create(mesh, c.xyz, constraints, &out, &error), &error, CURVOPT_ERROR_ARGUMENT,
                  element, part);
    CHECK_TRUE(!out.freedom && !out.direction && !out.anchor && !out.springs.stiffness);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_bad_constraints_are_refused(void **state) {
    (void)state;
    const int32_t vertex[2] = {5, 5}, outside[1] = {N}, before[1] = {-1}, line[2] = {1, 1}, free[1] = {3},
                  less[1] = {-1};
    const double x[6] = {1, 0, 0, 0, 1, 0}, zero[3] = {0, 0, 0}, wild[3] = {1, NAN, 0};
    const double heavy[1] = {1.5}, light[1] = {-0.1}, unknown[1] = {NAN}, differ[2] = {0.5, 0.25};
    expect_refusal(&(curvopt_constraints){.n = -1, .vertices = vertex}, -1, "-1 of them, vertices given");
    expect_refusal(&(curvopt_constraints){.n = 1}, -1, "vertices is NULL");
    expect_refusal(&(curvopt_constraints){.n = 1, .vertices = outside}, 0, "on vertex 16; there are 16");
    expect_refusal(&(curvopt_constraints){.n = 1, .vertices = before}, 0, "on vertex -1");
    expect_refusal(&(curvopt_constraints){.n = 1, .vertices = vertex, .freedom = free}, 0, "3 dimensions");
    expect_refusal(&(curvopt_constraints){.n = 1, .vertices = vertex, .freedom = less}, 0, "-1 dimensions");
    expect_refusal(&(curvopt_constraints){.n = 1, .vertices = vertex, .weights = heavy}, 0, "weight 1.5");
    expect_refusal(&(curvopt_constraints){.n = 1, .vertices = vertex, .weights = light}, 0, "weight -0.1");
    expect_refusal(&(curvopt_constraints){.n = 1, .vertices = vertex, .weights = unknown}, 0, "weight ");
    expect_refusal(&(curvopt_constraints){.n = 1, .vertices = vertex, .freedom = line}, 0, "has no direction");
    expect_refusal(&(curvopt_constraints){.n = 1, .vertices = vertex, .freedom = line, .directions = zero}, 0,
                   "the direction 0 0 0");
    expect_refusal(&(curvopt_constraints){.n = 1, .vertices = vertex, .freedom = line, .directions = wild}, 0,
                   "the direction 1 ");
    expect_refusal(&(curvopt_constraints){.n = 2, .vertices = vertex, .freedom = line, .directions = x}, 1,
                   "two constraints that contradict");
    expect_refusal(&(curvopt_constraints){.n = 2, .vertices = vertex, .weights = differ}, 1, "contradict");
}

static void test_constraints_are_taken_as_they_are(void **state) {
    (void)state;
    cage c = grid();
    curvopt_mesh *mesh = cage_mesh(&c);
    const int32_t vertex[4] = {5, 6, 6, 9}, freedom[4] = {0, 1, 1, 2};
    const double direction[12] = {0, 0, 0, 0, 0, 2, 0, 0, -5, 3, 4, 0};
    curvopt_constraints user = {.n = 4, .vertices = vertex, .freedom = freedom, .directions = direction};
    co_constraints given, copy, none;
    curvopt_error error;
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, &user, &given, &error), &error);
    CHECK_OK(co_constraints_copy(mesh, &given, &copy, &error), &error);
    for (int32_t v = 0; v < N; v++)
        CHECK_INT(copy.freedom[v], v == 5 ? 0 : v == 6 ? 1 : v == 9 ? 2 : CO_FREEDOM_ALL);
    CHECK_NEAR(fabs(copy.direction[3 * 6 + 2]), 1, 1e-15);
    CHECK_NEAR(copy.direction[3 * 9], 0.6, 1e-15);
    CHECK_NEAR(copy.direction[3 * 9 + 1], 0.8, 1e-15);
    CHECK_NEAR(copy.anchor[3 * 9], 2, 0);
    CHECK_TRUE(!copy.springs.stiffness && copy.freedom != given.freedom);
    CHECK_TRUE(co_constraints_allow_motion(mesh, &copy));
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, NULL, &none, &error), &error);
    CHECK_TRUE(!none.freedom);
    CHECK_TRUE(co_constraints_allow_motion(mesh, &none));
    co_constraints_free(&given);
    co_constraints_free(&copy);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Weights below 1 are soft: the vertex itself is free. A weight of 0 is none, and one next to 1 is 1. */
static void test_weights_make_springs(void **state) {
    (void)state;
    cage c = grid();
    curvopt_mesh *mesh = cage_mesh(&c);
    const int32_t vertex[4] = {0, 5, 15, 12};
    const double weight[4] = {1, 0.75, 0, 1 - 1e-12};
    curvopt_constraints user = {.n = 4, .vertices = vertex, .weights = weight};
    co_constraints given;
    curvopt_error error;
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, &user, &given, &error), &error);
    for (int32_t v = 0; v < N; v++) {
        CHECK_INT(given.freedom[v], v == 0 || v == 12 ? CO_FREEDOM_NONE : CO_FREEDOM_ALL);
        CHECK_NEAR(given.springs.stiffness[v], v == 5 ? 3 : 0, 1e-15); /* .75 / (1 - .75) */
    }
    co_constraints_free(&given);
    user = (curvopt_constraints){.n = 1, .vertices = vertex + 2, .weights = weight + 2};
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, &user, &given, &error), &error);
    CHECK_TRUE(!given.freedom && !given.springs.stiffness);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* The face of vertices 5, 6, 9, 10 is constrained as a piece of surface; 0, 3 and 12 go back to point, line and plane.
 */
static void test_subdivision_inherits_faces_and_puts_vertices_back(void **state) {
    (void)state;
    cage c = grid();
    curvopt_mesh *mesh = cage_mesh(&c), *fine = NULL;
    const int32_t vertex[7] = {5, 6, 9, 10, 0, 3, 12}, freedom[7] = {1, 1, 1, 1, 0, 1, 2};
    const double direction[21] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, 2, 0, 0};
    curvopt_constraints user = {.n = 7, .vertices = vertex, .freedom = freedom, .directions = direction};
    co_constraints held;
    co_sparse_rows rows;
    curvopt_error error;
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, &user, &held, &error), &error);
    CHECK_OK(co_subdivide(mesh, &fine, &rows, &error), &error);
    double *xyz = calloc(3 * (size_t)fine->info.n_vertices, sizeof *xyz);
    double *smooth = calloc(3 * (size_t)fine->info.n_vertices, sizeof *smooth);
    CHECK_TRUE(xyz && smooth);
    co_sparse_rows_apply(&rows, c.xyz, xyz);
    memcpy(smooth, xyz, 3 * (size_t)fine->info.n_vertices * sizeof *xyz);
    CHECK_OK(co_constraints_subdivide(mesh, fine, &rows, xyz, &held, &error), &error);
    int n_lines = 0, n_points = 0, n_planes = 0;
    for (int32_t v = 0; v < fine->info.n_vertices; v++) {
        n_lines += held.freedom[v] == CO_FREEDOM_LINE;
        n_points += held.freedom[v] == CO_FREEDOM_NONE;
        n_planes += held.freedom[v] == CO_FREEDOM_PLANE;
        for (int32_t k = 0; k < 3 && v != 0 && v != 3 && v != 12; k++)
            CHECK_NEAR(xyz[3 * v + k], smooth[3 * v + k], 0);
    }
    CHECK_INT(n_lines, 9 + 1); /* the face's 3 x 3, and vertex 3 */
    CHECK_INT(n_points, 1);
    CHECK_INT(n_planes, 1);
    CHECK_TRUE(smooth[0] > 0.1); /* a corner is smoothed away */
    CHECK_NEAR(xyz[0], 0, 0);
    CHECK_NEAR(xyz[1], 0, 0);
    /* vertex 3 at (0, 3) on the line along x, vertex 12 at (3, 0) in the plane normal to x: the closest points */
    CHECK_TRUE(smooth[9] > 0.1 && smooth[10] < 2.9 && smooth[36] < 2.9 && smooth[37] > 0.1);
    CHECK_NEAR(xyz[9], smooth[9], 1e-15);
    CHECK_NEAR(xyz[10], 3, 1e-15);
    CHECK_NEAR(xyz[36], 3, 1e-15);
    CHECK_NEAR(xyz[37], smooth[37], 1e-15);
    CHECK_NEAR(held.anchor[36], 3, 0);
    free(xyz);
    free(smooth);
    co_sparse_rows_free(&rows);
    co_constraints_free(&held);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* A closed cage has no boundary, but infinitely sharp vertices and edges are constrained like one. */
static void test_infinitely_sharp_creases_are_held_like_boundaries(void **state) {
    (void)state;
    cage c = cage_torus(6, 6, 2, 1);
    const int32_t edge[2] = {0, 1}, corner[1] = {20};
    const double edge_sharpness[1] = {10}, corner_sharpness[1] = {10};
    curvopt_creases creases = {edge, edge_sharpness, corner, corner_sharpness, 1, 1, 0, 0};
    curvopt_mesh *plain = cage_mesh(&c), *sharp;
    co_constraints held = {0}, all;
    curvopt_error error;
    CHECK_OK(curvopt_mesh_create_creased(c.n_vertices, c.n_faces, c.sizes, c.vertices, &creases, &sharp, &error),
             &error);
    CHECK_OK(co_constraints_boundary(plain, CURVOPT_BOUNDARY_CURVATURE, &held, &error), &error);
    CHECK_TRUE(!held.freedom);
    CHECK_OK(co_constraints_boundary(sharp, CURVOPT_BOUNDARY_FREE, &held, &error), &error);
    CHECK_TRUE(!held.freedom);
    CHECK_OK(co_constraints_all(sharp, &held, CURVOPT_BOUNDARY_CURVATURE, &all, &error), &error);
    for (int32_t v = 0; v < c.n_vertices; v++)
        CHECK_INT(all.freedom[v], v == 0 || v == 1 || v == 20 ? CO_FREEDOM_NONE : CO_FREEDOM_ALL);
    co_constraints_free(&all);
    curvopt_mesh_destroy(sharp);
    curvopt_mesh_destroy(plain);
    cage_free(&c);
}

/* On a sphere-like cage normals are radial. */
static void test_free_vertices_are_put_on_their_normals(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&c);
    const int32_t vertex[1] = {3}, freedom[1] = {CO_FREEDOM_PLANE};
    const double direction[3] = {0, 0, 1};
    curvopt_constraints user = {.n = 1, .vertices = vertex, .freedom = freedom, .directions = direction};
    co_constraints none = {0}, some, lines;
    curvopt_error error;
    CHECK_OK(co_constraints_to_normals(mesh, &none, c.xyz, &lines, &error), &error);
    for (int32_t v = 0; v < 8; v++) {
        CHECK_INT(lines.freedom[v], CO_FREEDOM_LINE);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(lines.direction[3 * v + k] * c.xyz[3 * v + k] * lines.direction[3 * v] * c.xyz[3 * v], 1.0 / 3,
                       1e-15);
    }
    co_constraints_free(&lines);
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, &user, &some, &error), &error);
    CHECK_OK(co_constraints_to_normals(mesh, &some, c.xyz, &lines, &error), &error);
    CHECK_INT(lines.freedom[3], CO_FREEDOM_LINE); /* in its plane */
    CHECK_NEAR(lines.direction[11], 0, 1e-15);
    CHECK_NEAR(lines.direction[9] * lines.direction[9], 0.5, 1e-15);
    CHECK_INT(lines.freedom[2], CO_FREEDOM_LINE);
    co_constraints_free(&lines);
    co_constraints_free(&some);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* The motion of vertex v of a flat grid that is left of one constraint. */
static void check_left(int32_t v, int32_t freedom, const double direction[3], int expected, const double along[3]) {
    cage c = grid();
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_constraints user = {.n = 1, .vertices = &v, .freedom = &freedom, .directions = direction};
    co_constraints some, lines;
    curvopt_error error;
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, &user, &some, &error), &error);
    CHECK_OK(co_constraints_to_normals(mesh, &some, c.xyz, &lines, &error), &error);
    CHECK_INT(lines.freedom[v], expected);
    const double *d = lines.direction + 3 * v;
    if (expected == CO_FREEDOM_LINE || expected == CO_FREEDOM_PLANE)
        CHECK_NEAR(fabs(d[0] * along[0] + d[1] * along[1] + d[2] * along[2]), 1, 1e-14);
    co_constraints_free(&lines);
    co_constraints_free(&some);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Of 4 x 4 vertices in the plane z = 0, 5 is an inner one and 4 is on the boundary, which runs along x there. */
static void test_constraints_leave_what_is_nearest_to_the_shape(void **state) {
    (void)state;
    static const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1}, tilted[3] = {0.6, 0, 0.8},
                        steepest[3] = {-0.8, 0, 0.6}, nearly_x[3] = {0.999, 0, 0.04};
    enum { POINT = CO_FREEDOM_NONE, LINE = CO_FREEDOM_LINE, PLANE = CO_FREEDOM_PLANE };
    check_left(5, LINE, tilted, LINE, tilted);
    check_left(5, LINE, x, POINT, x);
    check_left(5, LINE, nearly_x, POINT, x);
    check_left(5, PLANE, tilted, LINE, steepest);
    check_left(5, PLANE, z, POINT, z);
    check_left(5, POINT, z, POINT, z);
    check_left(4, LINE, z, LINE, z);
    check_left(4, LINE, x, POINT, x);
    check_left(4, PLANE, y, LINE, z);
    check_left(4, PLANE, z, LINE, y);
    check_left(4, PLANE, x, PLANE, x);
}

/* A free boundary moves across itself, its corners anywhere. */
static void test_boundaries_move_across_themselves(void **state) {
    (void)state;
    for (int corners = 0; corners < 2; corners++) {
        cage c = grid();
        curvopt_mesh *mesh = NULL;
        co_constraints none = {0}, lines;
        curvopt_error error;
        const curvopt_creases creases = {.boundary_rule =
                                             corners ? CURVOPT_BOUNDARY_RULE_CORNERS : CURVOPT_BOUNDARY_RULE_SMOOTH};
        CHECK_OK(curvopt_mesh_create_creased(c.n_vertices, c.n_faces, c.sizes, c.vertices, &creases, &mesh, &error),
                 &error);
        CHECK_OK(co_constraints_to_normals(mesh, &none, c.xyz, &lines, &error), &error);
        CHECK_INT(lines.freedom[5], CO_FREEDOM_LINE);
        CHECK_NEAR(fabs(lines.direction[17]), 1, 1e-15);
        CHECK_INT(lines.freedom[4], CO_FREEDOM_PLANE);
        CHECK_NEAR(fabs(lines.direction[12]), 1, 1e-15);
        CHECK_INT(lines.freedom[0], corners ? CO_FREEDOM_ALL : CO_FREEDOM_PLANE);
        if (!corners) /* the curve turns there */
            CHECK_NEAR(lines.direction[0] * lines.direction[1], -0.5, 1e-15);
        co_constraints_free(&lines);
        curvopt_mesh_destroy(mesh);
        cage_free(&c);
    }
}

static void test_a_cage_that_cannot_move_is_refused(void **state) {
    (void)state;
    cage c = grid();
    curvopt_mesh *mesh = cage_mesh(&c);
    co_constraints held = {0};
    curvopt_error error;
    CHECK_OK(co_constraints_boundary(mesh, CURVOPT_BOUNDARY_TANGENT, &held, &error), &error);
    CHECK_TRUE(!co_constraints_allow_motion(mesh, &held));
    CHECK_REFUSED(co_constraints_refuse(mesh, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "nothing may move: all 16 vertices");
    held.freedom[7] = CO_FREEDOM_LINE;
    CHECK_TRUE(co_constraints_allow_motion(mesh, &held));
    co_constraints_free(&held);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* On a grid in the plane z = 0, vertex 4 i + j at (i, j, 0): with `weight` each. */
static void expect_dilation(int is_allowed, int32_t n, const int32_t *vertices, const int32_t *freedom,
                            const double *directions, const double *weight, int32_t boundary) {
    cage c = grid();
    curvopt_mesh *mesh = cage_mesh(&c);
    const curvopt_constraints given = {
        .n = n, .vertices = vertices, .freedom = freedom, .directions = directions, .weights = weight};
    co_constraints held, all;
    curvopt_error error;
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, &given, &held, &error), &error);
    CHECK_OK(co_constraints_all(mesh, &held, boundary, &all, &error), &error);
    CHECK_INT(co_constraints_allow_dilation(mesh, c.xyz, &all, 1), is_allowed);
    co_constraints_free(&all);
    co_constraints_free(&held);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_what_leaves_a_cage_its_size(void **state) {
    (void)state;
    const int32_t v[3] = {0, 5, 10}, corner[3] = {0, 3, 12}; /* on the diagonal; (0, 0), (0, 3), (3, 0) */
    const int32_t line[3] = {1, 1, 1}, plane[3] = {2, 2, 2}, point_and_line[2] = {0, 1};
    const double up[9] = {0, 0, 1, 0, 0, 1, 0, 0, 1}, along_x[9] = {1, 0, 0, 1, 0, 0, 1, 0, 0};
    const double across[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, diagonal[9] = {1, 1, 0, 1, 1, 0, 1, 1, 0};
    const double soft[3] = {0.5, 0.5, 0.5};
    expect_dilation(1, 1, v, NULL, NULL, NULL, CURVOPT_BOUNDARY_FREE);
    expect_dilation(1, 1, v + 2, NULL, NULL, soft, CURVOPT_BOUNDARY_FREE);
    expect_dilation(0, 2, v, NULL, NULL, NULL, CURVOPT_BOUNDARY_FREE);
    expect_dilation(0, 2, v, NULL, NULL, soft, CURVOPT_BOUNDARY_FREE);
    expect_dilation(1, 3, corner, plane, up, NULL, CURVOPT_BOUNDARY_FREE);      /* in one plane */
    expect_dilation(0, 3, corner, plane, along_x, NULL, CURVOPT_BOUNDARY_FREE); /* in two planes side by side */
    expect_dilation(1, 3, corner, plane, across, NULL,
                    CURVOPT_BOUNDARY_FREE); /* in three planes with one common point */
    expect_dilation(0, 3, corner, line, along_x, NULL, CURVOPT_BOUNDARY_FREE); /* two lines side by side */
    expect_dilation(1, 3, v, line, diagonal, NULL, CURVOPT_BOUNDARY_FREE);     /* one line, thrice */
    expect_dilation(0, 3, v, line, across, NULL, CURVOPT_BOUNDARY_FREE);       /* lines that do not meet */
    expect_dilation(1, 2, v, point_and_line, diagonal, NULL, CURVOPT_BOUNDARY_FREE);
    expect_dilation(0, 2, v, point_and_line, across + 3, NULL, CURVOPT_BOUNDARY_FREE);
    expect_dilation(0, 1, v, NULL, NULL, NULL, CURVOPT_BOUNDARY_POSITION);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bad_constraints_are_refused),
        cmocka_unit_test(test_constraints_are_taken_as_they_are),
        cmocka_unit_test(test_weights_make_springs),
        cmocka_unit_test(test_subdivision_inherits_faces_and_puts_vertices_back),
        cmocka_unit_test(test_infinitely_sharp_creases_are_held_like_boundaries),
        cmocka_unit_test(test_free_vertices_are_put_on_their_normals),
        cmocka_unit_test(test_constraints_leave_what_is_nearest_to_the_shape),
        cmocka_unit_test(test_boundaries_move_across_themselves),
        cmocka_unit_test(test_a_cage_that_cannot_move_is_refused),
        cmocka_unit_test(test_what_leaves_a_cage_its_size),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
