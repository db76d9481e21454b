/* Small dense matrices: inverse and eigenvalues. SPDX-License-Identifier: GPL-3.0-or-later */
#include "linalg/small_dense.h"

#include <math.h>

void co_small_dense_invert(int n, int stride, double *a, double *out) {
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            out[i * stride + j] = i == j;
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(a[i * stride + k]) > fabs(a[pivot * stride + k]))
                pivot = i;
        for (int j = 0; j < n; j++) {
            double x = a[k * stride + j], y = out[k * stride + j];
            a[k * stride + j] = a[pivot * stride + j];
            a[pivot * stride + j] = x;
            out[k * stride + j] = out[pivot * stride + j];
            out[pivot * stride + j] = y;
        }
        double scale = 1 / a[k * stride + k];
        for (int j = 0; j < n; j++) {
            a[k * stride + j] *= scale;
            out[k * stride + j] *= scale;
        }
        for (int i = 0; i < n; i++) {
            double factor = a[i * stride + k];
            for (int j = 0; j < n && i != k; j++) {
                a[i * stride + j] -= factor * a[k * stride + j];
                out[i * stride + j] -= factor * out[k * stride + j];
            }
        }
    }
}

/* (x, y) <- (c x - s y, s x + c y) for the n pairs at x and y, `step` numbers apart. */
static void rotate(int n, int step, double *x, double *y, double c, double s) {
    for (int k = 0; k < n; k++, x += step, y += step) {
        double old_x = *x, old_y = *y;
        *x = c * old_x - s * old_y;
        *y = s * old_x + c * old_y;
    }
}

void co_small_dense_eigen(int n, int stride, double *a, double *value, double *v) {
    enum { MOST_SWEEPS = 60 }; /* far more than the ten or so after which all of the triangle is 0 */
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            v[i * stride + j] = i == j;
    for (int sweep = 0; sweep < MOST_SWEEPS; sweep++)
        for (int p = 0; p < n; p++)
            for (int q = p + 1; q < n; q++) {
                double off = a[p * stride + q];
                if (off == 0)
                    continue;
                double theta = (a[q * stride + q] - a[p * stride + p]) / (2 * off);
                double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
                double c = 1 / sqrt(t * t + 1), s = t * c;
                rotate(n, stride, a + p, a + q, c, s);
                rotate(n, 1, a + p * stride, a + q * stride, c, s);
                rotate(n, stride, v + p, v + q, c, s);
            }
    for (int i = 0; i < n; i++)
        value[i] = a[i * stride + i];
}
