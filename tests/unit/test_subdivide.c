/* Catmull-Clark subdivision. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"
#include "mesh/subdivide.h"

#include <stdlib.h>

typedef struct refined {
    cage coarse;
    curvopt_mesh *mesh, *fine;
    co_sparse_rows rows;
} refined;

static refined refine(cage c) {
    refined r = {.coarse = c, .mesh = cage_mesh(&c)};
    curvopt_error error;
    CHECK_OK(co_subdivide(r.mesh, &r.fine, &r.rows, &error), &error);
    return r;
}

static void refined_free(refined *r) {
    co_sparse_rows_free(&r->rows);
    curvopt_mesh_destroy(r->mesh);
    curvopt_mesh_destroy(r->fine);
    cage_free(&r->coarse);
}

static void check_counts(cage c) {
    refined r = refine(c);
    const curvopt_mesh_info *a = &r.mesh->info, *b = &r.fine->info;
    CHECK_INT(b->n_vertices, a->n_vertices + a->n_edges + a->n_faces);
    CHECK_INT(b->n_faces, a->n_corners);
    CHECK_INT(b->n_edges, 2 * a->n_edges + a->n_corners);
    CHECK_INT(b->euler, a->euler);
    CHECK_INT(b->n_components, a->n_components);
    CHECK_INT(b->n_boundary_edges, 0);
    CHECK_INT(b->all_quads, 1);
    CHECK_INT(r.rows.n_rows, b->n_vertices);
    CHECK_INT(r.rows.n_columns, a->n_vertices);
    refined_free(&r);
}

static void test_counts_follow_from_the_coarse_ones(void **state) {
    (void)state;
    check_counts(cage_tetrahedron());
    check_counts(cage_prism(7));
    check_counts(cage_torus(6, 5, 1, 0.4));
    check_counts(cage_both(cage_cube(), cage_trapezohedron(6), 4));
}

static void test_rows_are_convex_combinations(void **state) {
    (void)state;
    refined r = refine(cage_both(cage_prism(9), cage_trapezohedron(11), 4));
    for (int32_t i = 0; i < r.rows.n_rows; i++) {
        double sum = 0;
        for (size_t e = r.rows.start[i]; e < r.rows.start[i + 1]; e++) {
            CHECK_TRUE(r.rows.value[e] > 0);
            sum += r.rows.value[e];
        }
        CHECK_NEAR(sum, 1, 1e-15);
    }
    refined_free(&r);
}

static void affine(const double *in, int32_t n, double *out) {
    static const double a[3][3] = {{2, 0.3, -1}, {0.5, 1.5, 0}, {0, -0.7, 3}}, b[3] = {5, -7, 11};
    for (int32_t v = 0; v < n; v++)
        for (int i = 0; i < 3; i++)
            out[3 * v + i] = b[i] + a[i][0] * in[3 * v] + a[i][1] * in[3 * v + 1] + a[i][2] * in[3 * v + 2];
}

static void test_affine_maps_commute_with_subdivision(void **state) {
    (void)state;
    refined r = refine(cage_prism(5));
    double mapped[30], fine_of_mapped[96], fine[96], mapped_fine[96];
    CHECK_INT(r.rows.n_rows, 32);
    affine(r.coarse.xyz, 10, mapped);
    co_sparse_rows_apply(&r.rows, mapped, fine_of_mapped);
    co_sparse_rows_apply(&r.rows, r.coarse.xyz, fine);
    affine(fine, 32, mapped_fine);
    for (int i = 0; i < 96; i++)
        CHECK_NEAR(fine_of_mapped[i], mapped_fine[i], 1e-14);
    refined_free(&r);
}

/* Face points are face centres, edge points (3/4, 3/4, 0), vertices move to 5/9 of themselves. */
static void test_cube_by_hand(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&c), *fine;
    curvopt_error error;
    double xyz[78];
    CHECK_OK(curvopt_mesh_refine(mesh, c.xyz, &fine, xyz, &error), &error);
    for (int i = 0; i < 24; i++)
        CHECK_NEAR(xyz[i], c.xyz[i] * 5 / 9, 1e-15);
    for (int h = 0; h < 24; h++) { /* every child: vertex, edge leaving, face, edge arriving */
        const int32_t *corner = fine->corner_vertex + 4 * h;
        const double *face = xyz + 3 * corner[2], *vertex = c.xyz + 3 * mesh->corner_vertex[h];
        const double *next = c.xyz + 3 * co_mesh_destination(mesh, h);
        CHECK_INT(corner[0], mesh->corner_vertex[h]);
        CHECK_INT(corner[1], 8 + mesh->edge[h]);
        CHECK_INT(corner[2], 20 + h / 4);
        CHECK_INT(corner[3], 8 + mesh->edge[co_mesh_prev(mesh, h)]);
        CHECK_NEAR(fabs(face[0]) + fabs(face[1]) + fabs(face[2]), 1, 1e-15);
        CHECK_NEAR(face[0] * vertex[0] + face[1] * vertex[1] + face[2] * vertex[2], 1, 1e-15);
        for (int i = 0; i < 3; i++)
            CHECK_NEAR(xyz[3 * corner[1] + i], 0.75 * (vertex[i] + next[i]) / 2, 1e-15);
    }
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* An open grid of 5 x 5 vertices at whole places: subdivision puts the refined ones at half places, but for the
 * corners, where the boundary curve turns. */
