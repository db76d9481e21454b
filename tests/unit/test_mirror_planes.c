/* Mirror planes that the user chose: their group, refusals that name what is astray.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "constraints/given_constraints.h"
#include "constraints/mirror_planes.h"

static void expect_refusal(const cage *c, const curvopt_mesh *mesh, const co_constraints *constraints, int32_t planes,
                           int32_t element, const char *part) {
    co_symmetry s;
    curvopt_error error;
    CHECK_REFUSED(co_mirror_planes_create(mesh, c->xyz, constraints, planes, &s, &error), &error,
                  CURVOPT_ERROR_GEOMETRY, element, part);
    CHECK_TRUE(!s.corner && !s.product);
}

static void test_planes_generate_their_group(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&c);
    const co_constraints none = {0};
    curvopt_error error;
    for (int32_t planes = 1; planes < 8; planes++) {
        co_symmetry s;
        CHECK_OK(co_mirror_planes_create(mesh, c.xyz, &none, planes, &s, &error), &error);
        int bits = (planes & 1) + (planes >> 1 & 1) + (planes >> 2);
        CHECK_INT(s.order, 1 << bits);
        for (int32_t g = 0; g < s.order; g++)
            for (int32_t v = 0; v < 8; v++)
                for (int k = 0; k < 3; k++) {
                    double sign = s.matrix[9 * g + 4 * k];
                    CHECK_TRUE(sign == 1 || (sign == -1 && planes >> k & 1));
                    CHECK_NEAR(c.xyz[3 * co_symmetry_vertex(&s, mesh, g, v) + k], sign * c.xyz[3 * v + k], 1e-15);
                }
        for (int32_t g = 0; g < s.order; g++)
            for (int32_t h = 0; h < s.order; h++)
                for (int k = 0; k < 3; k++)
                    CHECK_NEAR(s.matrix[9 * s.product[g * s.order + h] + 4 * k],
                               s.matrix[9 * g + 4 * k] * s.matrix[9 * h + 4 * k], 0);
        co_symmetry_free(&s);
    }
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* One vertex astray: it is the one that is named, though it moves the mean, with the distance and the plane. */
static void test_the_vertex_astray_is_named(void **state) {
    (void)state;
    cage c = cage_refined(cage_cube(), 1);
    const co_constraints none = {0};
    c.xyz[3 * 5] *= 1.2;
    curvopt_mesh *mesh = cage_mesh(&c);
    expect_refusal(&c, mesh, &none, 1, 1,
                   "plane x = 0: vertex 1 has no partner, the nearest to its mirror image is vertex 5");
    expect_refusal(&c, mesh, &none, 2, 5, "plane y = 0: vertex 5 has no partner");
    expect_refusal(&c, mesh, &none, 7, 1, "plane x");
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* A cube whose face x = 1 is cut by a diagonal and x = -1 is not: vertices have partners, faces have not. */
static void test_a_face_without_a_partner_is_named(void **state) {
    (void)state;
    static const int32_t sizes[] = {4, 3, 3, 4, 4, 4, 4};
    static const int32_t vertices[] = {0, 1, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3};
    cage cube = cage_cube(), c = cage_of(8, 7, sizes, vertices, cube.xyz);
    curvopt_mesh *mesh = cage_mesh(&c);
    const co_constraints none = {0};
    expect_refusal(&c, mesh, &none, 1, 1, "its vertices are, but face 1 has no partner");
    curvopt_mesh_destroy(mesh);
    cage_free(&cube);
    cage_free(&c);
}

static void test_vertices_that_are_marked_differently_are_named(void **state) {
    (void)state;
    cage c = cage_cube();
    const int32_t edge[2] = {6, 7}, corner[1] = {7}, both[2] = {3, 7}, line[2] = {CO_FREEDOM_LINE, CO_FREEDOM_LINE};
    const double sharpness[1] = {2}, directions[6] = {1, 2, 0, 1, 2, 0};
    curvopt_creases creases = {edge, sharpness, NULL, NULL, 1, 0, 0, 0};
    curvopt_constraints pin = {.n = 1, .vertices = corner},
                        lines = {.n = 2, .vertices = both, .freedom = line, .directions = directions};
    const co_constraints none = {0};
    co_constraints held;
    curvopt_error error;
    curvopt_mesh *mesh;
    CHECK_OK(curvopt_mesh_create_creased(c.n_vertices, c.n_faces, c.sizes, c.vertices, &creases, &mesh, &error),
             &error);
    expect_refusal(&c, mesh, &none, 1, 3, "vertex 3 and its partner 7 differ in creases or in how they are held");
    curvopt_mesh_destroy(mesh);
    mesh = cage_mesh(&c);
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, &pin, &held, &error), &error);
    expect_refusal(&c, mesh, &held, 1, 3, "vertex 3 and its partner 7 differ");
    co_constraints_free(&held);
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, &lines, &held, &error), &error);
    expect_refusal(&c, mesh, &held, 1, -1, "but not the directions in which vertices may move");
    co_constraints_free(&held);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_symmetrized_positions_are_symmetric_to_rounding(void **state) {
    (void)state;
    cage c = cage_refined(cage_cube(), 1);
    const co_constraints none = {0};
    curvopt_error error;
    co_symmetry s;
    cage_perturb(&c, 3e-6, 5);
    curvopt_mesh *mesh = cage_mesh(&c);
    CHECK_OK(co_mirror_planes_create(mesh, c.xyz, &none, 7, &s, &error), &error);
    double *before = calloc(3 * (size_t)c.n_vertices, sizeof *before), centroid[3] = {0, 0, 0}, worst = 0;
    CHECK_TRUE(before != NULL);
    memcpy(before, c.xyz, 3 * (size_t)c.n_vertices * sizeof *before);
    CHECK_OK(co_mirror_planes_symmetrize(mesh, &s, c.xyz, &error), &error);
    for (int32_t i = 0; i < 3 * c.n_vertices; i++) {
        centroid[i % 3] += c.xyz[i] / c.n_vertices;
        worst = fmax(worst, fabs(c.xyz[i] - before[i]));
    }
    CHECK_BETWEEN(worst, 1e-7, 1e-5);
    for (int32_t g = 0; g < s.order; g++)
        for (int32_t v = 0; v < c.n_vertices; v++)
            for (int k = 0; k < 3; k++)
                CHECK_NEAR(c.xyz[3 * co_symmetry_vertex(&s, mesh, g, v) + k] - centroid[k],
                           s.matrix[9 * g + 4 * k] * (c.xyz[3 * v + k] - centroid[k]), 1e-15);
    free(before);
    co_symmetry_free(&s);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_planes_generate_their_group),
        cmocka_unit_test(test_the_vertex_astray_is_named),
        cmocka_unit_test(test_a_face_without_a_partner_is_named),
        cmocka_unit_test(test_vertices_that_are_marked_differently_are_named),
        cmocka_unit_test(test_symmetrized_positions_are_symmetric_to_rounding),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
