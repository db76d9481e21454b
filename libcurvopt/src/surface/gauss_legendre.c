/* Gauss-Legendre quadrature rules on 0..1 (source: gauss_legendre.h). SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/gauss_legendre.h"

#include "base/elementary.h"

#include <math.h>

/* Legendre polynomial of degree n and its derivative at x, by the three-term recurrence. */
static void legendre(int n, double x, double *value, double *slope) {
    double p0 = 1, p1 = x;
    for (int k = 2; k <= n; k++) {
        double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
    }
    *value = p1;
    *slope = n * (x * p1 - p0) / (x * x - 1);
}

void co_gauss_legendre(int n, double *nodes, double *weights) {
    if (n == 1) {
        nodes[0] = 0.5;
        weights[0] = 1;
        return;
    }
    for (int i = 0; i < n; i++) {
        double x = -co_cos_pi((i + 0.75) / (n + 0.5)), value, slope;
        for (int step = 0; step < 8; step++) { /* Newton; quadratic from Tricomi's start */
            legendre(n, x, &value, &slope);
            x -= value / slope;
        }
        legendre(n, x, &value, &slope);
        nodes[i] = (1 + x) / 2;
        weights[i] = 1 / ((1 - x * x) * slope * slope);
    }
}