static void test_grid_reproduces_its_own_coordinates(void **state) {
    (void)state;
    enum { SIDE = 5, FACES = 16 };
    int32_t sizes[FACES], vertices[4 * FACES];
    double xyz[3 * SIDE * SIDE];
    for (int v = 0; v < SIDE * SIDE; v++) {
        xyz[3 * v] = v % SIDE;
        xyz[3 * v + 1] = v / SIDE;
        xyz[3 * v + 2] = 7;
    }
    for (int f = 0; f < FACES; f++) {
        int32_t at = f / 4 * SIDE + f % 4, corner[4] = {at, at + 1, at + SIDE + 1, at + SIDE};
        sizes[f] = 4;
        memcpy(vertices + 4 * f, corner, sizeof corner);
    }
    refined r = refine(cage_of(SIDE * SIDE, FACES, sizes, vertices, xyz));
    double fine[3 * 81];
    CHECK_INT(r.fine->info.n_vertices, 81);
    CHECK_INT(r.fine->info.n_boundary_edges, 32);
    co_sparse_rows_apply(&r.rows, xyz, fine);
    for (int v = 0; v < SIDE * SIDE; v++) {
        int corner = (v % SIDE == 0 || v % SIDE == SIDE - 1) && (v / SIDE == 0 || v / SIDE == SIDE - 1);
        CHECK_NEAR(fabs(fine[3 * v] - xyz[3 * v]), corner ? 0.125 : 0, 1e-15);
        CHECK_NEAR(fabs(fine[3 * v + 1] - xyz[3 * v + 1]), corner ? 0.125 : 0, 1e-15);
    }
    for (int e = 0; e < r.mesh->info.n_edges; e++) {
        int32_t h = r.mesh->edge_corner[e], a = r.mesh->corner_vertex[h], b = co_mesh_destination(r.mesh, h);
        for (int i = 0; i < 3; i++)
            CHECK_NEAR(fine[3 * (25 + e) + i], (xyz[3 * a + i] + xyz[3 * b + i]) / 2, 1e-15);
    }
    refined_free(&r);
}

static void test_positions_come_in_pairs(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&c), *fine = mesh;
    curvopt_error error;
    double xyz[78];
    CHECK_REFUSED(curvopt_mesh_refine(mesh, c.xyz, &fine, NULL, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "fine_xyz is NULL");
    CHECK_TRUE(fine == NULL);
    CHECK_REFUSED(curvopt_mesh_refine(mesh, NULL, &fine, xyz, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "xyz is NULL");
    CHECK_REFUSED(curvopt_mesh_refine(NULL, NULL, &fine, NULL, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "mesh is NULL");
    CHECK_REFUSED(curvopt_mesh_refine(mesh, NULL, NULL, NULL, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "out is NULL");
    CHECK_OK(curvopt_mesh_refine(mesh, NULL, &fine, NULL, &error), &error);
    CHECK_INT(fine->info.n_vertices, 26);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counts_follow_from_the_coarse_ones),
        cmocka_unit_test(test_rows_are_convex_combinations),
        cmocka_unit_test(test_affine_maps_commute_with_subdivision),
        cmocka_unit_test(test_cube_by_hand),
        cmocka_unit_test(test_grid_reproduces_its_own_coordinates),
        cmocka_unit_test(test_positions_come_in_pairs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
