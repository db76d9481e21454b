/* Derivatives with respect to one pair of coordinates from those with respect to another.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "chart.h"

#include <math.h>
#include <string.h>

enum { LARGEST_BLOCK = 4 };
static const int block_start[5] = {0, 1, 3, 6, CO_JET}; /* derivatives of order 0, 1, 2, 3 */

void co_chart_create(const co_real x[CO_JET], const co_real y[CO_JET], co_chart *chart) {
    co_real d[2][CO_JET];
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
        static const co_real factorial[4] = {1, 1, 2, 6};
        for (int j = 0; j < CO_JET; j++)
            chart->monomial[k][j] /= factorial[co_jet_order_u[k]] * factorial[co_jet_order_v[k]];
    }
    chart->jacobian = x[1] * y[2] - x[2] * y[1];
}

/* Solves a x = b in place of b by Gaussian elimination with pivots. */
static void solve(int n, co_real a[LARGEST_BLOCK][LARGEST_BLOCK], co_real *b) {
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabsl(a[i][k]) > fabsl(a[pivot][k]))
                pivot = i;
        for (int j = 0; j < n; j++) {
            co_real swap = a[k][j];
            a[k][j] = a[pivot][j];
            a[pivot][j] = swap;
        }
        co_real swap = b[k];
        b[k] = b[pivot];
        b[pivot] = swap;
        for (int i = k + 1; i < n; i++) {
            co_real factor = a[i][k] / a[k][k];
            for (int j = k; j < n; j++)
                a[i][j] -= factor * a[k][j];
            b[i] -= factor * b[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++)
            b[k] -= a[k][j] * b[j];
        b[k] /= a[k][k];
    }
}

void co_chart_apply(const co_chart *chart, co_real jet[CO_JET]) {
    for (int order = 1; order <= 3; order++) {
        int first = block_start[order], end = block_start[order + 1];
        co_real block[LARGEST_BLOCK][LARGEST_BLOCK];
        for (int j = first; j < end; j++)
            for (int k = first; k < end; k++)
                block[j - first][k - first] = chart->monomial[k][j];
        solve(end - first, block, jet + first);
        for (int j = end; j < CO_JET; j++) /* what derivatives of this order leave in higher ones */
            for (int k = first; k < end; k++)
                jet[j] -= jet[k] * chart->monomial[k][j];
    }
}
