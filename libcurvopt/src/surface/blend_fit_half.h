/* The fit of the surface `polynomial` on half discs: m x m faces, m > 1, of each of the n sectors on one side of a
 * boundary or crease that runs smoothly through a vertex (blend_fit_cut.h has m = 1).
 *
 * The map is made of the natural net: n equal parts of a half turn, the curve along y = 0 with its points at whole x.
 * Subdivision does not keep that shape: round the vertex y shrinks to .58 of itself a step at n = 3, .635 at n = 6, x
 * to 1/2. A net that was natural some steps ago has a map of its own, the natural net subdivided as many times; which
 * one suits a net best is decided by its positions (blend_disc_half.h). x is uniform along the curve in all of them.
 *
 * Along the curve nothing may change. P(x, y) = p(x) + j_p |(x, y)|^3 + y Q(x, y): p of degree 5 and j_p are the
 * least-squares fit of the B-spline curve c(x) alone, over |x| < m; then Q, of degree 4, is fitted to the rest of S on
 * all faces. With m = 1 that would be the blend of blend_fit_cut.h. With m > 1 the curve is not quite p(x) + j_p |x|^3,
 * and what is missing is added in the faces along it:
 *     S' = (1 - W) S + W (P + E),   W = w(u / m) w(v / m),
 *     E = w(u) w(v) (q(x) - p(x) + (j - j_p) |(x, y)|^3)   in the faces at the vertex, where c is q(x) + j |x|^3,
 *       + (1 - w(u)) w(v) (c(u) - p(u) - j_p u^3)          in the first sector's faces along the curve, where x = u;
 *                                                          w(u) = 0 for u > 1; in the last sector's alike, x = -v
 * Along the curve these add up to c - p - j_p |x|^3. E is as small as the error of such a fit, or as the points' noise:
 * not multiplied by m^2, as it would be if the two segments at the vertex were prescribed as far as x = m. On a curve
 * that is a cubic on either side, as on a cage that was subdivided, it is 0. It has square integrable third
 * derivatives, and breaks only between faces, where quadrature expects it. One face (n = 1) stays at width 1: there y
 * shrinks to 1/4 and x to 1/2 from ring to ring, and functions of u alone have no bounded derivatives by y.
 *
 * Points: those at places 0 <= x, y <= m + 1 of each sector, numbered as a fan's two-ring (fan.h): each sector owns
 * those with x > 0, row by row, and the curve's m + 1 at the far end come last.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BLEND_FIT_HALF_H
#define CO_SURFACE_BLEND_FIT_HALF_H

#include "surface/blend_fit.h"

static inline int32_t co_blend_fit_half_n_points(int32_t n_sectors, int width) {
    return 1 + (width + 1) * (n_sectors * (width + 2) + 1);
}
/* The point at place (x, y), -1 <= x, y <= width + 1, not both negative, as a combination of points; beyond the curve
 * it is a phantom 2 P - Q (ring.h). Returns how many. */
int co_blend_fit_half_point(int32_t n_sectors, int width, int32_t sector, int x, int y, int32_t index[2],
                            double weight[2]);

/* What a map, and a fit, are for. */
typedef struct co_blend_fit_half_kind {
    int32_t n_sectors;
    int width; /* > 1 */
    int steps; /* of the map */
} co_blend_fit_half_kind;
static inline co_blend_fit_half_kind co_blend_fit_half_kind_of(int32_t patch_kind) {
    return (co_blend_fit_half_kind){co_fan_sectors(patch_kind), co_fan_wide_width(patch_kind),
                                    co_fan_half_steps(patch_kind)};
}
/* Makes the map alone, without fit. ERROR_MEMORY. */
int32_t co_blend_fit_create_half_map(const co_blend_fit_half_kind *kind, co_blend_fit *out, curvopt_error *error);
/* Makes map and fit, of as many samples a face as on closed discs. Linear in the faces. ERROR_MEMORY. */
int32_t co_blend_fit_create_half(const co_blend_fit_half_kind *kind, co_blend_fit *out, curvopt_error *error);

#endif
