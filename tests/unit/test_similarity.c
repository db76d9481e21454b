/* Rigid motions and scale. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "mesh/similarity.h"

enum { N = 12 };

static void random_points(double *xyz, uint64_t seed) {
    for (int i = 0; i < 3 * N; i++)
        xyz[i] = check_random(&seed);
}

/* Turned by 2.5 about (1, 2, 2) / 3, scaled, moved. */
static void moved(const double *in, double scale, double *out) {
    static const double axis[3] = {1.0 / 3, 2.0 / 3, 2.0 / 3}, shift[3] = {10, -20, 5};
    double c = cos(2.5), s = sin(2.5);
    for (int p = 0; p < N; p++) {
        const double *x = in + 3 * p;
        double along = axis[0] * x[0] + axis[1] * x[1] + axis[2] * x[2];
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            double cross = axis[j] * x[k] - axis[k] * x[j];
            out[3 * p + i] = scale * (c * x[i] + s * cross + (1 - c) * along * axis[i]) + shift[i];
        }
    }
}

static void test_frame_is_mean_and_root_mean_square(void **state) {
    (void)state;
    static const double xyz[] = {1, 5, 0, 3, 5, 0, 2, 4, 0, 2, 6, 0}; /* all 1 from (2, 5, 0) */
    double centroid[3];
    CHECK_NEAR(co_similarity_frame(4, xyz, centroid), 1, 1e-15);
    CHECK_NEAR(centroid[0], 2, 1e-15);
    CHECK_NEAR(centroid[1], 5, 1e-15);
    CHECK_NEAR(centroid[2], 0, 0);
}

static void test_align_undoes_a_rigid_motion(void **state) {
    (void)state;
    double reference[3 * N], xyz[3 * N];
    random_points(reference, 7);
    moved(reference, 1, xyz);
    co_similarity_align(N, reference, xyz);
    for (int i = 0; i < 3 * N; i++)
        CHECK_NEAR(xyz[i], reference[i], 1e-13);
}

static void test_align_keeps_size_and_takes_the_centroid(void **state) {
    (void)state;
    double reference[3 * N], xyz[3 * N], want[3], got[3];
    random_points(reference, 8);
    moved(reference, 7, xyz);
    double radius = co_similarity_frame(N, xyz, got);
    co_similarity_align(N, reference, xyz);
    co_similarity_frame(N, reference, want);
    CHECK_NEAR(co_similarity_frame(N, xyz, got), radius, 1e-13);
    for (int i = 0; i < 3; i++)
        CHECK_NEAR(got[i], want[i], 1e-14);
    for (int i = 0; i < 3 * N; i++)
        CHECK_NEAR(xyz[i] - got[i % 3], 7 * (reference[i] - want[i % 3]), 1e-12);
}

/* The best rotation of a deformed copy: turning the result a little either way brings it farther from the reference. */
static void test_align_is_closest_among_rotations(void **state) {
    (void)state;
    double reference[3 * N], xyz[3 * N], best = 0, centroid[3];
    random_points(reference, 9);
    moved(reference, 1.3, xyz);
    uint64_t seed = 77;
    for (int i = 0; i < 3 * N; i++)
        xyz[i] += 0.1 * check_random(&seed);
    co_similarity_align(N, reference, xyz);
    co_similarity_frame(N, xyz, centroid);
    for (int i = 0; i < 3 * N; i++)
        best += (xyz[i] - reference[i]) * (xyz[i] - reference[i]);
    for (int axis = 0; axis < 3; axis++)
        for (int sign = -1; sign <= 1; sign += 2) {
            double sum = 0, c = cos(1e-3), s = sign * sin(1e-3);
            int j = (axis + 1) % 3, k = (axis + 2) % 3;
            for (int p = 0; p < N; p++) {
                double x[3];
                for (int i = 0; i < 3; i++)
                    x[i] = xyz[3 * p + i] - centroid[i];
                double y[3] = {x[0], x[1], x[2]};
                y[j] = c * x[j] - s * x[k];
                y[k] = s * x[j] + c * x[k];
                for (int i = 0; i < 3; i++)
                    sum += pow(y[i] + centroid[i] - reference[3 * p + i], 2);
            }
            CHECK_TRUE(sum > best);
        }
}

static void test_align_never_mirrors_and_never_fails(void **state) {
    (void)state;
    double reference[3 * N], mirrored[3 * N], line[3 * N], centroid[3], radius;
    random_points(reference, 10);
    for (int i = 0; i < 3 * N; i++) {
        mirrored[i] = i % 3 == 2 ? -reference[i] : reference[i];
        line[i] = i / 3 * (i % 3 + 1);
    }
    radius = co_similarity_frame(N, line, centroid);
    co_similarity_align(N, reference, mirrored);
    co_similarity_align(N, reference, line);
    double a[3][3];
    for (int p = 0; p < 3; p++)
        for (int i = 0; i < 3; i++)
            a[p][i] = (mirrored[3 * (p + 1) + i] - mirrored[i]);
    double b[3][3];
    for (int p = 0; p < 3; p++)
        for (int i = 0; i < 3; i++)
            b[p][i] = (reference[3 * (p + 1) + i] - reference[i]);
    double volume[2];
    for (int n = 0; n < 2; n++) {
        double(*m)[3] = n ? b : a;
        volume[n] = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) +
                    m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2]) +
                    m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    }
    CHECK_NEAR(volume[0], -volume[1], 1e-13);
    CHECK_NEAR(co_similarity_frame(N, line, centroid), radius, 1e-12);
}

static void test_positions_without_extent_are_refused(void **state) {
    double xyz[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    curvopt_error error;
    (void)state;
    CHECK_OK(co_similarity_check(3, xyz, &error), &error);
    xyz[4] = (double)NAN;
    CHECK_REFUSED(co_similarity_check(3, xyz, &error), &error, CURVOPT_ERROR_GEOMETRY, 1, "vertex 1 has coordinate y");
    xyz[4] = (double)-INFINITY;
    CHECK_REFUSED(co_similarity_check(3, xyz, &error), &error, CURVOPT_ERROR_GEOMETRY, 1, "coordinate y = -inf");
    for (int i = 0; i < 9; i++)
        xyz[i] = 1e5 + 1e-6 * (i == 5); /* 1e-11 of where it lies */
    CHECK_REFUSED(co_similarity_check(3, xyz, &error), &error, CURVOPT_ERROR_GEOMETRY, -1, "zero area");
    xyz[5] = 1e5 + 1;
    CHECK_OK(co_similarity_check(3, xyz, &error), &error);
    memset(xyz, 0, sizeof xyz);
    CHECK_REFUSED(co_similarity_check(3, xyz, &error), &error, CURVOPT_ERROR_GEOMETRY, -1, "zero area");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_frame_is_mean_and_root_mean_square),
        cmocka_unit_test(test_align_undoes_a_rigid_motion),
        cmocka_unit_test(test_align_keeps_size_and_takes_the_centroid),
        cmocka_unit_test(test_align_is_closest_among_rotations),
        cmocka_unit_test(test_align_never_mirrors_and_never_fails),
        cmocka_unit_test(test_positions_without_extent_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
