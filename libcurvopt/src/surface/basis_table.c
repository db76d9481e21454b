/* Quadrature points and basis rows of a kind of face (finite elements: tabulated shape functions).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/basis_table.h"

#include "base/elementary.h"
#include "base/memory.h"
#include "surface/blend_fit_cut.h"
#include "surface/blend_fit_half.h"
#include "surface/gauss_legendre.h"
#include "surface/patches.h"
#include "surface/ring_cell.h"

#include <math.h>
#include <stdlib.h>

/* Quadrature rules of each kind of face, from coarse to fine, found by experiment
 * (notes/20-rules-at-an-extraordinary-vertex.md). A regular face has one product rule of Gauss. Round an extraordinary
 * vertex each ring of three cells has rules of its own, down to a hole; the integral over the hole is not dropped: what
 * happens in the last ring repeats in the rings inside it with a known ratio (ring_tail), which its weights take up.
 *
 * Points a side fall from ring to ring, down to `least`:
 * - `limit`: by one. All rings look alike, and inner ones count for less and less.
 * - `plane`, `polynomial`: by the factors in `fall`. A blend varies most in the first ring
 *   (libcurvopt/notes/20-rules-at-an-extraordinary-vertex.md).
 * - the vertex of a wide disc: by one, and down to a large hole, since w is flat there and the surface all but a
 *   polynomial of the chart.
 * Every rule is finer in all respects than the one before it, or comparing the two would not tell what is missing.
 *
 * Example: rule 1 of `limit`, {4, 3, 1e-4}, at valence 3. Integrals shrink by lambda^2 = 0.168 a ring, and 0.168^6 <
 * 1e-4 makes 6 rings, of 4, 3, 3, 3, 3, 3 points a side: 3 (16 + 5 * 9) = 183 samples. */
typedef struct rule {
    int points;  /* points a side of the face, or of the first ring's cells */
    int least;   /* points a side of the cells of inner rings, at least */
    double hole; /* largest part that the hole may have of an integral over the face; 1: there is no hole */
} rule;
enum { RULES_REGULAR, RULES_LIMIT, RULES_PLANE, RULES_POLYNOMIAL, RULES_WIDE, N_RULE_SETS };
static const rule rules[N_RULE_SETS][CO_N_RULES] = {
    {{3, 3, 1}, {4, 4, 1}, {6, 6, 1}, {12, 12, 1}, {24, 24, 1}, {48, 48, 1}, {72, 72, 1}, {96, 96, 1}},
    {{3, 2, 1e-3},
     {4, 3, 1e-4},
     {6, 4, 1e-5},
     {10, 5, 1e-6},
     {16, 6, 1e-7},
     {24, 8, 1e-8},
     {36, 10, 1e-9},
     {48, 12, 1e-9}},
    {{8, 3, 1e-3},
     {16, 4, 1e-4},
     {24, 5, 1e-5},
     {36, 6, 1e-6},
     {48, 7, 1e-7},
     {72, 8, 1e-8},
     {96, 9, 3e-9},
     {120, 10, 1e-9}},
    {{4, 1, 1e-3},
     {6, 2, 1e-4},
     {8, 3, 1e-5},
     {12, 4, 1e-6},
     {16, 5, 3e-7},
     {24, 6, 1e-7},
     {36, 9, 3e-8},
     {48, 12, 1e-8}},
    {{3, 2, 1e-1},
     {4, 3, 1e-2},
     {6, 4, 1e-3},
     {10, 5, 1e-4},
     {16, 6, 1e-5},
     {24, 8, 1e-6},
     {36, 10, 1e-7},
     {48, 12, 1e-8}}};
/* Points a side of a ring over those of the ring around it; 0: one less instead. */
static const double fall[N_RULE_SETS] = {[RULES_PLANE] = 0.5, [RULES_POLYNOMIAL] = 0.62};
enum {
    MIN_RINGS = 4,     /* least number of rings at an extraordinary vertex */
    MAX_RINGS = 40,    /* largest number of rings */
    MAX_GAUSS = 12,    /* points a side of one Gauss rule; finer rules are of several sub-cells */
    WORTH_THREADS = 64 /* points of a patch from which on a cell is worth waking a second thread */
};

