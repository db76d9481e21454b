/* Double-double arithmetic: a number as the sum of two doubles, 106 bits. It needs IEEE doubles that are rounded to
 * nearest, and nothing else of a platform: `long double` has 64 bits on x86, 113 on some others, and 53 on the rest.
 *
 * Sums: Knuth, "The art of computer programming", volume 2, 1969, section 4.2.2, theorem B. Products: Dekker, "A
 * floating-point technique for extending the available precision", 1971, or one fused multiply-add where that is an
 * instruction; both give the same bits. Bounds: Joldes, Muller, Popescu, "Tight and rigorous error bounds for basic
 * building blocks of double-word arithmetic", 2017, algorithms 6 and 10: with u = 2^-53 the relative errors of a sum
 * and a product are at most 3 u^2 + 13 u^3 and 7 u^2; ours of a quotient and a root are below 2^-102
 * (test_double_double.c).
 *
 * Users are compiled with -ffp-contract=off. Numbers must stay below 2^996, and products above 2^-969.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_DOUBLE_DOUBLE_H
#define CO_BASE_DOUBLE_DOUBLE_H

#include <float.h>
#include <math.h>

#if FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 1
#error "double-double arithmetic needs doubles that are rounded to double; on 32-bit x86: -msse2 -mfpmath=sse"
#endif
#ifdef __FAST_MATH__
#error "double-double arithmetic cannot do with -ffast-math"
#endif

/* high is the sum rounded to double. */
typedef struct co_double_double {
    double high, low;
} co_double_double;

/* a + b exactly; |a| >= |b|, or a = 0. */
static inline co_double_double co_double_double_quick_sum(double a, double b) {
    const double sum = a + b;
    return (co_double_double){sum, b - (sum - a)};
}

/* a + b exactly. */
static inline co_double_double co_double_double_two_sum(double a, double b) {
    const double sum = a + b, of_b = sum - a, of_a = sum - of_b;
    return (co_double_double){sum, (a - of_a) + (b - of_b)};
}

/* a b exactly. */
static inline co_double_double co_double_double_two_product(double a, double b) {
    const double product = a * b;
#ifdef __FP_FAST_FMA
    return (co_double_double){product, fma(a, b, -product)};
#else
    const double splitter = 0x1p27 + 1, big_a = splitter * a, big_b = splitter * b;
    const double a1 = big_a - (big_a - a), a2 = a - a1, b1 = big_b - (big_b - b), b2 = b - b1;
    return (co_double_double){product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2};
#endif
}

static inline co_double_double co_double_double_add(co_double_double a, co_double_double b) {
    const co_double_double high = co_double_double_two_sum(a.high, b.high);
    const co_double_double low = co_double_double_two_sum(a.low, b.low);
    const co_double_double sum = co_double_double_quick_sum(high.high, high.low + low.high);
    return co_double_double_quick_sum(sum.high, low.low + sum.low);
}

static inline co_double_double co_double_double_negative(co_double_double a) {
    return (co_double_double){-a.high, -a.low};
}

static inline co_double_double co_double_double_multiply(co_double_double a, co_double_double b) {
    const co_double_double product = co_double_double_two_product(a.high, b.high);
    return co_double_double_quick_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
}

/* sum + a b for doubles a and b: what it adds to the error of the sum is 2 u^2 of the larger of both at most. */
static inline co_double_double co_double_double_add_product(co_double_double sum, double a, double b) {
    const co_double_double product = co_double_double_two_product(a, b);
    const co_double_double high = co_double_double_two_sum(sum.high, product.high);
    return co_double_double_quick_sum(high.high, high.low + (sum.low + product.low));
}

/* a - b c. */
static inline co_double_double co_double_double_subtract_product(co_double_double a, co_double_double b,
                                                                 co_double_double c) {
    return co_double_double_add(a, co_double_double_multiply(co_double_double_negative(b), c));
}

/* Long division. */
static inline co_double_double co_double_double_divide(co_double_double a, co_double_double b) {
    const double first = a.high / b.high;
    const co_double_double rest = co_double_double_subtract_product(a, b, (co_double_double){first, 0});
    return co_double_double_quick_sum(first, rest.high / b.high);
}

/* One step of Newton's method from the square root in double; a > 0. */
static inline co_double_double co_double_double_sqrt(co_double_double a) {
    const double first = sqrt(a.high);
    const co_double_double root = {first, 0}, rest = co_double_double_subtract_product(a, root, root);
    return co_double_double_quick_sum(first, rest.high / (2 * first));
}

#endif
