/* A run without new crossings. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/no_crossings.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int32_t find(const curvopt_mesh *mesh, const double *xyz, co_thread_pool *threads, const curvopt_cancel *cancel,
                    co_crossings *out, curvopt_error *error) {
    co_surface_pieces pieces;
    *out = (co_crossings){0};
    int32_t status = co_pieces_create(mesh, xyz, CO_REPULSION_TIP, threads, cancel, &pieces, error);
    if (status == CURVOPT_OK)
        status = co_crossings_find(mesh, &pieces, threads, cancel, out, error);
    co_pieces_free(&pieces);
    if (status == CURVOPT_OK && co_cancel_is_requested(cancel))
        status = CO_CANCELLED;
    return status;
}

int32_t co_no_crossings_check(const curvopt_mesh *mesh, const double *xyz, const co_no_crossings *c,
                              co_thread_pool *threads, const curvopt_cancel *cancel, curvopt_error *error) {
    co_crossings found;
    int32_t status = find(mesh, xyz, threads, cancel, &found, error);
    const int is_worse = status == CURVOPT_OK && !co_face_pairs_allow(&c->exceptions.pairs, &found);
    for (size_t k = 0; k < found.n && is_worse && status == CURVOPT_OK; k++) {
        const int32_t *face = found.pair[k].face;
        if (found.pair[k].what == CO_CROSSING_PROVEN)
            status = co_status_fail(error, CURVOPT_ERROR_GEOMETRY, face[0],
                                    "no_crossings: with the constraints at their places the surface crosses itself, "
                                    "for example at faces %d and %d",
                                    face[0], face[1]);
    }
    co_crossings_free(&found);
    return status;
}

int32_t co_no_crossings_create(const curvopt_mesh *mesh, const double *xyz, const double *start,
                               co_thread_pool *threads, const curvopt_cancel *cancel, co_no_crossings *c,
                               curvopt_error *error) {
    const size_t n = 3 * (size_t)mesh->info.n_vertices;
    co_crossings found;
    *c = (co_no_crossings){0};
    int32_t status = find(mesh, xyz, threads, cancel, &found, error);
    if (status == CURVOPT_OK)
        status = co_face_pairs_create(mesh, &found, &c->exceptions.pairs, error);
    co_crossings_free(&found);
    if (status == CURVOPT_OK && memcmp(xyz, start, n * sizeof *xyz) != 0)
        status = co_no_crossings_check(mesh, start, c, threads, cancel, error);
    if (status != CURVOPT_OK)
        co_no_crossings_free(c);
    return status;
}

void co_no_crossings_free(co_no_crossings *c) {
    co_face_pairs_free(&c->exceptions.pairs);
    free(c->origin);
    *c = (co_no_crossings){0};
}

static int compare(const void *a, const void *b) {
    const int32_t *x = a, *y = b;
    const int k = x[0] == y[0];
    return (x[k] > y[k]) - (x[k] < y[k]);
}

int32_t co_no_crossings_touching(co_repulsion *r, const double *x, int32_t (**pairs)[2], int32_t *n, double *least,
                                 curvopt_error *error) {
    *n = 0;
    *least = (double)NAN;
    co_repulsion_look(r, x);
    const size_t n_all = r->facings.n;
    const int32_t *origin = r->exceptions->pairs.origin;
    int32_t(*all)[2] = co_memory_zeroed(n_all, sizeof *all);
    *pairs = all;
    if (!all || r->exceptions->failed != CURVOPT_OK)
        return co_status_no_memory(error);
    for (size_t k = 0; k < n_all; k++) {
        const co_facing *f = &r->facings.pair[k];
        const int32_t face[2] = {r->pieces.place[f->piece[0]].face, r->pieces.place[f->piece[1]].face};
        const int32_t one = origin ? origin[face[0]] : face[0], two = origin ? origin[face[1]] : face[1];
        all[k][0] = one < two ? one : two;
        all[k][1] = one < two ? two : one;
        *least = fmin(*least, f->distance); /* of a number and NAN the number */
    }
    qsort(all, n_all, sizeof *all, compare);
    for (size_t k = 0; k < n_all; k++)
        if (*n == 0 || compare(all[*n - 1], all[k]) != 0)
            memmove(all[(*n)++], all[k], sizeof all[k]);
    return CURVOPT_OK;
}

/* Child k of a face starts at its corner k. */
int32_t co_no_crossings_subdivide(const curvopt_mesh *coarse, const curvopt_mesh *fine, const double *xyz,
                                  co_thread_pool *threads, const curvopt_cancel *cancel, co_no_crossings *c,
                                  curvopt_error *error) {
    co_crossings found;
    int32_t *origin = CO_NEW(int32_t, coarse->info.n_corners);
    if (!origin)
        return co_status_no_memory(error);
    for (int32_t h = 0; h < coarse->info.n_corners; h++)
        origin[h] = c->origin ? c->origin[coarse->corner_face[h]] : coarse->corner_face[h];
    free(c->origin);
    c->origin = origin;
    c->exceptions.pairs.origin = origin;
    int32_t status = find(fine, xyz, threads, cancel, &found, error);
    if (status == CURVOPT_OK)
        co_face_pairs_accept(&c->exceptions.pairs, &found);
    co_crossings_free(&found);
    return status == CO_CANCELLED ? CURVOPT_OK : status; /* the level that follows sees it */
}
