/* One cell of a ring round an extraordinary vertex (stam.h): rows of its points over the two-ring, on any surface
 * that is linear in it. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_RING_CELL_H
#define CO_SURFACE_RING_CELL_H

#include "surface/blend_fit.h"
#include "surface/chart.h"

/* The functions that rows of a cell's points are sums of: 1 - w, the patch's 16, the polynomial's, and on half discs
 * five of the curve. */
enum {
    CO_RING_CELL_TERM = 1 + 16, /* index of the polynomial's first */
    CO_RING_CELL_CURVE = CO_RING_CELL_TERM + CO_BLEND_FIT_FUNCTIONS,
    CO_RING_CELL_GENERATORS = CO_RING_CELL_CURVE + 5 /* CO_BLEND_FIT_CURVE */
};

/* On a surface of width 1 (blend_fit.h) rows stand on the two-ring alone. On wider ones the polynomial's coefficients
 * c_a are points of their own, CO_BLEND_FIT_TERMS of them after the cell's: q_0 = c_0, q_a = c_0 + c_a. Rows then sum
 * to 1: sum of c_a p_a = (1 - sum over a > 0 of p_a) q_0 + sum over a > 0 of p_a q_a. So it is in discs of width 1.
 *
 * There the rows of points far from the face are nearly the same (co_stam_in_window): with `window` their mean row,
 * once for neighbours over edges and once for those across faces, is taken off all rows, and goes to the mean of these
 * neighbours (blend_disc.h), as many times as there are. Rows of far points are then left out; their sum is 0. */
typedef struct co_ring_cell {
    int32_t sector;         /* of the fan; in closed ones 0 */
    int is_face;            /* not at the vertex: one bicubic patch */
    int32_t n_points;       /* points of the two-ring, or 16 on a face of a wide disc away from the vertex */
    double origin[2], side; /* corner next to the vertex, and side, in units of a face of the sector */
    double *base;           /* [n_points] the row that is nearly the same in all of the cell's points */
    double *points;         /* [16][n_points] control points of the cell's bicubic patch, less `base` */
    double *weights;        /* [n_points][CO_RING_CELL_GENERATORS] weights of the functions in each row */
    double map[16][2];      /* control points of the map, less `map_base`; unused without chart and polynomial */
    double map_base[2];     /* where the map has the vertex in this ring; not 0 at darts alone */
    int32_t window;         /* sectors on either side whose points have rows; 0: all */
    double mean[2][CO_RING_CELL_GENERATORS]; /* weights of the functions in the rows of means; 0 without window */
    const co_blend_fit *polynomial;          /* NULL: the limit surface itself */
    int order;           /* of the highest derivatives that rows have, 2 or 3; what is above is NAN */
    const double *chart; /* [2 n_points] the characteristic map; NULL: derivatives are with respect to s, t */
} co_ring_cell;

/* Makes room for the cells of a disc, without window, of third order. polynomial: NULL for the limit surface. chart:
 * the polynomial's map; without polynomial the characteristic map's control points [2 n_points] over the two-ring; NULL
 * for derivatives with respect to s and t. Both are borrowed and must outlive the cell. ERROR_MEMORY. */
int32_t co_ring_cell_create(const co_stam_disc *disc, const co_blend_fit *polynomial, const double *chart,
                            co_ring_cell *cell, curvopt_error *error);
/* Makes a cell that is the whole face (i, j) of a sector of a wide disc, not the one at the vertex. ERROR_MEMORY. */
int32_t co_ring_cell_create_face(const co_blend_fit *polynomial, int32_t sector, int i, int j, co_ring_cell *cell,
                                 curvopt_error *error);
void co_ring_cell_free(co_ring_cell *cell);
/* Becomes cell number `which` of the disc's present ring. */
void co_ring_cell_set(co_ring_cell *cell, const co_stam_disc *disc, int which);
/* Rows at (s, t) in 0..1 of the cell: rows [n_support][CO_JET] for the points support [n_support]; those from n_points
 * on are a disc's coefficients. Derivatives are with respect to the characteristic map, and *chart is the change to it;
 * without one they are with respect to s, t, and chart->jacobian is 1. Derivatives above cell->order are NAN. */
void co_ring_cell_rows(const co_ring_cell *cell, double s, double t, int32_t n_support, const int32_t *support,
                       double *rows, co_chart *chart);
/* Jet of the blending weight at (s, t), derivatives with respect to s, t. */
void co_ring_cell_blend(const co_ring_cell *cell, co_blend_kind blend, double s, double t, double jet[CO_JET]);

#endif
