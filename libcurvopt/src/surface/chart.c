/* Derivatives with respect to one pair of coordinates from those with respect to another.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/chart.h"

#include <math.h>
#include <string.h>

enum { LARGEST_BLOCK = 4 };
static const int block_start[4] = {0, 1, 3, 6}; /* derivatives of order 0, 1, 2, 3 */

/* Inverts a [n][n] by Gauss's and Jordan's elimination with pivots. */
static void invert(int n, double a[LARGEST_BLOCK][LARGEST_BLOCK], double out[LARGEST_BLOCK][LARGEST_BLOCK]) {
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            out[i][j] = i == j;
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(a[i][k]) > fabs(a[pivot][k]))
                pivot = i;
        for (int j = 0; j < n; j++) {
            double x = a[k][j], y = out[k][j];
            a[k][j] = a[pivot][j];
            a[pivot][j] = x;
            out[k][j] = out[pivot][j];
            out[pivot][j] = y;
        }
        double scale = 1 / a[k][k];
        for (int j = 0; j < n; j++) {
            a[k][j] *= scale;
            out[k][j] *= scale;
        }
        for (int i = 0; i < n; i++) {
            double factor = a[i][k];
            for (int j = 0; j < n && i != k; j++) {
                a[i][j] -= factor * a[k][j];
                out[i][j] -= factor * out[k][j];
            }
        }
    }
}

void co_chart_create(const double x[CO_JET], const double y[CO_JET], co_chart *chart) {
    double d[2][CO_JET];
    memcpy(d[0], x, sizeof d[0]);
    memcpy(d[1], y, sizeof d[1]);
    d[0][0] = d[1][0] = 0;
    memset(chart->monomial, 0, sizeof chart->monomial);
    chart->monomial[0][0] = 1;
    for (int order = 1; order <= 3; order++) {
        int at = block_start[order], before = block_start[order - 1];
        for (int b = 0; b <= order; b++) /* dx^(order - b) dy^b, from one factor less of the coordinate that is there */
            co_jet_multiply(d[b > 0], chart->monomial[before + (b > 0 ? b - 1 : 0)], chart->monomial[at + b]);
    }
    for (int k = 0; k < CO_JET; k++) {
        static const double factorial[4] = {1, 1, 2, 6};
        for (int j = 0; j < CO_JET; j++)
            chart->monomial[k][j] /= factorial[co_jet_order_u[k]] * factorial[co_jet_order_v[k]];
    }
    for (int order = 1; order <= 3; order++) {
        int first = block_start[order], n = order + 1;
        double block[LARGEST_BLOCK][LARGEST_BLOCK];
        for (int j = 0; j < n; j++)
            for (int k = 0; k < n; k++)
                block[j][k] = chart->monomial[first + k][first + j];
        invert(n, block, chart->inverse[order]);
    }
    chart->jacobian = x[1] * y[2] - x[2] * y[1];
}

void co_chart_apply(const co_chart *chart, double jet[CO_JET]) {
    for (int order = 1; order <= 3; order++) {
        int first = block_start[order], end = first + order + 1;
        double in[LARGEST_BLOCK];
        memcpy(in, jet + first, sizeof *in * (size_t)(end - first));
        for (int k = first; k < end; k++) {
            jet[k] = 0;
            for (int j = first; j < end; j++)
                jet[k] += chart->inverse[order][k - first][j - first] * in[j - first];
        }
        for (int j = end; j < CO_JET; j++) /* what derivatives of this order leave in higher ones */
            for (int k = first; k < end; k++)
                jet[j] -= jet[k] * chart->monomial[k][j];
    }
}
