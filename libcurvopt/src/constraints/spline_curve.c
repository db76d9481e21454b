/* Uniform cubic B-spline curves. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/spline_curve.h"

#include <math.h>

/* Control point i, also beyond the curve's ends. */
static void control_point(const co_spline_curve *s, int32_t i, double p[3]) {
    if (s->closed)
        i = (i % s->n + s->n) % s->n;
    int32_t end = i < 0 ? 0 : s->n - 1, inner = i < 0 ? 1 : s->n - 2;
    int is_beyond = i < 0 || i >= s->n;
    for (int c = 0; c < 3; c++)
        p[c] = is_beyond ? 2 * s->control[3 * end + c] - s->control[3 * inner + c] : s->control[3 * i + c];
}

void co_spline_curve_limit(const co_spline_curve *s, int32_t i, double point[3]) {
    double before[3], at[3], after[3];
    control_point(s, i - 1, before);
    control_point(s, i, at);
    control_point(s, i + 1, after);
    for (int c = 0; c < 3; c++)
        point[c] = (before[c] + after[c] + 4 * at[c]) / 6;
}

void co_spline_curve_at(const co_spline_curve *s, double t, double jet[3][3]) {
    double first = floor(t);
    if (!s->closed)
        first = fmin(fmax(first, 0), s->n - 2);
    const double u = t - first, v = 1 - u;
    const double weight[3][4] = {
        {v * v * v / 6, (u * u * (3 * u - 6) + 4) / 6, (v * v * (3 * v - 6) + 4) / 6, u * u * u / 6},
        {-v * v / 2, u * (3 * u - 4) / 2, -v * (3 * v - 4) / 2, u * u / 2},
        {v, 3 * u - 2, 3 * v - 2, u}};
    for (int k = 0; k < 9; k++)
        jet[k / 3][k % 3] = 0;
    for (int i = 0; i < 4; i++) {
        double p[3];
        control_point(s, (int32_t)first - 1 + i, p);
        for (int k = 0; k < 9; k++)
            jet[k / 3][k % 3] += weight[k / 3][i] * p[k % 3];
    }
}

double co_spline_curve_closest(const co_spline_curve *s, const double x[3], double from, double reach) {
    enum { MOST_STEPS = 30 };
    static const double ENOUGH = 1e-15; /* of a step, in spans: rounding */
    double t = from, least = from - reach, most = from + reach;
    if (!s->closed) {
        least = fmax(least, 0);
        most = fmin(most, s->n - 1);
    }
    for (int k = 0; k < MOST_STEPS; k++) {
        double jet[3][3], slope = 0, square = 0, bend = 0;
        co_spline_curve_at(s, t, jet);
        for (int c = 0; c < 3; c++) {
            double off = x[c] - jet[0][c];
            slope += off * jet[1][c];
            square += jet[1][c] * jet[1][c];
            bend += off * jet[2][c];
        }
        double step = slope / fmax(square - bend, square / 4);
        if (!isfinite(step)) /* the curve has no tangent there */
            return from;
        double next = fmin(fmax(t + step, least), most);
        if (fabs(next - t) <= ENOUGH * (1 + fabs(t)))
            return next;
        t = next;
    }
    return t;
}
