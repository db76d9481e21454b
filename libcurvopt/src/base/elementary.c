/* Elementary functions: arguments are reduced exactly or nearly so, and Taylor's series does the rest (Muller,
 * "Elementary functions", 3rd ed., 2016, chapters 3 and 11). SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/elementary.h"

#include "base/constants.h"

#include <math.h>
#include <stdlib.h>

/* x / 1! - x^3 / 3! + ..: sine, up to pi / 4 */
static double sine(double x) {
    double square = x * x, sum = 0;
    for (int k = 17; k > 1; k -= 2)
        sum = (1 + sum) * -square / (k * (k - 1));
    return x + x * sum;
}

/* 1 - x^2 / 2! + ..: cosine, up to pi / 4 */
static double cosine(double x) {
    double square = x * x, sum = 0;
    for (int k = 18; k > 0; k -= 2)
        sum = (1 + sum) * -square / (k * (k - 1));
    return 1 + sum;
}

/* sin(pi (x + quarters / 2)) */
static double wave(double x, int quarters) {
    double halves = floor(2 * x + 0.5), rest = CO_PI * (x - halves / 2); /* the difference is exact */
    switch (((int)fmod(halves, 4) + quarters + 4) % 4) {
    case 0:
        return sine(rest);
    case 1:
        return cosine(rest);
    case 2:
        return -sine(rest);
    default:
        return -cosine(rest);
    }
}

double co_cos_pi(double x) {
    return wave(x, 1);
}

double co_sin_pi(double x) {
    return wave(x, 0);
}

/* atan(t) / pi for 0 <= t <= 1: the angle is halved twice, then x - x^3 / 3 + .. */
static double arc_over_pi(double t) {
    double square, sum = 0;
    for (int halving = 0; halving < 2; halving++)
        t = t / (1 + sqrt(1 + t * t));
    square = t * t;
    for (int k = 23; k > 1; k -= 2)
        sum = -square * (1.0 / k + sum);
    return 4 * (t + t * sum) / CO_PI;
}

double co_angle_over_pi(double y, double x) {
    double a = fabs(x), b = fabs(y), angle;
    if (a == 0 && b == 0)
        return 0;
    angle = b <= a ? arc_over_pi(b / a) : 0.5 - arc_over_pi(a / b);
    angle = x < 0 ? 1 - angle : angle;
    return y < 0 ? -angle : angle;
}

double co_arc_cosine(double x) {
    return CO_PI * co_angle_over_pi(sqrt((1 - x) * (1 + x)), x);
}

double co_exp(double x) {
    static const double ln2_high = 0x1.62e42fefa0000p-1,
                        ln2_low = 0x1.cf79abc9e3b3ap-40; /* products with k are exact */
    double k = floor(x / (ln2_high + ln2_low) + 0.5), rest = (x - k * ln2_high) - k * ln2_low, sum = 0;
    if (x > 710 || x < -746)
        return x > 0 ? (double)INFINITY : 0;
    for (int i = 14; i > 1; i--)
        sum = rest * (1 + sum) / i;
    return ldexp(1 + (rest + rest * sum), (int)k);
}

double co_log(double x) {
    static const double ln2_high = 0x1.62e42fefa0000p-1, ln2_low = 0x1.cf79abc9e3b3ap-40;
    int k;
    double f = frexp(x, &k), s, square, sum = 0;
    if (f < 0.70710678118654752) { /* sqrt(1/2) <= f < sqrt(2) */
        f *= 2;
        k--;
    }
    f -= 1; /* exact */
    s = f / (2 + f);
    square = s * s;
    for (int i = 21; i > 1; i -= 2)
        sum = square * (2.0 / i + sum);
    /* log(1 + f) = 2 s + s sum, and 2 s = f - s f */
    return k * ln2_high + (f + (k * ln2_low - s * (f - sum)));
}

double co_log_1_plus(double x) {
    double whole = 1 + x;
    return co_log(whole) + (x - (whole - 1)) / whole; /* what was rounded off */
}

double co_power(double x, int n) {
    double power = 1;
    for (int i = 0; i < abs(n); i++)
        power *= x;
    return n < 0 ? 1 / power : power;
}

double co_length(double x, double y) {
    return sqrt(x * x + y * y);
}
