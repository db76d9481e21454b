/* A cage as patches. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"
#include "surface/patches.h"

#include <stdlib.h>

typedef struct covered {
    cage c;
    curvopt_mesh *mesh;
    co_patches patches;
} covered;

static covered cover(cage c) {
    covered x = {.c = c, .mesh = cage_mesh(&c)};
    curvopt_error error;
    CHECK_OK(co_patches_create(x.mesh, NULL, NULL, CURVOPT_SURFACE_LIMIT, 1, NULL, &x.patches, &error), &error);
    return x;
}

static void covered_free(covered *x) {
    co_patches_free(&x->patches);
    curvopt_mesh_destroy(x->mesh);
    cage_free(&x->c);
}

/* Patches lie inside their face (or its quarter) and their areas add up to it. */
static void check_cover(cage c) {
    covered x = cover(c);
    double *area = calloc((size_t)x.mesh->info.n_corners, sizeof *area);
    CHECK_TRUE(area != NULL);
    for (int32_t p = 0; p < x.patches.n_patches; p++) {
        const co_place *place = &x.patches.place[p];
        static const double along[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
        double scale = 1.0 / (1 << place->level);
        for (int i = 0; i < 2; i++) {
            double far = place->origin[i] + scale * along[place->rotation][i];
            CHECK_BETWEEN(place->origin[i], 0, 1);
            CHECK_BETWEEN(far, 0, 1);
        }
        area[x.mesh->face_start[place->face] + place->quarter] += scale * scale;
    }
    for (int32_t f = 0; f < x.mesh->info.n_faces; f++)
        for (int32_t k = 0; k < co_mesh_face_size(x.mesh, f); k++)
            CHECK_NEAR(area[x.mesh->face_start[f] + k], co_mesh_face_size(x.mesh, f) != 4 || k == 0, 1e-14);
    free(area);
    covered_free(&x);
}

static void test_every_face_is_covered_once(void **state) {
    (void)state;
    check_cover(cage_torus(6, 5, 1, 0.4));
    check_cover(cage_cube());
    check_cover(cage_tetrahedron());
    check_cover(cage_prism(7));
    check_cover(cage_trapezohedron(9));
    check_cover(cage_both(cage_torus(7, 4, 1, 0.3), cage_prism(5), 4));
}

static void test_regular_cage_needs_no_subdivision(void **state) {
    (void)state;
    covered x = cover(cage_torus(6, 5, 1, 0.4));
    CHECK_INT(x.patches.n_patches, 30);
    CHECK_INT(x.patches.n_points, 30);
    CHECK_INT(x.patches.derived.n_rows, 0);
    for (int32_t p = 0; p < 30; p++) {
        CHECK_INT(x.patches.kind[p], 4);
        CHECK_INT(x.patches.start[p + 1] - x.patches.start[p], 16);
    }
    covered_free(&x);
}

/* Point 4 j + i of a patch of a torus is i on along one direction and j along the other. */
static void test_regular_points_follow_the_grid(void **state) {
    (void)state;
    covered x = cover(cage_torus(6, 5, 1, 0.4));
    for (int32_t p = 0; p < 30; p++) {
        int32_t face = x.patches.place[p].face, a = face / 5, b = face % 5;
        CHECK_INT(x.patches.place[p].rotation, 0);
        for (int k = 0; k < 16; k++) {
            int32_t u = (a + k % 4 - 1 + 6) % 6, v = (b + k / 4 - 1 + 5) % 5;
            CHECK_INT(x.patches.points[16 * p + k], 5 * u + v);
        }
    }
    covered_free(&x);
}

static void test_derived_points_are_convex_combinations(void **state) {
    (void)state;
    covered x = cover(cage_prism(7));
    const co_sparse_rows *rows = &x.patches.derived;
    CHECK_INT(x.patches.n_cage, 14);
    CHECK_INT(rows->n_rows, x.patches.n_points - 14);
    CHECK_TRUE(rows->n_rows > 0);
    for (int32_t r = 0; r < rows->n_rows; r++) {
        double sum = 0;
        for (size_t e = rows->start[r]; e < rows->start[r + 1]; e++) {
            CHECK_TRUE(rows->value[e] > 0 && rows->column[e] < 14);
            sum += rows->value[e];
        }
        CHECK_NEAR(sum, 1, 1e-14);
    }
    covered_free(&x);
}

static void test_extraordinary_patches_have_whole_two_rings(void **state) {
    (void)state;
    covered x = cover(cage_cube());
    int seen = 0;
    for (int32_t p = 0; p < x.patches.n_patches; p++) {
        int32_t size = co_patches_size(x.patches.kind[p]);
        CHECK_INT(x.patches.start[p + 1] - x.patches.start[p], size);
        for (int32_t i = 0; i < size; i++)
            CHECK_BETWEEN(x.patches.points[x.patches.start[p] + (size_t)i], 0, x.patches.n_points - 1);
        seen += x.patches.kind[p] == 3;
    }
    CHECK_INT(seen, 24); /* three faces at each of eight corners */
    covered_free(&x);
}

static void test_open_cage_has_phantom_points(void **state) {
    (void)state;
    int32_t sizes[4] = {4, 4, 4, 4}, vertices[16];
    for (int32_t f = 0; f < 4; f++) {
        int32_t v = f / 2 * 3 + f % 2, corner[4] = {v, v + 1, v + 4, v + 3};
        memcpy(vertices + 4 * f, corner, sizeof corner);
    }
    curvopt_creases corners = {.boundary_rule = CURVOPT_BOUNDARY_RULE_CORNERS};
    curvopt_mesh *mesh;
    co_patches patches;
    curvopt_error error;
    CHECK_OK(curvopt_mesh_create_creased(9, 4, sizes, vertices, &corners, &mesh, &error), &error);
    CHECK_OK(co_patches_create(mesh, NULL, NULL, CURVOPT_SURFACE_LIMIT, 1, NULL, &patches, &error), &error);
    CHECK_INT(patches.n_patches, 4); /* a grid of 2 x 2 quads needs no subdivision */
    CHECK_INT(patches.n_kinds, 1);
    CHECK_INT(patches.derived.n_rows, 16); /* the ring round its 9 points */
    for (int32_t r = 0; r < patches.derived.n_rows; r++) {
        double sum = 0;
        for (size_t e = patches.derived.start[r]; e < patches.derived.start[r + 1]; e++)
            sum += patches.derived.value[e];
        CHECK_NEAR(sum, 1, 1e-15);
    }
    co_patches_free(&patches);
    curvopt_mesh_destroy(mesh);
}

static void test_a_raised_flag_leaves_nothing(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_cancel *flag;
    co_cancel cancel = {0};
    co_patches patches;
    curvopt_error error;
    CHECK_OK(curvopt_cancel_create(&flag, &error), &error);
    co_cancel_start_at_once(&cancel, flag);
    CHECK_OK(co_patches_create(mesh, NULL, NULL, CURVOPT_SURFACE_LIMIT, 1, &cancel, &patches, &error), &error);
    co_patches_free(&patches);
    curvopt_cancel_request(flag);
    CHECK_INT(co_patches_create(mesh, NULL, NULL, CURVOPT_SURFACE_LIMIT, 1, &cancel, &patches, &error), CO_CANCELLED);
    CHECK_TRUE(patches.n_patches == 0 && !patches.points && !patches.start);
    curvopt_cancel_destroy(flag);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_face_is_covered_once),
        cmocka_unit_test(test_regular_cage_needs_no_subdivision),
        cmocka_unit_test(test_regular_points_follow_the_grid),
        cmocka_unit_test(test_derived_points_are_convex_combinations),
        cmocka_unit_test(test_extraordinary_patches_have_whole_two_rings),
        cmocka_unit_test(test_open_cage_has_phantom_points),
        cmocka_unit_test(test_a_raised_flag_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