/* Whether a face is one piece, not rings round an extraordinary vertex. */
static int is_one_piece(int32_t fan) {
    return co_patches_own_size(fan) == CO_RING_REGULAR; /* no fan has as many */
}
static int rule_set_of(const co_basis_table *t) {
    static const int of_surface[] = {[CURVOPT_SURFACE_LIMIT] = RULES_LIMIT,
                                     [CURVOPT_SURFACE_PLANE] = RULES_PLANE,
                                     [CURVOPT_SURFACE_POLYNOMIAL] = RULES_POLYNOMIAL};
    if (is_one_piece(t->kind))
        return RULES_REGULAR;
    if (co_fan_is_half(t->kind)) /* whose E is as narrow as a blend of width 1 (blend_fit_half.h) */
        return RULES_POLYNOMIAL;
    return co_fan_is_wide(t->kind) && co_fan_wide_width(t->kind) > 1 ? RULES_WIDE : of_surface[t->surface];
}

static int points_of_ring(int set, const rule *r, int ring) {
    int points = fall[set] > 0 ? (int)ceil(r->points * co_power(fall[set], ring - 1)) : r->points - (ring - 1);
    points = points > r->least ? points : r->least;
    int splits = (points + MAX_GAUSS - 1) / MAX_GAUSS; /* equal sub-cells: rounded up to a multiple */
    return (points + splits - 1) / splits * splits;
}

/* Ratios of the integrals over successive rings, of area and of squared curvature (stam.h). */
typedef struct ring_tail {
    double area_ratio;      /* lambda^2 */
    double curvature_ratio; /* (mu / lambda^2)^2 lambda^2; where a blend makes curvature a constant, lambda^2 */
    int n_rings;            /* rings down to the hole */
} ring_tail;

static ring_tail tail_of(const co_stam_disc *disc, int32_t surface, double hole) {
    double lambda = disc->lambda, mu = disc->mu;
    ring_tail t = {.area_ratio = lambda * lambda, .curvature_ratio = mu * mu / (lambda * lambda)};
    if (surface != CURVOPT_SURFACE_LIMIT) /* smooth there: curvature behaves like a constant */
        t.curvature_ratio = t.area_ratio;
    const double ratio = fmax(t.area_ratio, t.curvature_ratio);
    t.n_rings = MIN_RINGS;
    while (t.n_rings < MAX_RINGS && co_power(ratio, t.n_rings) > hole)
        t.n_rings++;
    return t;
}

