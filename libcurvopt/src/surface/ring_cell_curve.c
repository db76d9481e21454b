/* The curve's part of rows on a half disc. SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/ring_cell_curve.h"

#include "base/elementary.h"

#include <math.h>
#include <string.h>

enum { P_FUNCTIONS = CO_BLEND_FIT_DEGREE + 2 /* of p: 1, x, .. x^5, and the cusp */ };

/* The parameter along the curve in which a cell's face borders on it: 0 for u, 1 for v, -1 for none. */
static int along(const co_ring_cell_place *cell) {
    const int32_t last = cell->polynomial->valence - 1;
    if (cell->sector == 0 && cell->origin[1] < 1)
        return 0;
    return cell->sector == last && cell->origin[0] < 1 ? 1 : -1;
}

void co_ring_cell_curve_weights(const co_ring_cell_place *cell, double *weights, size_t stride) {
    if (cell->is_face) { /* the curve's points are in the second row, or the second column */
        for (size_t k = 0; along(cell) >= 0 && k < 4; k++)
            weights[(along(cell) ? 4 * k + 1 : 4 + k) * stride + k] = 1;
        return;
    }
    const double per_unit = 1 / cell->polynomial->unit;
    int32_t point[CO_BLEND_FIT_CURVE];
    co_blend_fit_curve_points(co_fan_make(CO_FAN_CREASE, cell->polynomial->valence, 0), point);
    for (int a = 0; a < CO_BLEND_FIT_CURVE; a++) /* of x^a, and of |x|^3 */
        for (int i = 0; i < CO_BLEND_FIT_CURVE; i++)
            weights[(size_t)point[i] * stride + (size_t)a] =
                (co_blend_fit_curve_weight[a][i] * co_power(per_unit, a < 4 ? a : 3));
}

/* Jet of w(u) w(v) over the faces at the vertex; with `only` 0 or 1 that of w(u) or w(v) alone. */
static void narrow_weight(const co_ring_cell_place *cell, double s, double t, int only, double out[CO_JET]) {
    double jet[CO_JET];
    const double u = cell->origin[0] + cell->side * s, v = cell->origin[1] + cell->side * t;
    co_blend_weight(CO_BLEND_POLYNOMIAL, only == 1 ? 0 : u, only == 0 ? 0 : v, jet);
    for (int k = 0; k < CO_JET; k++)
        out[k] = (jet[k] * co_power(cell->side, co_jet_order_u[k] + co_jet_order_v[k]));
}

/* Weights and coordinates of E's two parts: at the vertex, and along the curve. */
typedef struct curve_part {
    double at_vertex[CO_JET], beside[CO_JET]; /* jets of their weights, W among the factors */
    double xi[CO_JET];                        /* jet of the map's x of the point of the curve beside */
} curve_part;

static void find_weights(const co_ring_cell_place *cell, double s, double t, const double w[CO_JET],
                         const co_chart *chart, curve_part *e) {
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
    const double scale = (axis ? -1 : 1) * cell->polynomial->unit;
    e->xi[0] = (scale * (cell->origin[axis] + cell->side * (axis ? t : s)));
    e->xi[1 + axis] = (scale * cell->side);
    if (chart)
        co_chart_apply(chart, e->xi);
}

/* The four cubics of the curve's segment. */
static void fill_segment(const double weight[CO_JET], int axis, double along_curve, double out[4][CO_JET]) {
    double basis[4][4];
    static const int of_axis[2][4] = {{0, 1, 3, 6}, {0, 2, 5, 9}};
    co_bspline_cubic(along_curve, basis);
    for (int i = 0; i < 4; i++) {
        double jet[CO_JET] = {0};
        for (int k = 0; k < 4; k++)
            jet[of_axis[axis][k]] = basis[i][k];
        co_jet_multiply(weight, jet, out[i]);
    }
}

/* weight c, for each function c of the curve's polynomial p: powers of x, and the cube whose jet is given. */
static void fill_functions(const double weight[CO_JET], const double x[CO_JET], const double cube[CO_JET],
                           double out[P_FUNCTIONS][CO_JET]) {
    memcpy(out[0], weight, sizeof out[0]);
    for (int a = 1; a < P_FUNCTIONS - 1; a++)
        co_jet_multiply(out[a - 1], x, out[a]);
    co_jet_multiply(weight, cube, out[P_FUNCTIONS - 1]);
}

static void cube_of(const double x[CO_JET], double sign, double out[CO_JET]) {
    double square[CO_JET];
    co_jet_multiply(x, x, square);
    co_jet_multiply(square, x, out);
    for (int k = 0; k < CO_JET; k++)
        out[k] *= sign;
}

void co_ring_cell_curve_apply(const co_ring_cell_place *cell, double s, double t, const co_chart *chart,
                              const double w[CO_JET], double chi[2][CO_JET], double (*terms)[CO_JET],
                              double (*curve)[CO_JET]) {
    curve_part e;
    double cube[CO_JET], part[P_FUNCTIONS][CO_JET] = {{0}}, beside[P_FUNCTIONS][CO_JET];
    find_weights(cell, s, t, w, chart, &e);
    if (!cell->is_face) {
        co_blend_fit_cusp(chi[0], chi[1], cube);
        fill_functions(e.at_vertex, chi[0], cube, part);
    }
    cube_of(e.xi, along(cell) == 1 ? -1 : 1, cube); /* |xi|^3 */
    fill_functions(e.beside, e.xi, cube, beside);
    for (int a = 0; a < P_FUNCTIONS; a++) {
        double *term = terms[a < P_FUNCTIONS - 1 ? co_blend_fit_term(a, 0) : CO_BLEND_FIT_CUSP];
        for (int k = 0; k < CO_JET; k++) {
            part[a][k] += beside[a][k];
            term[k] -= part[a][k];
        }
    }
    memset(curve, 0, CO_BLEND_FIT_CURVE * sizeof *curve);
    if (cell->is_face && along(cell) >= 0)
        fill_segment(e.beside, along(cell), along(cell) ? t : s, curve);
    if (cell->is_face)
        return;
    memcpy(curve, part, 4 * sizeof *curve);
    memcpy(curve[4], part[P_FUNCTIONS - 1], sizeof *curve);
}
