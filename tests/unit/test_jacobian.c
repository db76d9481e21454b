/* The least Jacobian of a cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "mesh/jacobian.h"

#include <float.h>
#include <math.h>

/* left_out [n_faces] or NULL. */
static double least_without(const cage *c, const uint8_t *left_out) {
    double out = -1;
    curvopt_error error;
    curvopt_mesh *mesh = cage_mesh(c);
    CHECK_OK(co_jacobian_least(mesh, left_out, c->xyz, &out, &error), &error);
    curvopt_mesh_destroy(mesh);
    return out;
}

static double least_of(const cage *c) {
    return least_without(c, NULL);
}

/* By Heron's formula in the faces of the cage refined twice, `group` of which belong together. */
static double by_lengths(cage fine, int group) {
    double least = DBL_MAX;
    fine = cage_refined(fine, 2);
    for (int32_t first = 0; first < fine.n_faces; first += group) {
        double low = DBL_MAX, sum = 0;
        for (int k = 0; k < 4 * group; k++) {
            const int32_t *v = fine.vertices + 4 * (first + k / 4),
                          corner[3] = {v[k % 4], v[(k + 1) % 4], v[(k + 3) % 4]};
            double l[3];
            for (int e = 0; e < 3; e++) {
                const double *p = fine.xyz + 3 * corner[e], *q = fine.xyz + 3 * corner[(e + 1) % 3];
                l[e] = sqrt(pow(p[0] - q[0], 2) + pow(p[1] - q[1], 2) + pow(p[2] - q[2], 2));
            }
            const double s = (l[0] + l[1] + l[2]) / 2, area = 2 * sqrt(s * (s - l[0]) * (s - l[1]) * (s - l[2]));
            low = fmin(low, area);
            sum += area;
        }
        least = fmin(least, 4 * group * low / sum);
    }
    cage_free(&fine);
    return least;
}

static void test_by_lengths(void **state) {
    (void)state;
    cage torus = cage_shaken(cage_torus(8, 4, 3, 1.2), 0.3), prism = cage_prism(5), solid = cage_tetrahedron();
    const double of[3] = {least_of(&torus), least_of(&prism), least_of(&solid)};
    CHECK_NEAR(of[0], by_lengths(torus, 16), 1e-6);
    CHECK_NEAR(of[1], by_lengths(prism, 4), 1e-6); /* by quarters of faces */
    CHECK_NEAR(of[2], by_lengths(solid, 4), 1e-6);
    CHECK_BETWEEN(of[0], 0.01, 0.9);
}

/* Size and place do not count. A face that folds back on itself has next to none; with half of the torus left out the
 * rest has what it had. */
static void test_folds(void **state) {
    (void)state;
    cage c = cage_torus(8, 4, 3, 1.2);
    const double even = least_of(&c);
    for (int i = 0; i < 3 * c.n_vertices; i++)
        c.xyz[i] = 1e-3 * c.xyz[i] + i % 3;
    CHECK_NEAR(least_of(&c), even, 1e-9);
    uint8_t left_out[32];
    CHECK_INT(c.n_faces, 32);
    for (int32_t k = 0; k < 32; k++) /* faces are numbered round the hole, four by four */
        left_out[k] = k / 4 < 3 || k / 4 > 5;
    const double rest_before = least_without(&c, left_out);
    const int32_t *v = c.vertices;
    for (int i = 0; i < 3; i++)
        c.xyz[3 * v[0] + i] = c.xyz[3 * v[2] + i];
    const double all = least_of(&c), rest = least_without(&c, left_out);
    CHECK_NEAR(rest, rest_before, 1e-9);
    CHECK_TRUE(all < 0.3 * even && rest > 0.99 * even);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_by_lengths), cmocka_unit_test(test_folds)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
