/* Symmetry groups of cages: their order, their table, what they are kept by. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "cages.h"
#include "check.h"

#include "constraints/given_constraints.h"
#include "constraints/symmetry.h"

static const double pi = 3.14159265358979323846;

/* A torus of 4^4 rings of four vertices, the outer and the inner ones off their circles by waves of amplitude .6e-5,
 * .6e-6, .6e-7, .6e-8, each of four times the period of the one before. At the tolerance 1e-5 a turn by one ring is a
 * symmetry and a turn by two is none, so that the symmetries are no group; at 1e-6 it is so with four rings and eight,
 * and on down to 1e-8. At 1e-9 the mirror image in the plane z = 0 is left, of which every vertex has its line. */
static void test_directions_are_compared_at_tolerances_below_1e_8(void **state) {
    (void)state;
    enum { RINGS = 256 };
    cage c = cage_torus(RINGS, 4, 1, 0.4);
    const double radius = sqrt(1 + 0.4 * 0.4);
    int32_t vertices[4 * RINGS], freedom[4 * RINGS];
    double directions[12 * RINGS];
    for (int32_t v = 0; v < 4 * RINGS; v++) {
        int32_t ring = v / 4, side = v % 4;
        double a = 2 * pi * ring / RINGS, off = 0, up[4] = {0, 2, 0, -2};
        for (int k = 0, period = 4; k < 4; k++, period *= 4)
            off += 0.6 * pow(10, -5 - k) * radius * cos(2 * pi * ring / period);
        off *= side == 0 ? 1 : side == 2 ? -1 : 0; /* in opposite directions: the centroid stays */
        c.xyz[3 * v] += off * cos(a);
        c.xyz[3 * v + 1] += off * sin(a);
        vertices[v] = v;
        freedom[v] = CO_FREEDOM_LINE;
        directions[3 * v] = 3 * cos(a) - sin(a);
        directions[3 * v + 1] = 3 * sin(a) + cos(a);
        directions[3 * v + 2] = up[side];
    }
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_error error;
    co_constraints hold;
    co_symmetry symmetry;
    curvopt_constraints lines = {.n = c.n_vertices, .vertices = vertices, .freedom = freedom, .directions = directions};
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, &lines, &hold, &error), &error);
    CHECK_OK(co_symmetry_create(mesh, c.xyz, &hold, 1, NULL, &symmetry, &error), &error);
    CHECK_INT(symmetry.order, 2);
    for (int k = 0; k < 9; k++)
        CHECK_NEAR(symmetry.matrix[9 + k], k == 8 ? -1 : k % 4 == 0, 1e-10);
    co_symmetry_free(&symmetry);
    co_constraints_free(&hold);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static co_symmetry symmetry_of(const cage *c, const curvopt_mesh *mesh, const co_constraints *constraints,
                               int with_mirrors) {
    co_symmetry s;
    curvopt_error error;
    CHECK_OK(co_symmetry_create(mesh, c->xyz, constraints, with_mirrors, NULL, &s, &error), &error);
    return s;
}

/* Every element takes every vertex to its image, products are those of the matrices, and the identity comes first. */
static void check_group(const co_symmetry *s, const curvopt_mesh *mesh, const double *xyz, double tolerance) {
    const int32_t n = mesh->info.n_vertices;
    double centroid[3] = {0, 0, 0};
    for (int32_t i = 0; i < 3 * n; i++)
        centroid[i % 3] += xyz[i] / n;
    for (int32_t g = 0; g < s->order; g++) {
        const double *m = s->matrix + 9 * g;
        double det = m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
                     m[2] * (m[3] * m[7] - m[4] * m[6]);
        CHECK_NEAR(det, s->mirrored[g] ? -1 : 1, 1e-12);
        for (int32_t v = 0; v < n; v++) {
            int32_t w = co_symmetry_vertex(s, mesh, g, v);
            for (int i = 0; i < 3; i++) {
                double at = centroid[i];
                for (int j = 0; j < 3; j++)
                    at += m[3 * i + j] * (xyz[3 * v + j] - centroid[j]);
                CHECK_NEAR(at, xyz[3 * w + i], tolerance);
            }
            for (int32_t h = 0; h < s->order; h++)
                CHECK_INT(co_symmetry_vertex(s, mesh, s->product[h * s->order + g], v),
                          co_symmetry_vertex(s, mesh, h, w));
        }
    }
    for (int32_t v = 0; v < n; v++)
        CHECK_INT(co_symmetry_vertex(s, mesh, 0, v), v);
}

