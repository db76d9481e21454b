/* Gauss-Legendre rules on 0..1. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_GAUSS_LEGENDRE_H
#define CO_SURFACE_GAUSS_LEGENDRE_H

#include "surface/bspline.h"

/* Nodes and weights [n]; weights sum to 1. */
void co_gauss_legendre(int n, co_real *nodes, co_real *weights);

#endif
