/* The curve's part of rows on a half disc: E of blend_fit_half.h. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_RING_CELL_CURVE_H
#define CO_SURFACE_RING_CELL_CURVE_H

#include "surface/ring_cell.h"

/* Jets of a cell's functions, one after the other (ring_cell.c). */
typedef double co_ring_cell_generators[CO_RING_CELL_GENERATORS][CO_JET];

/* Sets the weights of the curve's points in cell->weights, where the other points' are 0. */
void co_ring_cell_curve_weights(co_ring_cell *cell);
/* At (s, t): takes p's part of E off the monomials' functions, and fills those of the curve. w: jet of W; chi: of the
 * map; both, as all in g, in the chart's coordinates, or if it is NULL in s, t. */
void co_ring_cell_curve_apply(const co_ring_cell *cell, co_real s, co_real t, const co_chart *chart,
                              const double w[CO_JET], double chi[2][CO_JET], co_ring_cell_generators g);

#endif
