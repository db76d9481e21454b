/* How far two limit surfaces are from each other: Hausdorff distance with a bound, and root mean square distance.
 * notes/110-deviation-with-a-bound.md
 *
 * Two bounds of the distance d(x, B) hold for all x of a part a of surface A. With x0 its middle and r the distance
 * from there to the farthest control point, d(x, B) <= d(x0, B) + r. And for any map phi from the part's parameters (s,
 * t) in [0, 1]^2 to those of one piece b of B, d(x, B) <= |F|, F = a - b o phi. phi is bilinear here, between the
 * parameters of those points of b that are nearest to the part's corners. A bilinear interpolant of F has its largest
 * length at a corner, and differs from F by (max |F_ss| + max |F_tt|) / 8 at most; second derivatives are bounded by
 * control nets. So the bound is exact to second order in the part's side, and to third where both surfaces bend alike.
 *
 * Parts whose bound is too far above the largest distance found are cut in four (branch and bound). Of many patches
 * groups come first, with the distance of one point and the first bound.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_DEVIATION_H
#define CO_MEASURE_DEVIATION_H

#include "base/cancel.h"
#include "measure/nearest.h"

/* Parts are cut until the bound is so many times the largest distance found; the interface promises 1.2. */
#define CO_DEVIATION_RATIO 1.15
/* As long as few parts have been looked at, it is this, so that the largest distance found is close, too. */
#define CO_DEVIATION_CLOSE 1.02
enum {
    CO_DEVIATION_FEW = 3000,     /* parts; patches that are more by far begin in about so many groups */
    CO_DEVIATION_GLIMPSE = 2000, /* patches of which a glimpse looks at all; at fewer of more */
    CO_DEVIATION_CLIMBS = 16     /* parts from which a larger distance is looked for at the end */
};
/* Distances below it count as none, in root mean square radii of the first cage. */
#define CO_DEVIATION_FLOOR 1e-9

typedef struct co_deviation {
    double max;         /* largest distance found */
    double rms;         /* over the first surface, by area; NAN if cancelled */
    double bound;       /* no point of either surface is farther from the other one */
    double point[2][3]; /* where `max` was found: a point of the first surface, and one of the second */
    size_t n_parts;     /* parts that were looked at, without groups */
    size_t n_steps;     /* of Newton's method for nearest points, for these */
} co_deviation;

/* Largest distance of the patches' middles and tips, of both surfaces: at most `max`, at the price of one generation.
 * 0 if cancelled. ERROR_MEMORY. */
int32_t co_deviation_glimpse(const co_nearest surface[2], co_thread_pool *pool, const curvopt_cancel *cancel,
                             double *out, curvopt_error *error);

/* Of surface[0] and surface[1], with the same bits for any number of threads. Before more than `budget` steps, or when
 * cancelled, the bound stays as it is, and may be more than CO_DEVIATION_RATIO times the largest distance.
 * ERROR_MEMORY. */
int32_t co_deviation_measure(const co_nearest surface[2], size_t budget, co_thread_pool *pool,
                             const curvopt_cancel *cancel, co_deviation *out, curvopt_error *error);

#endif
