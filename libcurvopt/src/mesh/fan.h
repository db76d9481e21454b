/* Fans: the faces round a vertex, on one side of the sharp edges there, as far as the limit surface is concerned.
 *
 * A fan's kind is one integer, so that patches, tables and blocks can be sorted by it. A closed fan of smooth rules is
 * its valence alone; its patches are numbered from their own sector. In the others sector 0 begins at a sharp edge, and
 * the patch's sector is part of the kind.
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
    CO_FAN_CLOSED, /* smooth */
    CO_FAN_CREASE, /* open: between the two sharp edges of a crease or boundary */
    CO_FAN_CORNER, /* open: between two sharp edges at a corner, which stays where it is */
    CO_FAN_DART,   /* closed and smooth, with a sharp edge that ends there before sector 0 */
    CO_FAN_CONE,   /* closed round an infinitely sharp vertex without sharp edges */
    CO_FAN_WIDE /* not a fan of its own: a face of a wide blend round a smooth vertex (blend_disc.h); where it lies in
                   its sector stands where others have their sector */
} co_fan_type;

enum {
    CO_FAN_BITS = 14, /* of sectors and sector; the type above them */
    CO_FAN_MAX = (1 << CO_FAN_BITS) - 1,
    CO_FAN_REGULAR = 4, /* the closed fan of four quads: every patch that is one bicubic has this kind */
    CO_FAN_SECTOR_POINTS = 6
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
static inline int co_fan_is_wide(int32_t fan) {
    return co_fan_type_of(fan) == CO_FAN_WIDE;
}
static inline int co_fan_is_smooth(int32_t fan) {
    return co_fan_type_of(fan) == CO_FAN_CLOSED || co_fan_is_wide(fan);
}
/* Face (i, j) of the width x width faces of each sector, i along u; width, i, j < 16. */
static inline int32_t co_fan_make_wide(int32_t valence, int width, int i, int j) {
    return co_fan_make(CO_FAN_WIDE, valence, width << 8 | i << 4 | j);
}
static inline int co_fan_wide_width(int32_t fan) {
    return co_fan_sector(fan) >> 8;
}
static inline int co_fan_wide_i(int32_t fan) {
    return co_fan_sector(fan) >> 4 & 15;
}
static inline int co_fan_wide_j(int32_t fan) {
    return co_fan_sector(fan) & 15;
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
/* Whether squared curvature has a finite integral there, whatever the positions. With eigenvalues a >= b of the fan's
 * subdivision making its tangent plane and c the height above it, rings' integrals go like (c / b^2)^2 a b; at a smooth
 * corner of one quad (1/2, 1/4, 1/4), at creases of four quads a side (0.61, 1/2, 1/2), at corners of two (1/2, 1/2,
 * 1/2) and cones this is 1 or more, and with more quads there is no tangent plane at all: Biermann, Levin, Zorin,
 * "Piecewise smooth subdivision surfaces with normal control", SIGGRAPH 2000, change the rules for that reason. */
int co_fan_is_integrable(int32_t fan);
/* Index of place (x, y), 0 <= x, y <= 2, of sector s; modulo the sectors where the fan is closed. */
int32_t co_fan_index(int32_t fan, int32_t sector, int x, int y);

#endif
