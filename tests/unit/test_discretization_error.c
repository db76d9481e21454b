/* How much of a minimum's energy is the net's: sequences whose limit is known. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#include "check.h"

#include "solve/discretization_error.h"

#include <math.h>

/* Of levels with the energies 1 + ratio^k. */
static double of_ratio(double ratio, int32_t n) {
    curvopt_level_report level[8] = {{0}};
    for (int32_t k = 0; k < n; k++)
        level[k].energy = 1 + pow(ratio, k);
    return co_discretization_error(level, n);
}

static void test_slow_sequences_are_extrapolated_exactly(void **state) {
    (void)state;
    for (int32_t n = 3; n <= 8; n++) {
        CHECK_NEAR(of_ratio(0.7, n), pow(0.7, n - 1), 1e-12);
        CHECK_NEAR(of_ratio(0.85, n), pow(0.85, n - 1), 1e-12);
    }
}

static void test_fast_sequences_and_two_levels_count_as_slow(void **state) {
    (void)state;
    CHECK_NEAR(of_ratio(0.0625, 4), 1.5 * (pow(0.0625, 2) - pow(0.0625, 3)), 1e-15);
    CHECK_NEAR(of_ratio(0.25, 2), 1.5 * 0.75, 1e-15);
}

static void test_a_rise_counts_as_a_fall(void **state) {
    (void)state;
    const curvopt_level_report level[3] = {{.energy = 4}, {.energy = 5}, {.energy = 4.7}};
    CHECK_NEAR(co_discretization_error(level, 3), 0.3 * 1.5, 1e-14);
}

static void test_no_change_is_no_error(void **state) {
    (void)state;
    const curvopt_level_report level[3] = {{.energy = 2}, {.energy = 2}, {.energy = 2}};
    CHECK_NEAR(co_discretization_error(level, 2), 0, 0);
    CHECK_NEAR(co_discretization_error(level, 3), 0, 0);
}

static void test_no_more_than_all_can_go(void **state) {
    (void)state;
    const curvopt_level_report level[2] = {{.energy = 100}, {.energy = 20}};
    CHECK_NEAR(co_discretization_error(level, 2), 20, 0);
}

static void test_nothing_is_known(void **state) {
    (void)state;
    CHECK_TRUE(isnan(of_ratio(0.5, 1)));
    CHECK_TRUE(isnan(of_ratio(0.95, 3)));
    CHECK_TRUE(isnan(of_ratio(1.5, 4)));
    static const int32_t unfinished[] = {CURVOPT_STOP_CANCELLED, CURVOPT_STOP_LIMIT, CURVOPT_STOP_UNRESOLVED};
    for (size_t k = 0; k < 3; k++)
        for (int32_t i = 0; i < 4; i++) { /* of four levels the first does not count */
            curvopt_level_report level[4] = {{.energy = 9}, {.energy = 3}, {.energy = 2}, {.energy = 1.5}};
            level[i].stop = unfinished[k];
            CHECK_INT(isnan(co_discretization_error(level, 4)) != 0, i > 0);
        }
    const curvopt_level_report lost[2] = {{.energy = (double)NAN}, {.energy = 1}};
    CHECK_TRUE(isnan(co_discretization_error(lost, 2)));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_slow_sequences_are_extrapolated_exactly),
        cmocka_unit_test(test_fast_sequences_and_two_levels_count_as_slow),
        cmocka_unit_test(test_a_rise_counts_as_a_fall),
        cmocka_unit_test(test_no_change_is_no_error),
        cmocka_unit_test(test_no_more_than_all_can_go),
        cmocka_unit_test(test_nothing_is_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
