/* Gauss-Legendre rules on 0..1. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_QUADRATURE_H
#define CO_QUADRATURE_H

#include "bspline.h"

enum { CO_GAUSS_MAX = 16 };

/* Nodes and weights [n], n <= CO_GAUSS_MAX; weights sum to 1. */
void co_quadrature_gauss(int n, co_real *nodes, co_real *weights);

#endif
