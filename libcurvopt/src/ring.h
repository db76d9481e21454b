/* Ordered neighbourhoods: which points a face's surface depends on, and what makes a vertex or face regular.
 *
 * Regular face, 16 points numbered 4 j + i (i along u, j along v); the face is the middle cell:
 *
 *     12--13--14--15        corner 0 of the face is point 5, corner 1 point 6, 2 point 10, 3 point 9
 *      8---9--10--11
 *      4---5---6---7        v
 *      0---1---2---3        |__ u
 *
 * Two-ring of an extraordinary vertex of valence N, 6 N + 1 points: the vertex is point 0; sector s (counter-clockwise)
 * owns the points 1 + 6 s .. 6 + 6 s at these places of its quarter (x along the sector's first edge, y towards the
 * next sector's):        (1,0) (2,0) (1,1) (2,1) (1,2) (2,2)
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_RING_H
#define CO_RING_H

#include "mesh.h"

enum { CO_RING_REGULAR = 16, CO_RING_SECTOR = 6 };

static inline int32_t co_ring_two_ring_size(int32_t valence) {
    return CO_RING_SECTOR * valence + 1;
}
/* Index in the two-ring of place (x, y), 0 <= x, y <= 2, of sector s (any integer: taken modulo the valence). */
int32_t co_ring_two_ring_index(int32_t valence, int32_t sector, int x, int y);

/* How each vertex may be used, from its incident faces. */
typedef enum co_vertex_kind {
    CO_VERTEX_REGULAR,       /* interior, valence 4, quads round it */
    CO_VERTEX_EXTRAORDINARY, /* interior, other valence, quads round it, and regular vertices on all of these */
    CO_VERTEX_UNREADY        /* anything else: needs a subdivision first */
} co_vertex_kind;

/* Fills kind [n_vertices]. */
void co_ring_classify(const curvopt_mesh *mesh, uint8_t *kind);

/* The 16 points of the face with first half-edge h: all four corners regular. points [16] */
void co_ring_regular(const curvopt_mesh *mesh, int32_t h, int32_t *points);
/* The two-ring of the extraordinary vertex that h leaves, h's face being sector 0. points [6 N + 1] */
void co_ring_two_ring(const curvopt_mesh *mesh, int32_t h, int32_t *points);

#endif
