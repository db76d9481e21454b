/* Faces in which the surface is folded: it has a point without a tangent plane.
 *
 * A map of a surface into space that cannot be mended by moving it a little has pinch points (H. Whitney, "The general
 * type of singularity of a set of 2n - 1 smooth functions of n variables", Duke Math. J. 10, 1943): S_u x S_v = 0, and
 * round such a point the normal turns once round. Lines along which the surface crosses itself end there, and energies
 * of curvature are infinite.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_FOLDS_H
#define CO_SURFACE_FOLDS_H

#include "base/cancel.h"
#include "mesh/mesh.h"

/* Marks folded faces of the limit surface at xyz [3 n_vertices], in folded [n_faces]; *n: how many. Faces that left_out
 * [n_faces] has (NULL: none) are not looked at. Each patch is cut into 8 x 8 cells; a face is folded where the normals
 * at a cell's corners are in no common half space, by a margin: also where such a point is close beyond its edge.
 * ERROR_TOPOLOGY as co_patches_create, ERROR_MEMORY, CO_CANCELLED. */
int32_t co_folds_find(const curvopt_mesh *mesh, const double *xyz, const uint8_t *left_out, co_cancel *cancel,
                      uint8_t *folded, int32_t *n, curvopt_error *error);

#endif
