/* Change of parameters (method: chart.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/chart.h"

#include "linalg/small_dense.h"

#include <math.h>
#include <string.h>

enum { LARGEST_BLOCK = 4 };
/* First of the derivatives of order 0, 1, 2, 3; last, their number. */
static const int block_start[5] = {0, 1, 3, 6, CO_JET};

void co_chart_create(const double x[CO_JET], const double y[CO_JET], int highest, co_chart *chart) {
    double d[2][CO_JET];
    memcpy(d[0], x, sizeof d[0]);
    memcpy(d[1], y, sizeof d[1]);
    d[0][0] = d[1][0] = 0;
    chart->order = highest;
    memset(chart->monomial, 0, sizeof chart->monomial);
    chart->monomial[0][0] = 1;
    for (int order = 1; order <= highest; order++) {
        int at = block_start[order], before = block_start[order - 1];
        for (int b = 0; b <= order; b++) /* dx^(order - b) dy^b, from one factor less of the coordinate that is there */
            co_jet_multiply(d[b > 0], chart->monomial[before + (b > 0 ? b - 1 : 0)], chart->monomial[at + b]);
    }
    for (int k = 0; k < block_start[highest + 1]; k++) {
        static const double factorial[4] = {1, 1, 2, 6};
        for (int j = 0; j < CO_JET; j++)
            chart->monomial[k][j] /= factorial[co_jet_order_u[k]] * factorial[co_jet_order_v[k]];
    }
    for (int order = 1; order <= highest; order++) {
        int first = block_start[order], n = order + 1;
        double block[LARGEST_BLOCK][LARGEST_BLOCK];
        for (int j = 0; j < n; j++)
            for (int k = 0; k < n; k++)
                block[j][k] = chart->monomial[first + k][first + j];
        co_small_dense_invert(n, LARGEST_BLOCK, block[0], chart->inverse[order][0]);
    }
    chart->jacobian = x[1] * y[2] - x[2] * y[1];
}

void co_chart_apply(const co_chart *chart, double jet[CO_JET]) {
    const int n = block_start[chart->order + 1];
    for (int order = 1; order <= chart->order; order++) {
        int first = block_start[order], end = block_start[order + 1];
        double in[LARGEST_BLOCK];
        memcpy(in, jet + first, sizeof *in * (size_t)(end - first));
        for (int k = first; k < end; k++) {
            jet[k] = 0;
            for (int j = first; j < end; j++)
                jet[k] += chart->inverse[order][k - first][j - first] * in[j - first];
        }
        for (int j = end; j < n; j++) /* takes the part of this order out of higher ones */
            for (int k = first; k < end; k++)
                jet[j] -= jet[k] * chart->monomial[k][j];
    }
    for (int j = n; j < CO_JET; j++)
        jet[j] = (double)NAN;
}
