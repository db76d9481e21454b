/* The limit surface of a cage as bicubic Bezier pieces.
 *
 * A regular patch is one piece. A patch with an extraordinary corner is cut into rings of three cells (stam.h), each a
 * piece, and a tip: what is left at the vertex, by its limit position and a radius. So every bound that follows from
 * convex hulls holds without any tolerance, but for the tips.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_PIECES_H
#define CO_MEASURE_PIECES_H

#include "base/cancel.h"
#include "base/thread_pool.h"
#include "measure/bezier.h"
#include "surface/substitution.h"

typedef struct co_tip {
    double at[3];  /* limit position of the vertex, a point of the surface */
    double radius; /* the tip is within this distance */
    int32_t patch; /* it is in this patch */
} co_tip;

typedef struct co_surface_pieces {
    co_patches patches;
    double *points;   /* [3 n_points] of the patches */
    int32_t n_pieces; /* in all */
    double *bezier;   /* [n_pieces][CO_BEZIER] */
    co_place *place;  /* [n_pieces] on the cage */
    int32_t *patch;   /* [n_pieces] patch that each is a part of */
    int32_t *first;   /* [n_patches + 1] first piece of each patch; rings from the outermost on, three pieces each */
    int32_t *tip_of;  /* [n_patches] index of the patch's tip; -1: none */
    int32_t n_tips;
    co_tip *tip;
    double size;                  /* root mean square distance of the cage's vertices from their centroid */
    struct co_ring_table *tables; /* [patches.n_kinds] rows of the rings, by kind of patch */
} co_surface_pieces;

/* Cuts rings until the tip is about `ratio` of its patch; fewer rings where there would be more than two million
 * pieces. cancel may be NULL. ERROR_TOPOLOGY, ERROR_GEOMETRY (not finite, zero size), ERROR_MEMORY, CO_CANCELLED.
 * Linear in the faces. */
int32_t co_pieces_create(const curvopt_mesh *mesh, const double *xyz, double ratio, co_thread_pool *pool,
                         const curvopt_cancel *cancel, co_surface_pieces *out, curvopt_error *error);
/* The same without positions, to be placed again and again. `substitution`: what some vertices stand for, or NULL; size
 * is 1. ERROR_TOPOLOGY, ERROR_MEMORY, CO_CANCELLED. */
int32_t co_pieces_prepare(const curvopt_mesh *mesh, const co_substitution *substitution, double ratio,
                          const curvopt_cancel *cancel, co_surface_pieces *out, curvopt_error *error);
/* Pieces and tips of positions x [3 n_vertices]. CO_CANCELLED, without a sentence. */
int32_t co_pieces_place(co_surface_pieces *pieces, const double *x, co_thread_pool *pool, const curvopt_cancel *cancel);
void co_pieces_free(co_surface_pieces *pieces);

/* The boxes of a patch's pieces, into box [n_pieces]; that of them all. */
co_box co_pieces_bound(const co_surface_pieces *pieces, int32_t patch, co_box *box);

/* The point (u, v) of a piece as weights over the points of its patch, row [co_patches_own_size()]. */
void co_pieces_row(const co_surface_pieces *pieces, int32_t piece, double u, double v, double *row);

static inline const double *co_pieces_bezier(const co_surface_pieces *s, int32_t piece) {
    return s->bezier + CO_BEZIER * (size_t)piece;
}
/* Number of rings of a patch; 0 of a regular one. */
static inline int32_t co_pieces_n_rings(const co_surface_pieces *s, int32_t patch) {
    return s->tip_of[patch] < 0 ? 0 : (s->first[patch + 1] - s->first[patch]) / CO_RING_CELLS;
}

#endif
