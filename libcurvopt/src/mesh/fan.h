/* Fans: the faces round a vertex, between the sharp edges there, as far as the limit surface depends on them.
 *
 * The kind of a patch (its fan, and which sector of it the patch is) is one integer, because patches, tables and
 * batches are sorted and searched by it; only this header knows how it is packed:
 *
 *     bits 28 .. 30   type
 *     bits 14 .. 27   sector of the patch; in a wide disc 0 0 width i j, four bits each for the last three;
 *                     in a half disc sector, log2 width, steps, i, j: 4, 2, 2, 3 and 3 bits
 *     bits  0 .. 13   number of sectors
 *
 * A closed fan of smooth rules is therefore its valence alone: 5 is a face at a smooth vertex of valence 5, whichever
 * of the five, since its points are numbered from its own sector on. In other fans sector 0 begins at a sharp edge, and
 * the patch's sector is part of the kind: co_fan_make(CO_FAN_CREASE, 3, 1) is the middle one of three faces on one side
 * of a crease.
 *
 * Points of a fan of k quads, its two-ring: the vertex is point 0; sector s (counter-clockwise) owns the points 1 + 6 s
 * .. 6 + 6 s at these places of its quarter (x along the sector's first edge, y towards the next sector's): (1,0) (2,0)
 * (1,1) (2,1) (1,2) (2,2) and an open fan ends with two more, (1,0) and (2,0) of a sector k that is not there.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_FAN_H
#define CO_MESH_FAN_H

#include <stdint.h>

typedef enum co_fan_type {
    CO_FAN_CLOSED, /* closed: round a smooth vertex */
    CO_FAN_CREASE, /* open: between the two sharp edges of a crease or boundary */
    CO_FAN_CORNER, /* open: between two sharp edges at a corner, which stays where it is */
    CO_FAN_DART,   /* closed and smooth, with a sharp edge that ends there before sector 0 */
    CO_FAN_CONE,   /* closed round an infinitely sharp vertex without sharp edges */
    CO_FAN_WIDE,   /* a face of a wide disc round a smooth vertex (blend_disc.h), by its place in its sector */
    CO_FAN_HALF    /* a face of a wide half disc on one side of a boundary or crease (blend_disc_half.h), likewise */
} co_fan_type;

enum {
    CO_FAN_BITS = 14,                    /* bits for the number of sectors, and again for the sector */
    CO_FAN_MAX = (1 << CO_FAN_BITS) - 1, /* largest number of sectors */
    CO_FAN_REGULAR = 4,                  /* kind of every patch that is one bicubic: the closed fan of four quads */
    CO_FAN_SECTOR_POINTS = 6,            /* points of the two-ring that a sector owns */
    CO_FAN_MOST_HALF = 16,               /* largest number of sectors of a wide half disc */
    CO_FAN_MOST_STEPS = 3                /* largest number of steps of its map (blend_fit_half.h) */
};

static inline int32_t co_fan_make(co_fan_type type, int32_t sectors, int32_t sector) {
    return ((int32_t)type << (2 * CO_FAN_BITS)) | (sector << CO_FAN_BITS) | sectors;
}
static inline co_fan_type co_fan_type_of(int32_t fan) {
    return (co_fan_type)(fan >> (2 * CO_FAN_BITS));
}
static inline int32_t co_fan_sectors(int32_t fan) {
    return fan & CO_FAN_MAX;
}
static inline int32_t co_fan_sector(int32_t fan) {
    return (fan >> CO_FAN_BITS) & CO_FAN_MAX;
}
static inline int co_fan_is_half(int32_t fan) {
    return co_fan_type_of(fan) == CO_FAN_HALF;
}
/* Whether the patch is a face of a disc or half disc. */
static inline int co_fan_is_wide(int32_t fan) {
    return co_fan_type_of(fan) == CO_FAN_WIDE || co_fan_is_half(fan);
}
static inline int co_fan_is_smooth(int32_t fan) {
    return co_fan_type_of(fan) == CO_FAN_CLOSED || co_fan_type_of(fan) == CO_FAN_WIDE;
}
/* Kind of face (i, j) of the width x width faces of each sector of a wide disc, i along u; width, i, j < 16. */
static inline int32_t co_fan_make_wide(int32_t valence, int width, int i, int j) {
    return co_fan_make(CO_FAN_WIDE, valence, width << 8 | i << 4 | j);
}
/* The same of a half disc, whose map has so many steps (blend_fit_half.h). sectors <= CO_FAN_MOST_HALF, width 2, 4
 * or 8.
 */
