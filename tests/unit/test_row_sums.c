/* Weighted sums of rows, by all instruction sets that run here, against a plain loop: the same bits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "hessian/row_sums.h"

enum { ROWS = 7, LONGEST = 110, TERMS = 5 };

static double rows[ROWS * LONGEST], expected[LONGEST], got[LONGEST + 1];

/* In the order of the terms, from 0 on. */
static void sum_plainly(const co_row_sum *s, size_t length) {
    for (size_t i = 0; i < length; i++) {
        expected[i] = 0;
        for (size_t e = 0; e < s->n; e++)
            if (s->row[s->point[e]] >= 0)
                expected[i] += s->weight[e] * rows[(size_t)s->row[s->point[e]] * length + i];
    }
}

static void check_set(const co_row_sums *set, const co_row_sum *s, size_t length) {
    sum_plainly(s, length);
    for (size_t i = 0; i <= length; i++)
        got[i] = -7;
    set->add_up(s, length, rows, got);
    CHECK_TRUE(memcmp(got, expected, length * sizeof *got) == 0);
    CHECK_NEAR(got[length], -7, 0); /* what comes after stays */
}

/* Every length from the least on, with points that have no row first, last and between. */
static void test_bits(void **state) {
    const double weight[TERMS] = {0.3, -1.7, 1, 0.0625, -0.1};
    const int32_t point[TERMS] = {2, 0, 3, 1, 2}, row[][4] = {{4, 0, 6, 1}, {-1, 2, 3, 5}, {0, -1, -1, 6}};
    (void)state;
    for (int i = 0; i < ROWS * LONGEST; i++)
        rows[i] = sin(1.3 * i) / (1 + i % 5);
    for (int set = 0; set < CO_N_INSTRUCTION_SETS; set++) {
        const co_row_sums *sums = co_row_sums_of((co_instruction_set)set);
        for (size_t k = 0; k < sizeof row / sizeof *row && co_has_instruction_set((co_instruction_set)set); k++)
            for (size_t length = CO_LEAST_ROW; length <= LONGEST; length++)
                for (size_t n = 0; n <= TERMS; n++)
                    check_set(sums, &(co_row_sum){n, weight, point, row[k]}, length);
    }
    CHECK_TRUE(co_row_sums_of(co_best_instruction_set()) != NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bits)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
