/* Quadrature points and basis rows of a kind of face. SPDX-License-Identifier: GPL-3.0-or-later */
#include "patch_table.h"

#include "blend.h"
#include "memory.h"
#include "quadrature.h"

#include <math.h>
#include <stdlib.h>

/* How finely a kind of face is sampled: points a side of the face, or of the first ring's cells; and how small a part
 * of the face the hole round an extraordinary vertex may be. The integral over that hole is not dropped: what happens
 * in the last ring repeats in the rings inside it with a known ratio (see ring_tail), which its weights take up.
 *
 * On `limit` all rings look alike and get the same points. A blend varies most where it lets go, in the first ring: its
 * rings get half as many points each as the one before, down to `least`. (One vertex of valence 3, MVS on `plane`: with
 * 24, 36, 48 points a side the first ring is off by 3e-3, 2e-4, 3e-5; 12 in the second ring by 1e-5; 6 in the third by
 * 2e-6 of the whole.) Every rule is finer than the one before it, or comparing the two would tell nothing. */
typedef struct rule {
    int points, least;
    double hole;
} rule;
enum { KIND_REGULAR, KIND_LIMIT, KIND_BLEND, N_KINDS };
static const rule rules[N_KINDS][CO_N_RULES] = {
    {{3, 3, 1}, {4, 4, 1}, {6, 6, 1}, {12, 12, 1}, {24, 24, 1}, {48, 48, 1}},
    {{3, 3, 1e-3}, {4, 4, 1e-3}, {6, 6, 1e-4}, {10, 10, 1e-5}, {16, 16, 1e-6}, {24, 24, 1e-7}},
    {{8, 3, 1e-3}, {16, 4, 1e-3}, {24, 4, 1e-4}, {36, 6, 1e-5}, {48, 6, 1e-6}, {72, 8, 1e-7}}};
enum { MIN_RINGS = 4, MAX_RINGS = 40, MAX_GAUSS = 12 };

static int kind_of(const co_table *t) {
    return t->valence == 4 ? KIND_REGULAR : t->surface == CURVOPT_SURFACE_LIMIT ? KIND_LIMIT : KIND_BLEND;
}

static int points_of_ring(int kind, const rule *r, int ring) {
    int points = kind == KIND_BLEND ? r->points >> (ring < 16 ? ring - 1 : 15) : r->points;
    return points > r->least ? points : r->least;
}

/* Ratios of successive rings' integrals: of area lambda^2, of squared curvature (mu / lambda^2)^2 lambda^2. */
typedef struct ring_tail {
    double area_ratio;
    double curvature_ratio;
    int n_rings;
} ring_tail;

static ring_tail tail_of(const co_disc *disc, int32_t surface, double hole) {
    double lambda = (double)disc->lambda, mu = (double)disc->mu;
    ring_tail t = {.area_ratio = lambda * lambda, .curvature_ratio = mu * mu / (lambda * lambda)};
    if (surface != CURVOPT_SURFACE_LIMIT) /* smooth there: curvature behaves like a constant */
        t.curvature_ratio = t.area_ratio;
    t.n_rings = (int)ceil(log(hole) / log(fmax(t.area_ratio, t.curvature_ratio)));
    t.n_rings = t.n_rings < MIN_RINGS ? MIN_RINGS : t.n_rings > MAX_RINGS ? MAX_RINGS : t.n_rings;
    return t;
}

void co_table_destroy(co_table *t) {
    if (!t)
        return;
    free(t->support);
    free(t->area_weight);
    free(t->weight);
    free(t->jacobian_scale);
    free(t->rows);
    free(t->blend);
    free(t->masks);
    free(t);
}

static int32_t allocate(co_table *t, curvopt_error *error) {
    size_t samples = (size_t)t->n_samples, points = (size_t)t->n_points;
    int plane = t->surface == CURVOPT_SURFACE_PLANE && t->valence != 4;
    t->area_weight = CO_NEW(double, samples);
    t->weight = CO_NEW(double, samples);
    t->jacobian_scale = CO_NEW(double, samples);
    t->rows = CO_NEW_ALIGNED(double, samples *points *CO_JET);
    t->blend = plane ? CO_NEW(double, samples *CO_JET) : NULL;
    t->masks = plane ? CO_NEW(double, 3 * points) : NULL;
    if (!t->area_weight || !t->weight || !t->jacobian_scale || !t->rows || (plane && (!t->blend || !t->masks)))
        return co_status_no_memory(error);
    return CURVOPT_OK;
}

/* The patch points that rows can be nonzero on. */
static int32_t choose_support(co_table *t, curvopt_error *error) {
    int32_t n = t->valence == 4 ? CO_RING_REGULAR : co_ring_two_ring_size(t->valence);
    t->support = CO_NEW(int32_t, n);
    if (!t->support)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < n; i++)
        if (t->valence == 4 || t->surface == CURVOPT_SURFACE_POLYNOMIAL || co_irregular_in_support(t->valence, i))
            t->support[t->n_points++] = i;
    return CURVOPT_OK;
}

