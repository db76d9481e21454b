/* A point of the limit surface inside a face, and its derivatives, as rows over the cage.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/place_rows.h"

#include "base/memory.h"
#include "surface/basis_point.h"
#include "surface/evaluate.h"

#include <stdlib.h>
#include <string.h>

/* S, S_u, S_v, and S_uu, S_uv, S_vv, the first six of a jet: transposed, three rows are what three axes are. */
enum { N_AXES = 3, N_PARTS = CO_PLACE_ROWS / N_AXES };

typedef struct work {
    co_patches patches;
    co_basis_table_cache tables;
    double *jets;   /* [most points of a patch][CO_JET] */
    double *points; /* [N_PARTS][N_AXES n_points] weights of the points */
    double *cage;   /* [N_PARTS][N_AXES n_cage] of the vertices */
} work;

static void work_free(work *w) {
    co_patches_free(&w->patches);
    co_basis_table_cache_free(&w->tables);
    free(w->jets);
    free(w->points);
    free(w->cage);
}

/* Patches of the faces that have places. */
static int32_t work_create(const curvopt_mesh *m, const co_face_place *place, int32_t n, work *w,
                           curvopt_error *error) {
    double *weight = CO_NEW(double, m->info.n_faces);
    *w = (work){0};
    co_basis_table_cache_create(CURVOPT_SURFACE_LIMIT, &w->tables);
    for (int32_t i = 0; weight && i < n; i++)
        weight[place[i].face] = 1;
    int32_t status = weight ? co_patches_create(m, NULL, weight, CURVOPT_SURFACE_LIMIT, 1, NULL, &w->patches, error)
                            : co_status_no_memory(error);
    free(weight);
    if (status != CURVOPT_OK)
        return status;
    int32_t most = 0;
    for (int32_t p = 0; p < w->patches.n_patches; p++) {
        const int32_t size = co_patches_size(w->patches.kind[p]);
        most = size > most ? size : most;
    }
    w->jets = CO_NEW(double, (size_t)most *CO_JET);
    w->points = CO_NEW(double, CO_PLACE_ROWS *(size_t)w->patches.n_points);
    w->cage = CO_NEW(double, CO_PLACE_ROWS *(size_t)w->patches.n_cage);
    return w->jets && w->points && w->cage ? CURVOPT_OK : co_status_no_memory(error);
}

/* The patch with the place, and its own coordinates there; -1 if there is none. */
static int32_t find_patch(const co_patches *p, const co_face_place *place, double st[2]) {
    for (int32_t i = 0; i < p->n_patches; i++)
        if (p->place[i].face == place->face && p->place[i].quarter == place->corner &&
            co_evaluate_to_patch(&p->place[i], place->uv, st))
            return i;
    return -1;
}

/* Rows 3 part .. 3 part + 2 of a place on patch `at`, whose jets have been made. */
static void make_part(work *w, int32_t at, int part) {
    co_patches *p = &w->patches;
    double *points = w->points + (size_t)part * N_AXES * (size_t)p->n_points;
    double *cage = w->cage + (size_t)part * N_AXES * (size_t)p->n_cage;
    memset(points, 0, N_AXES * sizeof(double) * (size_t)p->n_points);
    memset(cage, 0, N_AXES * sizeof(double) * (size_t)p->n_cage);
    for (int32_t k = 0; k < co_patches_size(p->kind[at]); k++) {
        double along[CO_PLACE_ROWS];
        double *to = points + N_AXES * (size_t)p->points[p->start[at] + (size_t)k];
        co_evaluate_to_face(&p->place[at], CO_PLACE_ROWS, w->jets + (size_t)k * CO_JET, along);
        for (int r = 0; r < N_AXES; r++)
            to[r] += along[N_AXES * part + r];
    }
    co_patches_add_derived(p, points, cage);
}

static int32_t visit_place(work *w, const co_face_place *place, int32_t i, co_place_rows_fn visit, void *context,
                           curvopt_error *error) {
    double st[2], weight[CO_JET];
    co_patches *p = &w->patches;
    const int32_t at = find_patch(p, place, st);
    int32_t status =
        at < 0 ? CURVOPT_ERROR_ARGUMENT : co_basis_point(&w->tables, p->kind[at], st[0], st[1], w->jets, weight, error);
    if (at < 0)
        return co_status_fail(error, status, i, "u = %g, v = %g is not on face %d", place->uv[0], place->uv[1],
                              place->face);
    if (status != CURVOPT_OK)
        return status;
    const int n_rows = place->has_second ? CO_PLACE_ROWS : N_AXES;
    for (int part = 0; N_AXES * part < n_rows; part++)
        make_part(w, at, part);
    for (size_t v = 0; v < (size_t)p->n_cage; v++) {
        double sum[CO_PLACE_ROWS] = {0};
        int any = 0;
        for (size_t r = 0; r < (size_t)n_rows; r++) {
            const size_t part = r / N_AXES, axis = N_AXES * v + r % N_AXES;
            sum[r] = w->points[part * N_AXES * (size_t)p->n_points + axis] +
                     w->cage[part * N_AXES * (size_t)p->n_cage + axis];
            any |= sum[r] != 0;
        }
        if (any)
            visit(i, (int32_t)v, sum, context);
    }
    return CURVOPT_OK;
}

int32_t co_place_rows_visit(const curvopt_mesh *m, const co_face_place *place, int32_t n, co_place_rows_fn visit,
                            void *context, curvopt_error *error) {
    work w;
    if (n == 0)
        return CURVOPT_OK;
    int32_t status = work_create(m, place, n, &w, error);
    for (int32_t i = 0; status == CURVOPT_OK && i < n; i++)
        status = visit_place(&w, &place[i], i, visit, context, error);
    work_free(&w);
    return status;
}
