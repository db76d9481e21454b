/* Gauss-Legendre rules. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "surface/gauss_legendre.h"

enum { MOST = 24 };

/* The rule's error on the shifted Legendre-like (2 x - 1)^degree, whose integral over 0..1 is 1 / (degree + 1) or 0. */
static double power_error(int n, int degree) {
    double node[MOST], weight[MOST], sum = 0;
    co_gauss_legendre(n, node, weight);
    for (int i = 0; i < n; i++)
        sum += weight[i] * pow(2 * node[i] - 1, degree);
    return sum - (degree % 2 ? 0 : 1.0 / (degree + 1));
}

static void test_degree_two_n_minus_one_is_exact(void **state) {
    (void)state;
    for (int n = 1; n <= MOST; n++)
        for (int degree = 0; degree < 2 * n; degree++)
            CHECK_NEAR(power_error(n, degree), 0, 2e-15);
}

/* x^2n is off by the squared norm of the monic Legendre polynomial, 2^(2n+1) n!^4 / ((2n+1) (2n)!^2) on -1..1. */
static void test_degree_two_n_is_off_by_the_known_amount(void **state) {
    (void)state;
    for (int n = 1; n <= 12; n++) {
        double norm = 1; /* of half the interval's length: an average, as weights sum to 1 */
        for (int k = 1; k <= n; k++)
            norm *= (double)k * k / ((2 * k - 1) * (2 * k + 1.0));
        CHECK_NEAR(power_error(n, 2 * n) / -norm, 1, 1e-9);
    }
}

static void test_nodes_ascend_inside_and_are_symmetric(void **state) {
    (void)state;
    for (int n = 1; n <= MOST; n++) {
        double node[MOST], weight[MOST];
        co_gauss_legendre(n, node, weight);
        for (int i = 0; i < n; i++) {
            CHECK_TRUE(node[i] > (i ? node[i - 1] : 0) && node[i] < 1 && weight[i] > 0);
            CHECK_NEAR(node[i] + node[n - 1 - i], 1, 1e-15);
            CHECK_NEAR(weight[i], weight[n - 1 - i], 1e-15);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_degree_two_n_minus_one_is_exact),
        cmocka_unit_test(test_degree_two_n_is_off_by_the_known_amount),
        cmocka_unit_test(test_nodes_ascend_inside_and_are_symmetric),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
