/* Vertices that a minimization leaves where they are. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HOLD_H
#define CO_HOLD_H

#include "mesh.h"

/* *held [n_vertices], to be freed: 1 where `boundary` (curvopt_boundary) holds a vertex; NULL if it holds none.
 *
 * The limit of a boundary is a B-spline curve of the boundary's vertices. Of the surface's derivatives across it the
 * first depends on the next row of vertices too, and the second, 0 in the parameter across, on no more than that; a
 * third row holds how curvature changes. Subdivision keeps all this: what the finer cage's rows determine is what the
 * coarser one's did. Rows are counted by faces: all vertices of a face that touches the row before. */
int32_t co_hold_create(const curvopt_mesh *mesh, int32_t boundary, uint8_t **held, curvopt_error *error);
/* Sets the three coordinates of held vertices to 0; held may be NULL. */
void co_hold_clear(const uint8_t *held, int32_t n_vertices, double *xyz);
/* Copies those of held vertices; held may be NULL. */
void co_hold_copy(const uint8_t *held, int32_t n_vertices, const double *from, double *to);

#endif
