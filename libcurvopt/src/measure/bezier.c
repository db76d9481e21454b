/* Bicubic Bezier pieces (sources: bezier.h). SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/bezier.h"

#include "base/constants.h"
#include "base/elementary.h"
#include "base/vec3.h"

#include <math.h>
#include <string.h>

/* Rows of four points, `n` numbers in a row side by side, from a cubic B-spline's to the Bezier points. */
static void rows_from_bspline(const double *in, int n, double *restrict out) {
    for (int k = 0; k < n; k++) {
        const double a = in[k], b = in[n + k], c = in[2 * n + k], d = in[3 * n + k];
        out[k] = (a + 4 * b + c) / 6;
        out[n + k] = (2 * b + c) / 3;
        out[2 * n + k] = (b + 2 * c) / 3;
        out[3 * n + k] = (b + 4 * c + d) / 6;
    }
}

void co_bezier_from_bspline(const double spline[CO_BEZIER], double out[CO_BEZIER]) {
    double rows[CO_BEZIER];
    rows_from_bspline(spline, 12, rows);
    for (size_t j = 0; j < 4; j++)
        rows_from_bspline(rows + 12 * j, 3, out + 12 * j);
}

/* Bernstein's polynomials of degree 3 and their derivatives. */
static void bernstein(double t, double b[3][4]) {
    const double s = 1 - t;
    b[0][0] = s * s * s;
    b[0][1] = 3 * s * s * t;
    b[0][2] = 3 * s * t * t;
    b[0][3] = t * t * t;
    b[1][0] = -3 * s * s;
    b[1][1] = 3 * s * s - 6 * s * t;
    b[1][2] = 6 * s * t - 3 * t * t;
    b[1][3] = 3 * t * t;
    b[2][0] = 6 * s;
    b[2][1] = 6 * t - 12 * s;
    b[2][2] = 6 * s - 12 * t;
    b[2][3] = 6 * t;
}

void co_bezier_at(const double piece[CO_BEZIER], double u, double v, co_bezier_jet *out) {
    double bu[3][4], bv[3][4], row[3][4][3];
    bernstein(u, bu);
    bernstein(v, bv);
    for (int k = 0; k < 3; k++)
        for (int j = 0; j < 4; j++)
            for (int c = 0; c < 3; c++) {
                const double *p = piece + 12 * j + c;
                row[k][j][c] = bu[k][0] * p[0] + bu[k][1] * p[3] + bu[k][2] * p[6] + bu[k][3] * p[9];
            }
    for (int c = 0; c < 3; c++) {
        double sum[6] = {0};
        for (int j = 0; j < 4; j++) {
            sum[0] += bv[0][j] * row[0][j][c];
            sum[1] += bv[0][j] * row[1][j][c];
            sum[2] += bv[1][j] * row[0][j][c];
            sum[3] += bv[0][j] * row[2][j][c];
            sum[4] += bv[1][j] * row[1][j][c];
            sum[5] += bv[2][j] * row[0][j][c];
        }
        out->s[c] = sum[0];
        out->u[c] = sum[1];
        out->v[c] = sum[2];
        out->uu[c] = sum[3];
        out->uv[c] = sum[4];
        out->vv[c] = sum[5];
    }
}

void co_bezier_point(const double piece[CO_BEZIER], double u, double v, double out[3]) {
    const double s = 1 - u, t = 1 - v;
    const double bu[4] = {s * s * s, 3 * s * s * u, 3 * s * u * u, u * u * u};
    const double bv[4] = {t * t * t, 3 * t * t * v, 3 * t * v * v, v * v * v};
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (int j = 0; j < 4; j++) {
            const double *p = piece + 12 * j + c;
            sum += bv[j] * (bu[0] * p[0] + bu[1] * p[3] + bu[2] * p[6] + bu[3] * p[9]);
        }
        out[c] = sum;
    }
}

/* The blossom's values at a a a, a a b, a b b, b b b over the four points of a cubic: those of the part [a, b]. */
static void cut_weights(double a, double b, double w[4][4]) {
    const double parameter[4][3] = {{a, a, a}, {a, a, b}, {a, b, b}, {b, b, b}};
    for (int k = 0; k < 4; k++) {
        const double x = parameter[k][0], y = parameter[k][1], z = parameter[k][2];
        const double p = 1 - x, q = 1 - y, r = 1 - z;
        w[k][0] = p * q * r;
        w[k][1] = x * q * r + p * y * r + p * q * z;
        w[k][2] = p * y * z + x * q * z + x * y * r;
        w[k][3] = x * y * z;
    }
}