/* One sample from the jets of the 16 bicubic basis functions and, for a ring's cell, the cell's points over the
 * two-ring (cell [16][stride], NULL for a regular face). */
static void store_rows(co_table *t, int32_t sample, co_real basis[16][CO_JET], const co_real *cell, int32_t stride) {
    double *rows = t->rows + (size_t)sample * (size_t)t->n_points * CO_JET;
    for (int32_t p = 0; p < t->n_points; p++, rows += CO_JET)
        for (int k = 0; k < CO_JET; k++) {
            co_real sum = 0;
            if (cell)
                for (int i = 0; i < 16; i++)
                    sum += basis[i][k] * cell[i * stride + t->support[p]];
            else
                sum = basis[t->support[p]][k];
            rows[k] = (double)sum;
        }
}

/* The blend's jet at (u, v) of the face, derivatives with respect to a cell of the given side. */
static void blend_of_cell(co_real u, co_real v, co_real side, double *out) {
    co_real jet[CO_JET];
    co_blend_weight(u, v, jet);
    for (int k = 0; k < CO_JET; k++) {
        for (int order = co_jet_order_u[k] + co_jet_order_v[k]; order > 0; order--)
            jet[k] *= side;
        out[k] = (double)jet[k];
    }
}

/* The samples of one cell, from number `sample` on; returns the next free one. */
typedef struct cell_info {
    int n_side;            /* points a side, in sub-cells of at most MAX_GAUSS each way */
    const co_real *points; /* [16][stride] or NULL */
    int32_t stride;
    co_real origin[2], side; /* of the cell in its face */
    double area_factor, curvature_factor, jacobian_scale;
} cell_info;

static int32_t add_cell(co_table *t, const cell_info *cell, int32_t sample) {
    co_real node[MAX_GAUSS], weight[MAX_GAUSS], basis[16][CO_JET];
    int splits = (cell->n_side + MAX_GAUSS - 1) / MAX_GAUSS, gauss = cell->n_side / splits;
    co_quadrature_gauss(gauss, node, weight);
    for (int j = 0; j < cell->n_side; j++)
        for (int i = 0; i < cell->n_side; i++, sample++) {
            co_real u = (i / gauss + node[i % gauss]) / splits;
            co_real v = (j / gauss + node[j % gauss]) / splits;
            co_real w = weight[i % gauss] * weight[j % gauss] / (splits * splits);
            co_bspline_bicubic(u, v, basis);
            store_rows(t, sample, basis, cell->points, cell->stride);
            t->area_weight[sample] = (double)w * cell->area_factor;
            t->weight[sample] = (double)w * cell->curvature_factor;
            t->jacobian_scale[sample] = cell->jacobian_scale;
            if (t->blend)
                blend_of_cell(cell->origin[0] + cell->side * u, cell->origin[1] + cell->side * v, cell->side,
                              t->blend + (size_t)sample * CO_JET);
        }
    return sample;
}

static int32_t fill_irregular(co_table *t, co_disc *disc, const rule *r, ring_tail tail, curvopt_error *error) {
    co_real *points = CO_NEW(co_real, 16 * (size_t)disc->n_points);
    co_real *masks = CO_NEW(co_real, 3 * (size_t)disc->n_points);
    int32_t sample = 0, status = CURVOPT_ERROR_MEMORY;
    co_real side = 1;
    if (!points || !masks) {
        co_status_no_memory(error);
        goto done;
    }
    for (int ring = 1; ring <= tail.n_rings; ring++) {
        int last = ring == tail.n_rings;
        side /= 2;
        for (int c = 0; c < CO_RING_CELLS; c++) {
            cell_info cell = {.n_side = points_of_ring(kind_of(t), r, ring),
                              .points = points,
                              .stride = disc->n_points,
                              .side = side};
            cell.origin[0] = side * co_irregular_cell_place[c][0];
            cell.origin[1] = side * co_irregular_cell_place[c][1];
            cell.area_factor = last ? 1 / (1 - tail.area_ratio) : 1;
            cell.curvature_factor = last ? 1 / (1 - tail.curvature_ratio) : 1;
            cell.jacobian_scale = pow(tail.area_ratio, -ring);
            co_disc_cell(disc, c, points);
            sample = add_cell(t, &cell, sample);
        }
        co_disc_advance(disc);
    }
    if (t->masks) {
        co_irregular_limit_masks(t->valence, masks);
        for (int m = 0; m < 3; m++)
            for (int32_t p = 0; p < t->n_points; p++)
                t->masks[m * t->n_points + p] = (double)masks[m * disc->n_points + t->support[p]];
    }
    status = CURVOPT_OK;
done:
    free(points);
    free(masks);
    return status;
}

