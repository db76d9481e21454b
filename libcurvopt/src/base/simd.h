/* Vectors of numbers, such as one face in each lane: of doubles, or where CO_SINGLE is defined of floats. CO_DOUBLES,
 * how many doubles a vector of this instruction set has, is set by the build, once per instruction set. The order
 * in which sums are written is the order of their roundings, and no a*b+c is fused (-ffp-contract=off): results are the
 * same bits with all instruction sets (libcurvopt/notes/98-other-platforms.md). SPDX-License-Identifier:
 * GPL-3.0-or-later */
#ifndef CO_BASE_SIMD_H
#define CO_BASE_SIMD_H

#include <math.h>
#include <string.h>

#ifndef CO_DOUBLES
#error "CO_DOUBLES: doubles in a vector of this instruction set"
#endif

/* Lanes of this many doubles: as many, or twice as many floats, 8 at most. */
#define CO_LANES_OF_DOUBLES(doubles) (doubles)
#define CO_LANES_OF_FLOATS(doubles)  ((doubles) < 8 ? 2 * (doubles) : 8)
#ifdef CO_SINGLE
#define CO_LANES CO_LANES_OF_FLOATS(CO_DOUBLES)
typedef float real;
#define CO_REAL_TINY 1e-30F
#else
#define CO_LANES     CO_LANES_OF_DOUBLES(CO_DOUBLES)
typedef double real;
#define CO_REAL_TINY 1e-300
#endif

typedef real lane __attribute__((vector_size(sizeof(real) * CO_LANES)));
typedef double double_lane __attribute__((vector_size(sizeof(double) * CO_LANES)));
#define CO_SIMD_INLINE static inline __attribute__((always_inline))

CO_SIMD_INLINE lane lane_all(real x) {
    return x - (lane){0}; /* and not + 0, which -0 is not the same with */
}
/* As doubles, out [n][CO_LANES]. */
CO_SIMD_INLINE void lane_store(const lane *x, size_t n, double *out) {
    for (size_t i = 0; i < n; i++) {
        const double_lane as_doubles = __builtin_convertvector(x[i], double_lane);
        memcpy(out + i * CO_LANES, &as_doubles, sizeof as_doubles);
    }
}
CO_SIMD_INLINE lane lane_sqrt(lane x) {
    for (int i = 0; i < CO_LANES; i++)
#ifdef CO_SINGLE
        x[i] = sqrtf(x[i]);
#else
        x[i] = sqrt(x[i]);
#endif
    return x;
}
/* The lesser of each lane; where one is NAN, y. A compiler makes no vectors of a loop of comparisons. */
CO_SIMD_INLINE lane lane_min(lane x, lane y) {
    const __typeof__(x < y) is_less = x < y;
    return (lane)((is_less & (__typeof__(is_less))x) | (~is_less & (__typeof__(is_less))y));
}
CO_SIMD_INLINE lane lane_max(lane x, lane y) {
    return -lane_min(-x, -y);
}
CO_SIMD_INLINE lane lane_dot(const lane a[3], const lane b[3]) {
    return a[2] * b[2] + (a[1] * b[1] + a[0] * b[0]);
}
CO_SIMD_INLINE void lane_cross(const lane a[3], const lane b[3], lane out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}
/* x of a table or an integrand, times y. */
CO_SIMD_INLINE lane lane_scaled(double x, lane y) {
    return (real)x * y;
}
/* y += s x */
CO_SIMD_INLINE void lane_add_scaled(lane y[3], lane s, const lane x[3]) {
    for (int c = 0; c < 3; c++)
        y[c] += s * x[c];
}

#endif
