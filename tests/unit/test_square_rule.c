/* Cubature on the square. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "surface/square_rule.h"

/* Mean of (2 u - 1)^i (2 v - 1)^j over 0..1 x 0..1. */
static double moment(int i, int j) {
    return i % 2 || j % 2 ? 0 : 1.0 / ((i + 1) * (j + 1));
}

/* Largest error of a rule on products of powers of that total degree. */
static double largest_error(const co_square_rule *rule, int degree) {
    double largest = 0;
    for (int i = 0; i <= degree; i++) {
        double sum = 0;
        for (int k = 0; k < rule->n; k++)
            sum += rule->weight[k] * pow(2 * rule->point[k][0] - 1, i) * pow(2 * rule->point[k][1] - 1, degree - i);
        largest = fmax(largest, fabs(sum - moment(i, degree - i)));
    }
    return largest;
}

/* Exact up to its degree, and no further: the degree is bounded from both sides. */
static void test_degree(void **state) {
    (void)state;
    for (int gauss = 1; gauss <= CO_SQUARE_RULE_GAUSS; gauss++) {
        co_square_rule rule;
        co_square_rule_make(gauss, &rule);
        CHECK_INT(rule.n, co_square_rule_size(gauss));
        for (int degree = 0; degree < 2 * gauss; degree++)
            CHECK_NEAR(largest_error(&rule, degree), 0, 2e-15);
        CHECK_TRUE(largest_error(&rule, 2 * gauss) > 1e-3 * pow(4, -2 * gauss));
    }
}

/* Numbers of points of F. D. Witherden, P. E. Vincent, 2015; elsewhere those of Gauss. */
static void test_sizes(void **state) {
    (void)state;
    static const int sizes[] = {0, 1, 4, 8, 12, 20, 28, 37, 48, 60, 72, 85, 144};
    for (int gauss = 1; gauss <= CO_SQUARE_RULE_GAUSS; gauss++)
        CHECK_INT(co_square_rule_size(gauss), sizes[gauss]);
}

/* Weight of the point at a place; 0: there is none. */
static double weight_at(const co_square_rule *rule, double u, double v) {
    for (int k = 0; k < rule->n; k++)
        if (fabs(rule->point[k][0] - u) < 1e-15 && fabs(rule->point[k][1] - v) < 1e-15)
            return rule->weight[k];
    return 0;
}

static void test_points_are_inside_and_as_symmetric_as_the_square(void **state) {
    (void)state;
    for (int gauss = 1; gauss <= CO_SQUARE_RULE_GAUSS; gauss++) {
        co_square_rule rule;
        co_square_rule_make(gauss, &rule);
        for (int k = 0; k < rule.n; k++) {
            const double u = rule.point[k][0], v = rule.point[k][1], weight = rule.weight[k];
            CHECK_TRUE(weight > 0 && u > 0 && u < 1 && v > 0 && v < 1);
            CHECK_NEAR(weight_at(&rule, v, u), weight, 1e-15 * weight);
            CHECK_NEAR(weight_at(&rule, 1 - u, v), weight, 1e-14 * weight);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_degree),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_points_are_inside_and_as_symmetric_as_the_square),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
