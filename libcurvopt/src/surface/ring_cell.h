/* One cell of a ring round an extraordinary vertex (stam.h): rows of its points over the two-ring, on any surface
 * that is linear in it. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_RING_CELL_H
#define CO_SURFACE_RING_CELL_H

#include "surface/blend_fit.h"
#include "surface/chart.h"

/* Functions that the rows of a cell's points are sums of: one beside its patch's 16 and the polynomial's. */
enum { CO_RING_CELL_GENERATORS = 1 + 16 + CO_BLEND_FIT_TERMS };

/* A surface of width 1 (blend_fit.h) is rows over the two-ring. On wider ones the polynomial's coefficients are points
 * of their own, CO_BLEND_FIT_TERMS of them after the cell's: q_0 = c_0, q_a = c_0 + c_a, so that rows sum to 1. */
typedef struct co_ring_cell {
    int32_t n_points;               /* of the two-ring; 16 on faces of a wide disc away from the vertex */
    co_real origin[2], side;        /* place in the sector, in faces */
    co_real *points;                /* [16][n_points] control points of its bicubic patch over these */
    double *weights;                /* [n_points][CO_RING_CELL_GENERATORS] what each one's row is made of (cell.c) */
    double map[16][2];              /* control points of the characteristic map, if it is known */
    const co_blend_fit *polynomial; /* NULL: the limit surface itself */
    const co_real *chart;           /* NULL: derivatives are with respect to s, t */
} co_ring_cell;

/* Room for cells of a disc. Both must outlive them: `polynomial`, NULL for the limit surface; `chart`, the polynomial's
 * map, without one [2 n_points] the characteristic map's control points over the two-ring, NULL for derivatives with
 * respect to s, t. */
int32_t co_ring_cell_create(const co_stam_disc *disc, const co_blend_fit *polynomial, const co_real *chart,
                            co_ring_cell *cell, curvopt_error *error);
/* The whole face (i, j) of a wide disc, not the one at the vertex. */
int32_t co_ring_cell_create_face(const co_blend_fit *polynomial, int i, int j, co_ring_cell *cell,
                                 curvopt_error *error);
void co_ring_cell_free(co_ring_cell *cell);
/* Becomes cell number `which` of the disc's present ring. */
void co_ring_cell_set(co_ring_cell *cell, const co_stam_disc *disc, int which);
/* Rows at (s, t) in 0..1 of the cell: rows [n_support][CO_JET], of the two-ring points support [n_support]; points from
 * n_points on are the polynomial's. Derivatives are with respect to the chart, the characteristic map, if there is one,
 * else to s, t. *chart is the former; its Jacobian is 1 if there is none. */
void co_ring_cell_rows(const co_ring_cell *cell, co_real s, co_real t, int32_t n_support, const int32_t *support,
                       double *rows, co_chart *chart);
/* Jet of the blend there, derivatives with respect to s, t. */
void co_ring_cell_blend(const co_ring_cell *cell, co_blend_kind blend, co_real s, co_real t, co_real jet[CO_JET]);

#endif
