/* Fans, creases, rims and held vertices. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"
#include "constraints/constraints.h"
#include "energy/admissibility.h"
#include "mesh/crease.h"
#include "surface/basis_point.h"
#include "surface/basis_table_cache.h"
#include "surface/boundary_turning.h"

#include <math.h>
#include <stdlib.h>

enum { SIDE = 4, N_VERTICES = (SIDE + 1) * (SIDE + 1), N_FACES = SIDE * SIDE };

/* An open grid of SIDE x SIDE quads, its corners kept. */
static curvopt_mesh *grid_mesh(const curvopt_creases *creases) {
    int32_t sizes[N_FACES], vertices[4 * N_FACES];
    const curvopt_creases corners = {.boundary_rule = CURVOPT_BOUNDARY_RULE_CORNERS};
    curvopt_mesh *mesh;
    curvopt_error error;
    for (int32_t f = 0; f < N_FACES; f++) {
        int32_t v = f / SIDE * (SIDE + 1) + f % SIDE, corner[4] = {v, v + 1, v + SIDE + 2, v + SIDE + 1};
        sizes[f] = 4;
        memcpy(vertices + 4 * f, corner, sizeof corner);
    }
    CHECK_OK(
        curvopt_mesh_create_creased(N_VERTICES, N_FACES, sizes, vertices, creases ? creases : &corners, &mesh, &error),
        &error);
    return mesh;
}

static void test_fan_codes_come_apart_again(void **state) {
    (void)state;
    for (int type = CO_FAN_CLOSED; type <= CO_FAN_CONE; type++)
        for (int32_t n = 3; n <= 1000; n = 2 * n + 1) {
            int32_t fan = co_fan_make((co_fan_type)type, n, n - 1);
            CHECK_INT(co_fan_type_of(fan), type);
            CHECK_INT(co_fan_sectors(fan), n);
            CHECK_INT(co_fan_sector(fan), n - 1);
            CHECK_INT(co_fan_n_points(fan), 6 * n + (co_fan_is_open(fan) ? 3 : 1));
        }
    CHECK_INT(co_fan_make(CO_FAN_CLOSED, 7, 0), 7); /* a valence is a fan */
}

static void test_rows_of_every_fan_reproduce_constants(void **state) {
    (void)state;
    for (int type = CO_FAN_CREASE; type <= CO_FAN_CONE; type++)
        for (int32_t n = type < CO_FAN_DART ? 1 : 3; n <= 5; n++)
            for (int32_t s = 0; s < (type == CO_FAN_CONE ? 1 : n); s++) {
                co_basis_table *t;
                curvopt_error error;
                CHECK_OK(co_basis_table_create(CURVOPT_SURFACE_POLYNOMIAL, co_fan_make((co_fan_type)type, n, s), 0, &t,
                                               &error),
                         &error);
                CHECK_INT(t->surface, type == CO_FAN_CORNER || type == CO_FAN_CONE ? CURVOPT_SURFACE_LIMIT
                                                                                   : CURVOPT_SURFACE_POLYNOMIAL);
                const int n_jet =
                    t->surface == CURVOPT_SURFACE_LIMIT ? CO_JET_SECOND : CO_JET; /* no third derivatives there */
                for (int32_t i = 0; i < t->n_samples * CO_JET; i++) {
                    double sum = 0, absolute = 0;
                    if (i % CO_JET >= n_jet)
                        continue;
                    for (int32_t p = 0; p < t->n_points; p++) {
                        double row = t->rows[((size_t)(i / CO_JET) * (size_t)t->n_points + (size_t)p) * CO_JET +
                                             (size_t)(i % CO_JET)];
                        sum += row;
                        absolute += fabs(row);
                    }
                    CHECK_NEAR(sum, i % CO_JET == 0,
                               1e-13 * (t->surface == CURVOPT_SURFACE_LIMIT ? 1 : fmax(1, absolute)));
                }
                co_basis_table_destroy(t);
            }
}

/* The regular crease and corner are fans of two and one: evaluated as extraordinary ones they must give the same rows
 * as a bicubic patch with phantom points. Limits at the vertex: (A + 4 P + B) / 6 and P. */
static void test_vertex_limits_of_creases_and_corners(void **state) {
    (void)state;
    co_basis_table_cache limit_tables = {.surface = CURVOPT_SURFACE_LIMIT}; /* of which single points keep nothing */
    double rows[(6 * 5 + 3) * CO_JET], weight[CO_JET];
    curvopt_error error;
    for (int32_t n = 1; n <= 5; n++) {
        int32_t crease = co_fan_make(CO_FAN_CREASE, n, 0), corner = co_fan_make(CO_FAN_CORNER, n, n - 1);
        CHECK_OK(co_basis_point(&limit_tables, crease, 0, 0, rows, weight, &error), &error);
        CHECK_NEAR(rows[0], 2.0 / 3, 1e-15);
        CHECK_NEAR(rows[CO_JET * co_fan_index(crease, 0, 1, 0)], 1.0 / 6, 1e-15);
        CHECK_NEAR(rows[CO_JET * co_fan_index(crease, n, 1, 0)], 1.0 / 6, 1e-15);
        CHECK_OK(co_basis_point(&limit_tables, corner, 0, 0, rows, weight, &error), &error);
        CHECK_NEAR(rows[0], 1, 1e-15);
    }
}