static int32_t fill(co_table *t, int32_t rule_number, curvopt_error *error) {
    const rule *r = &rules[kind_of(t)][rule_number];
    int32_t status = choose_support(t, error);
    if (status != CURVOPT_OK)
        return status;
    if (t->valence == 4) {
        t->n_samples = r->points * r->points;
        status = allocate(t, error);
        if (status == CURVOPT_OK) {
            cell_info whole = {
                .n_side = r->points, .side = 1, .area_factor = 1, .curvature_factor = 1, .jacobian_scale = 1};
            add_cell(t, &whole, 0);
        }
        return status;
    }
    co_disc disc;
    status = co_disc_create(t->valence, &disc, error);
    if (status != CURVOPT_OK)
        return status;
    ring_tail tail = tail_of(&disc, t->surface, r->hole);
    for (int ring = 1; ring <= tail.n_rings; ring++)
        t->n_samples += CO_RING_CELLS * points_of_ring(kind_of(t), r, ring) * points_of_ring(kind_of(t), r, ring);
    status = allocate(t, error);
    if (status == CURVOPT_OK)
        status = fill_irregular(t, &disc, r, tail, error);
    co_disc_free(&disc);
    return status;
}

int32_t co_table_create(int32_t surface, int32_t valence, int32_t rule_number, co_table **out, curvopt_error *error) {
    *out = NULL;
    co_table *t = CO_NEW(co_table, 1);
    if (!t)
        return co_status_no_memory(error);
    t->surface = surface;
    t->valence = valence;
    int32_t status = fill(t, rule_number, error);
    if (status != CURVOPT_OK) {
        co_table_destroy(t);
        return status;
    }
    *out = t;
    return CURVOPT_OK;
}

/* Ring and cell that contain (u, v) of an irregular patch; `side` their side. */
static int locate(double u, double v, int *ring, co_real *side) {
    *ring = 1;
    *side = 0.5L;
    while (u < *side && v < *side) {
        ++*ring;
        *side /= 2;
    }
    return v < *side ? 0 : u < *side ? 2 : 1;
}

static int32_t irregular_point(int32_t valence, double u, double v, double *rows, curvopt_error *error) {
    co_disc disc;
    co_real *points = NULL, basis[16][CO_JET], side = 1;
    int32_t status = co_disc_create(valence, &disc, error);
    if (status != CURVOPT_OK)
        return status;
    int32_t n = disc.n_points;
    points = CO_NEW(co_real, 16 * (size_t)n);
    if (!points) {
        status = co_status_no_memory(error);
        goto done;
    }
    if (u == 0 && v == 0) {
        co_irregular_limit_masks(valence, points);
        for (int32_t i = 0; i < n * CO_JET; i++)
            rows[i] = i % CO_JET ? (double)NAN : (double)points[i / CO_JET];
        goto done;
    }
    int ring, c = locate(u, v, &ring, &side);
    while (disc.ring < ring)
        co_disc_advance(&disc);
    co_disc_cell(&disc, c, points);
    co_bspline_bicubic(u / side - co_irregular_cell_place[c][0], v / side - co_irregular_cell_place[c][1], basis);
    for (int32_t p = 0; p < n; p++)
        for (int k = 0; k < CO_JET; k++) {
            co_real sum = 0;
            for (int i = 0; i < 16; i++)
                sum += basis[i][k] * points[i * n + p];
            rows[p * CO_JET + k] = (double)(sum / powl(side, co_jet_order_u[k] + co_jet_order_v[k]));
        }
done:
    free(points);
    co_disc_free(&disc);
    return status;
}

int32_t co_table_point(int32_t surface, int32_t valence, double u, double v, double *rows, double *weight,
                       curvopt_error *error) {
    for (int k = 0; k < CO_JET; k++)
        weight[k] = 0;
    if (valence != 4) {
        if (surface != CURVOPT_SURFACE_LIMIT)
            blend_of_cell(u, v, 1, weight);
        return irregular_point(valence, u, v, rows, error);
    }
    co_real basis[16][CO_JET];
    co_bspline_bicubic(u, v, basis);
    for (int i = 0; i < 16 * CO_JET; i++)
        rows[i] = (double)basis[i / CO_JET][i % CO_JET];
    return CURVOPT_OK;
}

int32_t co_table_cache_create(int32_t surface, int32_t max_valence, co_table_cache *cache, curvopt_error *error) {
    *cache = (co_table_cache){.surface = surface, .max_valence = max_valence};
    cache->table = CO_NEW(co_table *, (size_t)(max_valence + 1) * CO_N_RULES);
    return cache->table ? CURVOPT_OK : co_status_no_memory(error);
}

void co_table_cache_free(co_table_cache *cache) {
    for (int32_t i = 0; cache->table && i < (cache->max_valence + 1) * CO_N_RULES; i++)
        co_table_destroy(cache->table[i]);
    free(cache->table);
    *cache = (co_table_cache){0};
}

int32_t co_table_cache_get(co_table_cache *cache, int32_t valence, int32_t rule_number, const co_table **out,
                           curvopt_error *error) {
    co_table **slot = &cache->table[valence * CO_N_RULES + rule_number];
    int32_t status = CURVOPT_OK;
    if (!*slot)
        status = co_table_create(cache->surface, valence, rule_number, slot, error);
    *out = *slot;
    return status;
}