/* Rows of four points, `n` numbers in a row side by side: out[k] = sum of w[k][i] in[i]. */
static void combine(const double w[4][4], const double *in, int n, double *out) {
    for (int k = 0; k < 4; k++)
        for (int c = 0; c < n; c++)
            out[k * n + c] = w[k][0] * in[c] + w[k][1] * in[n + c] + w[k][2] * in[2 * n + c] + w[k][3] * in[3 * n + c];
}

void co_bezier_part(const double piece[CO_BEZIER], const double u[2], const double v[2], double out[CO_BEZIER]) {
    double rows[CO_BEZIER], w[4][4];
    memcpy(rows, piece, sizeof rows);
    if (u[0] != 0 || u[1] != 1) {
        cut_weights(u[0], u[1], w);
        for (size_t j = 0; j < 4; j++)
            combine((const double(*)[4])w, piece + 12 * j, 3, rows + 12 * j);
    }
    if (v[0] != 0 || v[1] != 1) {
        cut_weights(v[0], v[1], w);
        combine((const double(*)[4])w, rows, 12, out);
    } else {
        memcpy(out, rows, sizeof rows);
    }
}

/* Square of the length of a second difference of control points. */
static double second_difference(const double *p, int step_one, int step_two) {
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        const double d = p[c] - p[step_one + c] - p[step_two + c] + p[step_one + step_two + c];
        sum += d * d;
    }
    return sum;
}

void co_bezier_second(const double piece[CO_BEZIER], double bound[3]) {
    double largest[3] = {0};
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++) {
            const double *p = piece + 12 * j + 3 * i;
            if (i < 2)
                largest[0] = fmax(largest[0], second_difference(p, 3, 3));
            if (i < 3 && j < 3)
                largest[1] = fmax(largest[1], second_difference(p, 3, 12));
            if (j < 2)
                largest[2] = fmax(largest[2], second_difference(p, 12, 12));
        }
    bound[0] = 6 * sqrt(largest[0]);
    bound[1] = 9 * sqrt(largest[1]);
    bound[2] = 6 * sqrt(largest[2]);
}

/* The difference i of 12 of a piece's neighbouring control points along u (step 3) or v (step 12). */
static void difference(const double *piece, int step, int i, double out[3]) {
    const double *p = piece + (step == 3 ? 12 * (i / 3) + 3 * (i % 3) : 3 * i);
    for (int c = 0; c < 3; c++)
        out[c] = p[step + c] - p[c];
}

/* The cone of n pieces' directions along u (step 3) or v (step 12); those of length 0 count as any. */
static co_cone cone_of(const double *pieces, int n, int step) {
    co_cone cone = {.angle = CO_PI};
    double d[3], least = 1;
    for (int k = 0; k < 12 * n; k++) {
        difference(pieces + (size_t)CO_BEZIER * (size_t)(k / 12), step, k % 12, d);
        const double length = co_length3(d);
        if (!(length > 0))
            return cone;
        for (int c = 0; c < 3; c++)
            cone.axis[c] += d[c] / length;
    }
    const double length = co_length3(cone.axis);
    if (!(length > 0))
        return cone;
    for (int c = 0; c < 3; c++)
        cone.axis[c] /= length;
    for (int k = 0; k < 12 * n; k++) {
        difference(pieces + (size_t)CO_BEZIER * (size_t)(k / 12), step, k % 12, d);
        const double along = co_dot3(d, cone.axis) / co_length3(d);
        least = along < least ? along : least;
    }
    cone.angle = co_arc_cosine(fmax(-1, least));
    return cone;
}

void co_bezier_cones(const double *pieces, int n, co_cone *u, co_cone *v) {
    *u = cone_of(pieces, n, 3);
    *v = cone_of(pieces, n, 12);
}

/* Places in the net of S_u x S_v, of degree 5 by 5, get products of Bernstein coefficients of S_u, of degree 2 by 3,
 * and S_v, of degree 3 by 2 (Farin, chapter 6); their weights but for a factor of each place. */
