/* Vectors. SPDX-License-Identifier: GPL-3.0-or-later */
#include "linalg/vector.h"

#include <math.h>

double co_vector_dot(size_t n, const double *a, const double *b) {
    double sum[4] = {0, 0, 0, 0};
    size_t i = 0;
    for (; i + 4 <= n; i += 4)
        for (size_t k = 0; k < 4; k++)
            sum[k] += a[i + k] * b[i + k];
    for (; i < n; i++)
        sum[0] += a[i] * b[i];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

double co_vector_norm(size_t n, const double *a) {
    return sqrt(co_vector_dot(n, a, a));
}

void co_vector_add(size_t n, double s, const double *x, double *y) {
    for (size_t i = 0; i < n; i++)
        y[i] += s * x[i];
}

void co_vector_remove(size_t n, size_t count, const double *q, double *x) {
    for (size_t k = 0; k < count; k++)
        co_vector_add(n, -co_vector_dot(n, q + k * n, x), q + k * n, x);
}
