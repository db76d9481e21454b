/* The fit of the surface `polynomial` (blend_fit.h) at vertices where sharp edges cut the fan: poles on boundaries and
 * creases, and darts.
 *
 * Such fans have no characteristic map, or a useless one: with four faces and more on one side of a curve the
 * eigenvalues belong to no two coordinates. A blend does not need one. Any map chi does that is made of control points
 * as the surface is, and one-to-one: near the vertex the surface is then P over the image, smooth whatever chi is. We
 * take the natural net, the sectors as equal parts of a half or a whole turn. Its limit has a Jacobian of one sign, as
 * far as 32 faces and 12 rings were looked at (notes/16-blends-at-boundaries.md). Of one face it is (u - v, u v).
 *
 * Along the curve nothing may change, or the sides of a crease would come apart, and a boundary that is held would
 * move. There the surface is the B-spline curve c(x): two cubics, q(x) + j x^3 and q(x) - j x^3. Hence
 *     P(x, y) = q(x) + j |(x, y)|^3 + y Q(x, y),
 * which is c along y = 0 and has bounded third derivatives. Q, of degree 4, is fitted. A dart has no such curve: there
 * P is any polynomial.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BLEND_FIT_CUT_H
#define CO_SURFACE_BLEND_FIT_CUT_H

#include "surface/blend_fit.h"

/* Makes map and fit, of width 1, of a fan that is cut, whatever its sector; no corner. Linear in the number of sectors
 * times the lesser of it and 32. ERROR_MEMORY. */
int32_t co_blend_fit_create_cut(int32_t fan, co_blend_fit *out, curvopt_error *error);

/* Place (x, y) of a sector of the fan in the natural net, in units of a face. */
void co_blend_fit_natural(int32_t fan, int32_t sector, int x, int y, double at[2]);

/* The B-spline's two segments at the vertex, q(x) + j |x|^3: its coefficients, of 1, x, x^2, x^3 and |x|^3, from the
 * points of the curve at x = -2 .. 2. */
enum { CO_BLEND_FIT_CURVE = 5 };
extern const double co_blend_fit_curve_weight[CO_BLEND_FIT_CURVE][CO_BLEND_FIT_CURVE];
/* Indices of these points in an open fan's two-ring. */
void co_blend_fit_curve_points(int32_t fan, int32_t point[CO_BLEND_FIT_CURVE]);

#endif
