/* Products of rows and points on regular faces, where a basis function is a product of one along u and one along v (a
 * tensor product), by sum factorization (S. A. Orszag, "Spectral methods for problems in complex geometries", J.
 * Comput. Phys. 37, 1980): a strip of samples with the same v has its points summed along v once, and its samples sum
 * four of these along u, instead of sixteen each. Their transposes likewise. Included by element_kernel.c only, as
 * kernel_rows.h is.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KERNEL_STRIP_H
#define CO_ENERGY_KERNEL_STRIP_H

#include "energy/kernel_rows.h"

/* [order of the derivative along v][control point along u][coordinate]: the points of a strip, or adjoints of them. */
typedef lane strip[4][4][3];

/* The points summed along v, with derivatives of up to `order`; along_v: side [j] of the table. */
CO_SIMD_INLINE void strip_begin(const double *along_v, int order, lane (*P)[3], strip out) {
    for (int i = 0; i < 4; i++)
        for (int c = 0; c < 3; c++)
            for (int b = 0; b <= order; b++) {
                lane sum = along_v[b] * P[i][c];
                for (int j = 1; j < 4; j++)
                    sum += along_v[4 * j + b] * P[4 * j + i][c];
                out[b][i][c] = sum;
            }
}

/* The transpose of strip_begin(), added to G. */
CO_SIMD_INLINE void strip_end(const double *along_v, int order, strip bar, lane (*G)[3]) {
    for (int i = 0; i < 4; i++)
        for (int c = 0; c < 3; c++)
            for (int j = 0; j < 4; j++) {
                lane sum = along_v[4 * j + 0] * bar[0][i][c];
                for (int b = 1; b <= order; b++)
                    sum += along_v[4 * j + b] * bar[b][i][c];
                G[4 * j + i][c] += sum;
            }
}

/* Those of S [first..last] with derivative b along v, of a sample. */
CO_SIMD_INLINE void strip_jets_of(const double *along_u, int b, lane (*m)[3], int first, int last, lane S[CO_JET][3]) {
    for (int a = 0; a + b < 4; a++) {
        const int k = co_jet_index(a, b);
        if (k < first || k > last)
            continue;
        for (int c = 0; c < 3; c++)
            S[k][c] =
                along_u[a] * m[0][c] + along_u[4 + a] * m[1][c] + along_u[8 + a] * m[2][c] + along_u[12 + a] * m[3][c];
    }
}

/* S [first..last] of a sample; along_u: side [i] of the table. `first` and `last` are constants where this is called.
 */
CO_SIMD_INLINE void strip_jets(const double *along_u, strip m, int first, int last, lane S[CO_JET][3]) {
    strip_jets_of(along_u, 0, m[0], first, last, S);
    strip_jets_of(along_u, 1, m[1], first, last, S);
    strip_jets_of(along_u, 2, m[2], first, last, S);
    strip_jets_of(along_u, 3, m[3], first, last, S);
}

/* The transpose of strip_jets_of(), added to the adjoints of its points. */
CO_SIMD_INLINE void strip_scatter_of(const double *along_u, int b, lane S_bar[CO_JET][3], int first, int last,
                                     lane (*bar)[3]) {
    for (int i = 0; i < 4; i++)
        for (int c = 0; c < 3; c++) {
            lane sum = bar[i][c];
            for (int a = 0; a + b < 4; a++) {
                const int k = co_jet_index(a, b);
                if (k >= first && k <= last)
                    sum += along_u[4 * i + a] * S_bar[k][c];
            }
            bar[i][c] = sum;
        }
}

/* The transpose of strip_jets(), added to `bar`. */
CO_SIMD_INLINE void strip_scatter(const double *along_u, lane S_bar[CO_JET][3], int first, int last, strip bar) {
    strip_scatter_of(along_u, 0, S_bar, first, last, bar[0]);
    if (last >= co_jet_index(0, 1))
        strip_scatter_of(along_u, 1, S_bar, first, last, bar[1]);
    if (last >= co_jet_index(0, 2))
        strip_scatter_of(along_u, 2, S_bar, first, last, bar[2]);
    if (last >= co_jet_index(0, 3))
        strip_scatter_of(along_u, 3, S_bar, first, last, bar[3]);
}

#endif