void co_basis_table_destroy(co_basis_table *t) {
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

static int32_t allocate(co_basis_table *t, curvopt_error *error) {
    size_t samples = (size_t)t->n_samples, points = (size_t)t->n_points;
    int plane = t->surface == CURVOPT_SURFACE_PLANE && t->kind != CO_FAN_REGULAR;
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

/* The sectors on either side of a face whose points have rows of their own, in that many rings; 0: all have. */
static int32_t window_of(const co_basis_table *t, int n_rings) {
    int is_disc = co_fan_type_of(t->kind) == CO_FAN_WIDE && !is_one_piece(t->kind) && co_fan_wide_width(t->kind) == 1;
    return is_disc && co_fan_sectors(t->kind) >= 2 * (n_rings + 1) + 4 ? n_rings + 1 : 0;
}

/* The patch points that rows can be nonzero on. */
static int32_t choose_support(co_basis_table *t, int32_t window, curvopt_error *error) {
    int32_t n = co_patches_own_size(t->kind), all = co_patches_size(t->kind), fan = co_fan_at_vertex(t->kind);
    int folded = t->surface == CURVOPT_SURFACE_POLYNOMIAL && !co_fan_is_wide(t->kind); /* the fit, into rows */
    int n_terms = co_fan_is_half(t->kind) ? CO_BLEND_FIT_FUNCTIONS : CO_BLEND_FIT_TERMS;
    t->support = CO_NEW(int32_t, all);
    if (!t->support)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < all; i++)
        if (i >= n ? i - n < n_terms || window
                   : folded || is_one_piece(t->kind) || co_patches_is_of_curve(t->kind, i) ||
                         (co_stam_in_support(fan, i) && (!window || co_stam_in_window(fan, window, i))))
            t->support[t->n_points++] = i;
    while (t->n_own < t->n_points && t->support[t->n_own] < n)
        t->n_own++;
    return CURVOPT_OK;
}

/* The common properties of the samples of one cell. */
typedef struct cell_samples {
    const co_ring_cell *cell; /* NULL: a whole regular face */
    int n_side;               /* points a side, in sub-cells of at most MAX_GAUSS each way */
    double area_factor;       /* of area weights: more than 1 in the last ring, which stands for those inside it */
    double curvature_factor;  /* of curvature weights, likewise */
    double jacobian_scale;    /* undoes the shrinking of the ring in Jacobians */
    co_thread_pool *threads;  /* NULL: one */
    co_cancel *cancel;
} cell_samples;

static void regular_rows(double u, double v, double *rows) {
    double basis[16][CO_JET];
    co_bspline_bicubic(u, v, basis);
    for (int i = 0; i < 16; i++)
        co_jet_store(basis[i], rows + CO_JET * i);
}

static void store_sample(co_basis_table *t, const cell_samples *c, double u, double v, double weight, int32_t sample) {
    double *rows = t->rows + (size_t)sample * (size_t)t->n_points * CO_JET;
    co_chart chart;
    chart.jacobian = 1;
    if (c->cell) {
        co_ring_cell_rows(c->cell, u, v, t->n_points, t->support, rows, &chart);
    } else {
        regular_rows(u, v, rows);
    }
    t->area_weight[sample] = weight * chart.jacobian * c->area_factor;
    t->weight[sample] = weight * chart.jacobian * c->curvature_factor;
    t->jacobian_scale[sample] = chart.jacobian * c->jacobian_scale;
    if (t->blend) {
        double jet[CO_JET];
        double *blend = t->blend + (size_t)sample * CO_JET;
        co_ring_cell_blend(c->cell, CO_BLEND_SMOOTH, u, v, jet);
        co_jet_store(jet, blend);
        co_chart_apply(&chart, blend);
    }
}

/* Gauss's points in the sub-cells of a cell. */
typedef struct cell_grid {
    co_basis_table *table;
    const cell_samples *samples;
    int splits, gauss; /* sub-cells a side, points a side of each */
    int32_t first;     /* number of the first sample */
    double node[MAX_GAUSS], weight[MAX_GAUSS];
} cell_grid;

static void store_samples(void *context, size_t begin, size_t end) {
    const cell_grid *g = context;
    const cell_samples *c = g->samples;
    const int gauss = g->gauss, splits = g->splits;
    for (int k = (int)begin; k < (int)end && !co_cancel_is_due(c->cancel); k++) {
        int i = k % c->n_side, j = k / c->n_side;
        store_sample(g->table, c, (i / gauss + g->node[i % gauss]) / splits, (j / gauss + g->node[j % gauss]) / splits,
                     g->weight[i % gauss] * g->weight[j % gauss] / (splits * splits), g->first + k);
    }
}

/* The samples of one cell, from number `sample` on; the next free one. */
static int32_t add_samples(co_basis_table *t, const cell_samples *c, int32_t sample) {
    cell_grid g = {.table = t, .samples = c, .splits = (c->n_side + MAX_GAUSS - 1) / MAX_GAUSS, .first = sample};
    g.gauss = c->n_side / g.splits;
    co_gauss_legendre(g.gauss, g.node, g.weight);
    co_thread_pool_for(c->threads, (size_t)c->n_side * (size_t)c->n_side, store_samples, &g);
    return sample + c->n_side * c->n_side;
}

static int32_t fill_masks(co_basis_table *t, int32_t n_points, curvopt_error *error) {
    double *masks = CO_NEW(double, 3 * (size_t)n_points);
    if (!masks)
        return co_status_no_memory(error);
    co_stam_limit_masks(t->kind, masks);
    for (int m = 0; m < 3; m++)
        for (int32_t p = 0; p < t->n_points; p++)
            t->masks[m * t->n_points + p] = masks[m * n_points + t->support[p]];
    free(masks);
    return CURVOPT_OK;
}

struct co_cached_table {
    int32_t kind, rule; /* what the table is for */
    co_basis_table *table;
};

struct co_cached_fit {
    int32_t key, width; /* what the fit is for: kind with steps of a map, but no sector or place; width */
    co_blend_fit polynomial;
};

/* The polynomial of a kind of patch; the fit only where it is folded into rows. */
static int32_t create_polynomial(const co_stam_disc *disc, int32_t kind, co_blend_fit *out, curvopt_error *error) {
    const co_blend_fit_half_kind half = co_blend_fit_half_kind_of(kind);
    return co_fan_is_half(kind)   ? co_blend_fit_create_half_map(&half, out, error)
           : co_fan_is_wide(kind) ? co_blend_fit_create_map(disc, co_fan_wide_width(kind), out, error)
           : co_fan_is_cut(kind)  ? co_blend_fit_create_cut(disc->fan, out, error)
                                  : co_blend_fit_create(disc, 1, out, error);
}

/* The polynomial fitted at this kind's vertex, kept for the next table or point. */
static int32_t find_fit(co_basis_table_cache *cache, int32_t kind, const co_blend_fit **out, curvopt_error *error) {
    int32_t type = co_fan_type_of(kind), width = co_fan_is_wide(kind) ? co_fan_wide_width(kind) : 1;
    const int steps = co_fan_is_half(kind) ? co_fan_half_steps(kind) : 0;
    int32_t key = co_fan_make(type, co_fan_sectors(kind), steps); /* all sectors' */
    int32_t fan = co_fan_is_wide(kind) ? co_fan_at_vertex(kind) : key;
    for (int32_t i = 0; i < cache->n_fits; i++)
        if (cache->fit[i].key == key && cache->fit[i].width == width) {
            *out = &cache->fit[i].polynomial;
            return CURVOPT_OK;
        }
    struct co_cached_fit *fit = CO_RESIZED(cache->fit, (size_t)cache->n_fits + 1);
    if (!fit)
        return co_status_no_memory(error);
    cache->fit = fit;
    fit += cache->n_fits;
    *fit = (struct co_cached_fit){.key = key, .width = width};
    co_stam_disc disc;
    int32_t status = co_stam_disc_create(fan, &disc, error);
    if (status != CURVOPT_OK)
        return status;
    status = create_polynomial(&disc, kind, &fit->polynomial, error);
    co_stam_disc_free(&disc);
    if (status == CURVOPT_OK) {
        cache->n_fits++;
        *out = &fit->polynomial;
    }
    return status;
}

/* Fills a table of rings; polynomial is NULL on surfaces without one. */
static int32_t fill_irregular(co_basis_table *t, const co_basis_table_cache *cache, co_stam_disc *disc,
                              const co_blend_fit *polynomial, const rule *r, ring_tail tail, curvopt_error *error) {
    co_ring_cell cell = {0};
    int32_t sample = 0, status;
    double *map = CO_NEW(double, 2 * (size_t)disc->n_points);
    const double *chart = polynomial ? polynomial->map : co_fan_is_smooth(disc->fan) ? map : NULL;
    if (!map)
        return co_status_no_memory(error);
    if (chart == map)
        co_stam_characteristic_map(disc, map);
    status = co_ring_cell_create(disc, polynomial, chart, &cell, error);
    cell.window = window_of(t, tail.n_rings);
    for (int ring = 1; status == CURVOPT_OK && ring <= tail.n_rings; ring++) {
        int last = ring == tail.n_rings;
        cell_samples samples = {.cell = &cell,
                                .n_side = points_of_ring(rule_set_of(t), r, ring),
                                .threads = t->n_points >= WORTH_THREADS ? cache->threads : NULL,
                                .cancel = cache->cancel,
                                .area_factor = last ? 1 / (1 - tail.area_ratio) : 1,
                                .curvature_factor = last ? 1 / (1 - tail.curvature_ratio) : 1,
                                .jacobian_scale = co_power(tail.area_ratio, -ring)};
        for (int c = 0; c < CO_RING_CELLS; c++) {
            co_ring_cell_set(&cell, disc, c);
            sample = add_samples(t, &samples, sample);
        }
        co_stam_disc_advance(disc);
        if (co_cancel_is_due(cache->cancel))
            status = CO_CANCELLED;
    }
    if (status == CURVOPT_OK && t->masks)
        status = fill_masks(t, disc->n_points, error);
    co_ring_cell_free(&cell);
    free(map);
    return status;
}

/* A regular face, or one of a wide disc away from the vertex, with its polynomial. */
static int32_t fill_one_piece(co_basis_table *t, const co_blend_fit *polynomial, const rule *r, curvopt_error *error) {
    co_ring_cell cell = {0};
    cell_samples whole = {.n_side = r->points, .area_factor = 1, .curvature_factor = 1, .jacobian_scale = 1};
    int32_t status = CURVOPT_OK;
    if (co_fan_is_wide(t->kind)) {
        status = co_ring_cell_create_face(polynomial, co_fan_wide_sector(t->kind), co_fan_wide_i(t->kind),
                                          co_fan_wide_j(t->kind), &cell, error);
        whole.cell = &cell;
    }
    if (status == CURVOPT_OK)
        add_samples(t, &whole, 0);
    co_ring_cell_free(&cell);
    return status;
}

static int32_t fill(co_basis_table *t, const co_basis_table_cache *cache, const co_blend_fit *polynomial,
                    int32_t rule_number, curvopt_error *error) {
    const rule *r = &rules[rule_set_of(t)][rule_number];
    int one_piece = is_one_piece(t->kind);
    co_stam_disc disc = {0};
    ring_tail tail = {0};
    int32_t status = one_piece ? CURVOPT_OK : co_stam_disc_create(co_fan_at_vertex(t->kind), &disc, error);
    if (status != CURVOPT_OK)
        return status;
    if (one_piece)
        t->n_samples = r->points * r->points;
    else
        tail = tail_of(&disc, t->surface, r->hole);
    status = choose_support(t, window_of(t, tail.n_rings), error);
    for (int ring = 1; ring <= tail.n_rings; ring++)
        t->n_samples +=
            CO_RING_CELLS * points_of_ring(rule_set_of(t), r, ring) * points_of_ring(rule_set_of(t), r, ring);
    if (status == CURVOPT_OK)
        status = allocate(t, error);
    if (status == CURVOPT_OK)
        status = one_piece ? fill_one_piece(t, polynomial, r, error)
                           : fill_irregular(t, cache, &disc, polynomial, r, tail, error);
    co_stam_disc_free(&disc);
    return status;
}

/* A table of the cache's surface, with the fit that the cache has or makes. */
static int32_t create_table(co_basis_table_cache *cache, int32_t kind, int32_t rule_number, co_basis_table **out,
                            curvopt_error *error) {
    const co_blend_fit *polynomial = NULL;
    *out = NULL;
    co_basis_table *t = CO_NEW(co_basis_table, 1);
    if (!t)
        return co_status_no_memory(error);
    t->surface = co_blend_fit_surface(cache->surface, kind);
    t->kind = kind;
    int32_t status = CURVOPT_OK;
    if (t->surface == CURVOPT_SURFACE_POLYNOMIAL)
        status = find_fit(cache, kind, &polynomial, error);
    if (status == CURVOPT_OK)
        status = fill(t, cache, polynomial, rule_number, error);
    if (status != CURVOPT_OK) {
        co_basis_table_destroy(t);
        return status;
    }
    *out = t;
    return CURVOPT_OK;
}

int32_t co_basis_table_create(int32_t surface, int32_t kind, int32_t rule_number, co_basis_table **out,
                              curvopt_error *error) {
    co_basis_table_cache cache;
    co_basis_table_cache_create(surface, &cache);
    int32_t status = create_table(&cache, kind, rule_number, out, error);
    co_basis_table_cache_free(&cache);
    return status;
}

/* Rows of the vertex itself: its position, and NAN for derivatives, which do not exist there. */
static int32_t vertex_rows(co_stam_disc *disc, const co_blend_fit *polynomial, int is_disc, double *rows,
                           curvopt_error *error) {
    int32_t n = disc->n_points, n_all = n + (is_disc ? CO_BLEND_DISC_TERMS : 0);
    double *masks = CO_NEW(double, 3 * (size_t)n);
    if (!masks)
        return co_status_no_memory(error);
    if (co_fan_is_smooth(disc->fan))
        co_stam_limit_masks(disc->valence, masks);
    else
        co_stam_disc_limit_mask(disc, masks);
    const int is_half = polynomial->is_half; /* the vertex stays where the curve has it */
    for (int32_t i = 0; i < n_all * CO_JET; i++)
        rows[i] = i % CO_JET ? (double)NAN
                  : is_half  ? (i < n * CO_JET ? masks[i / CO_JET] : 0)
                  : i >= n * CO_JET || (is_disc && polynomial->width)
                      ? polynomial->width && i == n * CO_JET /* the first of the polynomial's points lies there */
                  : polynomial->width ? polynomial->fit[i / CO_JET]
                                      : masks[i / CO_JET];
    free(masks);
    return CURVOPT_OK;
}

/* Rows at (u, v) of a cell of the right ring, (u, v) not both 0; derivatives with respect to u, v. */
static int32_t ring_rows(co_stam_disc *disc, const co_blend_fit *polynomial, double u, double v, int32_t n_all,
                         const int32_t *all, double *rows, curvopt_error *error) {
    co_ring_cell cell;
    co_chart chart;
    int32_t status = co_ring_cell_create(disc, polynomial->width ? polynomial : NULL, NULL, &cell, error);
    if (status != CURVOPT_OK)
        return status;
    double side = 0.5;
    for (; u < side && v < side; side /= 2)
        co_stam_disc_advance(disc);
    co_ring_cell_set(&cell, disc, v < side ? 0 : u < side ? 2 : 1);
    co_ring_cell_rows(&cell, (u - cell.origin[0]) / side, (v - cell.origin[1]) / side, n_all, all, rows, &chart);
    for (int32_t i = 0; i < n_all * CO_JET; i++)
        rows[i] /= co_power(side, co_jet_order_u[i % CO_JET] + co_jet_order_v[i % CO_JET]);
    co_ring_cell_free(&cell);
    return CURVOPT_OK;
}

/* Rows of a face of a wide disc, not of that at the vertex. */
static int32_t wide_rows(const co_blend_fit *polynomial, int32_t kind, double u, double v, const int32_t *all,
                         double *rows, curvopt_error *error) {
    co_ring_cell cell;
    co_chart chart;
    int32_t status = co_ring_cell_create_face(polynomial, co_fan_wide_sector(kind), co_fan_wide_i(kind),
                                              co_fan_wide_j(kind), &cell, error);
    if (status == CURVOPT_OK)
        co_ring_cell_rows(&cell, u, v, co_patches_size(kind), all, rows, &chart);
    co_ring_cell_free(&cell);
    return status;
}

/* Rows of a face at an extraordinary vertex. */
static int32_t vertex_face_rows(const co_blend_fit *polynomial, int32_t kind, double u, double v, const int32_t *all,
                                double *rows, curvopt_error *error) {
    co_stam_disc disc;
    int32_t status = co_stam_disc_create(co_fan_at_vertex(kind), &disc, error);
    if (status == CURVOPT_OK)
        status = u == 0 && v == 0 ? vertex_rows(&disc, polynomial, co_fan_is_wide(kind), rows, error)
                                  : ring_rows(&disc, polynomial, u, v, co_patches_size(kind), all, rows, error);
    co_stam_disc_free(&disc);
    return status;
}

static int32_t irregular_point(co_basis_table_cache *cache, int32_t surface, int32_t kind, double u, double v,
                               double *rows, curvopt_error *error) {
    static const co_blend_fit none = {0};
    const co_blend_fit *polynomial = &none;
    int32_t n_all = co_patches_size(kind), *all = CO_NEW(int32_t, n_all);
    int32_t status = all ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK && surface == CURVOPT_SURFACE_POLYNOMIAL)
        status = find_fit(cache, kind, &polynomial, error);
    for (int32_t i = 0; status == CURVOPT_OK && i < n_all; i++)
        all[i] = i;
    if (status == CURVOPT_OK)
        status = (is_one_piece(kind) ? wide_rows : vertex_face_rows)(polynomial, kind, u, v, all, rows, error);
    free(all);
    return status;
}

