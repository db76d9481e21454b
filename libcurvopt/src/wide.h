/* Wide blends: where the cage has room round an extraordinary vertex, `polynomial` blends over m x m faces of each
 * sector there instead of one.
 *
 * With one face the surface near the vertex looks the same at every level of refinement but for its size, and keeps the
 * same error in third-order energies; with m growing as faces shrink, the disc stays about the same piece of surface
 * and the error goes (tests/bench/README.md). The width follows from the mesh alone: a quarter of the distance in rings
 * of faces to the nearest vertex that is not regular, `widest` at most. So discs never meet, nor their points,
 * and a refined cage has discs of twice the width, up to the largest.
 *
 * The coefficients of P are points of the surface, which patches on a disc have beside their own: 21 a sector, because
 * patches of one kind must find theirs in their own sector's frame. Sector 0's are rows over the disc's points, the
 * same for all discs of a valence and width; the others are these, turned.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_WIDE_H
#define CO_WIDE_H

#include "mesh.h"
#include "polynomial.h"

enum { CO_WIDE_LARGEST = 8, CO_WIDE_TERMS = CO_POLYNOMIAL_TERMS };

/* What discs of one valence and width have in common. */
typedef struct co_wide_fit {
    int32_t valence, width, n_points;
    double *matrix; /* [CO_WIDE_TERMS][n_points] sector 0's points over the disc's; each row sums to 1 */
    double *turn;   /* [valence][CO_WIDE_TERMS][CO_WIDE_TERMS] other sectors' points over sector 0's */
} co_wide_fit;

typedef struct co_wide_disc {
    int32_t fit;
    int32_t first_point; /* number of sector 0's first one; sector s begins CO_WIDE_TERMS s later */
    size_t column;       /* of co_wide.column: where the disc's points begin */
    int is_used;         /* whether any patch on it counts */
} co_wide_disc;

typedef struct co_wide_face {
    int32_t disc;  /* -1: on none */
    int32_t first; /* half-edge that leaves the corner nearest to the vertex along the sector's u */
    int32_t sector, i, j;
} co_wide_face;

typedef struct co_wide {
    int32_t n_fits, n_discs, n_points; /* points: of all sectors of all discs */
    co_wide_fit *fit;
    co_wide_disc *disc;
    int32_t *column;    /* vertices */
    co_wide_face *face; /* [n_faces]; NULL if there are no discs, and once there are patches */
} co_wide;

/* kind [n_corners]: ring.h; widest: 1 .. CO_WIDE_LARGEST. Points are numbered from 0 on. ERROR_MEMORY. */
int32_t co_wide_find(const curvopt_mesh *mesh, const uint8_t *kind, int widest, co_wide *out, curvopt_error *error);
void co_wide_free(co_wide *wide);
/* Points of the discs that are used from the cage's, both in points [3 n]. */
void co_wide_apply(const co_wide *wide, double *points);
/* gradient [3 n_cage] += what gradients with respect to the discs' points, in point_gradient [3 n], are worth. */
void co_wide_add_transposed(const co_wide *wide, const double *point_gradient, double *gradient);

static inline const co_wide_fit *co_wide_fit_of(const co_wide *wide, const co_wide_disc *disc) {
    return &wide->fit[disc->fit];
}

#endif
