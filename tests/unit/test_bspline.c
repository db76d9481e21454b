/* The bicubic basis and its jets. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "surface/bspline.h"

static void test_basis_sums_to_one_and_derivatives_to_zero(void **state) {
    (void)state;
    for (int n = 0; n <= 8; n++) {
        double basis[16][CO_JET];
        co_bspline_bicubic(n / 8.0, (8 - n) / 11.0, basis);
        for (int k = 0; k < CO_JET; k++) {
            double sum = 0;
            for (int i = 0; i < 16; i++)
                sum += basis[i][k];
            CHECK_NEAR(sum, k == 0, 2e-15);
        }
    }
}

/* Cubic B-splines reproduce the Greville abscissae: sum of i B_i(t) = t + 1 with knots one apart. */
static void test_basis_reproduces_linear_functions(void **state) {
    (void)state;
    for (int n = 0; n <= 4; n++) {
        double t = n / 4.0, basis[4][4], value = 0, slope = 0;
        co_bspline_cubic(t, basis);
        for (int i = 0; i < 4; i++) {
            value += i * basis[i][0];
            slope += i * basis[i][1];
        }
        CHECK_NEAR(value, t + 1, 2e-15);
        CHECK_NEAR(slope, 1, 2e-15);
    }
}

static void test_pieces_join_with_two_derivatives(void **state) {
    (void)state;
    double end[4][4], begin[4][4];
    co_bspline_cubic(1, end);
    co_bspline_cubic(0, begin);
    for (int k = 0; k < 3; k++) {
        CHECK_NEAR(end[0][k], 0, 2e-15);
        CHECK_NEAR(begin[3][k], 0, 2e-15);
        for (int i = 0; i < 3; i++)
            CHECK_NEAR(end[i + 1][k], begin[i][k], 2e-15);
    }
    CHECK_NEAR(begin[0][0], 1.0 / 6, 2e-15);
    CHECK_NEAR(begin[1][0], 2.0 / 3, 2e-15);
}

/* Largest error of a central difference of jet entry `from` against entry `to`, over all 16 functions. */
static double difference_error(int from, int to, int along_v, double h) {
    double plus[16][CO_JET], minus[16][CO_JET], at[16][CO_JET], u = 0.37, v = 0.58, worst = 0;
    co_bspline_bicubic(u + (along_v ? 0 : h), v + (along_v ? h : 0), plus);
    co_bspline_bicubic(u - (along_v ? 0 : h), v - (along_v ? h : 0), minus);
    co_bspline_bicubic(u, v, at);
    for (int i = 0; i < 16; i++) {
        double error = fabs((plus[i][from] - minus[i][from]) / (2 * h) - at[i][to]);
        worst = error > worst ? error : worst;
    }
    return (double)worst;
}

/* Central differences of a cubic are off by h^2 f''' / 6 exactly; of what is at most quadratic in the variable, by
 * nothing. */
static void test_every_derivative_is_the_slope_of_the_one_before(void **state) {
    (void)state;
    for (int from = 0; from < 6; from++)
        for (int along_v = 0; along_v < 2; along_v++) {
            int p = co_jet_order_u[from] + !along_v, q = co_jet_order_v[from] + along_v;
            int to = (p + q) * (p + q + 1) / 2 + q;
            CHECK_INT(co_jet_order_u[to], p);
            CHECK_INT(co_jet_order_v[to], q);
            double coarse = difference_error(from, to, along_v, 0.1);
            double fine = difference_error(from, to, along_v, 0.05);
            if ((along_v ? q : p) == 1)
                CHECK_BETWEEN(check_order(coarse, fine), 1.99, 2.01);
            else
                CHECK_NEAR(coarse, 0, 4e-14);
        }
}

/* (f g)(a b) computed as a product of jets and as the jet of (f a)(g b). */
static void test_product_of_jets_follows_leibniz(void **state) {
    (void)state;
    /* polynomials by their derivatives at one place: t^3 and t^2 at 1/2, 1 + t at 1/3 */
    const double cube[4] = {1 / 8.0, 3 / 4.0, 3, 6}, square[4] = {1 / 4.0, 1, 2, 0};
    const double line[4] = {4 / 3.0, 1, 0, 0}, fifth[4] = {1 / 32.0, 5 / 16.0, 5 / 2.0, 15};
    const double line_square[4] = {16 / 9.0, 8 / 3.0, 2, 0};
    double a[CO_JET], b[CO_JET], product[CO_JET], expected[CO_JET];
    co_jet_of_product(cube, line, a);
    co_jet_of_product(square, line, b);
    co_jet_multiply(a, b, product);
    co_jet_of_product(fifth, line_square, expected);
    for (int k = 0; k < CO_JET; k++)
        CHECK_NEAR(product[k], expected[k], 1e-14);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_basis_sums_to_one_and_derivatives_to_zero),
        cmocka_unit_test(test_basis_reproduces_linear_functions),
        cmocka_unit_test(test_pieces_join_with_two_derivatives),
        cmocka_unit_test(test_every_derivative_is_the_slope_of_the_one_before),
        cmocka_unit_test(test_product_of_jets_follows_leibniz),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