static void test_creases_are_inherited_and_soften(void **state) {
    (void)state;
    const int32_t edge[6] = {0, 1, 6, 7, 7, 6}, vertex[2] = {12, 3};
    const double edge_sharpness[3] = {3, 0.5, 2.25}, vertex_sharpness[2] = {10, 0.75};
    curvopt_creases creases = {edge, edge_sharpness, vertex, vertex_sharpness, 3, 2, 0, 0};
    curvopt_mesh *mesh = grid_mesh(&creases), *fine;
    curvopt_error error;
    int32_t n_creases, n_corners, pair[4], corner[2];
    double sharpness[2], corner_sharpness[2];
    curvopt_mesh_count_creases(mesh, &n_creases, &n_corners);
    CHECK_INT(n_creases, 2); /* 6-7 is named twice: the last time counts */
    CHECK_INT(n_corners, 2);
    curvopt_mesh_get_creases(mesh, pair, sharpness, corner, corner_sharpness);
    CHECK_NEAR(sharpness[pair[0] + pair[1] == 13 ? 0 : 1], 2.25, 0);
    CHECK_OK(curvopt_mesh_refine(mesh, NULL, &fine, NULL, &error), &error);
    curvopt_mesh_count_creases(fine, &n_creases, &n_corners);
    CHECK_INT(n_creases, 4);
    CHECK_INT(n_corners, 1); /* 0.75 has faded */
    CHECK_NEAR(co_crease_largest_fading(fine), 2, 0);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
}

/* A square, flat: no geodesic curvature, four right angles. A disc's boundary turns by 2 pi whatever its shape. */
static void test_boundary_of_a_disc_turns_once(void **state) {
    (void)state;
    const double pi = 3.14159265358979323846;
    curvopt_mesh *mesh = grid_mesh(NULL);
    curvopt_error error;
    co_patches patches;
    co_boundary_turning rim;
    uint64_t random = 5;
    CHECK_OK(co_patches_create(mesh, NULL, NULL, CURVOPT_SURFACE_LIMIT, 1, NULL, &patches, &error), &error);
    CHECK_OK(co_boundary_turning_create(mesh, &patches, CURVOPT_SURFACE_LIMIT, &rim, &error), &error);
    double *points = calloc(3 * (size_t)patches.n_points, sizeof *points);
    CHECK_INT(rim.n_sides, 4 * SIDE);
    CHECK_NEAR(rim.target, 2 * pi, 1e-15);
    for (int shaken = 0; shaken < 2; shaken++) {
        for (int32_t v = 0; v < N_VERTICES; v++) {
            points[3 * v] = v % (SIDE + 1) + shaken * 0.2 * check_random(&random);
            points[3 * v + 1] = v / (SIDE + 1) + shaken * 0.2 * check_random(&random);
        }
        co_sparse_rows_apply(&patches.derived, points, points + 3 * (size_t)patches.n_cage);
        CHECK_NEAR(co_boundary_turning_total(&rim, &patches, NULL, points), 2 * pi, shaken ? 1e-9 : 1e-13);
    }
    free(points);
    co_boundary_turning_free(&rim);
    co_patches_free(&patches);
    curvopt_mesh_destroy(mesh);
}

static void test_rows_of_vertices_are_held(void **state) {
    (void)state;
    static const int expected[4] = {16, 24, 25, 0}; /* of 5 x 5 */
    curvopt_mesh *mesh = grid_mesh(NULL);
    curvopt_error error;
    for (int32_t boundary = CURVOPT_BOUNDARY_POSITION; boundary <= CURVOPT_BOUNDARY_FREE; boundary++) {
        co_constraints hold = {0};
        int n = 0;
        CHECK_OK(co_constraints_boundary(mesh, boundary, &hold, &error), &error);
        for (int32_t v = 0; hold.freedom && v < N_VERTICES; v++)
            n += hold.freedom[v] == CO_FREEDOM_NONE;
        CHECK_INT(n, expected[boundary]);
        co_constraints_free(&hold);
    }
    curvopt_mesh_destroy(mesh);
}

static void test_only_integrable_fans_carry_energies(void **state) {
    (void)state;
    for (int32_t n = 1; n <= 6; n++) {
        CHECK_INT(co_fan_is_integrable(co_fan_make(CO_FAN_CREASE, n, 0)), n == 2 || n == 3);
        CHECK_INT(co_fan_is_integrable(co_fan_make(CO_FAN_CORNER, n, 0)), n == 1);
    }
    for (int32_t n = 3; n <= 6; n++) {
        co_stam_disc disc;
        curvopt_error error;
        CHECK_OK(co_stam_disc_create(co_fan_make(CO_FAN_DART, n, 0), &disc, &error), &error);
        CHECK_TRUE(disc.mu < 0.9 * disc.lambda);
        co_stam_disc_free(&disc);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fan_codes_come_apart_again),
        cmocka_unit_test(test_rows_of_every_fan_reproduce_constants),
        cmocka_unit_test(test_vertex_limits_of_creases_and_corners),
        cmocka_unit_test(test_creases_are_inherited_and_soften),
        cmocka_unit_test(test_boundary_of_a_disc_turns_once),
        cmocka_unit_test(test_rows_of_vertices_are_held),
        cmocka_unit_test(test_only_integrable_fans_carry_energies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
