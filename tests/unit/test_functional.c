/* Energies as weights over a few invariants. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "energy/functional.h"

static int is_third(int term) {
    return term >= CURVOPT_TERM_MVS && term <= CURVOPT_TERM_MEHLUM_TARROU;
}

static void random_integrals(uint64_t *seed, double *integral) {
    for (int i = 0; i < CO_N_INTEGRALS; i++)
        integral[i] = 2 + check_random(seed);
}

static void test_cross_is_a_combination_of_variation_and_mvs(void **state) {
    (void)state;
    uint64_t seed = 3;
    for (int n = 0; n < 20; n++) {
        double integral[CO_N_INTEGRALS], term[8];
        random_integrals(&seed, integral);
        co_functional_terms(integral, 1, term);
        CHECK_NEAR(3 * term[CURVOPT_TERM_MVS_CROSS], term[CURVOPT_TERM_VARIATION] + 2 * term[CURVOPT_TERM_MVS], 1e-13);
    }
}

/* Integrals of a surface of area 1 with h = diag(k1, k2), k1 > k2, and C everywhere. */
static void integrals_of(const double C[4], double *integral) {
    double A1 = 0.75 * (C[0] + C[2]), B1 = 0.75 * (C[1] + C[3]);
    double A3 = 0.25 * C[0] - 0.75 * C[2], B3 = 0.75 * C[1] - 0.25 * C[3];
    integral[CO_INT_AREA] = 1;
    integral[CO_INT_H2] = integral[CO_INT_K] = 0;
    integral[CO_INT_F1] = A1 * A1 + B1 * B1;
    integral[CO_INT_F3] = A3 * A3 + B3 * B3;
    integral[CO_INT_X] = A1 * A3 - B1 * B3; /* Re(F1 F3), q real */
}

/* h cos(k s) on a plane, one wave: what a term's definition gives, with u'' and u''' alone. */
static void test_a_wave_on_a_plane(void **state) {
    (void)state;
    static const double density[CURVOPT_N_TERMS][3] = {/* of k^2, k^4 and area k^6 */
                                                       [CURVOPT_TERM_WILLMORE] = {0, 1, 0},
                                                       [CURVOPT_TERM_MVS] = {0, 0, 1},
                                                       [CURVOPT_TERM_MVS_CROSS] = {0, 0, 1},
                                                       [CURVOPT_TERM_VARIATION] = {0, 0, 1},
                                                       [CURVOPT_TERM_MEHLUM_TARROU] = {0, 0, 0.625},
                                                       [CURVOPT_TERM_AREA] = {0.5, 0, 0},
                                                       [CURVOPT_TERM_MEAN] = {0, 0.25, 0}};
    for (int t = 0; t < CURVOPT_N_TERMS; t++) {
        double weights[CURVOPT_MAX_TERMS] = {[CURVOPT_TERM_WILLMORE] = 0};
        weights[t] = 3;
        const co_functional f = co_functional_of_weights(weights);
        for (double k = 0.5; k < 3; k++) {
            double wanted = density[t][0] * k * k + density[t][1] * pow(k, 4) + 7 * density[t][2] * pow(k, 6);
            CHECK_NEAR(co_functional_of_wave(&f, k, 7), 3 * wanted, 1e-12 * (1 + wanted));
        }
    }
}

/* In the principal frame dk1/de1 = C111, grad k1 = (C111, C112), dk2/de2 = C222, grad k2 = (C122, C222). */
static void test_terms_are_their_definitions_in_the_principal_frame(void **state) {
    (void)state;
    uint64_t seed = 17;
    for (int n = 0; n < 20; n++) {
        double C[4], integral[CO_N_INTEGRALS], term[8], mean = 0;
        for (int i = 0; i < 4; i++)
            C[i] = check_random(&seed);
        integrals_of(C, integral);
        co_functional_terms(integral, 1, term);
        for (int i = 0; i < 8; i++) { /* the mean of kappa'(theta)^2 twice; 8 directions integrate degree 6 exactly */
            double c = cos(i * 0.78539816339744831), s = sin(i * 0.78539816339744831);
            double slope = C[0] * c * c * c + 3 * C[1] * c * c * s + 3 * C[2] * c * s * s + C[3] * s * s * s;
            mean += 2 * slope * slope / 8;
        }
        CHECK_NEAR(term[CURVOPT_TERM_MVS], C[0] * C[0] + C[3] * C[3], 1e-14);
        CHECK_NEAR(term[CURVOPT_TERM_MVS_CROSS], C[0] * C[0] + C[1] * C[1] + C[2] * C[2] + C[3] * C[3], 1e-14);
        CHECK_NEAR(term[CURVOPT_TERM_VARIATION], C[0] * C[0] + 3 * C[1] * C[1] + 3 * C[2] * C[2] + C[3] * C[3], 1e-14);
        CHECK_NEAR(term[CURVOPT_TERM_MEHLUM_TARROU], mean, 1e-14);
    }
}

static void test_third_order_terms_carry_the_area_and_willmore_does_not(void **state) {
    (void)state;
    uint64_t seed = 5;
    double integral[CO_N_INTEGRALS], term[8], doubled[8];
    random_integrals(&seed, integral);
    co_functional_terms(integral, 1, term);
    integral[CO_INT_AREA] *= 2;
    co_functional_terms(integral, 1, doubled);
    CHECK_NEAR(term[CURVOPT_TERM_WILLMORE], integral[CO_INT_H2], 0);
    CHECK_NEAR(doubled[CURVOPT_TERM_WILLMORE], term[CURVOPT_TERM_WILLMORE], 0);
    CHECK_NEAR(doubled[CURVOPT_TERM_AREA], integral[CO_INT_AREA], 0);
    for (int t = CURVOPT_TERM_MVS; t <= CURVOPT_TERM_MEHLUM_TARROU; t++)
        CHECK_NEAR(doubled[t], 2 * term[t], 1e-14);
}

