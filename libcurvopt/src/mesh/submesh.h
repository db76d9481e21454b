/* Copies of meshes and of some of their faces, creases included. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_SUBMESH_H
#define CO_MESH_SUBMESH_H

#include "mesh/mesh.h"

int32_t co_submesh_copy(const curvopt_mesh *mesh, curvopt_mesh **out, curvopt_error *error);

/* The faces with keep[f] != 0 as a mesh of its own; its vertices are numbered in order of their old index, which
 * vertex_of [vertices kept] (allocated here, the caller's to free) gives; faces keep their order. Loose, as above. */
int32_t co_submesh_extract(const curvopt_mesh *mesh, const uint8_t *keep, curvopt_mesh **out, int32_t **vertex_of,
                           curvopt_error *error);

/* keep [n_faces] != 0: so many rings of faces round them are kept as well, then. ERROR_MEMORY. */
int32_t co_submesh_grow(const curvopt_mesh *mesh, int rings, uint8_t *keep, curvopt_error *error);

#endif