static inline int32_t co_fan_make_half(int32_t sectors, int32_t sector, int width, int steps, int i, int j) {
    const int log2_width = width == 8 ? 3 : width / 2;
    return co_fan_make(CO_FAN_HALF, sectors, sector << 10 | log2_width << 8 | steps << 6 | i << 3 | j);
}
static inline int co_fan_wide_width(int32_t fan) {
    return co_fan_is_half(fan) ? 1 << (co_fan_sector(fan) >> 8 & 3) : co_fan_sector(fan) >> 8;
}
static inline int co_fan_wide_i(int32_t fan) {
    return co_fan_is_half(fan) ? co_fan_sector(fan) >> 3 & 7 : co_fan_sector(fan) >> 4 & 15;
}
static inline int co_fan_wide_j(int32_t fan) {
    return co_fan_sector(fan) & (co_fan_is_half(fan) ? 7 : 15);
}
static inline int co_fan_half_steps(int32_t fan) {
    return co_fan_sector(fan) >> 6 & 3;
}
/* The sector of a face of a disc; of closed ones always 0. */
static inline int32_t co_fan_wide_sector(int32_t fan) {
    return co_fan_is_half(fan) ? co_fan_sector(fan) >> 10 : 0;
}
/* The fan at the vertex of a kind of patch: of faces of discs that of the disc's vertex, seen from their sector. */
static inline int32_t co_fan_at_vertex(int32_t kind) {
    return co_fan_is_half(kind)   ? co_fan_make(CO_FAN_CREASE, co_fan_sectors(kind), co_fan_wide_sector(kind))
           : co_fan_is_wide(kind) ? co_fan_sectors(kind)
                                  : kind;
}
static inline int co_fan_is_open(int32_t fan) {
    return co_fan_type_of(fan) == CO_FAN_CREASE || co_fan_type_of(fan) == CO_FAN_CORNER;
}
/* Whether sharp edges bound the fan's sectors 0 and k - 1. */
static inline int co_fan_is_cut(int32_t fan) {
    return co_fan_is_open(fan) || co_fan_type_of(fan) == CO_FAN_DART;
}
static inline int32_t co_fan_n_points(int32_t fan) {
    return CO_FAN_SECTOR_POINTS * co_fan_sectors(fan) + (co_fan_is_open(fan) ? 3 : 1);
}
/* Whether squared curvature has a finite integral round the vertex, whatever the positions.
 *
 * Let the eigenvalues a >= b of the fan's subdivision make its tangent plane, and c the height above it. Integrals over
 * successive rings then have the ratio (c / b^2)^2 a b, and their sum is finite if that is less than 1. It is 1 or more
 * between two quads, at a smooth corner of one (a, b, c = 1/2, 1/4, 1/4), at creases of four quads a side (0.61, 1/2,
 * 1/2), at corners of two (1/2, 1/2, 1/2) and at cones; with more quads there is no tangent plane at all. Biermann,
 * Levin, Zorin, "Piecewise smooth subdivision surfaces with normal control", SIGGRAPH 2000, change the rules for that
 * reason; we keep them, and blend (blend_fit_cut.h) or, at corners and cones, leave the faces out (admissibility.c). */
int co_fan_is_integrable(int32_t fan);
/* Index of the point at place (x, y), 0 <= x, y <= 2, of a sector; sectors count modulo their number in a closed fan.
 */
int32_t co_fan_index(int32_t fan, int32_t sector, int x, int y);

#endif