static void test_terms_that_do_not_exist_are_nan(void **state) {
    (void)state;
    double integral[CO_N_INTEGRALS] = {1, 2, 3, 4, 5, 6}, term[8];
    co_functional_terms(integral, 0, term);
    CHECK_NEAR(term[CURVOPT_TERM_WILLMORE], 2, 0);
    for (int t = 0; t < 8; t++)
        CHECK_INT(isnan(term[t]) != 0, is_third(t) || t >= CURVOPT_N_TERMS);
    co_functional_terms(integral, 1, term);
    for (int t = 0; t < 8; t++)
        CHECK_INT(isnan(term[t]) != 0, t >= CURVOPT_N_TERMS);
}

static void test_third_order_terms_are_those_with_derivatives_of_curvature(void **state) {
    (void)state;
    for (int t = 0; t < CURVOPT_N_TERMS; t++) {
        double weights[CURVOPT_N_TERMS] = {0};
        weights[t] = 1;
        co_functional f = co_functional_of_weights(weights);
        CHECK_INT(co_functional_is_third_order(t), is_third(t));
        CHECK_INT(f.has_third, is_third(t));
        CHECK_INT(f.has_second, !is_third(t));
    }
    CHECK_NEAR(co_functional_eps4(1), 1.6e-7, 1e-22);
}

static void test_value_is_the_weighted_sum_of_terms(void **state) {
    (void)state;
    uint64_t seed = 29;
    for (int n = 0; n < 1 << CURVOPT_N_TERMS; n++) {
        double integral[CO_N_INTEGRALS], term[8], weights[CURVOPT_N_TERMS], sum = 0;
        random_integrals(&seed, integral);
        co_functional_terms(integral, 1, term);
        for (int t = 0; t < CURVOPT_N_TERMS; t++) {
            weights[t] = n >> t & 1 ? 1 + check_random(&seed) / 2 : 0;
            sum += weights[t] * term[t];
        }
        co_functional f = co_functional_of_weights(weights);
        CHECK_NEAR(co_functional_value(&f, integral), sum, 1e-13);
        CHECK_INT(f.has_second,
                  (n & (1 << CURVOPT_TERM_WILLMORE | 1 << CURVOPT_TERM_AREA | 1 << CURVOPT_TERM_MEAN)) != 0);
        CHECK_INT(f.has_third, (n & 30) != 0); /* terms 1 to 4 */
    }
}

/* The weights of an integrand and the integrals that they belong to, one by one: no other one counts. */
static void test_an_integrand_takes_each_integral_by_its_weight(void **state) {
    (void)state;
    static const int which[] = {CO_INT_AREA, CO_INT_H2, CO_INT_K,    CO_INT_F1,
                                CO_INT_F3,   CO_INT_X,  CO_INT_MEAN, CO_INT_VOLUME};
    for (int i = 0; i < 8; i++) {
        co_integrand w = {0}, sum = {.area = 1, .h2 = 1, .gauss = 1, .f1 = 1, .f3 = 1, .x = 1, .mean = 1, .volume = 1};
        double *const weight[] = {&w.area, &w.h2, &w.gauss, &w.f1, &w.f3, &w.x, &w.mean, &w.volume};
        double integral[CO_N_INTEGRALS] = {0}, all = 0;
        for (int k = 0; k < 8; k++) {
            integral[which[k]] = 2 + k;
            all += 2 + k;
        }
        *weight[i] = 3;
        CHECK_NEAR(co_functional_integrate(&w, integral), 3 * (2 + i), 1e-14);
        co_integrand_add(&sum, 0.5, &w);
        CHECK_NEAR(co_functional_integrate(&sum, integral), all + 1.5 * (2 + i), 1e-14);
    }
}

/* A term that is not wanted may be NAN: it must not spoil the objective. */
static void test_unwanted_integrals_do_not_matter(void **state) {
    (void)state;
    double integral[CO_N_INTEGRALS] = {2, 3, 1, (double)NAN, (double)NAN, (double)NAN};
    static const double willmore[CURVOPT_N_TERMS] = {0.5};
    co_functional f = co_functional_of_weights(willmore);
    CHECK_NEAR(f.second.h2, 0.5, 0);
    CHECK_INT(f.has_third, 0);
    integral[CO_INT_F1] = integral[CO_INT_F3] = integral[CO_INT_X] = 0;
    CHECK_NEAR(co_functional_value(&f, integral), 1.5, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_wave_on_a_plane),
        cmocka_unit_test(test_cross_is_a_combination_of_variation_and_mvs),
        cmocka_unit_test(test_terms_are_their_definitions_in_the_principal_frame),
        cmocka_unit_test(test_third_order_terms_carry_the_area_and_willmore_does_not),
        cmocka_unit_test(test_terms_that_do_not_exist_are_nan),
        cmocka_unit_test(test_third_order_terms_are_those_with_derivatives_of_curvature),
        cmocka_unit_test(test_value_is_the_weighted_sum_of_terms),
        cmocka_unit_test(test_an_integrand_takes_each_integral_by_its_weight),
        cmocka_unit_test(test_unwanted_integrals_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
