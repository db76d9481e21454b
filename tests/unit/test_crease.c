/* Creases: what is refused, what is stored, what fades; and which fans have finite curvature.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "mesh/crease.h"
#include "mesh/fan.h"

static int32_t create(const curvopt_creases *creases, curvopt_mesh **mesh, curvopt_error *error) {
    cage c = cage_cube();
    int32_t status = curvopt_mesh_create_creased(c.n_vertices, c.n_faces, c.sizes, c.vertices, creases, mesh, error);
    cage_free(&c);
    return status;
}

static void refused(curvopt_creases creases, int32_t element, const char *part) {
    curvopt_mesh *mesh = NULL;
    curvopt_error error;
    CHECK_REFUSED(create(&creases, &mesh, &error), &error, CURVOPT_ERROR_ARGUMENT, element, part);
    CHECK_TRUE(mesh == NULL);
}

static void test_wrong_creases_are_refused(void **state) {
    const int32_t edges[4] = {0, 1, 0, 4}, diagonal[4] = {0, 1, 0, 3}, beyond[4] = {0, 1, 0, 8},
                  below[4] = {-1, 1, 0, 1};
    const double good[2] = {1, 2}, negative[2] = {1, -0.1}, large[2] = {1, CURVOPT_SHARPNESS_MAX * 1.01};
    const double none[2] = {(double)NAN, 1};
    (void)state;
    refused((curvopt_creases){edges, negative, NULL, NULL, 2, 0, 0, 0}, 1, "crease 1 has sharpness -0.1");
    refused((curvopt_creases){edges, large, NULL, NULL, 2, 0, 0, 0}, 1, "crease 1 has sharpness");
    refused((curvopt_creases){edges, none, NULL, NULL, 2, 0, 0, 0}, 0, "crease 0 has sharpness");
    refused((curvopt_creases){diagonal, good, NULL, NULL, 2, 0, 0, 0}, 1, "which no edge of the cage joins");
    refused((curvopt_creases){beyond, good, NULL, NULL, 2, 0, 0, 0}, 1, "crease 1 names vertex 8");
    refused((curvopt_creases){below, good, NULL, NULL, 2, 0, 0, 0}, 0, "crease 0 names vertex -1");
    refused((curvopt_creases){NULL, NULL, beyond + 2, negative, 0, 2, 0, 0}, 1, "corner 1 has sharpness -0.1");
    refused((curvopt_creases){NULL, NULL, beyond + 2, good, 0, 2, 0, 0}, 1, "corner 1 names vertex 8");
    refused((curvopt_creases){.boundary_rule = 2}, -1, "boundary_rule is 2");
    refused((curvopt_creases){.reserved = 1}, -1, "reserved is 1");
    refused((curvopt_creases){edges, good, NULL, NULL, -1, 0, 0, 0}, -1, "-1 creases and 0 corners");
    refused((curvopt_creases){edges, good, edges, good, 1, -2, 0, 0}, -1, "1 creases and -2 corners");
    refused((curvopt_creases){NULL, good, NULL, NULL, 1, 0, 0, 0}, -1, "an array of the creases is NULL");
    refused((curvopt_creases){edges, NULL, NULL, NULL, 1, 0, 0, 0}, -1, "an array of the creases is NULL");
    refused((curvopt_creases){NULL, NULL, NULL, good, 0, 1, 0, 0}, -1, "an array of the creases is NULL");
    refused((curvopt_creases){NULL, NULL, edges, NULL, 0, 1, 0, 0}, -1, "an array of the creases is NULL");
}

static void test_largest_fading_sharpness(void **state) {
    const int32_t edges[6] = {0, 1, 0, 2, 0, 4}, vertices[2] = {3, 5};
    const double of_edges[3] = {2.5, CURVOPT_SHARPNESS_INFINITE, 0.5}, of_vertices[2] = {3.25, 40};
    curvopt_mesh *mesh;
    curvopt_error error;
    (void)state;
    CHECK_OK(create(&(curvopt_creases){edges, of_edges, NULL, NULL, 3, 0, 0, 0}, &mesh, &error), &error);
    CHECK_NEAR(co_crease_largest_fading(mesh), 2.5, 0);
    CHECK_NEAR(mesh->edge_sharpness[mesh->edge[mesh->vertex_corner[7]]], 0, 0);
    co_mesh_destroy(mesh);
    CHECK_OK(create(&(curvopt_creases){edges, of_edges, vertices, of_vertices, 3, 2, 0, 0}, &mesh, &error), &error);
    CHECK_NEAR(co_crease_largest_fading(mesh), 3.25, 0);
    co_mesh_destroy(mesh);
    CHECK_OK(create(NULL, &mesh, &error), &error);
    CHECK_NEAR(co_crease_largest_fading(mesh), 0, 0);
    co_mesh_destroy(mesh);
    CHECK_NEAR(co_crease_softened(2.5), 1.5, 0);
    CHECK_NEAR(co_crease_softened(0.5), 0, 0);
    CHECK_NEAR(co_crease_softened(CURVOPT_SHARPNESS_INFINITE), CURVOPT_SHARPNESS_INFINITE, 0);
    CHECK_TRUE(co_crease_alike(12, 20) && co_crease_alike(2, 2) && !co_crease_alike(2, 12) && !co_crease_alike(1, 2));
}

/* By the ratio of successive rings' integrals (fan.h), which must be below 1. */
static void test_which_fans_are_integrable(void **state) {
    (void)state;
    for (int32_t n = 1; n < 8; n++) {
        if (n > 2) {
            CHECK_TRUE(co_fan_is_integrable(n));
            CHECK_TRUE(co_fan_is_integrable(co_fan_make_wide(n, 4, 1, 3)));
            CHECK_TRUE(co_fan_is_integrable(co_fan_make(CO_FAN_DART, n, 1)));
            CHECK_TRUE(!co_fan_is_integrable(co_fan_make(CO_FAN_CONE, n, 0)));
        }
        CHECK_INT(co_fan_is_integrable(co_fan_make(CO_FAN_CREASE, n, 0)), n == 2 || n == 3);
        CHECK_INT(co_fan_is_integrable(co_fan_make(CO_FAN_CORNER, n, n - 1)), n == 1);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_wrong_creases_are_refused),
        cmocka_unit_test(test_largest_fading_sharpness),
        cmocka_unit_test(test_which_fans_are_integrable),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
