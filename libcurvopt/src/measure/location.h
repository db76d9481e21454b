/* Where pieces lie on the cage: corners, and what they have in common. Exact: parameters are binary fractions.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_LOCATION_H
#define CO_MEASURE_LOCATION_H

#include "measure/pieces.h"
#include "mesh/mesh.h"

/* A rectangle on a cage face: u in [u[0], u[1]], v in [v[0], v[1]], of the quarter at a corner if the face is no quad
 * (curvopt_sampler_jets). */
typedef struct co_location {
    int32_t face, quarter;
    double u[2], v[2];
} co_location;

/* What two locations have in common. */
typedef enum co_contact {
    CO_CONTACT_NONE,
    CO_CONTACT_VERTEX, /* a point */
    CO_CONTACT_EDGE    /* a segment of an edge or of a line inside a face */
} co_contact;

/* (u, v) of the face at (s, t) of a place. */
void co_location_uv(const co_place *place, const double st[2], double uv[2]);
/* The rectangle s in [s[0], s[1]], t in [t[0], t[1]] of a place. */
co_location co_location_of(const co_place *place, const double s[2], const double t[2]);
/* Of two rectangles whose insides have nothing in common. */
co_contact co_location_contact(const curvopt_mesh *mesh, const co_location *a, const co_location *b);
/* Whether (s, t) of a place is on the surface's boundary. */
int co_location_is_on_boundary(const curvopt_mesh *mesh, const co_place *place, const double st[2]);
/* The cage's vertex at corner (0, 0), (1, 0), (1, 1), (0, 1) of a place; -1: there is none. */
int32_t co_location_vertex(const curvopt_mesh *mesh, const co_place *place, int corner);
/* Limit points of the cage's vertices, point [3 n_vertices]; NAN of isolated ones. */
void co_location_limits(const curvopt_mesh *mesh, const co_surface_pieces *pieces, double *point);

#endif
