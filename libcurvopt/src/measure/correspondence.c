/* Surfaces of cages with the same faces. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/correspondence.h"

#include "base/memory.h"
#include "mesh/subdivide.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int are_same(const double *a, const double *b, int32_t n) {
    return !a == !b && (!a || memcmp(a, b, sizeof *a * (size_t)n) == 0);
}

static int have_same_faces(const curvopt_mesh *a, const curvopt_mesh *b) {
    const curvopt_mesh_info *i = &a->info, *j = &b->info;
    return i->n_vertices == j->n_vertices && i->n_faces == j->n_faces && i->n_corners == j->n_corners &&
           i->n_edges == j->n_edges &&
           memcmp(a->face_start, b->face_start, sizeof *a->face_start * ((size_t)i->n_faces + 1)) == 0 &&
           memcmp(a->corner_vertex, b->corner_vertex, sizeof *a->corner_vertex * (size_t)i->n_corners) == 0 &&
           are_same(a->edge_sharpness, b->edge_sharpness, i->n_edges) &&
           are_same(a->vertex_sharpness, b->vertex_sharpness, i->n_vertices);
}

static double farthest_vertex(size_t n, const double *a, const double *b) {
    double farthest = 0;
    for (size_t v = 0; v < n; v++) {
        double square = 0;
        for (size_t i = 3 * v; i < 3 * v + 3; i++)
            square += (a[i] - b[i]) * (a[i] - b[i]);
        farthest = fmax(farthest, sqrt(square));
    }
    return farthest;
}

/* A cage that is subdivided; its first mesh is the caller's. */
typedef struct refined {
    const curvopt_mesh *mesh;
    curvopt_mesh *own;
    double *xyz;
} refined;

static int32_t refine(refined *r, curvopt_error *error) {
    curvopt_mesh *fine = NULL;
    co_sparse_rows rows = {0};
    int32_t status = co_subdivide(r->mesh, &fine, &rows, error);
    double *xyz = status == CURVOPT_OK ? CO_NEW(double, 3 * (size_t)fine->info.n_vertices) : NULL;
    if (status == CURVOPT_OK && !xyz)
        status = co_status_no_memory(error);
    if (status == CURVOPT_OK)
        co_sparse_rows_apply(&rows, r->xyz, xyz);
    co_sparse_rows_free(&rows);
    curvopt_mesh_destroy(r->own);
    free(r->xyz);
    *r = (refined){.mesh = fine, .own = fine, .xyz = xyz};
    return status;
}

int32_t co_correspondence_farthest(const curvopt_mesh *const mesh[2], const double *const xyz[2], double *farthest,
                                   curvopt_error *error) {
    const int coarse = mesh[0]->info.n_vertices > mesh[1]->info.n_vertices;
    const curvopt_mesh *fine = mesh[!coarse];
    const size_t n = 3 * (size_t)mesh[coarse]->info.n_vertices;
    refined r = {.mesh = mesh[coarse], .xyz = CO_NEW(double, n)};
    int32_t status = r.xyz ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        memcpy(r.xyz, xyz[coarse], n * sizeof(double));
    while (status == CURVOPT_OK && r.mesh->info.n_vertices < fine->info.n_vertices)
        status = refine(&r, error);
    if (status == CURVOPT_OK)
        *farthest = have_same_faces(r.mesh, fine) ? farthest_vertex((size_t)fine->info.n_vertices, r.xyz, xyz[!coarse])
                                                  : (double)INFINITY;
    curvopt_mesh_destroy(r.own);
    free(r.xyz);
    return status;
}
