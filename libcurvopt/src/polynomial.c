/* The `polynomial` surface's fit. SPDX-License-Identifier: GPL-3.0-or-later */
#include "polynomial.h"

#include "memory.h"
#include "quadrature.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Points of the fit: Gauss points a side of each cell, rings; and the weight of the face's far parts, where w = 0. */
enum { FIT_GAUSS = 4, FIT_RINGS = 5 };
static const co_real FAR_WEIGHT = 1e-3L;

enum { TERMS = CO_POLYNOMIAL_TERMS };

void co_polynomial_free(co_polynomial *p) {
    free(p->map);
    free(p->fit);
    *p = (co_polynomial){0};
}

void co_polynomial_monomials(const co_real x[CO_JET], const co_real y[CO_JET], co_real out[TERMS][CO_JET]) {
    memset(out[0], 0, sizeof out[0]);
    out[0][0] = 1;
    /* degree after degree: x times those of the degree before, then y times the last of them */
    for (int degree = 1, at = 1; degree <= CO_POLYNOMIAL_DEGREE; degree++) {
        int before = at - degree;
        for (int i = 0; i < degree; i++)
            co_jet_multiply(x, out[before + i], out[at + i]);
        co_jet_multiply(y, out[at - 1], out[at + degree]);
        at += degree + 1;
    }
}

/* Values alone. */
static void monomial_values(co_real x, co_real y, co_real *out) {
    out[0] = 1;
    for (int degree = 1, at = 1; degree <= CO_POLYNOMIAL_DEGREE; degree++) {
        for (int i = 0; i < degree; i++)
            out[at + i] = x * out[at - degree + i];
        out[at + degree] = y * out[at - 1];
        at += degree + 1;
    }
}

/* One sample, weighted, in every sector by symmetry: row [n] is S over the two-ring in sector 0, (x, y) chi there. */
static void add_sample(int32_t valence, int32_t n, const co_real *row, co_real x, co_real y, co_real weight,
                       co_real *normal, co_real *right) {
    const co_real pi = 3.14159265358979323846264338327950288L;
    for (int32_t s = 0; s < valence; s++) {
        co_real c = cosl(2 * pi * s / valence), d = sinl(2 * pi * s / valence), value[TERMS];
        monomial_values(c * x - d * y, c * y + d * x, value);
        for (int a = 0; a < TERMS; a++) {
            for (int b = 0; b < TERMS; b++)
                normal[a * TERMS + b] += weight * value[a] * value[b];
            co_real *to = right + a * n, w = weight * value[a];
            to[0] += w * row[0];
            for (int32_t i = 1; i < n; i++) /* point i of sector 0's frame, s sectors on */
                to[1 + (i - 1 + CO_RING_SECTOR * s) % (n - 1)] += w * row[i];
        }
    }
}

/* Solves normal X = right in place of `right` [TERMS][n], by Cholesky's factorization. */
static void solve(co_real *normal, int32_t n, co_real *right) {
    for (int j = 0; j < TERMS; j++)
        for (int i = j; i < TERMS; i++) {
            co_real sum = normal[i * TERMS + j];
            for (int k = 0; k < j; k++)
                sum -= normal[i * TERMS + k] * normal[j * TERMS + k];
            normal[i * TERMS + j] = i == j ? sqrtl(sum) : sum / normal[j * TERMS + j];
        }
    for (int32_t c = 0; c < n; c++) {
        for (int i = 0; i < TERMS; i++) {
            for (int k = 0; k < i; k++)
                right[i * n + c] -= normal[i * TERMS + k] * right[k * n + c];
            right[i * n + c] /= normal[i * TERMS + i];
        }
        for (int i = TERMS - 1; i >= 0; i--) {
            for (int k = i + 1; k < TERMS; k++)
                right[i * n + c] -= normal[k * TERMS + i] * right[k * n + c];
            right[i * n + c] /= normal[i * TERMS + i];
        }
    }
}

/* The samples of one cell of ring `side`. cell [16][n] and row [n] are work space. */
static void add_cell(const co_disc *d, int c, co_real side, const co_polynomial *p, co_real *cell, co_real *row,
                     co_real *normal) {
    co_real node[FIT_GAUSS], gauss[FIT_GAUSS], basis[16][CO_JET], w[CO_JET];
    co_quadrature_gauss(FIT_GAUSS, node, gauss);
    co_disc_cell(d, c, cell);
    for (int j = 0; j < FIT_GAUSS; j++)
        for (int i = 0; i < FIT_GAUSS; i++) {
            co_real x = 0, y = 0;
            co_bspline_bicubic(node[i], node[j], basis);
            co_blend_weight(CO_BLEND_POLYNOMIAL, side * (co_irregular_cell_place[c][0] + node[i]),
                            side * (co_irregular_cell_place[c][1] + node[j]), w);
            for (int32_t q = 0; q < d->n_points; q++) {
                row[q] = 0;
                for (int k = 0; k < 16; k++)
                    row[q] += basis[k][0] * cell[k * d->n_points + q];
                x += row[q] * p->map[2 * q];
                y += row[q] * p->map[2 * q + 1];
            }
            add_sample(d->valence, d->n_points, row, x, y, gauss[i] * gauss[j] * side * side * (w[0] + FAR_WEIGHT),
                       normal, p->fit);
        }
}

int32_t co_polynomial_create(co_disc *disc, co_polynomial *p, curvopt_error *error) {
    size_t n = (size_t)disc->n_points;
    co_disc deeper = {0};
    co_real side = 1, normal[TERMS * TERMS] = {0};
    *p = (co_polynomial){.n_points = disc->n_points, .map = CO_NEW(co_real, 2 * n), .fit = CO_NEW(co_real, TERMS * n)};
    co_real *work = CO_NEW(co_real, 17 * n);
    int32_t status =
        !p->map || !p->fit || !work ? co_status_no_memory(error) : co_disc_create(disc->valence, &deeper, error);
    if (status != CURVOPT_OK) {
        free(work);
        co_polynomial_free(p);
        return status;
    }
    co_irregular_characteristic_map(disc, p->map);
    for (int ring = 1; ring <= FIT_RINGS; ring++) {
        side /= 2;
        for (int c = 0; c < CO_RING_CELLS; c++)
            add_cell(&deeper, c, side, p, work, work + 16 * n, normal);
        co_disc_advance(&deeper);
    }
    solve(normal, p->n_points, p->fit);
    free(work);
    co_disc_free(&deeper);
    return CURVOPT_OK;
}
