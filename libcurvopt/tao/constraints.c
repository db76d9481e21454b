/* Vertices that may not move freely. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints.h"

#include "collective.h"

#include <stdlib.h>
#include <string.h>

/* The next row of fixed vertices: those of faces that have one already. */
static void add_row(const curvopt_mesh_info *info, const int32_t *sizes, const int32_t *vertices, unsigned char *fixed,
                    unsigned char *touched) {
    for (int32_t f = 0, c = 0; f < info->n_faces; c += sizes[f++]) {
        touched[f] = 0;
        for (int32_t k = 0; k < sizes[f]; k++)
            touched[f] |= fixed[vertices[c + k]];
    }
    for (int32_t f = 0, c = 0; f < info->n_faces; c += sizes[f++])
        for (int32_t k = 0; k < sizes[f]; k++)
            fixed[vertices[c + k]] |= touched[f];
}

/* Vertices on infinitely sharp creases, and infinitely sharp ones. */
static void mark_creases(const subdomain *on, unsigned char *fixed) {
    int32_t n_creases, n_corners;
    curvopt_mesh_count_creases(on->mesh, &n_creases, &n_corners);
    int32_t *ends = COLLECTIVE_NEW(on->comm, int32_t, 2 * (size_t)n_creases),
            *corners = COLLECTIVE_NEW(on->comm, int32_t, n_corners);
    double *sharpness = COLLECTIVE_NEW(on->comm, double, n_creases),
           *corner = COLLECTIVE_NEW(on->comm, double, n_corners);
    curvopt_mesh_get_creases(on->mesh, ends, sharpness, corners, corner);
    for (int32_t i = 0; i < n_creases; i++)
        if (sharpness[i] >= CURVOPT_SHARPNESS_INFINITE)
            fixed[ends[2 * i]] = fixed[ends[2 * i + 1]] = 1;
    for (int32_t i = 0; i < n_corners; i++)
        fixed[corners[i]] |= corner[i] >= CURVOPT_SHARPNESS_INFINITE;
    free(ends);
    free(corners);
    free(sharpness);
    free(corner);
}

/* fixed [n_vertices], right at own vertices: the halo has the two rings of faces that this looks at. */
static void mark_boundary(const subdomain *on, int32_t boundary, unsigned char *fixed) {
    curvopt_mesh_info info;
    int rows = boundary == CURVOPT_BOUNDARY_CURVATURE ? 2 : boundary == CURVOPT_BOUNDARY_TANGENT;
    if (boundary == CURVOPT_BOUNDARY_FREE)
        return;
    curvopt_mesh_get_info(on->mesh, &info, sizeof info);
    int32_t *sizes = COLLECTIVE_NEW(on->comm, int32_t, info.n_faces),
            *vertices = COLLECTIVE_NEW(on->comm, int32_t, info.n_corners);
    unsigned char *touched = COLLECTIVE_NEW(on->comm, unsigned char, info.n_faces);
    curvopt_mesh_get_faces(on->mesh, sizes, vertices);
    memcpy(fixed, on->boundary, (size_t)on->n_vertices);
    for (int row = 0; row < rows; row++)
        add_row(&info, sizes, vertices, fixed, touched);
    mark_creases(on, fixed);
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

PetscErrorCode constraints_find(const subdomain *on, int32_t boundary, const constraints_pins *pins,
                                double **projectors, int *any_free) {
    int mine[2] = {0, 0}, all[2];
    PetscFunctionBeginUser;
    unsigned char *fixed = COLLECTIVE_NEW(on->comm, unsigned char, on->n_vertices);
    double *p = COLLECTIVE_NEW(on->comm, double, 9 * (size_t)on->n_own);
    mark_boundary(on, boundary, fixed);
    for (PetscInt v = 0; v < on->n_own; v++) {
        int freedom = fixed[on->own[v]] ? 0 : pins->freedom ? pins->freedom[v] : 3;
        set_projector(freedom, pins->freedom ? pins->direction + 3 * (size_t)v : NULL, p + 9 * (size_t)v);
        mine[0] |= freedom < 3;
        mine[1] |= freedom > 0;
    }
    PetscCallMPI(MPI_Allreduce(mine, all, 2, MPI_INT, MPI_MAX, on->comm));
    if (!all[0]) {
        free(p);
        p = NULL;
    }
    free(fixed);
    *projectors = p;
    *any_free = all[1];
    PetscFunctionReturn(0);
}

/* Normals of the cage at the mesh's vertices, as the library's constraints.c has them; right at own vertices. */
static void cage_normals(const objective *o, double *normal) {
    curvopt_mesh_info info;
    MPI_Comm comm = o->on->comm;
    curvopt_mesh_get_info(o->on->mesh, &info, sizeof info);
    int32_t *sizes = COLLECTIVE_NEW(comm, int32_t, info.n_faces),
            *vertices = COLLECTIVE_NEW(comm, int32_t, info.n_corners);
    curvopt_mesh_get_faces(o->on->mesh, sizes, vertices);
    for (int32_t f = 0, c = 0; f < info.n_faces; c += sizes[f++])
        for (int32_t k = 0; k < sizes[f]; k++) {
            const double *p = o->xyz + 3 * (size_t)vertices[c + k],
                         *a = o->xyz + 3 * (size_t)vertices[c + (k + 1) % sizes[f]],
                         *b = o->xyz + 3 * (size_t)vertices[c + (k + sizes[f] - 1) % sizes[f]];
            double *to = normal + 3 * (size_t)vertices[c + k];
            for (int i = 0; i < 3; i++) {
                int j = (i + 1) % 3, l = (i + 2) % 3;
                to[i] += (a[j] - p[j]) * (b[l] - p[l]) - (a[l] - p[l]) * (b[j] - p[j]);
            }
        }
    free(sizes);
    free(vertices);
}

PetscErrorCode constraints_to_normals(objective *o, Vec x) {
    const subdomain *on = o->on;
    PetscFunctionBeginUser;
    PetscCall(objective_place(o, x));
    double *normal = COLLECTIVE_NEW(on->comm, double, 3 * (size_t)on->n_vertices);
    double *projectors = COLLECTIVE_NEW(on->comm, double, 9 * (size_t)on->n_own);
    cage_normals(o, normal);
    for (PetscInt v = 0; v < on->n_own; v++) {
        const double *n = normal + 3 * (size_t)on->own[v], *old = o->project ? o->project + 9 * (size_t)v : NULL;
        double square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        int is_free = square > 0 && (!old || old[0] + old[4] + old[8] > 2.5); /* a projector's trace is its rank */
        for (int k = 0; is_free && k < 9; k++)
            projectors[9 * (size_t)v + (size_t)k] = n[k / 3] * n[k % 3] / square;
    }
    free(normal);
    PetscCall(objective_constrain(o, x, projectors));
    PetscFunctionReturn(0);
}
