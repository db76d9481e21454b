/* Elementary functions beside those of the C library. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "base/constants.h"
#include "base/elementary.h"

#include <float.h>
#include <math.h>

enum { N = 100000 };

/* Within `ulps` units in the last place of `expected`, and of `least` where that is larger. */
static void near(double got, double expected, double ulps, double least) {
    const double unit = fmax(fabs(expected), least) * DBL_EPSILON;
    if (!(fabs(got - expected) <= ulps * unit))
        CHECK_NEAR(got, expected, ulps * unit);
}

/* The reference has its own error of pi * x; x is a multiple of 2^-30 and small, which keeps that below half a unit. */
static void test_waves(void **state) {
    (void)state;
    uint64_t seed = 5;
    for (int i = 0; i < N; i++) {
        const double x = floor(0x1p28 * check_random(&seed)) * 0x1p-29;
        near(co_cos_pi(x), cos(CO_PI * x), 2, 1);
        near(co_sin_pi(x), sin(CO_PI * x), 2, 1e-3);
        CHECK_NEAR(co_cos_pi(x + 6), co_cos_pi(x), 0);
        CHECK_NEAR(co_cos_pi(x - 7), -co_cos_pi(x), 0);
        CHECK_NEAR(co_sin_pi(x + 7), -co_sin_pi(x), 0);
    }
    for (int k = -9; k <= 9; k++) {
        CHECK_NEAR(co_cos_pi(k / 2.0), k % 2 ? 0 : k % 4 ? -1 : 1, 0);
        CHECK_NEAR(co_sin_pi(k / 2.0), k % 2 == 0 ? 0 : (k + 16) % 4 == 1 ? 1 : -1, 0);
    }
}

static void test_angles(void **state) {
    (void)state;
    uint64_t seed = 6;
    for (int i = 0; i < N; i++) {
        const double x = check_random(&seed), y = check_random(&seed) * pow(2, i % 40 - 20);
        near(CO_PI * co_angle_over_pi(y, x), atan2(y, x), 4, 0);
        near(co_arc_cosine(x), acos(x), 4, 1e-2);
    }
    CHECK_NEAR(co_angle_over_pi(0, 0), 0, 0);
    CHECK_NEAR(co_angle_over_pi(0, 2), 0, 0);
    CHECK_NEAR(co_angle_over_pi(0, -2), 1, 0);
    CHECK_NEAR(co_angle_over_pi(3, 0), 0.5, 0);
    CHECK_NEAR(co_angle_over_pi(-3, 0), -0.5, 0);
}

static void test_exponentials_and_logarithms(void **state) {
    (void)state;
    uint64_t seed = 7;
    for (int i = 0; i < N; i++) {
        const double x = 700 * check_random(&seed), y = (fabs(check_random(&seed)) + 1e-3) * pow(2, i % 200 - 100);
        const double small = check_random(&seed) * pow(2, -i % 60);
        near(co_exp(x), exp(x), 2, DBL_MIN);
        near(co_exp(small), exp(small), 2, 0);
        near(co_log(y), log(y), 2, 0);
        near(co_log_1_plus(small), log1p(small), 2, 0);
    }
    CHECK_NEAR(co_exp(0), 1, 0);
    CHECK_NEAR(co_log(1), 0, 0);
    CHECK_NEAR(co_log_1_plus(0), 0, 0);
    CHECK_NEAR(co_exp(-800), 0, 0);
    CHECK_TRUE(isinf(co_exp(800)));
}

static void test_powers_and_lengths(void **state) {
    (void)state;
    for (int n = -20; n <= 20; n++)
        near(co_power(1.3, n), pow(1.3, n), 12, 0);
    CHECK_NEAR(co_power(0, 0), 1, 0);
    CHECK_NEAR(co_length(3, -4), 5, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_waves),
        cmocka_unit_test(test_angles),
        cmocka_unit_test(test_exponentials_and_logarithms),
        cmocka_unit_test(test_powers_and_lengths),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
