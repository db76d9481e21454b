/* Fits on half discs (method: blend_fit_half.h). SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/blend_fit_half.h"

#include "base/memory.h"
#include "surface/blend_fit_cut.h"

#include <math.h>
#include <stdlib.h>

enum { TERMS = CO_BLEND_FIT_TERMS };

int32_t co_blend_fit_half_index(int width, int32_t sector, int x, int y) {
    if (x == 0 && y == 0)
        return 0;
    if (x == 0) /* on the next sector's first edge */
        return co_blend_fit_half_index(width, sector + 1, y, 0);
    return 1 + (width + 1) * ((width + 2) * sector + y) + x - 1;
}

int co_blend_fit_half_point(int32_t n, int width, int32_t sector, int x, int y, int32_t index[2], co_real weight[2]) {
    const int below = y < 0 && sector == 0, beside = x < 0 && sector == n - 1;
    weight[0] = 1;
    if (below || beside) {
        index[0] = co_blend_fit_half_index(width, sector, beside ? 0 : x, below ? 0 : y);
        index[1] = co_blend_fit_half_index(width, sector, beside ? 1 : x, below ? 1 : y);
        weight[0] = 2;
        weight[1] = -1;
        return 2;
    }
    index[0] = y < 0   ? co_blend_fit_half_index(width, sector - 1, -y, x)
               : x < 0 ? co_blend_fit_half_index(width, sector + 1, y, -x)
                       : co_blend_fit_half_index(width, sector, x, y);
    return 1;
}

int32_t co_blend_fit_create_half_map(int32_t n, int width, co_blend_fit *p, curvopt_error *error) {
    const int32_t fan = co_fan_make(CO_FAN_CREASE, n, 0);
    const co_real scale = co_blend_fit_half_scale(width);
    *p = (co_blend_fit){
        .valence = n, .width = width, .is_half = 1, .n_points = co_blend_fit_half_n_points(n, width)};
    p->map = CO_NEW(co_real, 2 * (size_t)p->n_points);
    if (!p->map)
        return co_status_no_memory(error);
    for (int32_t s = 0; s < n; s++)
        for (int x = 0; x <= width + 1; x++)
            for (int y = 0; y <= width + 1; y++) {
                co_real *to = p->map + 2 * (size_t)co_blend_fit_half_index(width, s, x, y);
                co_blend_fit_natural(fan, s, x, y, to);
                to[0] *= scale;
                to[1] *= scale;
            }
    return CURVOPT_OK;
}

/* A fit that is being made. Rows of samples are over some points; each of the n entries says that as much of the row's
 * number `part` belongs to the disc's point `index`. */
typedef struct half_fit {
    co_blend_fit *p;
    int32_t n, *part, *index;      /* [n] */
    co_real *weight;               /* [n] */
    co_real normal[TERMS * TERMS]; /* lower triangle */
} half_fit;

/* p->fit holds the right-hand sides until they are solved for. */
static void add_sample(void *user, const co_real *row, co_real weight) {
    half_fit *f = user;
    const co_blend_fit *p = f->p;
    co_real x = 0, y = 0, value[TERMS];
    for (int32_t k = 0; k < f->n; k++) {
        x += row[f->part[k]] * f->weight[k] * p->map[2 * f->index[k]];
        y += row[f->part[k]] * f->weight[k] * p->map[2 * f->index[k] + 1];
    }
    co_blend_fit_values(x, y, value);
    for (int a = 0; a < TERMS; a++) {
        for (int b = 0; b <= a; b++)
            f->normal[a * TERMS + b] += weight * value[a] * value[b];
        for (int32_t k = 0; k < f->n; k++)
            p->fit[a * p->n_points + f->index[k]] += weight * row[f->part[k]] * f->weight[k] * value[a];
    }
}

/* The face at the vertex: rows over the two-ring. work: co_blend_fit_sample_rings */
static int32_t add_vertex_face(half_fit *f, int32_t sector, co_real *work, curvopt_error *error) {
    co_stam_disc disc;
    int32_t status = co_stam_disc_create(co_fan_make(CO_FAN_CREASE, f->p->valence, sector), &disc, error);
    if (status != CURVOPT_OK)
        return status;
    f->n = disc.n_points;
    for (int32_t k = 0; k < f->n; k++) {
        f->part[k] = k;
        f->index[k] = co_blend_fit_index_of_two_ring(f->p, k);
        f->weight[k] = 1;
    }
    co_blend_fit_sample_rings(&disc, f->p->width, work, add_sample, f);
    co_stam_disc_free(&disc);
    return CURVOPT_OK;
}

/* Any other face: rows over its 16 points. */
static void add_face(half_fit *f, int32_t sector, int i, int j) {
    f->n = 0;
    for (int k = 0; k < 16; k++) {
        int n = co_blend_fit_half_point(f->p->valence, f->p->width, sector, i + k % 4 - 1, j + k / 4 - 1,
                                        f->index + f->n, f->weight + f->n);
        for (; n > 0; n--)
            f->part[f->n++] = k;
    }
    co_blend_fit_sample_face(f->p->width, i, j, add_sample, f);
}

int32_t co_blend_fit_create_half(int32_t n, int width, co_blend_fit *p, curvopt_error *error) {
    const size_t two_ring = (size_t)co_fan_n_points(co_fan_make(CO_FAN_CREASE, n, 0)), most = two_ring + 32;
    int32_t status = co_blend_fit_create_half_map(n, width, p, error);
    if (status != CURVOPT_OK)
        return status;
    half_fit f = {
        .p = p, .part = CO_NEW(int32_t, most), .index = CO_NEW(int32_t, most), .weight = CO_NEW(co_real, most)};
    co_real *work = CO_NEW(co_real, 18 * two_ring);
    p->fit = CO_NEW(co_real, CO_BLEND_FIT_FUNCTIONS * (size_t)p->n_points);
    if (!f.part || !f.index || !f.weight || !work || !p->fit)
        status = co_status_no_memory(error);
    for (int32_t s = 0; status == CURVOPT_OK && s < n; s++) {
        status = add_vertex_face(&f, s, work, error);
        for (int k = 1; status == CURVOPT_OK && k < width * width; k++)
            add_face(&f, s, k % width, k / width);
    }
    if (status == CURVOPT_OK)
        co_blend_fit_solve(TERMS, f.normal, p->n_points, p->n_points, p->fit);
    else
        co_blend_fit_free(p);
    free(f.part);
    free(f.index);
    free(f.weight);
    free(work);
    return status;
}
