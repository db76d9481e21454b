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
#define CO_SIMD_INLINE static inline __attribute__((always_inline))

/* Lanes that are multiplied and added together where that is most of the work: 256 bits at most. Without fused
 * operations AMD's Zen 4 does that faster than 512 bits (libcurvopt/notes/94-where-the-time-goes.md). */
enum { LANE_PARTS = CO_LANES > 4 ? CO_LANES / 4 : 1 };
typedef double lane_part __attribute__((vector_size(8 * CO_LANES / LANE_PARTS)));
typedef double lane_part_in_memory __attribute__((vector_size(8 * CO_LANES / LANE_PARTS), may_alias));

CO_SIMD_INLINE lane_part lane_get_part(const lane *x, int part) {
    return ((const lane_part_in_memory *)(const void *)x)[part];
}
CO_SIMD_INLINE void lane_set_part(lane *x, int part, lane_part value) {
    ((lane_part_in_memory *)(void *)x)[part] = value;
}
/* In registers: a lane that was written in parts is read as a whole only after they have left for memory. */
CO_SIMD_INLINE lane lane_of_parts(const lane_part x[LANE_PARTS]) {
#if CO_LANES == 8
    return __builtin_shufflevector(x[0], x[1], 0, 1, 2, 3, 4, 5, 6, 7);
#else
    return x[0];
#endif
}
CO_SIMD_INLINE lane_part lane_part_all(double x) {
    return x - (lane_part){0}; /* as lane_all() */
}

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
