/* Gauss-Legendre rules on 0..1. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_QUADRATURE_H
#define CO_QUADRATURE_H

#include "bspline.h"

/* Nodes and weights [n]; weights sum to 1. */
void co_quadrature_gauss(int n, co_real *nodes, co_real *weights);

#endif
