/* Copies of meshes and of some of their faces. SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/submesh.h"

#include "base/memory.h"
#include "mesh/crease.h"

#include <stdlib.h>
#include <string.h>

int32_t co_submesh_copy(const curvopt_mesh *mesh, curvopt_mesh **out, curvopt_error *error) {
    int32_t *sizes = CO_NEW(int32_t, mesh->info.n_faces), status = CURVOPT_ERROR_MEMORY;
    if (sizes) {
        for (int32_t f = 0; f < mesh->info.n_faces; f++)
            sizes[f] = co_mesh_face_size(mesh, f);
        status = co_mesh_create(mesh->info.n_vertices, mesh->info.n_faces, sizes, mesh->corner_vertex, out, error);
        if (status == CURVOPT_OK)
            status = co_crease_inherit(mesh, NULL, NULL, out, error);
    } else {
        co_status_no_memory(error);
    }
    free(sizes);
    return status;
}

int32_t co_submesh_extract(const curvopt_mesh *mesh, const uint8_t *keep, curvopt_mesh **out, int32_t **vertex_of,
                           curvopt_error *error) {
    const curvopt_mesh_info *n = &mesh->info;
    int32_t status = CURVOPT_ERROR_MEMORY, n_faces = 0, n_corners = 0, n_vertices = 0;
    int32_t *new_index = CO_NEW(int32_t, n->n_vertices), *sizes = CO_NEW(int32_t, n->n_faces);
    int32_t *vertices = CO_NEW(int32_t, n->n_corners), *old_index = CO_NEW(int32_t, n->n_vertices);
    *out = NULL;
    *vertex_of = NULL;
    if (!new_index || !sizes || !vertices || !old_index) {
        co_status_no_memory(error);
        goto done;
    }
    for (int32_t h = 0; h < n->n_corners; h++)
        if (keep[mesh->corner_face[h]])
            new_index[mesh->corner_vertex[h]] = 1;
    for (int32_t v = 0; v < n->n_vertices; v++)
        if (new_index[v]) {
            old_index[n_vertices] = v;
            new_index[v] = n_vertices++;
        }
    for (int32_t f = 0; f < n->n_faces; f++) {
        if (!keep[f])
            continue;
        sizes[n_faces++] = co_mesh_face_size(mesh, f);
        for (int32_t h = mesh->face_start[f]; h < mesh->face_start[f + 1]; h++)
            vertices[n_corners++] = new_index[mesh->corner_vertex[h]];
    }
    status = co_mesh_create(n_vertices, n_faces, sizes, vertices, out, error);
    if (status == CURVOPT_OK)
        status = co_crease_inherit(mesh, keep, old_index, out, error);
    for (int32_t v = 0; status == CURVOPT_OK && (*out)->flaw && v < n_vertices; v++)
        if (co_mesh_flaw_of(mesh, old_index[v]) == CO_MESH_CURVE && (*out)->flaw[v] != CO_MESH_SOUND)
            (*out)->flaw[v] = CO_MESH_CURVE;
    if (status == CURVOPT_OK) {
        *vertex_of = old_index;
        old_index = NULL;
    }
done:
    free(new_index);
    free(sizes);
    free(vertices);
    free(old_index);
    return status;
}

int32_t co_submesh_grow(const curvopt_mesh *m, int rings, uint8_t *keep, curvopt_error *error) {
    uint8_t *touched = CO_NEW(uint8_t, m->info.n_vertices);
    if (!touched)
        return co_status_no_memory(error);
    for (int ring = 0; ring < rings; ring++) {
        for (int32_t h = 0; h < m->info.n_corners; h++)
            touched[m->corner_vertex[h]] |= keep[m->corner_face[h]];
        for (int32_t h = 0; h < m->info.n_corners; h++)
            keep[m->corner_face[h]] |= touched[m->corner_vertex[h]];
    }
    free(touched);
    return CURVOPT_OK;
}
