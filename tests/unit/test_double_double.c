/* Double-double arithmetic against exact integers: bounds from theory. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "base/double_double.h"

/* Numbers of 53 bits, or of `bits`, as integers: sums and products of 62 bits at most are exact in int64_t. */
static int64_t integer(uint64_t *seed, int bits) {
    return (int64_t)(check_random(seed) * (double)((int64_t)1 << bits));
}

/* The number, an integer below 2^63. */
static int64_t value_of(co_double_double a) {
    return (int64_t)a.high + (int64_t)a.low;
}

static co_double_double of_integer(int64_t i) {
    const double high = (double)i;
    return co_double_double_quick_sum(high, (double)(i - (int64_t)high));
}

static void test_sums_and_products_of_doubles_are_exact(void **state) {
    (void)state;
    uint64_t seed = 3;
    for (int n = 0; n < 10000; n++) {
        const int64_t a = integer(&seed, 31), b = integer(&seed, 31), large = integer(&seed, 52) * 512;
        CHECK_TRUE(value_of(co_double_double_two_product((double)a, (double)b)) == a * b);
        CHECK_TRUE(value_of(co_double_double_two_sum((double)large, (double)b)) == large + b);
        CHECK_TRUE(value_of(co_double_double_two_sum((double)b, (double)large)) == large + b);
        CHECK_TRUE(value_of(co_double_double_add_product(of_integer(large), (double)a, (double)b / 2)) * 2 ==
                       2 * large + a * b ||
                   b % 2);
    }
}

/* 2^53 + 1 times itself is 2^106 + 2^54 + 1: what Dekker's splitting is for. */
static void test_product_of_long_factors(void **state) {
    (void)state;
    const double a = 0x1p52 + 1;
    const co_double_double square = co_double_double_two_product(a, a);
    CHECK_TRUE(square.high == 0x1p104 + 0x1p53 && square.low == 1);
}

/* The error of `back` beside a, relative. */
static double error_of(co_double_double back, co_double_double a) {
    const co_double_double off = co_double_double_add(back, co_double_double_negative(a));
    return fabs(off.high / a.high);
}

static void test_quotients_and_roots_are_inverses(void **state) {
    (void)state;
    uint64_t seed = 4;
    for (int n = 0; n < 10000; n++) {
        const co_double_double a =
            co_double_double_quick_sum(1 + fabs(check_random(&seed)), 0x1p-55 * check_random(&seed));
        const co_double_double b = co_double_double_quick_sum(3 + check_random(&seed), 0x1p-54 * check_random(&seed));
        const co_double_double root = co_double_double_sqrt(a), quotient = co_double_double_divide(a, b);
        CHECK_BETWEEN(error_of(co_double_double_multiply(root, root), a), 0, 0x1p-101);
        CHECK_BETWEEN(error_of(co_double_double_multiply(quotient, b), a), 0, 0x1p-101);
    }
}

static void test_small_parts_survive(void **state) {
    (void)state;
    const co_double_double sum = co_double_double_add((co_double_double){1, 0x1p-80}, (co_double_double){-1, 0x1p-90});
    CHECK_TRUE(sum.high == 0x1p-80 + 0x1p-90 && sum.low == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sums_and_products_of_doubles_are_exact),
        cmocka_unit_test(test_product_of_long_factors),
        cmocka_unit_test(test_quotients_and_roots_are_inverses),
        cmocka_unit_test(test_small_parts_survive),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
