/* A bound of the distance between two bicubic pieces, by matching their parameters (deviation.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/deviation_bound.h"

#include "base/vec3.h"

#include <math.h>

/* Second derivatives uu, uv, vv over a piece: a vector in the middle of the control net, the largest distance from it,
 * and the largest length. */
typedef struct spread {
    double middle[3][3], radius[3], length[3];
} spread;

static const int step[3][2] = {{3, 3}, {3, 12}, {12, 12}}; /* of control points, per second difference */
static const int n_along[3][2] = {{2, 4}, {3, 3}, {4, 2}}; /* second differences along u and v */
static const int factor[3] = {6, 9, 6};

static void difference(const double *p, int which, double out[3]) {
    for (int c = 0; c < 3; c++)
        out[c] = factor[which] *
                 (p[c] - p[step[which][0] + c] - p[step[which][1] + c] + p[step[which][0] + step[which][1] + c]);
}

static spread second_derivatives(const double piece[CO_BEZIER]) {
    spread out = {.radius = {0}};
    for (int w = 0; w < 3; w++) {
        double net[9][3];
        int n = 0;
        for (int j = 0; j < n_along[w][1]; j++)
            for (int i = 0; i < n_along[w][0]; i++, n++)
                difference(piece + 12 * j + 3 * i, w, net[n]);
        for (int k = 0; k < n; k++)
            for (int c = 0; c < 3; c++)
                out.middle[w][c] += net[k][c] / n;
        for (int k = 0; k < n; k++) {
            out.radius[w] = fmax(out.radius[w], co_distance3_squared(net[k], out.middle[w]));
            out.length[w] = fmax(out.length[w], co_dot3(net[k], net[k]));
        }
        out.radius[w] = sqrt(out.radius[w]);
        out.length[w] = sqrt(out.length[w]);
    }
    return out;
}

/* Bound of |a_ss - (b o phi)_ss|: phi_s = d + tau e for some tau in [-1, 1]; which: 0 for s, 2 for t. */
static double second_of_difference(const spread *a, int which, const spread *b, const double d[2], const double e[2]) {
    const double square[3] = {d[0] * d[0], 2 * d[0] * d[1], d[1] * d[1]};
    const double twist[3] = {2 * fabs(d[0] * e[0]) + e[0] * e[0],
                             2 * (fabs(d[0] * e[1]) + fabs(d[1] * e[0]) + fabs(e[0] * e[1])),
                             2 * fabs(d[1] * e[1]) + e[1] * e[1]};
    double middle[3], bound = a->radius[which];
    for (int c = 0; c < 3; c++) {
        middle[c] = a->middle[which][c];
        for (int w = 0; w < 3; w++)
            middle[c] -= square[w] * b->middle[w][c];
    }
    for (int w = 0; w < 3; w++)
        bound += fabs(square[w]) * b->radius[w] + twist[w] * b->length[w];
    return bound + co_length3(middle);
}

/* The part of b that the corners' parameters uv span, and these in its own parameters. */
static void cut_to(const double b[CO_BEZIER], double uv[4][2], double part[CO_BEZIER]) {
    double range[2][2];
    for (int k = 0; k < 2; k++) {
        range[k][0] = fmin(fmin(uv[0][k], uv[1][k]), fmin(uv[2][k], uv[3][k]));
        range[k][1] = fmax(fmax(uv[0][k], uv[1][k]), fmax(uv[2][k], uv[3][k]));
        const double width = range[k][1] - range[k][0];
        for (int i = 0; i < 4; i++)
            uv[i][k] = width > 0 ? (uv[i][k] - range[k][0]) / width : 0;
    }
    co_bezier_part(b, range[0], range[1], part);
}

/* Largest distance of control points of a and of b's part between the means of the corners' parameters, along u and v
 * as these run: a bound with another phi, exact where both are the same surface. */
static double distance_of_nets(const double a[CO_BEZIER], const double b[CO_BEZIER], double at[4][2]) {
    const double *p = at[0], *q = at[1], *r = at[2], *s = at[3];
    const int swapped = fabs(q[0] - p[0] + s[0] - r[0]) < fabs(q[1] - p[1] + s[1] - r[1]);
    double range[2][2], part[CO_BEZIER], largest = 0;
    for (int k = 0; k < 2; k++) {
        const int along_s = (k == 0) != swapped;
        range[k][0] = (p[k] + (along_s ? r[k] : q[k])) / 2;
        range[k][1] = (s[k] + (along_s ? q[k] : r[k])) / 2;
    }
    co_bezier_part(b, range[0], range[1], part);
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++)
            largest = fmax(
                largest, co_distance3_squared(a + 12 * j + 3 * i, part + (swapped ? 12 * i + 3 * j : 12 * j + 3 * i)));
    return sqrt(largest);
}

double co_deviation_bound(const double a[CO_BEZIER], const double b[CO_BEZIER], const double uv[2], int32_t *n_steps) {
    static const double whole[2] = {0, 1};
    static const int corner[4] = {0, 9, 36, 45};
    double at[4][2], point[3], part[CO_BEZIER], largest = 0;
    for (int i = 0; i < 4; i++) {
        at[i][0] = uv[0];
        at[i][1] = uv[1];
        largest = fmax(largest, co_nearest_on_piece(b, a + corner[i], whole, whole, at[i], point, n_steps));
    }
    const double of_nets = distance_of_nets(a, b, at);
    cut_to(b, at, part);
    const spread of_a = second_derivatives(a), of_b = second_derivatives(part);
    double along[2][2], twist[2];
    for (int k = 0; k < 2; k++) {
        along[0][k] = (at[1][k] - at[0][k] + at[3][k] - at[2][k]) / 2;
        along[1][k] = (at[2][k] - at[0][k] + at[3][k] - at[1][k]) / 2;
        twist[k] = (at[3][k] - at[2][k] - at[1][k] + at[0][k]) / 2;
    }
    const double second =
        second_of_difference(&of_a, 0, &of_b, along[0], twist) + second_of_difference(&of_a, 2, &of_b, along[1], twist);
    return fmin(of_nets, largest + second / 8);
}
