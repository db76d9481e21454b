/* Jets and the uniform bicubic B-spline basis. SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/bspline.h"

void co_jet_of_product(const double f[4], const double g[4], double jet[CO_JET]) {
    for (int k = 0; k < CO_JET; k++)
        jet[k] = f[co_jet_order_u[k]] * g[co_jet_order_v[k]];
}

/* Leibniz' rule, written out: tables spend most of their time here. */
void co_jet_multiply(const double a[CO_JET], const double b[CO_JET], double out[CO_JET]) {
    out[0] = a[0] * b[0];
    out[1] = a[0] * b[1] + a[1] * b[0];
    out[2] = a[0] * b[2] + a[2] * b[0];
    out[3] = a[0] * b[3] + 2 * a[1] * b[1] + a[3] * b[0];
    out[4] = a[0] * b[4] + a[1] * b[2] + a[2] * b[1] + a[4] * b[0];
    out[5] = a[0] * b[5] + 2 * a[2] * b[2] + a[5] * b[0];
    out[6] = a[0] * b[6] + 3 * (a[1] * b[3] + a[3] * b[1]) + a[6] * b[0];
    out[7] = a[0] * b[7] + a[2] * b[3] + 2 * (a[1] * b[4] + a[4] * b[1]) + a[3] * b[2] + a[7] * b[0];
    out[8] = a[0] * b[8] + a[1] * b[5] + 2 * (a[2] * b[4] + a[4] * b[2]) + a[5] * b[1] + a[8] * b[0];
    out[9] = a[0] * b[9] + 3 * (a[2] * b[5] + a[5] * b[2]) + a[9] * b[0];
}

void co_bspline_cubic(double t, double basis[4][4]) {
    double s = 1 - t;
    const double b[4][4] = {
        {s * s * s / 6, -s * s / 2, s, -1},
        {(3 * t * t * t - 6 * t * t + 4) / 6, (3 * t * t - 4 * t) / 2, 3 * t - 2, 3},
        {(3 * s * s * s - 6 * s * s + 4) / 6, -(3 * s * s - 4 * s) / 2, 3 * s - 2, -3},
        {t * t * t / 6, t * t / 2, t, 1},
    };
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++)
            basis[i][k] = b[i][k];
}

void co_bspline_bicubic(double u, double v, double rows[16][CO_JET]) {
    double along_u[4][4], along_v[4][4];
    co_bspline_cubic(u, along_u);
    co_bspline_cubic(v, along_v);
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++)
            co_jet_of_product(along_u[i], along_v[j], rows[4 * j + i]);
}
