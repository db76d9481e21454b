/* Connected components of a mesh. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_COMPONENTS_H
#define CO_MESH_COMPONENTS_H

#include "mesh/mesh.h"

/* Faces that share a vertex are of one component. Components are numbered by their first faces. */
typedef struct co_components {
    int32_t n;
    int32_t *of_face;   /* [n_faces] */
    int32_t *of_vertex; /* [n_vertices] -1: isolated */
    int32_t *face;      /* [n_faces] number of each face within its component, where faces keep their order */
    int32_t *vertex;    /* [n_vertices] the same of vertices; of isolated ones not set */
} co_components;

/* Linear time. ERROR_MEMORY. */
int32_t co_components_find(const curvopt_mesh *mesh, co_components *out, curvopt_error *error);
void co_components_free(co_components *components);

#endif
