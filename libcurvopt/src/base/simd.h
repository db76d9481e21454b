/* Vectors of doubles, such as one face in each lane. CO_LANES is set by the build, once per instruction set. The order
 * in which sums are written is the order of their roundings, and no a*b+c is fused (-ffp-contract=off): results are the
 * same bits with all instruction sets (libcurvopt/notes/98-other-platforms.md). SPDX-License-Identifier:
 * GPL-3.0-or-later */
#ifndef CO_BASE_SIMD_H
#define CO_BASE_SIMD_H

#include <math.h>

#ifndef CO_LANES
#error "CO_LANES: lanes of this instruction set"
#endif

typedef double lane __attribute__((vector_size(8 * CO_LANES)));
typedef double unaligned_lane __attribute__((vector_size(8 * CO_LANES), aligned(8))); /* in memory */
#define CO_SIMD_INLINE static inline __attribute__((always_inline))

CO_SIMD_INLINE lane lane_all(double x) {
    return x - (lane){0}; /* and not + 0, which -0 is not the same with */
}
CO_SIMD_INLINE lane lane_sqrt(lane x) {
    for (int i = 0; i < CO_LANES; i++)
        x[i] = sqrt(x[i]);
    return x;
}
CO_SIMD_INLINE lane lane_min(lane x, lane y) {
    for (int i = 0; i < CO_LANES; i++)
        x[i] = x[i] < y[i] ? x[i] : y[i];
    return x;
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
/* y += s x */
CO_SIMD_INLINE void lane_add_scaled(lane y[3], lane s, const lane x[3]) {
    for (int c = 0; c < 3; c++)
        y[c] += s * x[c];
}

#endif
