/* One cell of a ring round an extraordinary vertex. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cell.h"

#include "memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int32_t co_cell_create(const co_disc *disc, const co_polynomial *polynomial, const co_real *chart, co_cell *cell,
                       curvopt_error *error) {
    *cell = (co_cell){.n_points = disc->n_points, .polynomial = polynomial, .chart = chart};
    cell->points = CO_NEW(co_real, 16 * (size_t)disc->n_points);
    return cell->points ? CURVOPT_OK : co_status_no_memory(error);
}

void co_cell_free(co_cell *cell) {
    free(cell->points);
    *cell = (co_cell){0};
}

void co_cell_set(co_cell *cell, const co_disc *disc, int which) {
    cell->side = ldexpl(1, -disc->ring);
    for (int c = 0; c < 2; c++)
        cell->origin[c] = cell->side * co_irregular_cell_place[which][c];
    co_disc_cell(disc, which, cell->points);
    memset(cell->map, 0, sizeof cell->map);
    for (int32_t p = 0; (cell->polynomial || cell->chart) && p < cell->n_points; p++) {
        const co_real *at = cell->polynomial
                                ? cell->polynomial->map + 2 * co_polynomial_index_of_two_ring(cell->polynomial, p)
                                : cell->chart + 2 * p;
        for (int i = 0; i < 16; i++)
            for (int c = 0; c < 2; c++)
                cell->map[i][c] += cell->points[i * cell->n_points + p] * at[c];
    }
}

int32_t co_cell_create_face(const co_polynomial *polynomial, int i, int j, co_cell *cell, curvopt_error *error) {
    *cell = (co_cell){.n_points = 16, .origin = {i, j}, .side = 1, .polynomial = polynomial};
    cell->points = CO_NEW(co_real, 16 * 16);
    if (!cell->points)
        return co_status_no_memory(error);
    for (int k = 0; k < 16; k++) {
        int32_t from = co_polynomial_index(polynomial->valence, polynomial->width, 0, i + k % 4 - 1, j + k / 4 - 1);
        cell->points[17 * k] = 1;
        memcpy(cell->map[k], polynomial->map + 2 * from, sizeof cell->map[k]);
    }
    return CURVOPT_OK;
}

/* Jets of the characteristic map. */
static void map_jets(const co_cell *cell, co_real basis[16][CO_JET], co_real chi[2][CO_JET]) {
    memset(chi, 0, 2 * sizeof *chi);
    for (int i = 0; i < 16; i++)
        for (int k = 0; k < CO_JET; k++)
            for (int c = 0; c < 2; c++)
                chi[c][k] += cell->map[i][c] * basis[i][k];
}

void co_cell_chart(const co_cell *cell, co_real s, co_real t, co_chart *chart) {
    co_real basis[16][CO_JET], chi[2][CO_JET] = {{0, 1}, {0, 0, 1}};
    co_bspline_bicubic(s, t, basis);
    if (cell->chart)
        map_jets(cell, basis, chi);
    co_chart_create(chi[0], chi[1], chart);
}

void co_cell_blend(const co_cell *cell, co_blend blend, co_real s, co_real t, co_real jet[CO_JET]) {
    int width = cell->polynomial ? cell->polynomial->width : 1;
    co_real side = cell->side / width;
    co_blend_weight(blend, cell->origin[0] / width + side * s, cell->origin[1] / width + side * t, jet);
    for (int k = 0; k < CO_JET; k++)
        jet[k] *= powl(side, co_jet_order_u[k] + co_jet_order_v[k]);
}

/* Jets that multiply what the surface is made of there: the cell's 16 points, and the polynomial's coefficients. */
typedef struct generators {
    co_real points[16][CO_JET];
    co_real terms[CO_POLYNOMIAL_TERMS][CO_JET];
} generators;

static void blend_generators(const co_cell *cell, co_real s, co_real t, generators *g) {
    co_real basis[16][CO_JET], monomial[CO_POLYNOMIAL_TERMS][CO_JET], chi[2][CO_JET], w[CO_JET], rest[CO_JET];
    memcpy(basis, g->points, sizeof basis);
    map_jets(cell, basis, chi);
    co_cell_blend(cell, CO_BLEND_POLYNOMIAL, s, t, w);
    for (int k = 0; k < CO_JET; k++)
        rest[k] = (k == 0) - w[k];
    for (int i = 0; i < 16; i++)
        co_jet_multiply(rest, basis[i], g->points[i]);
    co_polynomial_monomials(chi[0], chi[1], monomial);
    for (int i = 0; i < CO_POLYNOMIAL_TERMS; i++)
        co_jet_multiply(w, monomial[i], g->terms[i]);
}

/* Of one of the cell's points: through the patch's control points, and through the fit where that is folded in. */
static void point_row(const co_cell *cell, const generators *g, int32_t point, co_real sum[CO_JET]) {
    memset(sum, 0, CO_JET * sizeof *sum);
    for (int i = 0; i < 16; i++) {
        co_real factor = cell->points[i * cell->n_points + point];
        for (int k = 0; factor != 0 && k < CO_JET; k++)
            sum[k] += factor * g->points[i][k];
    }
    for (int i = 0; cell->polynomial && cell->polynomial->width == 1 && i < CO_POLYNOMIAL_TERMS; i++)
        for (int k = 0; k < CO_JET; k++)
            sum[k] += cell->polynomial->fit[i * cell->n_points + point] * g->terms[i][k];
}

/* Of the polynomial's point number `term`. */
static void term_row(const generators *g, int term, co_real sum[CO_JET]) {
    memcpy(sum, g->terms[term], sizeof g->terms[term]);
    for (int i = 1; term == 0 && i < CO_POLYNOMIAL_TERMS; i++)
        for (int k = 0; k < CO_JET; k++)
            sum[k] -= g->terms[i][k];
}

void co_cell_rows(const co_cell *cell, co_real s, co_real t, int32_t n_support, const int32_t *support, double *rows) {
    generators g;
    co_bspline_bicubic(s, t, g.points);
    if (cell->polynomial)
        blend_generators(cell, s, t, &g);
    if (cell->chart) {
        co_chart chart;
        co_cell_chart(cell, s, t, &chart);
        for (int i = 0; i < 16; i++)
            co_chart_apply(&chart, g.points[i]);
        for (int i = 0; cell->polynomial && i < CO_POLYNOMIAL_TERMS; i++)
            co_chart_apply(&chart, g.terms[i]);
    }
    for (int32_t p = 0; p < n_support; p++, rows += CO_JET) {
        co_real sum[CO_JET];
        if (support[p] < cell->n_points)
            point_row(cell, &g, support[p], sum);
        else
            term_row(&g, support[p] - cell->n_points, sum);
        for (int k = 0; k < CO_JET; k++)
            rows[k] = (double)sum[k];
    }
}
