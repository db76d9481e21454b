/* One cell of a ring round an extraordinary vertex. SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/ring_cell.h"

#include "base/memory.h"
#include "surface/blend_fit_half.h"
#include "surface/ring_cell_curve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void co_ring_cell_free(co_ring_cell *cell) {
    free(cell->base);
    free(cell->points);
    free(cell->weights);
    *cell = (co_ring_cell){0};
}

static int32_t allocate(co_ring_cell *cell, curvopt_error *error) {
    cell->base = CO_NEW(double, cell->n_points);
    cell->points = CO_NEW(double, 16 * (size_t)cell->n_points);
    cell->weights = CO_NEW(double, CO_RING_CELL_GENERATORS *(size_t)cell->n_points);
    if (cell->base && cell->points && cell->weights)
        return CURVOPT_OK;
    co_ring_cell_free(cell);
    return co_status_no_memory(error);
}

int32_t co_ring_cell_create(const co_stam_disc *disc, const co_blend_fit *polynomial, const double *chart,
                            co_ring_cell *cell, curvopt_error *error) {
    *cell = (co_ring_cell){.sector = co_fan_sector(disc->fan),
                           .n_points = disc->n_points,
                           .polynomial = polynomial,
                           .order = 3,
                           .chart = chart};
    return allocate(cell, error);
}

static void set_map(co_ring_cell *cell, double map[16][2], const double base[2]) {
    for (int c = 0; c < 2; c++) {
        cell->map_base[c] = base[c];
        for (int i = 0; i < 16; i++)
            cell->map[i][c] = map[i][c];
    }
}

/* Whether the polynomial's coefficients are multiplied out, into rows over the two-ring. */
static int is_folded(const co_ring_cell *cell) {
    return cell->polynomial && cell->polynomial->width == 1 && cell->polynomial->fit;
}

static int is_half(const co_ring_cell *cell) {
    return cell->polynomial && cell->polynomial->is_half;
}

static co_ring_cell_place place_of(const co_ring_cell *cell) {
    return (co_ring_cell_place){
        cell->polynomial, cell->sector, cell->is_face, {cell->origin[0], cell->origin[1]}, cell->side};
}

/* With B_i the patch's basis, the row of a point is the sum of its c_i B_i = c + sum of (c_i - c) B_i, c = `base`: deep
 * in the rings the c_i are nearly equal, and what matters is lost in the sum of c_i B_i. */
static void set_weights(co_ring_cell *cell) {
    const co_blend_fit *folded = is_folded(cell) ? cell->polynomial : NULL;
    for (int32_t p = 0; p < cell->n_points; p++) {
        double *to = cell->weights + (size_t)p * CO_RING_CELL_GENERATORS;
        to[0] = cell->base[p];
        for (int i = 0; i < 16; i++)
            to[1 + i] = cell->points[i * cell->n_points + p];
        for (int i = 0; i < CO_BLEND_FIT_FUNCTIONS; i++)
            to[CO_RING_CELL_TERM + i] = folded ? folded->fit[i * cell->n_points + p] : 0;
    }
    if (is_half(cell)) {
        const co_ring_cell_place place = place_of(cell);
        co_ring_cell_curve_weights(&place, cell->weights + CO_RING_CELL_CURVE, (size_t)CO_RING_CELL_GENERATORS);
    }
}

/* Takes the mean row of far points at a place of their sectors (fan.h) off all rows there; mean gets it, times their
 * number. */
static void take_mean(co_ring_cell *cell, const co_stam_disc *disc, int x, int y,
                      double mean[CO_RING_CELL_GENERATORS]) {
    int32_t n_far = 0;
    memset(mean, 0, CO_RING_CELL_GENERATORS * sizeof *mean);
    for (int pass = 0; pass < 2; pass++) {
        for (int32_t s = 0; s < disc->valence; s++) {
            const int32_t p = co_fan_index(disc->valence, s, x, y);
            const int is_far = !co_stam_in_window(disc->valence, cell->window, p);
            double *weights = cell->weights + (size_t)p * CO_RING_CELL_GENERATORS;
            n_far += pass == 0 && is_far;
            for (int i = 0; i < CO_RING_CELL_GENERATORS; i++)
                if (pass == 1)
                    weights[i] -= mean[i];
                else if (is_far)
                    mean[i] += weights[i];
        }
        for (int i = 0; i < CO_RING_CELL_GENERATORS; i++)
            mean[i] = pass == 0 ? mean[i] / n_far : mean[i] * disc->valence;
    }
}