static void expect_order(cage c, int with_mirrors, int32_t order) {
    curvopt_mesh *mesh = cage_mesh(&c);
    const co_constraints none = {0};
    co_symmetry s = symmetry_of(&c, mesh, &none, with_mirrors);
    CHECK_INT(s.order, order);
    check_group(&s, mesh, c.xyz, 1e-4);
    co_symmetry_free(&s);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_groups_have_the_order_of_their_solids(void **state) {
    (void)state;
    expect_order(cage_cube(), 1, 48);
    expect_order(cage_cube(), 0, 24);
    expect_order(cage_tetrahedron(), 1, 24);
    expect_order(cage_tetrahedron(), 0, 12);
    expect_order(cage_torus(6, 4, 2, 1), 1, 24);
    expect_order(cage_prism(5), 1, 20);
    expect_order(cage_trapezohedron(5), 1, 20);
    cage c = cage_cube();
    cage_perturb(&c, 0.1, 3);
    expect_order(c, 1, 1);
}

/* Positions that are symmetric up to 1e-6 only: the matrices are a group's all the same. */
static void test_matrices_are_those_of_a_group_though_positions_are_not_exact(void **state) {
    (void)state;
    cage c = cage_cube();
    cage_perturb(&c, 1e-6, 3);
    curvopt_mesh *mesh = cage_mesh(&c);
    const co_constraints none = {0};
    co_symmetry s = symmetry_of(&c, mesh, &none, 1);
    CHECK_INT(s.order, 48);
    for (int32_t g = 0; g < s.order; g++)
        for (int32_t h = 0; h < s.order; h++)
            for (int i = 0; i < 9; i++) {
                const double *a = s.matrix + 9 * g + 3 * (i / 3), *b = s.matrix + 9 * h + i % 3;
                CHECK_NEAR(a[0] * b[0] + a[1] * b[3] + a[2] * b[6], s.matrix[9 * s.product[g * s.order + h] + i],
                           1e-14);
            }
    co_symmetry_free(&s);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Two cubes along x keep one mirror plane that exchanges them, and the square's symmetries about their axis; two tori
 * of different size keep what either has about the axis. */
static void test_components_are_mapped_together(void **state) {
    (void)state;
    expect_order(cage_both(cage_cube(), cage_cube(), 5), 1, 16);
    expect_order(cage_both(cage_cube(), cage_tetrahedron(), 5), 1, 2 * 2);
    expect_order(cage_both(cage_torus(6, 4, 2, 0.5), cage_torus(3, 4, 4, 0.5), 0), 1, 12);
}

/* Faces that are there twice: every element is a permutation, the identity is one that moves nothing, and two cubes may
 * change places. Which of three do is no matter of where they are, so that nothing is kept of them. */
static void test_components_that_lie_in_the_same_place_are_not_mixed_up(void **state) {
    (void)state;
    expect_order(cage_both(cage_cube(), cage_cube(), 0), 1, 96);
    expect_order(cage_both(cage_cube(), cage_both(cage_cube(), cage_cube(), 0), 0), 1, 1);
    expect_order(
        cage_both(cage_torus(3, 4, 4, 0.5), cage_both(cage_torus(6, 4, 2, 0.5), cage_torus(6, 4, 2, 0.5), 0), 0), 1,
        12);
}

/* Vertices on a line or in one point determine no motion; a torus of 1 024 symmetries has too many. */
static void test_what_is_no_group_is_the_trivial_one(void **state) {
    (void)state;
    cage flat = cage_cube();
    for (int32_t i = 0; i < 24; i++)
        flat.xyz[i] *= i % 3 == 0;
    expect_order(flat, 1, 1);
    expect_order(cage_torus(256, 3, 2, 1), 1, 1);
}

/* A crease, a sharp vertex, a pin, a line and a spring at one vertex or edge of the cube leave what keeps it. */
static void test_marks_on_the_cage_are_kept(void **state) {
    (void)state;
    cage c = cage_cube();
    const int32_t edge[2] = {6, 7}, corner[1] = {7}, line[1] = {CO_FREEDOM_LINE};
    const double sharpness[1] = {2}, axis[3] = {1, 0, 0}, askew[3] = {1, 2, 3}, weight[1] = {0.5};
    const curvopt_creases creases[2] = {{edge, sharpness, NULL, NULL, 1, 0, 0, 0},
                                        {NULL, NULL, corner, sharpness, 0, 1, 0, 0}};
    const curvopt_constraints user[4] = {
        {.n = 1, .vertices = corner},
        {.n = 1, .vertices = corner, .freedom = line, .directions = axis},
        {.n = 1, .vertices = corner, .freedom = line, .directions = askew},
        {.n = 1, .vertices = corner, .freedom = line, .directions = axis, .weights = weight}};
    const int32_t of_crease[2] = {4, 6}, of_user[4] = {6, 2, 1, 2};
    curvopt_error error;
    for (int k = 0; k < 2; k++) {
        const co_constraints none = {0};
        curvopt_mesh *mesh;
        CHECK_OK(curvopt_mesh_create_creased(c.n_vertices, c.n_faces, c.sizes, c.vertices, &creases[k], &mesh, &error),
                 &error);
        co_symmetry s = symmetry_of(&c, mesh, &none, 1);
        CHECK_INT(s.order, of_crease[k]);
        check_group(&s, mesh, c.xyz, 1e-12);
        co_symmetry_free(&s);
        curvopt_mesh_destroy(mesh);
    }
    for (int k = 0; k < 4; k++) {
        co_constraints held;
        curvopt_mesh *mesh = cage_mesh(&c);
        CHECK_OK(co_given_constraints_create(mesh, c.xyz, &user[k], &held, &error), &error);
        co_symmetry s = symmetry_of(&c, mesh, &held, 1);
        CHECK_INT(s.order, of_user[k]);
        check_group(&s, mesh, c.xyz, 1e-12);
        co_symmetry_free(&s);
        co_constraints_free(&held);
        curvopt_mesh_destroy(mesh);
    }
    cage_free(&c);
}

static void test_subdivision_keeps_the_group(void **state) {
    (void)state;
    cage c = cage_prism(3), fine_cage = cage_refined(cage_prism(3), 1);
    curvopt_mesh *mesh = cage_mesh(&c), *fine = cage_mesh(&fine_cage);
    const co_constraints none = {0};
    curvopt_error error;
    co_symmetry s = symmetry_of(&c, mesh, &none, 1);
    CHECK_INT(s.order, 12);
    CHECK_OK(co_symmetry_subdivide(&s, &error), &error);
    check_group(&s, fine, fine_cage.xyz, 1e-12);
    co_symmetry_free(&s);
    CHECK_OK(co_symmetry_none(mesh, &s, &error), &error);
    CHECK_INT(s.order, 1);
    check_group(&s, mesh, c.xyz, 1e-12);
    co_symmetry_free(&s);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
    cage_free(&fine_cage);
    cage_free(&c);
}

/* The search ends by the flag, and leaves nothing. */
static void test_the_search_can_be_cancelled(void **state) {
    cage c = cage_torus(8, 4, 1, 0.5);
    curvopt_mesh *mesh = cage_mesh(&c);
    co_constraints hold = {0};
    co_symmetry symmetry;
    co_cancel cancel;
    curvopt_cancel *flag;
    curvopt_error error;
    (void)state;
    CHECK_OK(curvopt_cancel_create(&flag, &error), &error);
    co_cancel_start_at_once(&cancel, flag);
    CHECK_OK(co_symmetry_create(mesh, c.xyz, &hold, 1, &cancel, &symmetry, &error), &error);
    CHECK_INT(symmetry.order, 32);
    co_symmetry_free(&symmetry);
    curvopt_cancel_request(flag);
    CHECK_INT(co_symmetry_create(mesh, c.xyz, &hold, 1, &cancel, &symmetry, &error), CO_CANCELLED);
    CHECK_TRUE(symmetry.order == 0 && !symmetry.corner && !symmetry.matrix);
    curvopt_cancel_destroy(flag);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_groups_have_the_order_of_their_solids),
        cmocka_unit_test(test_matrices_are_those_of_a_group_though_positions_are_not_exact),
        cmocka_unit_test(test_components_are_mapped_together),
        cmocka_unit_test(test_components_that_lie_in_the_same_place_are_not_mixed_up),
        cmocka_unit_test(test_what_is_no_group_is_the_trivial_one),
        cmocka_unit_test(test_marks_on_the_cage_are_kept),
        cmocka_unit_test(test_subdivision_keeps_the_group),
        cmocka_unit_test(test_the_search_can_be_cancelled),
        cmocka_unit_test(test_directions_are_compared_at_tolerances_below_1e_8),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
