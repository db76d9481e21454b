/* Osculating paraboloids (quadric.h). SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/quadric.h"

#include "base/vec3.h"

#include <math.h>
#include <string.h>

/* Least area of the derivatives' parallelogram, in products of their lengths. */
#define DEGENERATE 1e-6

int co_quadric_at_middle(const double piece[CO_BEZIER], co_quadric *out) {
    co_bezier_jet j;
    co_bezier_at(piece, 0.5, 0.5, &j);
    double *t = out->axis[0], *s = out->axis[1], *n = out->axis[2];
    co_cross3(j.u, j.v, n);
    const double a = co_length3(j.u), area = co_length3(n);
    if (!(area > DEGENERATE * a * co_length3(j.v)))
        return 0;
    for (int c = 0; c < 3; c++) {
        n[c] /= area;
        t[c] = j.u[c] / a;
    }
    co_cross3(n, t, s);
    memcpy(out->origin, j.s, sizeof out->origin);
    /* du = (x - b y / c) / a and dv = y / c in z = (uu du^2 + 2 uv du dv + vv dv^2) / 2 */
    const double b = co_dot3(j.v, t), c = co_dot3(j.v, s), uu = co_dot3(j.uu, n) / (a * a),
                 uv = co_dot3(j.uv, n) / (a * c), vv = co_dot3(j.vv, n) / (c * c), slant = b / c;
    out->c[0] = 0.5 * uu;
    out->c[1] = uv - slant * uu;
    out->c[2] = 0.5 * (vv + slant * slant * uu) - slant * uv;
    return 1;
}

/* The product of Bernstein polynomials i and j of degree 3 is this much of that of number i + j of degree 6. */
static const double product[4][4] = {
    {1, 0.5, 0.2, 0.05}, {0.5, 0.6, 0.45, 0.2}, {0.2, 0.45, 0.6, 0.5}, {0.05, 0.2, 0.5, 1}};

/* A row of coefficients of degree 6 += that of the product of p and q, both of degree 3. */
static void add_product(const double p[4], const double q[4], double out[7]) {
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            out[i + j] += product[i][j] * p[i] * q[j];
}

/* The same function as a polynomial of degree 6. */
static void raise_degree(const double p[4], double out[7]) {
    static const double one[4] = {1, 1, 1, 1};
    memset(out, 0, 7 * sizeof *out);
    add_product(p, one, out);
}

void co_quadric_heights(const co_quadric *k, const double piece[CO_BEZIER], double range[2]) {
    double x[4][4], y[4][4], z[4][4], bent[4][4], flat[4][4]; /* bent: c[0] x + c[1] y, flat: c[2] y */
    double height[7][7], of_rows[4][7];
    for (int i = 0; i < 16; i++) {
        const double *p = piece + 3 * i, d[3] = {p[0] - k->origin[0], p[1] - k->origin[1], p[2] - k->origin[2]};
        x[i / 4][i % 4] = co_dot3(d, k->axis[0]);
        y[i / 4][i % 4] = co_dot3(d, k->axis[1]);
        z[i / 4][i % 4] = co_dot3(d, k->axis[2]);
        bent[i / 4][i % 4] = -(k->c[0] * x[i / 4][i % 4] + k->c[1] * y[i / 4][i % 4]);
        flat[i / 4][i % 4] = -k->c[2] * y[i / 4][i % 4];
    }
    for (int i = 0; i < 4; i++)
        raise_degree(z[i], of_rows[i]);
    for (int m = 0; m < 7; m++) {
        const double column[4] = {of_rows[0][m], of_rows[1][m], of_rows[2][m], of_rows[3][m]};
        double raised[7];
        raise_degree(column, raised);
        for (int i = 0; i < 7; i++)
            height[i][m] = raised[i];
    }
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double row[7] = {0};
            add_product(x[i], bent[j], row);
            add_product(y[i], flat[j], row);
            for (int m = 0; m < 7; m++)
                height[i + j][m] += product[i][j] * row[m];
        }
    range[0] = (double)INFINITY;
    range[1] = -(double)INFINITY;
    for (int i = 0; i < 49; i++) { /* fmin and fmax are calls */
        const double h = height[i / 7][i % 7];
        range[0] = h < range[0] ? h : range[0];
        range[1] = h > range[1] ? h : range[1];
    }
}
