/* Directions that constraints leave. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "constraints/freedom.h"

static void test_sines_tell_small_angles_apart(void **state) {
    (void)state;
    for (double angle = 3e-14; angle < 1; angle *= 10) {
        const double a[3] = {0, 1, 0}, b[3] = {0, cos(angle), sin(angle)}, c[3] = {0, -cos(angle), -sin(angle)};
        CHECK_NEAR(co_freedom_sine(a, b) / sin(angle), 1, 1e-15);
        CHECK_NEAR(co_freedom_sine(a, c) / sin(angle), 1, 1e-15);
        CHECK_INT(co_freedom_same_direction(a, b), angle < 1e-9);
        CHECK_INT(co_freedom_same_direction(b, c), 1);
    }
}

/* A projector onto `freedom` dimensions that keeps the line, or removes the plane's normal. */
static void test_projectors(void **state) {
    (void)state;
    const double d[3] = {2.0 / 7, 3.0 / 7, 6.0 / 7};
    for (int freedom = CO_FREEDOM_NONE; freedom <= CO_FREEDOM_ALL; freedom++) {
        double p[9], trace = 0;
        co_freedom_projector(freedom, freedom == CO_FREEDOM_NONE || freedom == CO_FREEDOM_ALL ? NULL : d, p);
        for (int i = 0; i < 3; i++) {
            double along = 0;
            trace += p[4 * i];
            for (int j = 0; j < 3; j++) {
                double square = 0;
                for (int k = 0; k < 3; k++)
                    square += p[3 * i + k] * p[3 * k + j];
                CHECK_NEAR(square, p[3 * i + j], 1e-15);
                CHECK_NEAR(p[3 * i + j], p[3 * j + i], 0);
                along += p[3 * i + j] * d[j];
            }
            int keeps = freedom == CO_FREEDOM_LINE || freedom == CO_FREEDOM_ALL;
            CHECK_NEAR(along, keeps ? d[i] : 0, 1e-15);
        }
        CHECK_NEAR(trace, freedom, 1e-15);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sines_tell_small_angles_apart),
        cmocka_unit_test(test_projectors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
