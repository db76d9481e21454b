/* Numbers of a surface that are held, and spontaneous curvature, which is a function of them: values by closed forms,
 * derivatives against differences, and that nothing depends on the size that integrals are of. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#include "check.h"
#include "energy/spontaneous_curvature.h"

enum { N_MEASURES = 4 };

static const int MEASURES[N_MEASURES] = {-1, CURVOPT_SCALAR_VOLUME, CURVOPT_SCALAR_AREA, CURVOPT_SCALAR_MEAN_CURVATURE};
static const co_integral INTEGRAL[CURVOPT_N_SCALARS] = {[CURVOPT_SCALAR_VOLUME] = CO_INT_VOLUME,
                                                        [CURVOPT_SCALAR_AREA] = CO_INT_AREA,
                                                        [CURVOPT_SCALAR_MEAN_CURVATURE] = CO_INT_MEAN};
static const int DEGREE[CURVOPT_N_SCALARS] = {
    [CURVOPT_SCALAR_VOLUME] = 3, [CURVOPT_SCALAR_AREA] = 2, [CURVOPT_SCALAR_MEAN_CURVATURE] = 1};

/* Numbers of some surface of this size, its normals outwards or, with -1, inwards. */
static void integrals_of(double size, double orientation, double *integral) {
    memset(integral, 0, CO_N_INTEGRALS * sizeof *integral);
    integral[CO_INT_AREA] = 7 * size * size;
    integral[CO_INT_VOLUME] = 1.1 * orientation * size * size * size;
    integral[CO_INT_MEAN] = 9 * orientation * size;
}

/* A function of the numbers. */
typedef co_held_residual (*number_fn)(const void *of, const double *integral);

