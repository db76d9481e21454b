/* Limit curves of boundaries and creases: uniform cubic B-splines. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_SPLINE_CURVE_H
#define CO_CONSTRAINTS_SPLINE_CURVE_H

#include <stdint.h>

/* The curve C(t) of the control points P_i: t = i is the limit point (P_{i-1} + 4 P_i + P_{i+1}) / 6 of vertex i. An
 * open curve, t from 0 to n - 1, begins and ends in its control points, without curvature: that is what subdivision
 * makes of a curve between corners, and it is a B-spline with one more control point 2 P_0 - P_1. */
typedef struct co_spline_curve {
    int32_t n;
    int closed;
    double *control; /* [3 n] */
} co_spline_curve;

/* C(t) and its first and second derivatives; of a closed curve t has the period n. */
void co_spline_curve_at(const co_spline_curve *curve, double t, double jet[3][3]);
/* Limit point of control point i. */
void co_spline_curve_limit(const co_spline_curve *curve, int32_t i, double point[3]);
/* Parameter of the point closest to x, from t on by Newton's method, at most `reach` away from t. */
double co_spline_curve_closest(const co_spline_curve *curve, const double x[3], double t, double reach);

#endif
