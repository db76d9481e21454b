/* Quadrature points and basis rows of a kind of face (finite elements: tabulated shape functions).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/basis_table.h"

#include "base/elementary.h"
#include "base/memory.h"
#include "surface/face_rule.h"
#include "surface/gauss_legendre.h"
#include "surface/patches.h"
#include "surface/ring_cell.h"

#include <stdlib.h>

enum { WORTH_THREADS = 64 }; /* points of a patch from which on a cell is worth waking a second thread */

void co_basis_table_destroy(co_basis_table *t) {
    if (!t)
        return;
    free(t->support);
    free(t->area_weight);
    free(t->weight);
    free(t->jacobian_scale);
    free(t->rows);
    free(t->side);
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
    t->side = t->n_side ? CO_NEW(double, 16 * (size_t)t->n_side) : NULL;
    t->blend = plane ? CO_NEW(double, samples *CO_JET) : NULL;
    t->masks = plane ? CO_NEW(double, 3 * points) : NULL;
    if (!t->area_weight || !t->weight || !t->jacobian_scale || !t->rows || (t->n_side && !t->side) ||
        (plane && (!t->blend || !t->masks)))
        return co_status_no_memory(error);
    return CURVOPT_OK;
}

/* The sectors on either side of a face whose points have rows of their own, in that many rings; 0: all have. */
static int32_t window_of(const co_basis_table *t, int n_rings) {
    int is_disc =
        co_fan_type_of(t->kind) == CO_FAN_WIDE && !co_patches_is_one_piece(t->kind) && co_fan_wide_width(t->kind) == 1;
    return is_disc && co_fan_sectors(t->kind) >= 2 * (n_rings + 1) + 4 ? n_rings + 1 : 0;
}

/* The patch points that rows can be nonzero on. */
static int32_t choose_support(co_basis_table *t, int32_t window, curvopt_error *error) {
    int32_t n = co_patches_own_size(t->kind), all = co_patches_size(t->kind);
    int n_terms = co_fan_is_half(t->kind) ? CO_BLEND_FIT_FUNCTIONS : CO_BLEND_FIT_TERMS;
    t->support = CO_NEW(int32_t, all);
    if (!t->support)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < all; i++)
        if (i < n ? co_patches_own_has_row(t->surface, t->kind, window, i) : i - n < n_terms || window)
            t->support[t->n_points++] = i;
    while (t->n_own < t->n_points && t->support[t->n_own] < n)
        t->n_own++;
    return CURVOPT_OK;
}

/* The common properties of the samples of one cell. */
typedef struct cell_samples {
    const co_ring_cell *cell; /* NULL: a whole regular face, whose samples are a grid */
    co_cell_rule rule;
    double area_factor;      /* of area weights: more than 1 in the last ring, which stands for those inside it */
    double curvature_factor; /* of curvature weights, likewise */
    double jacobian_scale;   /* undoes the shrinking of the ring in Jacobians */
    co_thread_pool *threads; /* NULL: one */
    co_cancel *cancel;
} cell_samples;

static void store_sample(co_basis_table *t, const cell_samples *c, double u, double v, double weight, int32_t sample) {
    double *rows = t->rows + (size_t)sample * (size_t)t->n_points * CO_JET;
    co_chart chart;
    chart.jacobian = 1;
    if (c->cell) {
        co_ring_cell_rows(c->cell, u, v, t->n_points, t->support, rows, &chart);
    } else {
        co_bspline_bicubic(u, v, (double(*)[CO_JET])rows);
    }
    t->area_weight[sample] = weight * chart.jacobian * c->area_factor;
    t->weight[sample] = weight * chart.jacobian * c->curvature_factor;
    t->jacobian_scale[sample] = chart.jacobian * c->jacobian_scale;
    if (t->blend) {
        double *blend = t->blend + (size_t)sample * CO_JET;
        co_ring_cell_blend(c->cell, CO_BLEND_SMOOTH, u, v, blend);
        co_chart_apply(&chart, blend);
    }
}

/* The points of a cell's rule, in its sub-cells. */
typedef struct cell_points {
    co_basis_table *table;
    const cell_samples *samples;
    int32_t first;       /* number of the first sample */
    co_square_rule rule; /* of each sub-cell */
} cell_points;

static void store_samples(void *context, size_t begin, size_t end) {
    const cell_points *c = context;
    const int splits = c->samples->rule.splits, n = c->rule.n;
    for (int k = (int)begin; k < (int)end && !co_cancel_is_due(c->samples->cancel); k++) {
        const double *at = c->rule.point[k % n];
        const int i = k / n % splits, j = k / n / splits;
        store_sample(c->table, c->samples, (i + at[0]) / splits, (j + at[1]) / splits,
                     c->rule.weight[k % n] / (splits * splits), c->first + k);
    }
}

/* The samples of one cell, from number `sample` on; the next free one. */
static int32_t add_samples(co_basis_table *t, const cell_samples *c, int32_t sample) {
    cell_points points = {.table = t, .samples = c, .first = sample};
    const int splits = c->rule.splits;
    co_square_rule_make(c->rule.gauss, &points.rule);
    const int n = splits * splits * points.rule.n;
    co_thread_pool_for(c->threads, (size_t)n, store_samples, &points);
    return sample + n;
}

/* Point i of a side that has so many sub-cells, with Gauss's nodes [gauss] in each. */
static double place_of(const co_cell_rule *rule, const double *node, int i) {
    return (i / rule->gauss + node[i % rule->gauss]) / rule->splits;
}

