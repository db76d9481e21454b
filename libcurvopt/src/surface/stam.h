/* The limit surface near an extraordinary vertex, as rows over its fan's two-ring (numbered as in fan.h).
 *
 * Follows: Stam, "Exact evaluation of Catmull-Clark subdivision surfaces at arbitrary parameter values", SIGGRAPH 1998.
 * Differs in that no eigenbasis is used: the few rows of control points that cells need are multiplied by the sparse
 * subdivision matrix from the left, ring after ring, in double (notes/35-tables-of-high-valence.md). Our parameter
 * values are known when the table is built, and nothing then depends on the conditioning of eigenvectors. The face,
 * parameters (0,0) at the vertex, is cut into rings: ring n = 1, 2, ... has three cells of side 2^-n, at (1,0), (1,1),
 * (0,1) in units of that side, each a bicubic patch:
 *
 *     +-------+-------+
 *     |       |       |      cells of ring 1: 0 right below, 1 diagonal, 2 left above; the fourth quarter, at the
 *     |   2   |   1   |      vertex V, is cut alike into ring 2 and a quarter of its own, and so on
 *     +---+---+-------+
 *     | 2 | 1 |       |      Example: (u, v) = (0.3, 0.1): 0.3 < 1/2, so not in ring 1; 0.3 >= 1/4, so in ring 2,
 *     +---+---+   0   |      and 0.1 < 1/4 makes it cell 0, at (s, t) = (0.3 - 1/4, 0.1) / (1/4) = (0.2, 0.4)
 *     V---+---+-------+
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_STAM_H
#define CO_SURFACE_STAM_H

#include "linalg/sparse_rows.h"
#include "mesh/ring.h"
#include "surface/bspline.h"

enum {
    CO_RING_CELLS = 3,
    CO_STAM_MOST_ROWS = 32, /* most points that the cells of a ring are made of: 5 x 5 places, and those of phantoms */
    CO_STAM_WINDOW = 24     /* the largest window: tables of blends have 22 rings at most */
};

/* Place (x, y) of each cell of a ring, in units of its side. */
extern const int co_stam_cell_place[CO_RING_CELLS][2];

typedef struct co_stam_disc {
    int32_t fan;                         /* kind of the patch (fan.h) */
    int32_t valence;                     /* number of sectors */
    int32_t n_points;                    /* points of the two-ring */
    int32_t ring;                        /* the present ring, whose cells co_stam_disc_cell() gives; 1 at first */
    co_sparse_rows refine;               /* the disc's refined points over the two-ring */
    int32_t *inner;                      /* [n_points] refined points that are the next ring's two-ring */
    int32_t n_rows;                      /* points that cells are made of; the first is the vertex */
    int32_t cell[CO_RING_CELLS][16];     /* which of them are each cell's; for a phantom 2 P - Q the point P */
    int32_t mirrored[CO_RING_CELLS][16]; /* the point Q of a phantom 2 P - Q; -1: no phantom */
    double *rows;      /* [n_points][n_rows] the present ring's such points over the two-ring, column by column: the
                           vertex, and how the others differ from it */
    double *next_rows; /* [n_points][n_rows] work space */
    double lambda;     /* ratio of lengths of successive rings, see below */
    double mu;         /* ratio of heights above the tangent plane, see below */
} co_stam_disc;

/* Rings' areas shrink by lambda^2, integrals of squared curvature over them by mu^2 / lambda^2. At a smooth vertex
 * lambda is the subdominant eigenvalue and mu the largest after it. Elsewhere two eigenvalues a >= b make the tangent
 * plane and c the height, which behaves worst along b; lambda and mu are then such that lambda^2 = a b and mu^2 /
 * lambda^2 = (c / b^2)^2 a b. */

/* Makes the disc of a fan that is not regular, at ring 1. Linear in the number of sectors. ERROR_MEMORY. */
int32_t co_stam_disc_create(int32_t fan, co_stam_disc *disc, curvopt_error *error);
void co_stam_disc_free(co_stam_disc *disc);
/* Goes on to the next ring: linear in n_points. */
void co_stam_disc_advance(co_stam_disc *disc);
/* Control points of a cell of the present ring as rows over the two-ring: vertex [n_points] + out [16][n_points]. The
 * differences from the vertex are as exact, in parts of themselves, however small they have become. */
void co_stam_disc_cell(const co_stam_disc *disc, int cell, double *vertex, double *out);

/* Limit position of the vertex as a row over the fan's points: mask [n_points]. Advances the disc to ring 120, where
 * subdivision has converged. */
void co_stam_disc_limit_mask(co_stam_disc *disc, double *mask);

/* Limit position and two tangents, whose cross product points outward, as rows over the two-ring of a smooth vertex:
 * masks [3][n_points]. Halstead, Kass, DeRose, "Efficient, fair interpolation using Catmull-Clark surfaces", SIGGRAPH
 * 1993.
 */
void co_stam_limit_masks(int32_t valence, double *masks);

/* Whether the limit patch of the fan's sector can depend on point i of the two-ring. In a closed fan of N sectors there
 * are 2 N + 8 such points. */
int co_stam_in_support(int32_t fan, int32_t i);
/* Whether point i of the two-ring of a closed fan is within `window` sectors of sector 0, or not in the one-ring. Each
 * subdivision makes a face depend on one more sector on either side, and on all others only by the vertex, which the
 * means of the one-ring move. So ring r depends alike on all points beyond r + 1 sectors. A window that would not leave
 * two points out has no effect. */
int co_stam_in_window(int32_t fan, int32_t window, int32_t i);

/* Control points of the characteristic map (Reif 1995) of a smooth vertex: xy [2 n_points], the eigenvectors of the
 * subdominant eigenvalue over the two-ring, scaled so that the first-ring edge points have distance 1 from the vertex.
 * By the power method on functions of frequency 1. Of valence 2, where the eigenvalue belongs to several vectors, the
 * net that it starts from. */
void co_stam_characteristic_map(const co_stam_disc *disc, double *xy);

#endif
