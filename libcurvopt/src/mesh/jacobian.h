/* How a cage's faces fold or pinch. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_JACOBIAN_H
#define CO_MESH_JACOBIAN_H

#include "mesh/mesh.h"

/* The cage xyz [3 n_vertices] is subdivided twice more. In each of the new quads, |S_u x S_v| at a corner is the area
 * between the two edges there. *out: the least of these, over the mean of those in the same face of the cage, or in the
 * same quarter of it if any face is no quad; 0 where one has no area. Near 0 the surface folds or pinches there;
 * valences other than 4 lower it, too, so that a cage is to be compared with one of the same valences. Faces that are
 * left out do not count: left_out [n_faces], or NULL. ERROR_SIZE as co_subdivide, ERROR_MEMORY. */
int32_t co_jacobian_least(const curvopt_mesh *mesh, const uint8_t *left_out, const double *xyz, double *out,
                          curvopt_error *error);

#endif
