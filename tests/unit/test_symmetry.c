/* Symmetry groups of cages: their order, their table, what they are kept by. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "cages.h"
#include "check.h"

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
    CHECK_OK(co_constraints_create(mesh, c.xyz, &lines, &hold, &error), &error);
    CHECK_OK(co_symmetry_create(mesh, c.xyz, &hold, 1, &symmetry, &error), &error);
    CHECK_INT(symmetry.order, 2);
    for (int k = 0; k < 9; k++)
        CHECK_NEAR(symmetry.matrix[9 + k], k == 8 ? -1 : k % 4 == 0, 1e-10);
    co_symmetry_free(&symmetry);
    co_constraints_free(&hold);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_directions_are_compared_at_tolerances_below_1e_8),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
