/* Copies of meshes and of some of their faces, creases included. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_SUBMESH_H
#define CO_MESH_SUBMESH_H

#include "mesh/mesh.h"

/* The same mesh, creases included, once more. ERROR_MEMORY. */
int32_t co_submesh_copy(const curvopt_mesh *mesh, curvopt_mesh **out, curvopt_error *error);

/* The faces with keep[f] != 0 as a mesh of their own, made by co_mesh_create. Faces and vertices keep their
 * order; vertex_of [vertices kept], which the caller frees, has their old numbers. ERROR_MEMORY. */
int32_t co_submesh_extract(const curvopt_mesh *mesh, const uint8_t *keep, curvopt_mesh **out, int32_t **vertex_of,
                           curvopt_error *error);

/* Adds to the faces with keep [n_faces] != 0 so many rings of faces round them: those that share a vertex with them,
 * and so on. ERROR_MEMORY. */
int32_t co_submesh_grow(const curvopt_mesh *mesh, int rings, uint8_t *keep, curvopt_error *error);

#endif
