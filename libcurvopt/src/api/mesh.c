/* Exported functions on meshes. SPDX-License-Identifier: GPL-3.0-or-later */
#include "api/api.h"
#include "energy/admissibility.h"
#include "mesh/similarity.h"
#include "mesh/subdivide.h"

#include <string.h>

int32_t curvopt_mesh_create(int32_t n_vertices, int32_t n_faces, const int32_t *face_sizes,
                            const int32_t *face_vertices, curvopt_mesh **out, curvopt_error *error) {
    return co_mesh_create(n_vertices, n_faces, face_sizes, face_vertices, out, error);
}

void curvopt_mesh_destroy(curvopt_mesh *mesh) {
    co_mesh_destroy(mesh);
}

void curvopt_mesh_get_info(const curvopt_mesh *mesh, curvopt_mesh_info *info, size_t size) {
    co_api_copy_out(info, size, &mesh->info, sizeof mesh->info);
}

void curvopt_mesh_get_faces(const curvopt_mesh *mesh, int32_t *face_sizes, int32_t *face_vertices) {
    for (int32_t f = 0; f < mesh->info.n_faces; f++)
        face_sizes[f] = co_mesh_face_size(mesh, f);
    memcpy(face_vertices, mesh->corner_vertex, sizeof(int32_t) * (size_t)mesh->info.n_corners);
}

int32_t curvopt_mesh_refine(const curvopt_mesh *mesh, const double *xyz, curvopt_mesh **out, double *fine_xyz,
                            curvopt_error *error) {
    co_sparse_rows rows = {0};
    if (!out)
        return co_api_null(error, "out");
    *out = NULL;
    if (!mesh)
        return co_api_null(error, "mesh");
    if (!xyz != !fine_xyz)
        return co_api_null(error, xyz ? "fine_xyz" : "xyz");
    int32_t status = co_subdivide(mesh, out, xyz ? &rows : NULL, error);
    if (status == CURVOPT_OK && xyz)
        co_sparse_rows_apply(&rows, xyz, fine_xyz);
    co_sparse_rows_free(&rows);
    return status;
}

int32_t curvopt_mesh_find_exceptions(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                                     int32_t *vertex_reason, int32_t *face_reason, curvopt_error *error) {
    curvopt_options own;
    co_exceptions found;
    if (!mesh)
        return co_api_null(error, "mesh");
    int32_t status = co_api_take_options(options, &own, error);
    if (status == CURVOPT_OK && xyz)
        status = co_similarity_check(mesh->info.n_vertices, xyz, error);
    if (status == CURVOPT_OK)
        status = co_exceptions_find(mesh, xyz, &own, &found, error);
    if (status != CURVOPT_OK)
        return status;
    for (int32_t v = 0; vertex_reason && v < mesh->info.n_vertices; v++)
        vertex_reason[v] = found.vertex[v];
    for (int32_t f = 0; face_reason && f < mesh->info.n_faces; f++)
        face_reason[f] = found.face[f];
    co_exceptions_free(&found);
    return CURVOPT_OK;
}
