/* A cage as a list of patches, each a fixed linear function of a few points.
 *
 * Every face becomes one patch where its corners allow it: all regular, or one isolated extraordinary vertex. Other
 * faces (n-gons, several extraordinary vertices on or beside a face) are subdivided, they alone, until their children
 * do; the children's points are rows over the cage, so the degrees of freedom stay the cage's.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_PATCHES_H
#define CO_PATCHES_H

#include "ring.h"
#include "rows.h"

/* Where a patch lies on its cage face: patch coordinates (s, t) in 0..1 are face coordinates
 * (u, v) = origin + scale * R^rotation (s, t), R a quarter turn counter-clockwise. */
typedef struct co_place {
    int32_t face;
    int32_t quarter; /* corner of the face that (u, v) start from; 0 for quads */
    int32_t rotation;
    int32_t level; /* scale = 2^-level */
    double origin[2];
} co_place;

typedef struct co_patches {
    int32_t n_cage;    /* points 0 .. n_cage - 1 are the cage's vertices, */
    int32_t n_points;  /* the others derived: */
    co_rows derived;   /* row r gives point n_cage + r from the cage */
    int32_t n_patches; /* in no particular order */
    int32_t *valence;  /* [n_patches] of the extraordinary vertex at (0, 0); 4 for regular patches */
    size_t *start;     /* [n_patches + 1] into points */
    int32_t *points;   /* 16 of a regular patch (ring.h), else the two-ring: 6 N + 1, the patch being sector 0 */
    co_place *place;   /* [n_patches] */
} co_patches;

/* ERROR_TOPOLOGY for open cages, ERROR_MEMORY. */
int32_t co_patches_create(const curvopt_mesh *mesh, co_patches *out, curvopt_error *error);
void co_patches_free(co_patches *patches);

static inline int32_t co_patches_size(int32_t valence) {
    return valence == 4 ? CO_RING_REGULAR : co_ring_two_ring_size(valence);
}

#endif
