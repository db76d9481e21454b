/* Ordered neighbourhoods: which points a face's surface depends on, and what makes a corner of it regular.
 *
 * Regular face, 16 points numbered 4 j + i (i along u, j along v); the face is the middle cell:
 *
 *     12--13--14--15        corner 0 of the face is point 5, corner 1 point 6, 2 point 10, 3 point 9
 *      8---9--10--11
 *      4---5---6---7        v
 *      0---1---2---3        |__ u
 *
 * Where a boundary or an infinitely sharp edge ends the neighbourhood, phantom points take the place of those beyond:
 * on a crease (two quads on this side) 2 P - Q, at a corner (one quad) 4 P - 2 Q - 2 R + S, which make the bicubic
 * patch follow the crease rule and the corner rule exactly (second derivative 0 across the edge). Phantoms are numbered
 * after the mesh's vertices: first two an edge, beyond its first half-edge's origin and beyond its destination; then
 * one a corner.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_RING_H
#define CO_MESH_RING_H

#include "mesh/fan.h"
#include "mesh/mesh.h"

enum { CO_RING_REGULAR = 16, CO_RING_SECTOR = CO_FAN_SECTOR_POINTS };

static inline int32_t co_ring_two_ring_size(int32_t valence) {
    return co_fan_n_points(valence);
}
/* Index in the two-ring of place (x, y), 0 <= x, y <= 2, of a sector, which may be any integer: it counts modulo the
 * valence. */
static inline int32_t co_ring_two_ring_index(int32_t valence, int32_t sector, int x, int y) {
    return co_fan_index(valence, sector, x, y);
}

/* How a face may be evaluated as far as one of its corners decides it: by the fan on its side of the sharp edges there.
 */
typedef enum co_corner_kind {
    CO_CORNER_REGULAR,       /* a closed fan of four quads */
    CO_CORNER_CREASE,        /* two quads between two sharp edges, crease rule */
    CO_CORNER_SHARP,         /* one quad between two sharp edges, corner rule */
    CO_CORNER_EXTRAORDINARY, /* any other fan of quads, all regular round it */
    CO_CORNER_UNREADY        /* anything else: needs a subdivision first */
} co_corner_kind;

/* Fills kind [n_corners] with a co_corner_kind for each corner. Linear time. */
void co_ring_classify(const curvopt_mesh *mesh, uint8_t *kind);

/* Kind of the patch that h's face is, seen from the vertex that h leaves: the fan there on h's side of the sharp edges.
 * *first is the half-edge that begins the fan. */
int32_t co_ring_fan(const curvopt_mesh *mesh, int32_t h, int32_t *first);

/* Fills fan [n_corners] with the kind of the fan that each corner is in, its sector left 0, as it is when all that
 * fades has faded. Linear time, but for flawed vertices, which take the square of their valence. */
void co_ring_fans(const curvopt_mesh *mesh, int32_t *fan);

/* Whether the mesh can need phantoms: it has a boundary, sharp edges or flaws. */
int co_ring_has_phantoms(const curvopt_mesh *mesh);
/* How many numbers vertices and phantoms have together. */
int32_t co_ring_n_numbers(const curvopt_mesh *mesh);
/* Writes a number, a vertex's or a phantom's, as a combination of vertices: vertex [4], weight [4]. Returns how many.
 */
int co_ring_resolve(const curvopt_mesh *mesh, int32_t number, int32_t *vertex, double *weight);

/* points [16]: vertices and phantoms of the face with first half-edge h, none of whose corners may be extraordinary or
 * unready by kind [n_corners]. */
void co_ring_regular(const curvopt_mesh *mesh, int32_t h, const uint8_t *kind, int32_t *points);
/* points [co_fan_n_points]: vertices of the extraordinary fan that half-edge `first` begins, numbered as in fan.h. */
void co_ring_two_ring(const curvopt_mesh *mesh, int32_t fan, int32_t first, int32_t *points);

#endif
