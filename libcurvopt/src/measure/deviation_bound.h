/* The second bound of deviation.h. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_DEVIATION_BOUND_H
#define CO_MEASURE_DEVIATION_BOUND_H

#include "measure/nearest.h"

/* A bound of the distance from part a to piece b, whose point nearest to a's middle is about at uv.
 * Adds the steps of Newton's method to *n_steps. */
double co_deviation_bound(const double a[CO_BEZIER], const double b[CO_BEZIER], const double uv[2], int32_t *n_steps);

#endif
