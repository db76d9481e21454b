/* Faces in which the surface is folded. SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/folds.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "surface/basis_point.h"
#include "surface/patches.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CELLS = 8, ACROSS = CELLS + 1, POINTS = ACROSS * ACROSS };
enum { BETWEEN = 1024 }; /* patches between two looks at the flag */
/* The outermost points lie this far inside a patch: at a pole there are no derivatives. */
static const double MARGIN = 1e-3;
/* Cosine that normals at a cell's corners have at least with their mean: .66 and more on 17 cages that are not folded,
 * -.11 and less on 35 that are (libcurvopt/notes/114-folded-cages.md). */
static const double LEAST_COSINE = 0.2;

typedef struct search {
    co_patches patches;
    co_basis_table_cache tables;
    double *points; /* [3 n_points] */
    double *rows;   /* [POINTS][2][largest] weights of S_u and S_v, of a kind of patch */
    double *jet;    /* [largest][CO_JET] of one point */
} search;

static void free_search(search *s) {
    co_patches_free(&s->patches);
    co_basis_table_cache_free(&s->tables);
    free(s->points);
    free(s->rows);
    free(s->jet);
}

static int32_t create_search(const curvopt_mesh *m, const double *xyz, const uint8_t *left_out, co_cancel *cancel,
                             search *s, curvopt_error *error) {
    size_t largest = 0;
    double *weight = left_out ? CO_NEW(double, m->info.n_faces) : NULL;
    *s = (search){0};
    co_basis_table_cache_create(CURVOPT_SURFACE_LIMIT, &s->tables);
    s->tables.cancel = cancel;
    if (left_out && !weight)
        return co_status_no_memory(error);
    for (int32_t f = 0; weight && f < m->info.n_faces; f++)
        weight[f] = !left_out[f];
    int32_t status = co_patches_create(m, xyz, weight, CURVOPT_SURFACE_LIMIT, 1, cancel, &s->patches, error);
    free(weight);
    if (status != CURVOPT_OK)
        return status;
    for (int32_t k = 0; k < s->patches.n_kinds; k++) {
        const size_t size = (size_t)co_patches_size(s->patches.kinds[k]);
        largest = size > largest ? size : largest;
    }
    s->points = CO_NEW(double, 3 * (size_t)s->patches.n_points);
    s->rows = CO_NEW(double, 2 * POINTS * largest);
    s->jet = CO_NEW(double, CO_JET *largest);
    if (!s->points || !s->rows || !s->jet)
        return co_status_no_memory(error);
    memcpy(s->points, xyz, 3 * sizeof *xyz * (size_t)s->patches.n_cage);
    co_patches_derive(&s->patches, s->points);
    return CURVOPT_OK;
}

/* Rows of first derivatives at the corners of cells. */
static int32_t make_rows(search *s, int32_t kind, curvopt_error *error) {
    const int32_t size = co_patches_size(kind);
    double unused[CO_JET];
    for (int i = 0; i < POINTS; i++) {
        const double u = MARGIN + (1 - 2 * MARGIN) * (i % ACROSS) / CELLS;
        const double v = MARGIN + (1 - 2 * MARGIN) * (i / ACROSS) / CELLS;
        int32_t status = co_basis_point(&s->tables, kind, u, v, s->jet, unused, error);
        if (status != CURVOPT_OK)
            return status;
        for (int32_t k = 0; k < size; k++)
            for (int d = 0; d < 2; d++)
                s->rows[(2 * (size_t)i + (size_t)d) * (size_t)size + (size_t)k] =
                    s->jet[(size_t)k * CO_JET + (size_t)d + 1];
    }
    return CURVOPT_OK;
}

/* Unit normals at the corners of a patch's cells; 0 where there is none. */
static void find_normals(const search *s, int32_t patch, double normal[POINTS][3]) {
    const int32_t size = co_patches_size(s->patches.kind[patch]);
    const int32_t *index = s->patches.points + s->patches.start[patch];
    for (int i = 0; i < POINTS; i++) {
        double along[2][3] = {{0}};
        for (int d = 0; d < 2; d++) {
            const double *row = s->rows + (2 * (size_t)i + (size_t)d) * (size_t)size;
            for (int32_t k = 0; k < size; k++)
                for (int c = 0; c < 3; c++)
                    along[d][c] += row[k] * s->points[3 * (size_t)index[k] + (size_t)c];
        }
        co_cross3(along[0], along[1], normal[i]);
        const double length = co_length3(normal[i]);
        for (int c = 0; c < 3; c++)
            normal[i][c] = length > 0 ? normal[i][c] / length : 0;
    }
}

/* Whether the normals at a cell's corners are in a common half space. */
static int is_cell_even(double normal[POINTS][3], int corner) {
    const int at[4] = {corner, corner + 1, corner + ACROSS, corner + ACROSS + 1};
    double mean[3] = {0};
    for (int k = 0; k < 4; k++)
        for (int c = 0; c < 3; c++)
            mean[c] += normal[at[k]][c];
    const double length = co_length3(mean);
    for (int k = 0; k < 4; k++)
        if (!(co_dot3(mean, normal[at[k]]) >= LEAST_COSINE * length && length > 0))
            return 0;
    return 1;
}

static int is_patch_even(const search *s, int32_t patch) {
    double normal[POINTS][3];
    int is_even = 1;
    find_normals(s, patch, normal);
    for (int v = 0; v < CELLS; v++)
        for (int u = 0; u < CELLS; u++)
            is_even &= is_cell_even(normal, v * ACROSS + u);
    return is_even;
}

static int32_t mark(search *s, co_cancel *cancel, uint8_t *folded, int32_t *n, curvopt_error *error) {
    const co_patches *p = &s->patches;
    for (int32_t k = 0; k < p->n_kinds; k++) {
        int32_t status = make_rows(s, p->kinds[k], error);
        if (status != CURVOPT_OK)
            return status;
        for (int32_t i = 0; i < p->n_patches; i++) {
            if (i % BETWEEN == 0 && co_cancel_is_due(cancel))
                return CO_CANCELLED;
            if (p->kind[i] != p->kinds[k] || folded[p->place[i].face] || is_patch_even(s, i))
                continue;
            folded[p->place[i].face] = 1;
            (*n)++;
        }
    }
    return CURVOPT_OK;
}

int32_t co_folds_find(const curvopt_mesh *mesh, const double *xyz, const uint8_t *left_out, co_cancel *cancel,
                      uint8_t *folded, int32_t *n, curvopt_error *error) {
    search s;
    *n = 0;
    memset(folded, 0, (size_t)mesh->info.n_faces);
    int32_t status = create_search(mesh, xyz, left_out, cancel, &s, error);
    if (status == CURVOPT_OK)
        status = mark(&s, cancel, folded, n, error);
    free_search(&s);
    return status;
}
