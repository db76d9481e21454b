/* Positions with centroid 0 and root mean square radius 1, and gradients with respect to others from there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_NORMALIZATION_H
#define CO_ENERGY_NORMALIZATION_H

#include "base/thread_pool.h"

#include <stddef.h>
#include <stdint.h>

/* Of which positions. */
typedef struct co_normalization {
    size_t n;                /* positions */
    size_t n_skipped;        /* of which so many do not count for centroid and radius */
    const int32_t *skipped;  /* [n_skipped] ascending */
    co_thread_pool *threads; /* NULL: the calling thread alone */
} co_normalization;

/* Whether x gets another value; what is no number is another. */
static inline int co_normalization_set(double value, double *x) {
    const int changes = !(value == *x);
    *x = value;
    return changes;
}

/* Normalizes xyz [3 n] into points [3 n]; returns the radius that was divided by. *changes: whether any point becomes
 * another. */
double co_normalization_apply(const co_normalization *normalization, const double *xyz, double *points, int *changes);
/* Gradient [3 n] with respect to positions from that with respect to normalized ones, `points`: parts along
 * translations and scaling drop out, the rest scales:  g <- (g - mean g - x (g.x) / n) / radius .
 * co_dof_map_normalized_gradient() has the same formula in the variables of a minimization. `stays`: what of g.x does
 * not drop out. That of skipped positions becomes 0. */
void co_normalization_gradient(const co_normalization *normalization, const double *points, double radius, double stays,
                               double *gradient);

#endif