void co_ring_cell_set(co_ring_cell *cell, const co_stam_disc *disc, int which) {
    double map[16][2] = {{0}}, base[2] = {0};
    cell->side = ldexp(1, -disc->ring);
    for (int c = 0; c < 2; c++)
        cell->origin[c] = cell->side * co_stam_cell_place[which][c];
    co_stam_disc_cell(disc, which, cell->base, cell->points);
    for (int32_t p = 0; (cell->polynomial || cell->chart) && p < cell->n_points; p++) {
        const double *at = cell->polynomial
                               ? cell->polynomial->map + 2 * co_blend_fit_index_of_two_ring(cell->polynomial, p)
                               : cell->chart + 2 * p;
        for (int c = 0; c < 2; c++) {
            base[c] += cell->base[p] * at[c];
            for (int i = 0; i < 16; i++)
                map[i][c] += cell->points[i * cell->n_points + p] * at[c];
        }
    }
    set_map(cell, map, base);
    set_weights(cell);
    if (cell->window) {
        take_mean(cell, disc, 1, 0, cell->mean[0]);
        take_mean(cell, disc, 1, 1, cell->mean[1]);
    }
}

/* The map's control point at place (x, y) of the cell's sector. */
static void map_at(const co_ring_cell *cell, int x, int y, double at[2]) {
    const co_blend_fit *p = cell->polynomial;
    int32_t index[2];
    double weight[2] = {1};
    const int n = p->is_half ? co_blend_fit_half_point(p->valence, p->width, cell->sector, x, y, index, weight) : 1;
    if (!p->is_half)
        index[0] = co_blend_fit_index(p->valence, p->width, 0, x, y);
    at[0] = at[1] = 0;
    for (int k = 0; k < n; k++)
        for (int c = 0; c < 2; c++)
            at[c] += weight[k] * p->map[2 * index[k] + c];
}

int32_t co_ring_cell_create_face(const co_blend_fit *polynomial, int32_t sector, int i, int j, co_ring_cell *cell,
                                 curvopt_error *error) {
    *cell = (co_ring_cell){.sector = sector,
                           .is_face = 1,
                           .n_points = 16,
                           .order = 3,
                           .origin = {i, j},
                           .side = 1,
                           .polynomial = polynomial};
    int32_t status = allocate(cell, error);
    if (status != CURVOPT_OK)
        return status;
    double map[16][2], base[2] = {0};
    cell->base[0] = 1;
    for (int k = 0; k < 16; k++) {
        cell->points[17 * k] = 1;
        cell->points[16 * k] -= 1;
        map_at(cell, i + k % 4 - 1, j + k / 4 - 1, map[k]);
    }
    set_map(cell, map, base);
    set_weights(cell);
    return CURVOPT_OK;
}

/* Jets of the map. */
static void map_jets(const co_ring_cell *cell, double basis[16][CO_JET], double chi[2][CO_JET]) {
    memset(chi, 0, 2 * sizeof *chi);
    for (int i = 0; i < 16; i++)
        for (int k = 0; k < CO_JET; k++)
            for (int c = 0; c < 2; c++)
                chi[c][k] += cell->map[i][c] * basis[i][k];
    for (int c = 0; c < 2; c++)
        chi[c][0] += cell->map_base[c];
}

void co_ring_cell_blend(const co_ring_cell *cell, co_blend_kind blend, double s, double t, double jet[CO_JET]) {
    int width = cell->polynomial ? cell->polynomial->width : 1;
    double side = cell->side / width;
    co_blend_weight(blend, cell->origin[0] / width + side * s, cell->origin[1] / width + side * t, jet);
    const double scale[4] = {1, side, side * side, side * side * side};
    for (int k = 0; k < CO_JET; k++)
        jet[k] *= scale[co_jet_order_u[k] + co_jet_order_v[k]];
}

/* Jets of the functions that rows are sums of: [0] 1, where blended 1 - w; [1 .. 16] the patch's basis, where blended
 * times 1 - w; [TERM ..] w times the polynomial's monomials; on half discs
 * less what the curve takes of them, and [CURVE ..] what it gives (ring_cell_curve.h).
 *
 * Example: point p of the two-ring has the coefficients c_i in the patch's control points and f_a in the fit. Its row
 * is c (1 - w) + sum over i of (c_i - c) (1 - w) B_i + sum over a of f_a w m_a, the weights of p (set_weights)
 * times these functions; with w = 0 that is the sum of c_i B_i. */
typedef double generators[CO_RING_CELL_GENERATORS][CO_JET];

