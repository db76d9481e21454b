/* Where edges of length 0 leave the limit surface without a tangent plane. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_DEGENERATE_H
#define CO_MESH_DEGENERATE_H

#include "mesh/mesh.h"

/* Marks the corners [n_corners] that are degenerate at xyz [3 n_vertices]. Such a corner is in a fan (ring.h) that has
 * a face with an edge of length 0, and in the limit the fan has no tangent plane at its vertex v, because
 *   - v is on a crease or boundary, and the two neighbours along the curve are in one place; or
 *   - v is a corner, and an edge of the curve there has length 0; or
 *   - v, the other ends of the fan's edges and the means of its faces are on one line, or in one place.
 * Tangents are combinations of the differences of these points. An edge of length 0 alone is not degenerate: a quad two
 * of whose corners are in one place mostly has a tangent plane everywhere. Lengths up to CURVOPT_COINCIDENT times the
 * root mean square radius of the vertices count as 0. Linear time, but for faces with such an edge, which take the
 * square of their size. ERROR_MEMORY. */
int32_t co_degenerate_mark(const curvopt_mesh *mesh, const double *xyz, uint8_t *corner, curvopt_error *error);

#endif
