/* A cage as a list of patches, each a fixed linear function of a few points.
 *
 * Every face becomes one patch where its corners allow it: all regular (inside, on a boundary or on an infinitely sharp
 * crease), or one isolated extraordinary fan. Other faces (n-gons, several extraordinary vertices on or beside a face,
 * creases that fade) are subdivided, they alone, until their children allow it. The children's points, and phantom
 * points beyond boundaries and creases (ring.h), are rows over the cage, and so are the coefficients of discs
 * (blend_disc.h): the degrees of freedom stay the cage's. Local subdivision where the surface is not regular follows
 * Nießner, Loop, Meyer, DeRose, "Feature-adaptive GPU rendering of Catmull-Clark subdivision surfaces", ACM TOG 31(1),
 * 2012; here it ends at isolated extraordinary vertices, which stam.h evaluates.
 *
 * Numbers of points:  0 .. n_cage - 1             the cage's vertices
 *                     n_cage .. + derived.n_rows  children's points and phantoms, rows of `derived`
 *                     .. n_points - 1             coefficients of discs (`wide`)
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_PATCHES_H
#define CO_SURFACE_PATCHES_H

#include "base/cancel.h"
#include "linalg/sparse_rows.h"
#include "mesh/ring.h"
#include "surface/blend_disc.h"

/* Where a patch lies on its cage face: patch coordinates (s, t) in 0..1 are face coordinates
 * (u, v) = origin + scale * R^rotation (s, t), R a quarter turn counter-clockwise. */
typedef struct co_place {
    int32_t face;     /* face of the cage */
    int32_t quarter;  /* corner of the face that (u, v) start from; 0 for quads */
    int32_t rotation; /* number of quarter turns, 0 .. 3 */
    int32_t level;    /* number of subdivisions; scale = 2^-level */
    double origin[2]; /* (u, v) of the patch's corner (0, 0) */
} co_place;

enum { CO_PATCHES_HALO = 2 }; /* rings of faces round a face that decide how it is evaluated */

typedef struct co_patches {
    int32_t surface;        /* curvopt_surface */
    int32_t n_cage;         /* number of the cage's vertices, which are the first points */
    int32_t n_points;       /* number of all points */
    co_sparse_rows derived; /* row r gives point n_cage + r from the cage's vertices */
    co_blend_discs wide;    /* wide blends, and vertices of high valence; their coefficients are the last points */
    int32_t n_patches;      /* in no particular order */
    int32_t *kind;   /* [n_patches] kind of each patch (fan.h): CO_FAN_REGULAR, or the fan at its corner (0, 0) */
    size_t *start;   /* [n_patches + 1] first entry of each patch in `points` */
    int32_t *points; /* each patch's points, co_patches_size() of them; a point may occur twice */
    co_place *place; /* [n_patches] place of each patch on the cage */
    uint8_t *cuts;   /* [n_patches] flags of each patch's sides and corners, counted as a quad's, (0, 0) first.
                        Bit k: the side after corner k lies on a boundary or an infinitely sharp edge. Bit
                        4 + k: corner k is a corner of the surface */
    int32_t n_kinds;
    int32_t *kinds; /* [n_kinds] the kinds that occur, ascending */
} co_patches;

/* Makes the patches of the faces whose face_weight [n_faces] is not 0; NULL: of all. Everything about them but the
 * widths of blends follows from two rings of faces round them (CO_PATCHES_HALO). xyz [3 n_vertices]: positions by which
 * half discs are chosen (blend_disc_half.h); NULL: there are none. surface: curvopt_surface; widest: the
 * largest width of a blend on `polynomial`. Linear in the faces, times the subdivisions that fading creases need.
 * cancel: ends it; NULL: nobody. ERROR_TOPOLOGY if a fan has 16383 faces or more, ERROR_MEMORY, CO_CANCELLED. */
int32_t co_patches_create(const curvopt_mesh *mesh, const double *xyz, const double *face_weight, int32_t surface,
                          int widest, co_cancel *cancel, co_patches *out, curvopt_error *error);
void co_patches_free(co_patches *patches);
/* The cage vertices of which a point is a combination: itself, or a derived point's row; no coefficient. */
typedef struct co_point_row {
    const int32_t *vertex;
    const double *weight;
    size_t n;
} co_point_row;
/* `point` must stay where it is while the result is in use. */
co_point_row co_patches_row(const co_patches *patches, const int32_t *point);
/* Computes all other points from the cage's vertices, in points [3 n_points]. */
void co_patches_derive(const co_patches *patches, double *points);
/* Transpose of co_patches_derive: gradient [3 n_cage] += the gradient with respect to the cage's vertices that belongs
 * to the gradient with respect to all other points in point_gradient [3 n_points], which is spent. */
void co_patches_add_derived(const co_patches *patches, double *point_gradient, double *gradient);

/* Number of a patch's points that are vertices or rows of `derived`: 16 of a regular patch (ring.h), else its fan's. */
static inline int32_t co_patches_own_size(int32_t kind) {
    int at_vertex = co_fan_is_wide(kind) && co_fan_wide_i(kind) == 0 && co_fan_wide_j(kind) == 0;
    if (at_vertex)
        return co_fan_n_points(co_fan_at_vertex(kind));
    return kind == CO_FAN_REGULAR || co_fan_is_wide(kind) ? CO_RING_REGULAR : co_fan_n_points(kind);
}
/* Whether a patch is one piece, not rings round an extraordinary vertex. */
static inline int co_patches_is_one_piece(int32_t kind) {
    return co_patches_own_size(kind) == CO_RING_REGULAR; /* no fan has as many */
}
/* Number of all points of a patch: on a disc its sector's coefficients come after the others. */
static inline int32_t co_patches_size(int32_t kind) {
    return co_patches_own_size(kind) + (co_fan_is_wide(kind) ? CO_BLEND_DISC_TERMS : 0);
}
/* Whether own point i is one of the curve's, on which all faces at the vertex of a half disc depend. */
static inline int co_patches_is_of_curve(int32_t kind, int32_t i) {
    const int32_t n = co_fan_sectors(kind);
    return co_fan_is_half(kind) && i > 0 && (i - 1) % CO_RING_SECTOR < 2 &&
           ((i - 1) / CO_RING_SECTOR == 0 || (i - 1) / CO_RING_SECTOR == n);
}
/* Whether rows of a patch of that kind can be nonzero on own point i. fitted: as co_blend_fit_surface; window: as
 * co_stam_in_window, or 0 where all sectors have rows. */
int co_patches_own_has_row(int32_t fitted, int32_t kind, int32_t window, int32_t i);
/* Whether the surface (curvopt_surface) on a patch of that kind can depend on own point i, by whatever rule. */
int co_patches_own_is_used(int32_t surface, int32_t kind, int32_t i);
/* Index of a kind in `kinds`. */
int32_t co_patches_kind(const co_patches *patches, int32_t kind);

#endif
