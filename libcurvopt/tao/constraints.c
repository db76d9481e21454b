/* What is held. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints.h"

#include "collective.h"

#include <stdlib.h>
#include <string.h>

/* The next row: vertices of faces with a held one. */
static void add_row(const curvopt_mesh_info *info, const int32_t *sizes, const int32_t *vertices, unsigned char *held,
                    unsigned char *touched) {
    for (int32_t f = 0, c = 0; f < info->n_faces; c += sizes[f++]) {
        touched[f] = 0;
        for (int32_t k = 0; k < sizes[f]; k++)
            touched[f] |= held[vertices[c + k]];
    }
    for (int32_t f = 0, c = 0; f < info->n_faces; c += sizes[f++])
        for (int32_t k = 0; k < sizes[f]; k++)
            held[vertices[c + k]] |= touched[f];
}

/* Vertices on infinitely sharp creases, and infinitely sharp ones. */
static void mark_creases(const portion *on, unsigned char *held) {
    int32_t n_creases, n_corners;
    curvopt_mesh_count_creases(on->mesh, &n_creases, &n_corners);
    int32_t *ends = AGREE_NEW(on->comm, int32_t, 2 * (size_t)n_creases),
            *corners = AGREE_NEW(on->comm, int32_t, n_corners);
    double *sharpness = AGREE_NEW(on->comm, double, n_creases), *corner = AGREE_NEW(on->comm, double, n_corners);
    curvopt_mesh_get_creases(on->mesh, ends, sharpness, corners, corner);
    for (int32_t i = 0; i < n_creases; i++)
        if (sharpness[i] >= CURVOPT_SHARPNESS_INFINITE)
            held[ends[2 * i]] = held[ends[2 * i + 1]] = 1;
    for (int32_t i = 0; i < n_corners; i++)
        held[corners[i]] |= corner[i] >= CURVOPT_SHARPNESS_INFINITE;
    free(ends);
    free(corners);
    free(sharpness);
    free(corner);
}

/* held [n_vertices], right at own vertices: the halo has the two rings of faces that this looks at. */
static void mark_boundary(const portion *on, int32_t boundary, unsigned char *held) {
    curvopt_mesh_info info;
    int rows = boundary == CURVOPT_BOUNDARY_CURVATURE ? 2 : boundary == CURVOPT_BOUNDARY_TANGENT;
    if (boundary == CURVOPT_BOUNDARY_FREE)
        return;
    curvopt_mesh_get_info(on->mesh, &info, sizeof info);
    int32_t *sizes = AGREE_NEW(on->comm, int32_t, info.n_faces),
            *vertices = AGREE_NEW(on->comm, int32_t, info.n_corners);
    unsigned char *touched = AGREE_NEW(on->comm, unsigned char, info.n_faces);
    curvopt_mesh_get_faces(on->mesh, sizes, vertices);
    memcpy(held, on->boundary, (size_t)on->n_vertices);
    for (int row = 0; row < rows; row++)
        add_row(&info, sizes, vertices, held, touched);
    mark_creases(on, held);
    free(sizes);
    free(vertices);
    free(touched);
}

/* p [9]: freedom 0 to 3 dimensions, along the direction or across it. */
static void set_projector(int freedom, const double *d, double *p) {
    double square = d ? d[0] * d[0] + d[1] * d[1] + d[2] * d[2] : 1;
    for (int k = 0; k < 9; k++) {
        p[k] = freedom >= 2 && k % 4 == 0;
        if (freedom == 1 || freedom == 2)
            p[k] += (freedom == 1 ? 1 : -1) * d[k / 3] * d[k % 3] / square;
    }
}

PetscErrorCode hold_find(const portion *on, int32_t boundary, const level_pins *pins, double **projectors,
                         int *any_free) {
    int mine[2] = {0, 0}, all[2];
    PetscFunctionBeginUser;
    unsigned char *held = AGREE_NEW(on->comm, unsigned char, on->n_vertices);
    double *p = AGREE_NEW(on->comm, double, 9 * (size_t)on->n_own);
    mark_boundary(on, boundary, held);
    for (PetscInt v = 0; v < on->n_own; v++) {
        int freedom = held[on->own[v]] ? 0 : pins->freedom ? pins->freedom[v] : 3;
        set_projector(freedom, pins->freedom ? pins->direction + 3 * (size_t)v : NULL, p + 9 * (size_t)v);
        mine[0] |= freedom < 3;
        mine[1] |= freedom > 0;
    }
    PetscCallMPI(MPI_Allreduce(mine, all, 2, MPI_INT, MPI_MAX, on->comm));
    if (!all[0]) {
        free(p);
        p = NULL;
    }
    free(held);
    *projectors = p;
    *any_free = all[1];
    PetscFunctionReturn(0);
}

/* Normals of the cage at the mesh's vertices, as hold.c has them; right at own vertices. */
static void cage_normals(const energy *e, double *normal) {
    curvopt_mesh_info info;
    MPI_Comm comm = e->on->comm;
    curvopt_mesh_get_info(e->on->mesh, &info, sizeof info);
    int32_t *sizes = AGREE_NEW(comm, int32_t, info.n_faces), *vertices = AGREE_NEW(comm, int32_t, info.n_corners);
    curvopt_mesh_get_faces(e->on->mesh, sizes, vertices);
    for (int32_t f = 0, c = 0; f < info.n_faces; c += sizes[f++])
        for (int32_t k = 0; k < sizes[f]; k++) {
            const double *p = e->xyz + 3 * (size_t)vertices[c + k],
                         *a = e->xyz + 3 * (size_t)vertices[c + (k + 1) % sizes[f]],
                         *b = e->xyz + 3 * (size_t)vertices[c + (k + sizes[f] - 1) % sizes[f]];
            double *to = normal + 3 * (size_t)vertices[c + k];
            for (int i = 0; i < 3; i++) {
                int j = (i + 1) % 3, l = (i + 2) % 3;
                to[i] += (a[j] - p[j]) * (b[l] - p[l]) - (a[l] - p[l]) * (b[j] - p[j]);
            }
        }
    free(sizes);
    free(vertices);
}

PetscErrorCode hold_to_normals(energy *e, Vec x) {
    const portion *on = e->on;
    PetscFunctionBeginUser;
    PetscCall(energy_place(e, x));
    double *normal = AGREE_NEW(on->comm, double, 3 * (size_t)on->n_vertices);
    double *projectors = AGREE_NEW(on->comm, double, 9 * (size_t)on->n_own);
    cage_normals(e, normal);
    for (PetscInt v = 0; v < on->n_own; v++) {
        const double *n = normal + 3 * (size_t)on->own[v], *old = e->project ? e->project + 9 * (size_t)v : NULL;
        double square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        int is_free = square > 0 && (!old || old[0] + old[4] + old[8] > 2.5); /* a projector's trace is its rank */
        for (int k = 0; is_free && k < 9; k++)
            projectors[9 * (size_t)v + (size_t)k] = n[k / 3] * n[k % 3] / square;
    }
    free(normal);
    PetscCall(energy_hold(e, x, projectors));
    PetscFunctionReturn(0);
}
