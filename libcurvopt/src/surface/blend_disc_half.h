/* Wide half discs at poles on boundaries and creases: how wide they are, by the mesh and by its positions.
 *
 * As at closed vertices the width is at most a quarter of the distance, in rings of faces on this side, to the next
 * vertex that is not regular; vertices on other boundaries count as such, those on the curve through the pole do not.
 *
 *     +----+----+----+----+      width 2 at a pole of 2 faces, for the drawing's sake: faces of sector 0 right of the
 *     |1,1 |0,1 |0,1 |1,1 |      pole V, those of sector 1 left of it. The curve runs along the lower side. P is fitted
 *     +----+----+----+----+      on all 2 * 4 faces, and depends on the points at places 0 .. 3 of each sector.
 *     |1,0 |0,0 |0,0 |1,0 |
 *     +----+----V----+----+
 *
 * Positions count, too. P is a polynomial over the natural net; where the cage's net is far from that, as where points
 * crowd at the pole, no polynomial is near the limit surface, and a narrow blend is better than a wide one. Hence the
 * guard: the largest width 8, 4 or 2 is taken where the curve's edges are about as long as each other and P is near the
 * limit surface, in units of edges; if none is, 1 (notes/16-blends-at-boundaries.md). So the surface is a linear
 * function of the cage only once its half discs are chosen; who compares positions must choose once.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BLEND_DISC_HALF_H
#define CO_SURFACE_BLEND_DISC_HALF_H

#include "surface/blend_disc.h"

/* Adds the half discs of a mesh at xyz [3 n_vertices] to its discs; kind [n_corners] (ring.h), widest as in
 * co_blend_discs_find. Makes the fits that it tries. ERROR_MEMORY. */
int32_t co_blend_disc_half_find(const curvopt_mesh *mesh, const uint8_t *kind, const double *xyz, int widest,
                                co_blend_discs *discs, curvopt_error *error);
/* Whether two cages of one mesh have the same half discs, as to width and map. */
int co_blend_disc_half_are_same(const co_blend_discs *a, const co_blend_discs *b);

#endif
