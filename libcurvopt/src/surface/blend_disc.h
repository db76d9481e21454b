/* Discs round extraordinary vertices, whose patches depend on the whole disc by a few coefficients.
 *
 * Wide blends: where the cage has room round an extraordinary vertex, `polynomial` blends over m x m faces of each
 * sector there instead of one.
 *
 * With one face the surface near the vertex looks the same at every level of refinement but for its size, and keeps the
 * same error in third-order energies; with m growing as faces shrink, the disc stays about the same piece of surface
 * and the error goes (notes/11-blend-width.md, notes/12-widest-blend.md). The width follows from the mesh alone: a
 * quarter of the distance in rings of faces to the nearest vertex that is not regular, `widest` at most. So discs never
 * meet, nor their points, and a refined cage has discs of twice the width, up to the largest. Width 2 at a vertex of
 * valence 3, sector 0:
 *
 *     +----+----+      faces (i, j) of the sector; the vertex V is its corner (0, 0). P is fitted on all 3 * 4 faces,
 *     |0,1 |1,1 |      w falls from 1 at V to 0 along the two outer sides. The fit depends on the points at places
 *     +----+----+      0 .. 3 of each sector, one ring of points more than the faces have: 1 + 3 * 3 * 4 = 37 points.
 *     |0,0 |1,0 |
 *     V----+----+
 *
 * The coefficients of P are points of the surface, which patches on a disc have beside their own: 21 a sector, because
 * patches of one kind must find theirs in their own sector's frame. Sector 0's are rows over the disc's points, the
 * same for all discs of a valence and width; the others are these, turned.
 *
 * Poles on boundaries and creases have half discs (blend_disc_half.h), with one set of coefficients for all sectors.
 *
 * Discs of width 1 are for vertices of high valence N. Every face there depends on all 6 N + 1 points round the
 * vertex, but on those that are far from it through few sums only: through P, and through the mean of the neighbours
 * over edges and that of the neighbours across faces, which each subdivision moves the vertex by. These means are two
 * more coefficients; what else a face depends on is near it (ring_cell.h).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BLEND_DISC_H
#define CO_SURFACE_BLEND_DISC_H

#include "mesh/mesh.h"
#include "surface/blend_fit.h"

enum {
    CO_BLEND_DISC_LARGEST = CURVOPT_MAX_BLEND_WIDTH, /* largest width (notes/12-widest-blend.md) */
    /* coefficients, which are points of a sector: P's, in discs of width 1 means of neighbours, in half discs the
       cusp's */
    CO_BLEND_DISC_CUSP = CO_BLEND_FIT_CUSP,
    CO_BLEND_DISC_EDGE_MEAN = CO_BLEND_FIT_TERMS,
    CO_BLEND_DISC_FACE_MEAN,
    CO_BLEND_DISC_TERMS
};

/* The valence from which on faces at a smooth vertex are a disc of width 1 on a surface. */
int32_t co_blend_disc_least_valence(int32_t surface);

/* The fit that all discs of one valence and width share. */
typedef struct co_blend_disc_fit {
    int32_t valence, width, n_points;
    int is_half;    /* of a half disc (blend_disc_half.h), */
    int steps;      /* whose map has so many steps */
    int32_t n_sets; /* sets of coefficients: one a sector; one in all of half discs, whose sectors differ anyway */
    double *map;    /* [2 n_points] of half discs its control points; NULL of others */
    double *matrix; /* [CO_BLEND_DISC_TERMS][n_points] set 0's points over the disc's; each row sums to 1 */
    double *turn;   /* [n_sets][CO_BLEND_DISC_TERMS][CO_BLEND_DISC_TERMS] other sets' points over set 0's */
} co_blend_disc_fit;

typedef struct co_blend_disc {
    int32_t fit;         /* index in co_blend_discs.fit */
    int32_t first_point; /* number of set 0's first coefficient; set s begins CO_BLEND_DISC_TERMS s later */
    size_t column;       /* index in co_blend_discs.column of the disc's first point */
    int is_used;         /* whether any patch on it counts */
} co_blend_disc;