/* A regular face's samples: the product of Gauss's rule with itself, in sub-cells where it has many points. */
static void add_grid(co_basis_table *t, const cell_samples *c) {
    const co_cell_rule *rule = &c->rule;
    const int n = t->n_side;
    double node[CO_SQUARE_RULE_GAUSS], weight[CO_SQUARE_RULE_GAUSS];
    co_gauss_legendre(rule->gauss, node, weight);
    for (int i = 0; i < n; i++)
        co_bspline_cubic(place_of(rule, node, i), (double(*)[4])(t->side + 16 * (size_t)i));
    for (int k = 0; k < n * n; k++) {
        const int i = k % n, j = k / n;
        store_sample(t, c, place_of(rule, node, i), place_of(rule, node, j),
                     weight[i % rule->gauss] * weight[j % rule->gauss] / (rule->splits * rule->splits), k);
    }
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

/* Fills a table of rings. */
static int32_t fill_irregular(co_basis_table *t, const co_table_making *making, co_stam_disc *disc,
                              const co_face_rule *rule, co_ring_tail tail, curvopt_error *error) {
    const co_blend_fit *polynomial = making->polynomial;
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
    cell.order = t->surface == CURVOPT_SURFACE_LIMIT ? 2 : 3; /* no energy of third order is finite there */
    for (int ring = 1; status == CURVOPT_OK && ring <= tail.n_rings; ring++) {
        int last = ring == tail.n_rings;
        cell_samples samples = {.cell = &cell,
                                .rule = co_face_rule_of_cell(rule, ring),
                                .threads = t->n_points >= WORTH_THREADS ? making->threads : NULL,
                                .cancel = making->cancel,
                                .area_factor = last ? 1 / (1 - tail.area_ratio) : 1,
                                .curvature_factor = last ? 1 / (1 - tail.curvature_ratio) : 1,
                                .jacobian_scale = co_power(tail.area_ratio, -ring)};
        for (int c = 0; c < CO_RING_CELLS; c++) {
            co_ring_cell_set(&cell, disc, c);
            sample = add_samples(t, &samples, sample);
        }
        co_stam_disc_advance(disc);
        if (co_cancel_is_due(making->cancel))
            status = CO_CANCELLED;
    }
    if (status == CURVOPT_OK && t->masks)
        status = fill_masks(t, disc->n_points, error);
    co_ring_cell_free(&cell);
    free(map);
    return status;
}

/* A regular face, or one of a wide disc away from the vertex, with its polynomial. */
static int32_t fill_one_piece(co_basis_table *t, const co_blend_fit *polynomial, const co_face_rule *rule,
                              curvopt_error *error) {
    co_ring_cell cell = {0};
    cell_samples whole = {
        .rule = co_face_rule_of_cell(rule, 1), .area_factor = 1, .curvature_factor = 1, .jacobian_scale = 1};
    if (!co_fan_is_wide(t->kind)) {
        add_grid(t, &whole);
        return CURVOPT_OK;
    }
    int32_t status = co_ring_cell_create_face(polynomial, co_fan_wide_sector(t->kind), co_fan_wide_i(t->kind),
                                              co_fan_wide_j(t->kind), &cell, error);
    whole.cell = &cell;
    if (status == CURVOPT_OK)
        add_samples(t, &whole, 0);
    co_ring_cell_free(&cell);
    return status;
}

static int32_t fill(co_basis_table *t, const co_table_making *making, const co_face_rule *rule, curvopt_error *error) {
    int one_piece = co_patches_is_one_piece(t->kind);
    co_stam_disc disc = {0};
    co_ring_tail tail = {0};
    int32_t status = one_piece ? CURVOPT_OK : co_stam_disc_create(co_fan_at_vertex(t->kind), &disc, error);
    if (status != CURVOPT_OK)
        return status;
    t->n_side = t->kind == CO_FAN_REGULAR ? rule->points : 0;
    if (one_piece)
        t->n_samples = t->n_side ? t->n_side * t->n_side : co_face_rule_samples(rule, 1);
    else
        tail = co_face_rule_tail(rule, &disc, t->surface);
    status = choose_support(t, window_of(t, tail.n_rings), error);
    for (int ring = 1; ring <= tail.n_rings; ring++)
        t->n_samples += CO_RING_CELLS * co_face_rule_samples(rule, ring);
    if (status == CURVOPT_OK)
        status = allocate(t, error);
    if (status == CURVOPT_OK)
        status = one_piece ? fill_one_piece(t, making->polynomial, rule, error)
                           : fill_irregular(t, making, &disc, rule, tail, error);
    co_stam_disc_free(&disc);
    return status;
}

int32_t co_basis_table_make(int32_t surface, int32_t kind, int32_t rule_number, const co_table_making *making,
                            co_basis_table **out, curvopt_error *error) {
    *out = NULL;
    co_basis_table *t = CO_NEW(co_basis_table, 1);
    if (!t)
        return co_status_no_memory(error);
    t->surface = surface;
    t->kind = kind;
    const co_face_rule rule = co_face_rule_of(surface, kind, rule_number);
    const int32_t status = fill(t, making, &rule, error);
    if (status != CURVOPT_OK) {
        co_basis_table_destroy(t);
        return status;
    }
    *out = t;
    return CURVOPT_OK;
}
