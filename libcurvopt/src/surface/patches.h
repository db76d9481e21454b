/* A cage as a list of patches, each a fixed linear function of a few points.
 *
 * Every face becomes one patch where its corners allow it: all regular (inside, on a boundary or on an infinitely sharp
 * crease), or one isolated extraordinary fan. Other faces (n-gons, several extraordinary vertices on or beside a face,
 * creases that fade) are subdivided, they alone, until their children do; the children's points, and phantom points
 * beyond boundaries and creases (ring.h), are rows over the cage, so the degrees of freedom stay the cage's. So are the
 * points that faces of wide blends have beside their own (blend_disc.h).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_PATCHES_H
#define CO_SURFACE_PATCHES_H

#include "linalg/sparse_rows.h"
#include "mesh/ring.h"
#include "surface/blend_disc.h"

/* Where a patch lies on its cage face: patch coordinates (s, t) in 0..1 are face coordinates
 * (u, v) = origin + scale * R^rotation (s, t), R a quarter turn counter-clockwise. */
typedef struct co_place {
    int32_t face;
    int32_t quarter; /* corner of the face that (u, v) start from; 0 for quads */
    int32_t rotation;
    int32_t level; /* scale = 2^-level */
    double origin[2];
} co_place;

enum { CO_PATCHES_HALO = 2 };

typedef struct co_patches {
    int32_t n_cage;         /* points 0 .. n_cage - 1 are the cage's vertices, */
    int32_t n_points;       /* the others derived: */
    co_sparse_rows derived; /* row r gives point n_cage + r from the cage; after those come */
    co_blend_discs wide;    /* the points of wide blends */
    int32_t n_patches;      /* in no particular order */
    int32_t *valence; /* [n_patches] fan at (0, 0) (fan.h): 4 for regular patches, N at a smooth vertex of valence N */
    size_t *start;    /* [n_patches + 1] into points */
    int32_t *points;  /* 16 of a regular patch (ring.h), else the fan's, and those of a wide blend; some may occur
                         twice */
    co_place *place;  /* [n_patches] */
    uint8_t *cuts;    /* [n_patches] bit k: the side after corner k lies on a boundary or an infinitely sharp edge; bit
                         4 + k: corner k is a corner of the surface. Corners are numbered as a quad's, (0, 0) first */
    int32_t n_kinds;
    int32_t *kinds; /* [n_kinds] the fans that occur, ascending */
} co_patches;

/* Of the faces whose face_weight [n_faces] is not 0; NULL: of all. Two rings of faces round these decide everything
 * about them (CO_PATCHES_HALO) but the widths of blends, for which `widest` is the largest; 1: there are no wide ones.
 * ERROR_TOPOLOGY (fans of 16383 faces), ERROR_MEMORY. */
int32_t co_patches_create(const curvopt_mesh *mesh, const double *face_weight, int widest, co_patches *out,
                          curvopt_error *error);
void co_patches_free(co_patches *patches);
/* All other points from the cage's, in points [3 n_points]. */
void co_patches_derive(const co_patches *patches, double *points);
/* gradient [3 n_cage] += what gradients with respect to derived points, in point_gradient [3 n_points], are worth. */
void co_patches_add_derived(const co_patches *patches, const double *point_gradient, double *gradient);

/* Points of a patch: on the cage or rows of `derived`; */
static inline int32_t co_patches_own_size(int32_t fan) {
    int at_vertex = co_fan_is_wide(fan) && co_fan_wide_i(fan) == 0 && co_fan_wide_j(fan) == 0;
    if (at_vertex)
        return co_fan_n_points(co_fan_sectors(fan));
    return fan == CO_FAN_REGULAR || co_fan_is_wide(fan) ? CO_RING_REGULAR : co_fan_n_points(fan);
}
/* and all of them. */
static inline int32_t co_patches_size(int32_t fan) {
    return co_patches_own_size(fan) + (co_fan_is_wide(fan) ? CO_BLEND_DISC_TERMS : 0);
}
/* Where a fan stands in kinds. */
int32_t co_patches_kind(const co_patches *patches, int32_t fan);

#endif
