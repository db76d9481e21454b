/* The limit surface near an extraordinary vertex, as rows over its fan's two-ring (numbered as in fan.h).
 *
 * Follows: Stam, "Exact evaluation of Catmull-Clark subdivision surfaces at arbitrary parameter values", SIGGRAPH 1998.
 * Differs in that the powers of the subdivision matrix are formed by repeated sparse products, in long double and once
 * per table, not by an eigenbasis: our parameter values are known when the table is built, and nothing then depends on
 * the conditioning of eigenvectors. The face, parameters (0,0) at the vertex, is cut into rings: ring n = 1, 2, ... has
 * three cells of side 2^-n, at (1,0), (1,1), (0,1) in units of that side, each a bicubic patch.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_STAM_H
#define CO_SURFACE_STAM_H

#include "linalg/sparse_rows.h"
#include "mesh/ring.h"
#include "surface/bspline.h"

enum { CO_RING_CELLS = 3 };

/* Places of a ring's cells in units of their side. */
extern const int co_stam_cell_place[CO_RING_CELLS][2];

typedef struct co_stam_disc {
    int32_t fan;
    int32_t valence;       /* sectors */
    int32_t n_points;      /* co_fan_n_points() */
    int32_t ring;          /* which ring's cells co_stam_disc_cell() gives; starts at 1 */
    co_sparse_rows refine; /* the disc's refined points over the two-ring */
    int32_t *inner;        /* [n_points] refined points that are the next ring's two-ring */
    int32_t cell[CO_RING_CELLS]
                [16]; /* refined points of each cell's bicubic patch; where that is a phantom, the point */
    int32_t mirrored[CO_RING_CELLS][16]; /* that is doubled, and here the one that is taken off; else -1 */
    co_real *power;                      /* [n_points][n_points] two-ring of this ring over the original one */
    co_real *next_power;                 /* work */
    /* Rings' areas shrink by lambda^2, integrals of squared curvature over them by mu^2 / lambda^2. At a smooth vertex
     * lambda is the subdominant eigenvalue, mu the largest after it. Elsewhere two eigenvalues a >= b make the tangent
     * plane and c the height, which behaves worst along b: lambda^2 = a b and mu^2 / lambda^2 = (c / b^2)^2 a b. */
    co_real lambda;
    co_real mu;
} co_stam_disc;

/* A valence, or any other fan but the regular ones. */
int32_t co_stam_disc_create(int32_t fan, co_stam_disc *disc, curvopt_error *error);
void co_stam_disc_free(co_stam_disc *disc);
/* To the next ring. */
void co_stam_disc_advance(co_stam_disc *disc);
/* Control points of a cell of the current ring over the two-ring: out [16][n_points]. */
void co_stam_disc_cell(const co_stam_disc *disc, int cell, co_real *out);

/* Limit position of the vertex over the fan's points: mask [n_points]. Advances the disc to where it has converged. */
void co_stam_disc_limit_mask(co_stam_disc *disc, co_real *mask);

/* Limit position and two tangents (their cross product points outward) over the two-ring of a smooth vertex: masks
 * [3][n_points]. Halstead, Kass, DeRose, "Efficient, fair interpolation using Catmull-Clark surfaces", SIGGRAPH 1993.
 */
void co_stam_limit_masks(int32_t valence, co_real *masks);

/* Whether the limit patch of the fan's sector can depend on point i of the two-ring (2 N + 8 of them where it is
 * closed). */
int co_stam_in_support(int32_t fan, int32_t i);

/* Eigenvectors of the subdominant eigenvalue over a smooth vertex's two-ring: the characteristic map's control points,
 * x y [2 n_points], scaled to mean distance 1 of the first-ring edge points. */
void co_stam_characteristic_map(const co_stam_disc *disc, co_real *xy);

#endif