/* Fills g from the jets of w, rest = 1 - w, the patch's basis and chi, all in the coordinates that rows are to have. */
static void blend_generators(const double w[CO_JET], const double rest[CO_JET], double basis[16][CO_JET],
                             double chi[2][CO_JET], int has_cusp, generators g) {
    double monomial[CO_BLEND_FIT_TERMS][CO_JET], cusp[CO_JET] = {0};
    memcpy(g[0], rest, sizeof g[0]);
    for (int i = 0; i < 16; i++)
        co_jet_multiply(rest, basis[i], g[1 + i]);
    co_blend_fit_monomials(chi[0], chi[1], monomial);
    for (int i = 0; i < CO_BLEND_FIT_TERMS; i++)
        co_jet_multiply(w, monomial[i], g[CO_RING_CELL_TERM + i]);
    if (has_cusp)
        co_blend_fit_cusp(chi[0], chi[1], cusp);
    co_jet_multiply(w, cusp, g[CO_RING_CELL_TERM + CO_BLEND_FIT_CUSP]);
}

/* All is taken to the chart first: there the coordinates' own jets are 1 and 0, and nothing cancels any more. */
static void find_generators(const co_ring_cell *cell, double s, double t, generators g, co_chart *chart) {
    double basis[16][CO_JET], w[CO_JET], rest[CO_JET], chi[2][CO_JET];
    co_bspline_bicubic(s, t, basis);
    if (cell->polynomial || cell->chart)
        map_jets(cell, basis, chi);
    chart->jacobian = 1;
    if (cell->chart) {
        co_chart_create(chi[0], chi[1], cell->order, chart);
        for (int i = 0; i < 16; i++)
            co_chart_apply(chart, basis[i]);
        for (int c = 0; c < 2; c++)
            for (int k = 1; k < CO_JET; k++)
                chi[c][k] = k == 1 + c;
    }
    if (!cell->polynomial) {
        memset(g[0], 0, sizeof g[0]);
        g[0][0] = 1;
        memcpy(g[1], basis, sizeof basis);
        return;
    }
    co_ring_cell_blend(cell, CO_BLEND_POLYNOMIAL, s, t, w);
    if (cell->chart)
        co_chart_apply(chart, w);
    for (int k = 0; k < CO_JET; k++)
        rest[k] = k ? -w[k] : 1 - w[0];
    blend_generators(w, rest, basis, chi, cell->polynomial->has_cusp, g);
    if (is_half(cell)) {
        const co_ring_cell_place place = place_of(cell);
        co_ring_cell_curve_apply(&place, s, t, cell->chart ? chart : NULL, w, chi, g + CO_RING_CELL_TERM,
                                 g + CO_RING_CELL_CURVE);
    }
}

/* A row from its first n_jet numbers; the others are NAN. n_jet is a constant where this is called. */
static inline void add_generators(generators g, const double *weight, int n, int n_jet, double *row) {
    double sum[CO_JET] = {0};
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n_jet; k++)
            sum[k] += weight[i] * g[i][k];
    for (int k = 0; k < CO_JET; k++)
        row[k] = k < n_jet ? sum[k] : (double)NAN;
}

/* The row of those weights: through the patch's control points, and through a fit that is folded in. */
static void weighted_row(const co_ring_cell *cell, generators g, const double *weight, double *row) {
    int n = is_half(cell) ? CO_RING_CELL_GENERATORS : is_folded(cell) ? CO_RING_CELL_CURVE : CO_RING_CELL_TERM;
    if (cell->order == 2)
        add_generators(g, weight, n, CO_JET_SECOND, row);
    else
        add_generators(g, weight, n, CO_JET, row);
}

/* Row of a disc's coefficient. */
static void term_row(const co_ring_cell *cell, generators g, int term, double *row) {
    const int n_terms = is_half(cell) ? CO_BLEND_FIT_FUNCTIONS : CO_BLEND_FIT_TERMS;
    if (term >= n_terms) {
        weighted_row(cell, g, cell->mean[term - CO_BLEND_FIT_TERMS], row);
        return;
    }
    memcpy(row, g[CO_RING_CELL_TERM + term], CO_JET * sizeof *row);
    for (int i = 1; term == 0 && i < n_terms; i++)
        for (int k = 0; k < CO_JET; k++)
            row[k] -= g[CO_RING_CELL_TERM + i][k];
}

void co_ring_cell_rows(const co_ring_cell *cell, double s, double t, int32_t n_support, const int32_t *support,
                       double *rows, co_chart *chart) {
    generators g;
    find_generators(cell, s, t, g, chart);
    for (int32_t p = 0; p < n_support; p++, rows += CO_JET)
        if (support[p] < cell->n_points)
            weighted_row(cell, g, cell->weights + (size_t)support[p] * CO_RING_CELL_GENERATORS, rows);
        else if (cell->polynomial || support[p] - cell->n_points >= CO_BLEND_FIT_TERMS)
            term_row(cell, g, support[p] - cell->n_points, rows);
        else
            memset(rows, 0, CO_JET * sizeof *rows);
}
