/* A cage that a run may begin with in place of one whose surface is folded.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/unfold.h"

#include "base/memory.h"
#include "constraints/freedom.h"
#include "mesh/fill.h"
#include "surface/folds.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_ROUNDS = 8, MOST_PASSES = 10 };
/* Of a cage's vertices at least this part stays, and says where the others belong. */
static const double LEAST_PART = 0.25;

typedef struct unfolding {
    const curvopt_mesh *mesh;
    co_constraints all;
    double *xyz;     /* [3 n_vertices] the cage with its free vertices in place */
    uint8_t *folded; /* [n_faces] */
    uint8_t *free;   /* [n_vertices] whether a vertex is put into place */
    int32_t *count;  /* [n_vertices] folded faces at a vertex; or whether it was free a round ago */
    int32_t n_free;
} unfolding;

static void take(unfolding *u, int32_t v) {
    const int is_held = u->all.freedom && u->all.freedom[v] != CO_FREEDOM_ALL;
    if (is_held || u->free[v])
        return;
    u->free[v] = 1;
    u->n_free++;
}

/* Vertices of `least` and more folded faces. Whether there are any that were not free. */
static int take_folded(unfolding *u, int least) {
    const curvopt_mesh *m = u->mesh;
    const int32_t before = u->n_free;
    memset(u->count, 0, sizeof *u->count * (size_t)m->info.n_vertices);
    for (int32_t h = 0; h < m->info.n_corners; h++)
        u->count[m->corner_vertex[h]] += u->folded[m->corner_face[h]];
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        if (u->count[v] >= least)
            take(u, v);
    return u->n_free > before;
}

/* Neighbours of free vertices. */
static int take_neighbours(unfolding *u) {
    const curvopt_mesh *m = u->mesh;
    const int32_t before = u->n_free;
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        u->count[v] = u->free[v];
    for (int32_t h = 0; h < m->info.n_corners; h++) {
        const int32_t v = m->corner_vertex[h], w = co_mesh_destination(m, h);
        if (u->count[v] != u->count[w])
            take(u, u->count[v] ? w : v);
    }
    return u->n_free > before;
}

/* First the vertices in which folded faces meet: two that have changed places are those. */
static int grow(unfolding *u) {
    return (u->n_free == 0 && take_folded(u, 2)) || take_folded(u, 1) || take_neighbours(u);
}

/* Rounds of filling and looking again. *n: folded faces that are left. */
static int32_t fill(unfolding *u, const double *xyz, co_cancel *cancel, int32_t *n, curvopt_error *error) {
    const double most = (1 - LEAST_PART) * u->mesh->info.n_vertices;
    int32_t status = CURVOPT_OK;
    for (int k = 0; status == CURVOPT_OK && *n > 0 && k < MOST_ROUNDS && grow(u) && u->n_free <= most; k++) {
        memcpy(u->xyz, xyz, 3 * sizeof *xyz * (size_t)u->mesh->info.n_vertices);
        status = co_mesh_fill(u->mesh, u->free, NULL, cancel, u->xyz, error);
        if (status == CURVOPT_OK)
            status = co_folds_find(u->mesh, u->xyz, u->all.left_out, cancel, u->folded, n, error);
    }
    return status;
}

/* next [3 n_vertices] becomes u->xyz with its free vertices half of the way to the mean of their neighbours. */
static void smooth(unfolding *u, double *next) {
    const curvopt_mesh *m = u->mesh;
    const size_t n = (size_t)m->info.n_vertices;
    memset(next, 0, 3 * n * sizeof *next);
    memset(u->count, 0, n * sizeof *u->count);
    for (int32_t k = 0; k < m->info.n_edges; k++) {
        const int32_t h = m->edge_corner[k], end[2] = {m->corner_vertex[h], co_mesh_destination(m, h)};
        for (int i = 0; i < 2; i++) {
            u->count[end[i]]++;
            for (size_t c = 0; c < 3; c++)
                next[3 * (size_t)end[i] + c] += u->xyz[3 * (size_t)end[1 - i] + c];
        }
    }
    for (size_t i = 0; i < 3 * n; i++)
        next[i] = u->free[i / 3] && u->count[i / 3] > 0 ? 0.5 * (u->xyz[i] + next[i] / u->count[i / 3]) : u->xyz[i];
}

/* Where too little of a cage is in its place to say where the rest belongs, all that may move is smoothed, as little as
 * will do. *n: folded faces that are left. */
static int32_t smooth_all(unfolding *u, const double *xyz, co_cancel *cancel, int32_t *n, curvopt_error *error) {
    const size_t size = 3 * sizeof *xyz * (size_t)u->mesh->info.n_vertices;
    double *next = CO_NEW(double, 3 * (size_t)u->mesh->info.n_vertices);
    int32_t status = next ? CURVOPT_OK : co_status_no_memory(error);
    memcpy(u->xyz, xyz, size);
    for (int32_t v = 0; v < u->mesh->info.n_vertices; v++)
        take(u, v);
    for (int pass = 0; status == CURVOPT_OK && *n > 0 && u->n_free > 0 && pass < MOST_PASSES; pass++) {
        smooth(u, next);
        memcpy(u->xyz, next, size);
        status = co_folds_find(u->mesh, u->xyz, u->all.left_out, cancel, u->folded, n, error);
    }
    free(next);
    return status;
}

int32_t co_unfold(const curvopt_mesh *mesh, const co_constraints *constraints, int32_t boundary, co_cancel *cancel,
                  double *xyz, co_unfolding *out, curvopt_error *error) {
    const size_t n = (size_t)mesh->info.n_vertices;
    int32_t n_left = 0;
    unfolding u = {.mesh = mesh,
                   .xyz = CO_NEW(double, 3 * n),
                   .folded = CO_NEW(uint8_t, mesh->info.n_faces),
                   .free = CO_NEW(uint8_t, n),
                   .count = CO_NEW(int32_t, n)};
    *out = (co_unfolding){0};
    int32_t status = u.xyz && u.folded && u.free && u.count ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = co_constraints_all(mesh, constraints, boundary, &u.all, error);
    if (status == CURVOPT_OK)
        status = co_folds_find(mesh, xyz, u.all.left_out, cancel, u.folded, &n_left, error);
    out->n_folded = n_left;
    if (status == CURVOPT_OK)
        status = fill(&u, xyz, cancel, &n_left, error);
    if (status == CURVOPT_OK && n_left > 0)
        status = smooth_all(&u, xyz, cancel, &n_left, error);
    if (status == CURVOPT_OK && out->n_folded && !n_left) {
        out->n_moved = u.n_free;
        memcpy(xyz, u.xyz, 3 * n * sizeof *xyz);
    }
    co_constraints_free(&u.all);
    free(u.xyz);
    free(u.folded);
    free(u.free);
    free(u.count);
    return status;
}
