/* The curve's part of rows on a half disc: E of blend_fit_half.h. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_RING_CELL_CURVE_H
#define CO_SURFACE_RING_CELL_CURVE_H

#include "surface/blend_fit_cut.h"
#include "surface/chart.h"

/* Which cell of a half disc it is: see co_ring_cell (ring_cell.h). */
typedef struct co_ring_cell_place {
    const co_blend_fit *polynomial;
    int32_t sector;
    int is_face; /* a whole face, not one of those at the vertex */
    double origin[2], side;
} co_ring_cell_place;

/* Sets the weights of CO_BLEND_FIT_CURVE functions in the rows of the curve's points: `weights` is the first point's,
 * `stride` doubles lie from point to point, and all are 0 before. */
void co_ring_cell_curve_weights(const co_ring_cell_place *cell, double *weights, size_t stride);
/* At (s, t): takes p's part of E off the jets `terms` [CO_BLEND_FIT_FUNCTIONS] of W times the polynomial's functions,
 * and fills the jets `curve` [CO_BLEND_FIT_CURVE] of the functions that those weights belong to. w: jet of W; chi: of
 * the map; all in the chart's coordinates, or if it is NULL in s, t. */
void co_ring_cell_curve_apply(const co_ring_cell_place *cell, double s, double t, const co_chart *chart,
                              const double w[CO_JET], double chi[2][CO_JET], double (*terms)[CO_JET],
                              double (*curve)[CO_JET]);

#endif
