/* Blending weights. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "surface/blend_weight.h"
#include "surface/gauss_legendre.h"

static const co_blend_kind blends[] = {CO_BLEND_SMOOTH, CO_BLEND_POLYNOMIAL};
enum { N_BLENDS = sizeof blends / sizeof *blends };

/* w and three derivatives at t: along u at v = 0, where the other factor is 1 and flat. */
static void weight(co_blend_kind blend, double t, double w[4]) {
    static const int place[4] = {0, 1, 3, 6};
    double jet[CO_JET];
    co_blend_weight(blend, t, 0, jet);
    for (int k = 0; k < 4; k++)
        w[k] = jet[place[k]];
}

static double h_of(double t) {
    return exp(2 * exp(-1 / t) / (t - 1));
}

static void test_smooth_weight_is_the_reports_formula(void **state) {
    (void)state;
    for (int n = 1; n < 20; n++) {
        double t = n / 20.0, w[4];
        weight(CO_BLEND_SMOOTH, t, w);
        CHECK_NEAR(w[0], h_of(t) / (h_of(t) + h_of(1 - t)), 4e-16);
    }
}

/* The polynomial is the one whose slope is -140 t^3 (1 - t)^3; a rule of 4 points integrates degree 6 exactly. */
static void test_polynomial_weight_is_the_integral_of_its_slope(void **state) {
    (void)state;
    double node[4], part[4];
    co_gauss_legendre(4, node, part);
    for (int n = 0; n <= 10; n++) {
        double t = n / 10.0, w[4], integral = 0;
        for (int i = 0; i < 4; i++)
            integral += part[i] * t * 140 * pow(node[i] * t, 3) * pow(1 - node[i] * t, 3);
        weight(CO_BLEND_POLYNOMIAL, t, w);
        CHECK_NEAR(w[0], 1 - integral, 1e-14);
        CHECK_NEAR(w[1], -140 * t * t * t * (1 - t) * (1 - t) * (1 - t), 1e-14);
    }
}

static void test_weights_of_both_ends_add_up_to_one(void **state) {
    (void)state;
    for (int b = 0; b < N_BLENDS; b++)
        for (int n = 0; n <= 50; n++) {
            double w[4], mirrored[4];
            weight(blends[b], n / 50.0, w);
            weight(blends[b], 1 - n / 50.0, mirrored);
            CHECK_NEAR(w[0] + mirrored[0], 1, 1e-14);
            CHECK_NEAR(w[1], mirrored[1], 1e-15);
            CHECK_NEAR(w[2], -mirrored[2], 1e-13);
            CHECK_NEAR(w[3], mirrored[3], 1e-11);
            CHECK_TRUE(w[1] <= 0);
        }
}

/* Derivative k + 1 at t from differences of derivative k at h. */
static double difference_error(co_blend_kind blend, int k, double t, double h) {
    double plus[4], minus[4], at[4];
    weight(blend, t + h, plus);
    weight(blend, t - h, minus);
    weight(blend, t, at);
    return fabs((double)((plus[k] - minus[k]) / (2 * h) - at[k + 1]));
}

static void test_derivatives_are_slopes(void **state) {
    (void)state;
    static const double places[] = {0.15, 0.31, 0.44, 0.56, 0.73, 0.88};
    for (int b = 0; b < N_BLENDS; b++)
        for (int k = 0; k < 3; k++)
            for (int n = 0; n < 6; n++) {
                double coarse = difference_error(blends[b], k, places[n], 2e-4);
                double fine = difference_error(blends[b], k, places[n], 1e-4);
                CHECK_BETWEEN(check_order(coarse, fine), 1.99, 2.01);
            }
}

static void test_ends_are_flat(void **state) {
    (void)state;
    for (int b = 0; b < N_BLENDS; b++) {
        double begin[4], end[4];
        weight(blends[b], 0, begin);
        weight(blends[b], 1, end);
        CHECK_NEAR(begin[0], 1, 0);
        CHECK_NEAR(end[0], 0, 0);
        for (int k = 1; k < 4; k++) {
            CHECK_NEAR(begin[k], 0, 0);
            CHECK_NEAR(end[k], 0, 0);
        }
    }
}

/* Close to an end the smooth weight is set to its limit: there must be no jump where that begins. */
static void test_smooth_weight_has_no_jump_near_its_ends(void **state) {
    (void)state;
    for (int side = 0; side < 2; side++) {
        double w[4], t = side ? 1 - 0.00501 : 0.00501;
        weight(CO_BLEND_SMOOTH, t, w);
        CHECK_NEAR(w[0], !side, 4e-16);
        for (int k = 1; k < 4; k++)
            CHECK_NEAR(w[k], 0, 1e-18);
    }
}

static void test_jet_is_the_product_of_both_directions(void **state) {
    (void)state;
    for (int b = 0; b < N_BLENDS; b++) {
        double along_u[4], along_v[4], jet[CO_JET];
        weight(blends[b], 0.3, along_u);
        weight(blends[b], 0.6, along_v);
        co_blend_weight(blends[b], 0.3, 0.6, jet);
        for (int k = 0; k < CO_JET; k++)
            CHECK_NEAR(jet[k], along_u[co_jet_order_u[k]] * along_v[co_jet_order_v[k]], 1e-15);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_smooth_weight_is_the_reports_formula),
        cmocka_unit_test(test_polynomial_weight_is_the_integral_of_its_slope),
        cmocka_unit_test(test_weights_of_both_ends_add_up_to_one),
        cmocka_unit_test(test_derivatives_are_slopes),
        cmocka_unit_test(test_ends_are_flat),
        cmocka_unit_test(test_smooth_weight_has_no_jump_near_its_ends),
        cmocka_unit_test(test_jet_is_the_product_of_both_directions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