/* Slopes and second derivatives against differences of fourth order. */
static void check_derivatives(number_fn f, const void *of, const double *at) {
    static const double step[4] = {-2, -1, 1, 2}, weight[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
    const co_held_residual got = f(of, at);
    for (int s = 0; s < CURVOPT_N_SCALARS; s++) {
        double slope = 0, second[CURVOPT_N_SCALARS] = {0}, integral[CO_N_INTEGRALS];
        for (int k = 0; k < 4; k++) {
            memcpy(integral, at, sizeof integral);
            integral[INTEGRAL[s]] += 1e-3 * step[k];
            const co_held_residual beside = f(of, integral);
            slope += weight[k] * beside.value / 1e-3;
            for (int t = 0; t < CURVOPT_N_SCALARS; t++)
                second[t] += weight[k] * beside.slope[t] / 1e-3;
        }
        CHECK_NEAR(got.slope[s], slope, 1e-9 * (1 + fabs(slope)));
        for (int t = 0; t < CURVOPT_N_SCALARS; t++)
            CHECK_NEAR(got.second[s][t], second[t], 1e-9 * (1 + fabs(second[t])));
    }
}

static co_held_residual residual(const void *of, const double *integral) {
    return co_held_numbers_residual(of, 0, integral);
}

/* Every number by every measure: (number / measure^(degrees' ratio) - target) / unit. */
static void test_numbers_over_lengths(void **state) {
    (void)state;
    double integral[CO_N_INTEGRALS];
    for (int s = 0; s < CURVOPT_N_SCALARS; s++)
        for (int m = 0; m < N_MEASURES; m++)
            for (double orientation = -1; orientation <= 1; orientation += 2) {
                const int by = MEASURES[m];
                const co_held_numbers one = {.n = 1,
                                             .orientation = orientation,
                                             .held = {{.scalar = s, .measure = by, .target = 0.3, .unit = 1.7}}};
                if (by == s)
                    continue;
                integrals_of(1, orientation, integral);
                const double number = fabs(integral[INTEGRAL[s]]),
                             length = by < 0 ? 1 : pow(fabs(integral[INTEGRAL[by]]), 1.0 / DEGREE[by]);
                CHECK_NEAR(residual(&one, integral).value, (number / pow(length, DEGREE[s]) - 0.3) / 1.7, 1e-13);
                check_derivatives(residual, &one, integral);
                CHECK_INT(co_held_numbers_degree(s), DEGREE[s]);
                CHECK_INT(co_held_numbers_has_mean(&one),
                          s == CURVOPT_SCALAR_MEAN_CURVATURE || by == CURVOPT_SCALAR_MEAN_CURVATURE);
            }
}

static void test_a_measure_that_is_not_positive(void **state) {
    (void)state;
    const co_held_numbers one = {
        .n = 1,
        .orientation = 1,
        .held = {{.scalar = CURVOPT_SCALAR_AREA, .measure = CURVOPT_SCALAR_VOLUME, .target = 1, .unit = 1}}};
    double integral[CO_N_INTEGRALS];
    integrals_of(1, 1, integral);
    CHECK_TRUE(isfinite(residual(&one, integral).value));
    integral[CO_INT_VOLUME] = 0;
    CHECK_TRUE(isnan(residual(&one, integral).value));
    integral[CO_INT_VOLUME] = -1;
    CHECK_TRUE(isnan(residual(&one, integral).value));
}

static co_held_residual added(const void *of, const double *integral) {
    return co_spontaneous_curvature_add(of, 1, integral).added;
}

/* w (-c0 M + c0^2 A / 4) of the surface scaled to where its measure is length^degree; w is 4 for Willmore's energy. */
static void test_spontaneous_curvature_is_of_numbers(void **state) {
    (void)state;
    const double c0 = 0.7, length = 1.3;
    double weights[CURVOPT_MAX_TERMS] = {0}, integral[CO_N_INTEGRALS];
    weights[CURVOPT_TERM_WILLMORE] = 2;
    weights[CURVOPT_TERM_MEAN] = 3;
    CHECK_TRUE(co_spontaneous_curvature_is_seen(weights));
    for (int m = 0; m < N_MEASURES; m++)
        for (double orientation = -1; orientation <= 1; orientation += 2) {
            co_spontaneous_curvature s = co_spontaneous_curvature_of(weights, c0);
            CHECK_NEAR(s.weight, 11, 0);
            s.orientation = orientation;
            s.measure = MEASURES[m];
            s.length = length;
            integrals_of(1, orientation, integral);
            const double scale =
                s.measure < 0 ? length : length / pow(fabs(integral[INTEGRAL[s.measure]]), 1.0 / DEGREE[s.measure]);
            const double mean = fabs(integral[CO_INT_MEAN]) * scale, area = integral[CO_INT_AREA] * scale * scale;
            CHECK_NEAR(added(&s, integral).value, 11 * (-c0 * mean + c0 * c0 / 4 * area), 1e-11);
            check_derivatives(added, &s, integral);
        }
}

/* The integrands that are added have the slopes as factors; what they say of scaling is a difference's, and nothing
 * where lengths are measured. */
static void test_integrands_are_the_slopes(void **state) {
    (void)state;
    double weights[CURVOPT_MAX_TERMS] = {0}, integral[CO_N_INTEGRALS], beside[CO_N_INTEGRALS];
    weights[CURVOPT_TERM_WILLMORE] = 1;
    for (int m = 0; m < N_MEASURES; m++) {
        co_spontaneous_curvature s = co_spontaneous_curvature_of(weights, -1.2);
        co_integrand integrand = {0};
        double change = 0;
        s.orientation = 1;
        s.measure = MEASURES[m];
        integrals_of(1, 1, integral);
        const double scaling = co_spontaneous_curvature_add_integrands(&s, 1, integral, &integrand);
        const co_held_residual whole = added(&s, integral);
        CHECK_NEAR(integrand.volume, whole.slope[CURVOPT_SCALAR_VOLUME], 1e-14);
        CHECK_NEAR(integrand.area, whole.slope[CURVOPT_SCALAR_AREA], 1e-14);
        CHECK_NEAR(integrand.mean, whole.slope[CURVOPT_SCALAR_MEAN_CURVATURE], 1e-14);
        for (int k = -1; k <= 1; k += 2) {
            integrals_of(1 + k * 1e-4, 1, beside);
            change += k * added(&s, beside).value / 2e-4;
        }
        CHECK_NEAR(scaling, change, 1e-5);
        CHECK_TRUE(m == 0 ? fabs(scaling) > 1 : fabs(scaling) < 1e-12);
    }
}

/* Without other words lengths are what they are: of a surface that was divided by its radius times that, and the sign
 * of the volume says which way normals point. */
static void test_lengths_are_as_they_are_at_first(void **state) {
    (void)state;
    double weights[CURVOPT_MAX_TERMS] = {0}, whole[CO_N_INTEGRALS], unit[CO_N_INTEGRALS];
    weights[CURVOPT_TERM_WILLMORE] = 1;
    for (double orientation = -1; orientation <= 1; orientation += 2) {
        const co_spontaneous_curvature s = co_spontaneous_curvature_of(weights, 0.4);
        integrals_of(2.5, orientation, whole);
        integrals_of(1, orientation, unit);
        const double wanted = 4 * (-0.4 * fabs(whole[CO_INT_MEAN]) + 0.04 * whole[CO_INT_AREA]);
        const co_spontaneous_part part = co_spontaneous_curvature_add(&s, 2.5, unit);
        CHECK_NEAR(part.added.value, wanted, 1e-12);
        CHECK_NEAR(co_spontaneous_curvature_add(&s, 1, whole).added.value, wanted, 1e-12);
        CHECK_NEAR(part.reference, 2 * 4 * 0.04 * whole[CO_INT_AREA], 1e-12); /* (m - 1) c0^2 A, m = 3 */
    }
}

/* With the reference what Cauchy's inequality says: (m c0^2 - c0^2) w A / 4 and the rest is no less than 0 for any M
 * with M^2 <= A int H^2; the area may be one that the run says. */
static void test_the_reference(void **state) {
    (void)state;
    double weights[CURVOPT_MAX_TERMS] = {0};
    weights[CURVOPT_TERM_MEAN] = 1;
    co_spontaneous_curvature s = co_spontaneous_curvature_of(weights, -3);
    CHECK_NEAR(co_spontaneous_curvature_reference(&s, 5), 2 * 9.0 / 4 * 5, 1e-13);
    s.area = 2;
    CHECK_NEAR(co_spontaneous_curvature_reference(&s, 5), 2 * 9.0 / 4 * 2, 1e-13);
    s.curvature = 0;
    CHECK_NEAR(co_spontaneous_curvature_reference(&s, 5), 0, 0);
    weights[CURVOPT_TERM_MEAN] = 0;
    CHECK_TRUE(!co_spontaneous_curvature_is_seen(weights));
    weights[CURVOPT_TERM_WILLMORE] = 1;
    CHECK_TRUE(co_spontaneous_curvature_is_seen(weights));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers_over_lengths),
        cmocka_unit_test(test_a_measure_that_is_not_positive),
        cmocka_unit_test(test_spontaneous_curvature_is_of_numbers),
        cmocka_unit_test(test_integrands_are_the_slopes),
        cmocka_unit_test(test_lengths_are_as_they_are_at_first),
        cmocka_unit_test(test_the_reference),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