typedef struct co_blend_disc_face {
    int32_t disc;         /* index of the disc that the face lies on; -1: none */
    int32_t first;        /* half-edge that leaves the corner nearest to the vertex along the sector's u */
    int32_t sector, i, j; /* the face's sector, and its place there */
} co_blend_disc_face;

typedef struct co_blend_discs {
    int32_t n_fits, n_discs;
    int32_t n_points;       /* coefficients of all sets of all discs */
    co_blend_disc_fit *fit; /* [n_fits] */
    co_blend_disc *disc;    /* [n_discs] */
    size_t n_columns;
    int32_t *column;          /* [n_columns] points that each disc's coefficients are made of, one disc after the other:
                                 the cage's vertices; of discs of width 1 also derived points (patches.h) */
    co_blend_disc_face *face; /* [n_faces]; NULL if there are no discs, and once there are patches */
} co_blend_discs;

/* Finds the discs of a mesh by kind [n_corners] (ring.h); widest: 1 .. CO_BLEND_DISC_LARGEST. Coefficients are numbered
 * from 0 on. Breadth-first search of 4 widest rings of faces round each extraordinary vertex. ERROR_MEMORY. */
int32_t co_blend_discs_find(const curvopt_mesh *mesh, const uint8_t *kind, int widest, co_blend_discs *out,
                            curvopt_error *error);
/* Starts discs->face, if it is not there yet. ERROR_MEMORY. */
int32_t co_blend_discs_start_faces(const curvopt_mesh *mesh, co_blend_discs *discs, curvopt_error *error);
/* Finds the fit of discs of the valence, width, is_half and steps of `wanted`, or makes it: *index in discs->fit.
 * ERROR_MEMORY. */
int32_t co_blend_discs_fit(const co_blend_disc_fit *wanted, co_blend_discs *discs, int32_t *index,
                           curvopt_error *error);
/* Adds a disc of a fit; its points are left as in co_blend_discs_add. ERROR_MEMORY. */
int32_t co_blend_discs_add_of_fit(int32_t fit, co_blend_discs *discs, curvopt_error *error);
/* Adds a disc; its points, as many as its fit has, are left to be filled from co_blend_discs.column on. ERROR_MEMORY.
 */
int32_t co_blend_discs_add(int32_t valence, int width, co_blend_discs *discs, curvopt_error *error);
void co_blend_discs_free(co_blend_discs *discs);
/* Computes the coefficients of the discs that are used from their points, both in points [3 n]. */
void co_blend_discs_apply(const co_blend_discs *discs, double *points);
/* Transpose of co_blend_discs_apply. The gradient with respect to the coefficients, in point_gradient [3 n], becomes
 * one with respect to the discs' points, and is added to gradient [3 n_cage] for the cage's vertices, to
 * point_gradient for derived points. */
void co_blend_discs_add_transposed(const co_blend_discs *discs, int32_t n_cage, double *point_gradient,
                                   double *gradient);

/* In a regular grid, the half-edge one face further along h; and the one that is h, one face to its left. */
static inline int32_t co_blend_disc_further(const curvopt_mesh *m, int32_t h) {
    return co_mesh_next(m, m->twin[co_mesh_next(m, h)]);
}
static inline int32_t co_blend_disc_beside(const curvopt_mesh *m, int32_t h) {
    return m->twin[co_mesh_next(m, co_mesh_next(m, h))];
}

static inline const co_blend_disc_fit *co_blend_disc_fit_of(const co_blend_discs *discs, const co_blend_disc *disc) {
    return &discs->fit[disc->fit];
}
/* Number of the first coefficient that a face's patch has. */
static inline int32_t co_blend_discs_coefficient(const co_blend_discs *discs, const co_blend_disc_face *face) {
    const co_blend_disc *disc = &discs->disc[face->disc];
    const int32_t set = co_blend_disc_fit_of(discs, disc)->n_sets > 1 ? face->sector : 0;
    return disc->first_point + CO_BLEND_DISC_TERMS * set;
}

#endif