static void multiply_derivatives(const double piece[CO_BEZIER], double net[36][3]) {
    static const double two[3] = {1, 2, 1}, three[4] = {1, 3, 3, 1};
    double u[3], v[3], product[3];
    memset(net, 0, 36 * sizeof *net);
    for (int i = 0; i < 12; i++) {
        difference(piece, 3, i, u);
        for (int k = 0; k < 12; k++) {
            const int row = i / 3 + k / 4, column = i % 3 + k % 4;
            const double weight = two[i % 3] * three[i / 3] * three[k % 4] * two[k / 4];
            difference(piece, 12, k, v);
            co_cross3(u, v, product);
            for (int c = 0; c < 3; c++)
                net[6 * row + column][c] += weight * product[c];
        }
    }
}

co_cone co_bezier_normals(const double piece[CO_BEZIER]) {
    co_cone cone = {.angle = CO_PI};
    double net[36][3], least = 1;
    multiply_derivatives(piece, net);
    for (int k = 0; k < 36; k++) {
        const double length = co_length3(net[k]);
        if (!(length > 0))
            return cone;
        for (int c = 0; c < 3; c++)
            cone.axis[c] += net[k][c] /= length;
    }
    const double length = co_length3(cone.axis);
    if (!(length > 0))
        return cone;
    for (int c = 0; c < 3; c++)
        cone.axis[c] /= length;
    for (int k = 0; k < 36; k++) {
        const double along = co_dot3(net[k], cone.axis);
        least = along < least ? along : least;
    }
    cone.angle = least > 0 ? co_arc_cosine(least) : CO_PI;
    return cone;
}

co_cone co_cone_product(const co_cone *u, const co_cone *v) {
    co_cone out = {.angle = CO_PI};
    co_cross3(u->axis, v->axis, out.axis);
    const double sine = co_length3(out.axis);
    const double a = co_sin_pi(u->angle / CO_PI), b = co_sin_pi(v->angle / CO_PI),
                 cosine = fabs(co_dot3(u->axis, v->axis));
    const double between = CO_PI * co_angle_over_pi(sine, cosine);
    if (!(u->angle + v->angle < between))
        return out;
    for (int c = 0; c < 3; c++)
        out.axis[c] /= sine;
    out.angle = asin(fmin(1, sqrt(a * a + 2 * a * b * cosine + b * b) / sine));
    return out;
}

void co_bezier_mean_directions(const double *const corner[4], double u[3], double v[3], double normal[3]) {
    const double *p = corner[0], *q = corner[1], *r = corner[2], *s = corner[3];
    for (int c = 0; c < 3; c++) {
        u[c] = q[c] - p[c] + s[c] - r[c];
        v[c] = r[c] - p[c] + s[c] - q[c];
    }
    co_cross3(u, v, normal);
}

/* Least sine of the angle between a piece's mean directions: below, rounding tilts their normal by more than 1e-13, and
 * of a piece that is one line by any angle; a box along such axes does not hold the piece. */
static const double LEAST_SINE = 1e-3;

co_oriented_box co_oriented_box_round(const double *const corner[4], const double *points, int n) {
    co_oriented_box box = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    double u[3], v[3], normal[3];
    co_bezier_mean_directions(corner, u, v, normal);
    const double length = co_length3(u), area = co_length3(normal);
    if (length > 0 && area > LEAST_SINE * length * co_length3(v)) {
        for (int c = 0; c < 3; c++) {
            box.axis[0][c] = u[c] / length;
            box.axis[2][c] = normal[c] / area;
        }
        co_cross3(box.axis[2], box.axis[0], box.axis[1]);
    }
    for (int k = 0; k < 3; k++) {
        double low = co_dot3(corner[0], box.axis[k]), high = low;
        for (int i = 0; i < n; i++) {
            const double along = co_dot3(points + 3 * (size_t)i, box.axis[k]);
            low = along < low ? along : low;
            high = along > high ? along : high;
        }
        box.half[k] = (high - low) / 2;
        for (int c = 0; c < 3; c++)
            box.centre[c] += (high + low) / 2 * box.axis[k][c];
    }
    return box;
}

co_oriented_box co_oriented_box_of(const double piece[CO_BEZIER]) {
    const double *const corner[4] = {piece, piece + 9, piece + 36, piece + 45};
    return co_oriented_box_round(corner, piece, 16);
}

co_box co_box_of(const double *points, int n) {
    co_box box = {{points[0], points[1], points[2]}, {points[0], points[1], points[2]}};
    for (int k = 1; k < n; k++)
        co_box_add(&box, points + 3 * (size_t)k, points + 3 * (size_t)k);
    return box;
}
