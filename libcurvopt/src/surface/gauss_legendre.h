/* Gauss-Legendre quadrature rules on 0..1: Abramowitz, Stegun, "Handbook of mathematical functions", 1964, 25.4.29;
 * nodes by Newton's iteration from Tricomi's start. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_GAUSS_LEGENDRE_H
#define CO_SURFACE_GAUSS_LEGENDRE_H

#include "surface/bspline.h"

/* Fills nodes and weights [n], n >= 1; weights sum to 1. O(n^2). */
void co_gauss_legendre(int n, double *nodes, double *weights);

#endif