int32_t co_basis_table_point(co_basis_table_cache *cache, int32_t kind, double u, double v, double *rows,
                             double *weight, curvopt_error *error) {
    if (kind == CO_FAN_REGULAR) {
        regular_rows(u, v, rows);
        return CURVOPT_OK;
    }
    const int is_limit = cache->surface == CURVOPT_SURFACE_LIMIT; /* points exist where integrals do not */
    int32_t surface = is_limit ? cache->surface : co_blend_fit_surface(cache->surface, kind);
    if (surface == CURVOPT_SURFACE_PLANE) {
        double jet[CO_JET];
        co_blend_weight(CO_BLEND_SMOOTH, u, v, jet);
        for (int k = 0; k < CO_JET; k++)
            weight[k] = jet[k];
    }
    return irregular_point(cache, surface, kind, u, v, rows, error);
}

void co_basis_table_cache_create(int32_t surface, co_basis_table_cache *cache) {
    *cache = (co_basis_table_cache){.surface = surface};
}

void co_basis_table_cache_free(co_basis_table_cache *cache) {
    for (int32_t i = 0; i < cache->n_tables; i++)
        co_basis_table_destroy(cache->table[i].table);
    for (int32_t i = 0; i < cache->n_fits; i++)
        co_blend_fit_free(&cache->fit[i].polynomial);
    free(cache->table);
    free(cache->fit);
    *cache = (co_basis_table_cache){0};
}

int32_t co_basis_table_cache_get(co_basis_table_cache *cache, int32_t kind, int32_t rule_number,
                                 const co_basis_table **out, curvopt_error *error) {
    *out = NULL;
    for (int32_t i = 0; i < cache->n_tables; i++)
        if (cache->table[i].kind == kind && cache->table[i].rule == rule_number) {
            *out = cache->table[i].table;
            return CURVOPT_OK;
        }
    if (co_cancel_is_due(cache->cancel))
        return CO_CANCELLED;
    struct co_cached_table entry = {.kind = kind, .rule = rule_number};
    struct co_cached_table *table = CO_RESIZED(cache->table, (size_t)cache->n_tables + 1);
    if (!table)
        return co_status_no_memory(error);
    cache->table = table;
    int32_t status = create_table(cache, kind, rule_number, &entry.table, error);
    if (status == CURVOPT_OK) {
        cache->table[cache->n_tables++] = entry;
        *out = entry.table;
        if (cache->made)
            cache->made(cache->user);
    }
    return status;
}
