/* The curve's part of rows on a half disc. SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/ring_cell_curve.h"

#include "surface/blend_fit_cut.h"
#include "surface/blend_fit_half.h"

#include <math.h>
#include <string.h>

enum { POWERS = CO_BLEND_FIT_DEGREE + 1 };

/* The parameter along the curve in which a cell's face borders on it: 0 for u, 1 for v, -1 for none. */
static int along(const co_ring_cell *cell) {
    const int32_t last = cell->polynomial->valence - 1;
    if (cell->sector == 0 && cell->origin[1] < 1)
        return 0;
    return cell->sector == last && cell->origin[0] < 1 ? 1 : -1;
}

void co_ring_cell_curve_weights(co_ring_cell *cell) {
    const size_t stride = CO_RING_CELL_GENERATORS;
    if (cell->is_face) { /* the curve's points are in the second row, or the second column */
        for (int k = 0; along(cell) >= 0 && k < 4; k++)
            cell->weights[(size_t)(along(cell) ? 4 * k + 1 : 4 + k) * stride + CO_RING_CELL_CURVE + (size_t)k] = 1;
        return;
    }
    const co_real unit = 1 / co_blend_fit_half_scale(cell->polynomial->width);
    int32_t point[CO_BLEND_FIT_CURVE];
    co_blend_fit_curve_points(co_fan_make(CO_FAN_CREASE, cell->polynomial->valence, 0), point);
    for (int a = 0; a < CO_BLEND_FIT_CURVE; a++) /* of x^a, and of |x|^3 */
        for (int i = 0; i < CO_BLEND_FIT_CURVE; i++)
            cell->weights[(size_t)point[i] * stride +
                          (size_t)(a < 4 ? CO_RING_CELL_CURVE + a : CO_RING_CELL_TERM + CO_BLEND_FIT_CUSP)] =
                (double)(co_blend_fit_curve_weight[a][i] * powl(unit, a < 4 ? a : 3));
}

/* Jet of w(u) w(v) over the faces at the vertex; with `only` 0 or 1 that of w(u) or w(v) alone. */
static void narrow_weight(const co_ring_cell *cell, co_real s, co_real t, int only, double out[CO_JET]) {
    co_real jet[CO_JET];
    const co_real u = cell->origin[0] + cell->side * s, v = cell->origin[1] + cell->side * t;
    co_blend_weight(CO_BLEND_POLYNOMIAL, only == 1 ? 0 : u, only == 0 ? 0 : v, jet);
    for (int k = 0; k < CO_JET; k++)
        out[k] = (double)(jet[k] * powl(cell->side, co_jet_order_u[k] + co_jet_order_v[k]));
}

/* Weights and coordinates of E's two parts: at the vertex, and along the curve. */
typedef struct curve_part {
    double at_vertex[CO_JET], beside[CO_JET]; /* jets of their weights, W among the factors */
    double xi[CO_JET];                        /* jet of the map's x of the point of the curve beside */
} curve_part;

static void find_weights(const co_ring_cell *cell, co_real s, co_real t, const double w[CO_JET], const co_chart *chart,
                         curve_part *e) {
    const int axis = along(cell);
    double jet[CO_JET] = {0}, across[CO_JET], product[CO_JET];
    *e = (curve_part){0};
    if (!cell->is_face) {
        narrow_weight(cell, s, t, -1, jet);
        if (chart)
            co_chart_apply(chart, jet);
        co_jet_multiply(w, jet, e->at_vertex);
    }
    if (axis < 0)
        return;
    narrow_weight(cell, s, t, !axis, across);
    memset(jet, 0, sizeof jet);
    if (!cell->is_face)
        narrow_weight(cell, s, t, axis, jet);
    for (int k = 0; k < CO_JET; k++) /* 1 - w */
        jet[k] = (k == 0) - jet[k];
    co_jet_multiply(jet, across, product);
    if (chart)
        co_chart_apply(chart, product);
    co_jet_multiply(w, product, e->beside);
    const co_real scale = (axis ? -1 : 1) * co_blend_fit_half_scale(cell->polynomial->width);
    e->xi[0] = (double)(scale * (cell->origin[axis] + cell->side * (axis ? t : s)));
    e->xi[1 + axis] = (double)(scale * cell->side);
    if (chart)
        co_chart_apply(chart, e->xi);
}

/* out[a] = weight x^a. */
static void add_powers(const double weight[CO_JET], const double x[CO_JET], double out[POWERS][CO_JET]) {
    double power[CO_JET], next[CO_JET];
    memcpy(power, weight, sizeof power);
    for (int a = 0; a < POWERS; a++) {
        for (int k = 0; k < CO_JET; k++)
            out[a][k] += power[k];
        co_jet_multiply(power, x, next);
        memcpy(power, next, sizeof power);
    }
}

/* The four cubics of the curve's segment. */
static void fill_segment(const double weight[CO_JET], int axis, co_real along_curve, double out[4][CO_JET]) {
    co_real basis[4][4];
    static const int of_axis[2][4] = {{0, 1, 3, 6}, {0, 2, 5, 9}};
    co_bspline_cubic(along_curve, basis);
    for (int i = 0; i < 4; i++) {
        double jet[CO_JET] = {0};
        for (int k = 0; k < 4; k++)
            jet[of_axis[axis][k]] = (double)basis[i][k];
        co_jet_multiply(weight, jet, out[i]);
    }
}

void co_ring_cell_curve_apply(const co_ring_cell *cell, co_real s, co_real t, const co_chart *chart,
                              const double w[CO_JET], double chi[2][CO_JET], co_ring_cell_generators g) {
    curve_part e;
    double power[POWERS][CO_JET] = {{0}}, cusp[CO_JET], cube[CO_JET];
    find_weights(cell, s, t, w, chart, &e);
    add_powers(e.at_vertex, chi[0], power);
    memset(cusp, 0, sizeof cusp);
    if (!cell->is_face) {
        co_blend_fit_cusp(chi[0], chi[1], cube);
        co_jet_multiply(e.at_vertex, cube, cusp);
    }
    double beside[POWERS][CO_JET] = {{0}};
    add_powers(e.beside, e.xi, beside);
    for (int a = 0; a < POWERS; a++)
        for (int k = 0; k < CO_JET; k++)
            power[a][k] += beside[a][k];
    for (int k = 0; k < CO_JET; k++) /* |xi|^3 */
        cusp[k] += (along(cell) == 1 ? -1 : 1) * beside[3][k];
    for (int a = 0; a < POWERS; a++)
        for (int k = 0; k < CO_JET; k++)
            g[CO_RING_CELL_TERM + co_blend_fit_term(a, 0)][k] -= power[a][k];
    memcpy(g[CO_RING_CELL_TERM + CO_BLEND_FIT_CUSP], cusp, sizeof cusp);
    memset(g[CO_RING_CELL_CURVE], 0, 4 * sizeof *g);
    if (!cell->is_face)
        memcpy(g[CO_RING_CELL_CURVE], power, 4 * sizeof *g);
    else if (along(cell) >= 0)
        fill_segment(e.beside, along(cell), along(cell) ? t : s, g + CO_RING_CELL_CURVE);
}
