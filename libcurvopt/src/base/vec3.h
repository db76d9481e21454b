/* Vectors of three doubles. Sums run from the first coordinate to the last. SPDX-License-Identifier: GPL-3.0-or-later
 */
#ifndef CO_BASE_VEC3_H
#define CO_BASE_VEC3_H

#include <math.h>

static inline double co_dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
static inline double co_length3(const double a[3]) {
    return sqrt(co_dot3(a, a));
}
static inline double co_distance3_squared(const double a[3], const double b[3]) {
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return co_dot3(d, d);
}
static inline double co_distance3(const double a[3], const double b[3]) {
    return sqrt(co_distance3_squared(a, b));
}
/* out = a x b; not one of these. */
static inline void co_cross3(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

#endif
