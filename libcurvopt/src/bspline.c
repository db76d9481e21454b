/* Jets and the uniform bicubic B-spline basis. SPDX-License-Identifier: GPL-3.0-or-later */
#include "bspline.h"

const int co_jet_order_u[CO_JET] = {0, 1, 0, 2, 1, 0, 3, 2, 1, 0};
const int co_jet_order_v[CO_JET] = {0, 0, 1, 0, 1, 2, 0, 1, 2, 3};

void co_jet_of_product(const co_real f[4], const co_real g[4], co_real jet[CO_JET]) {
    for (int k = 0; k < CO_JET; k++)
        jet[k] = f[co_jet_order_u[k]] * g[co_jet_order_v[k]];
}

static int jet_index(int order_u, int order_v) {
    int order = order_u + order_v;
    return order * (order + 1) / 2 + order_v;
}

void co_jet_multiply(const co_real a[CO_JET], const co_real b[CO_JET], co_real out[CO_JET]) {
    static const int binomial[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};
    for (int k = 0; k < CO_JET; k++) {
        int p = co_jet_order_u[k], q = co_jet_order_v[k];
        out[k] = 0;
        for (int i = 0; i <= p; i++)
            for (int j = 0; j <= q; j++)
                out[k] += binomial[p][i] * binomial[q][j] * a[jet_index(i, j)] * b[jet_index(p - i, q - j)];
    }
}

void co_bspline_cubic(co_real t, co_real basis[4][4]) {
    co_real s = 1 - t;
    const co_real b[4][4] = {
        {s * s * s / 6, -s * s / 2, s, -1},
        {(3 * t * t * t - 6 * t * t + 4) / 6, (3 * t * t - 4 * t) / 2, 3 * t - 2, 3},
        {(3 * s * s * s - 6 * s * s + 4) / 6, -(3 * s * s - 4 * s) / 2, 3 * s - 2, -3},
        {t * t * t / 6, t * t / 2, t, 1},
    };
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++)
            basis[i][k] = b[i][k];
}

void co_bspline_bicubic(co_real u, co_real v, co_real rows[16][CO_JET]) {
    co_real along_u[4][4], along_v[4][4];
    co_bspline_cubic(u, along_u);
    co_bspline_cubic(v, along_v);
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++)
            co_jet_of_product(along_u[i], along_v[j], rows[4 * j + i]);
}
