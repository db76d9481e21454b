/* Products of a sample's rows with points, S = R x, and of their transpose with adjoints. Energies and
 * gradients of regular faces have kernel_strip.h instead.
 * Included by element_kernel.c only, as kernel_gradient.h is. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KERNEL_ROWS_H
#define CO_ENERGY_KERNEL_ROWS_H

#include "base/simd.h"
#include "surface/basis_table.h"

/* Where a sample's rows begin. */
CO_SIMD_INLINE const double *rows_of(const co_basis_table *t, int32_t sample) {
    return t->rows + (size_t)sample * (size_t)t->n_points * CO_JET * (t->is_mixed ? CO_LANES : 1);
}
/* Entry i of some rows; mixed: of co_basis_table. */
CO_SIMD_INLINE lane entry(const double *rows, int mixed, int32_t i) {
    return mixed ? ((const lane *)(const void *)rows)[i] : lane_all(rows[i]);
}

/* Some rows from entry i on. */
CO_SIMD_INLINE const double *entries(const double *rows, int mixed, int32_t i) {
    return rows + (mixed ? CO_LANES : 1) * i;
}

/* Points of a block's part, relative to each face's first one. */
CO_SIMD_INLINE void gather(int32_t n, const int32_t *points, const double *xyz, lane (*P)[3]) {
    for (int l = 0; l < CO_LANES; l++) {
        const double *origin = xyz + 3 * (size_t)points[l];
        for (int32_t p = 0; p < n; p++) {
            const double *x = xyz + 3 * (size_t)points[p * CO_LANES + l];
            for (int c = 0; c < 3; c++)
                P[p][c][l] = x[c] - origin[c];
        }
    }
}

/* Derivatives that are summed together. Each entry of the rows is read once for three coordinates, and sums stay in
 * registers: as many as fit. Whatever the number is, all is added in the order of points, or of derivatives. */
#if CO_LANES == 8 || defined(__aarch64__) /* 32 registers */
enum { JETS_TOGETHER = 5 };
#else /* 16 */
enum { JETS_TOGETHER = 3 };
#endif

/* How many of the derivatives k..last come next. */
CO_SIMD_INLINE int jets_from(int k, int last) {
    return last + 1 - k < JETS_TOGETHER ? last + 1 - k : JETS_TOGETHER;
}

/* S [0..n - 1] from the rows' entries for these. `mixed` and n are constants where this is called. */
CO_SIMD_INLINE void sum_some_rows(const double *rows, int mixed, int32_t n_points, lane (*P)[3], int n, lane (*S)[3]) {
    lane sum[JETS_TOGETHER][3];
    for (int k = 0; k < n; k++)
        for (int c = 0; c < 3; c++)
            sum[k][c] = lane_all(0);
    for (int32_t p = 0; p < n_points; p++)
        for (int k = 0; k < n; k++)
            for (int c = 0; c < 3; c++)
                sum[k][c] += entry(rows, mixed, p * CO_JET + k) * P[p][c];
    for (int k = 0; k < n; k++) /* one by one: with memcpy() compilers would keep the sums in memory */
        for (int c = 0; c < 3; c++)
            S[k][c] = sum[k][c];
}

/* n is a constant where this is called. */
CO_SIMD_INLINE void sum_rows_of(const double *rows, int mixed, int32_t n_points, lane (*P)[3], int n, lane (*S)[3]) {
    if (mixed)
        sum_some_rows(rows, 1, n_points, P, n, S);
    else
        sum_some_rows(rows, 0, n_points, P, n, S);
}

/* Not inlined: loops then have all registers. Inlined they share them with what surrounds them, which gets slower, too
 * (libcurvopt/notes/94-where-the-time-goes.md). */
__attribute__((noinline)) static void sum_rows(const double *rows, int mixed, int32_t n_points, lane (*P)[3], int n,
                                               lane (*S)[3]) {
    if (n == 1)
        sum_rows_of(rows, mixed, n_points, P, 1, S);
    else if (n == 2)
        sum_rows_of(rows, mixed, n_points, P, 2, S);
    else if (n == 3 || JETS_TOGETHER == 3)
        sum_rows_of(rows, mixed, n_points, P, 3, S);
    else if (n == 4)
        sum_rows_of(rows, mixed, n_points, P, 4, S);
    else
        sum_rows_of(rows, mixed, n_points, P, 5, S);
}

/* S [first..last] of one sample from its rows. */
CO_SIMD_INLINE void jets(const double *rows, int mixed, int32_t n_points, lane (*P)[3], int first, int last,
                         lane S[CO_JET][3]) {
    for (int k = first; k <= last; k += JETS_TOGETHER)
        sum_rows(entries(rows, mixed, k), mixed, n_points, P, jets_from(k, last), S + k);
}

/* A vector, as a whole in registers. */
typedef struct vector {
    lane c[3];
} vector;

CO_SIMD_INLINE void add_entry(lane r, const vector *bar, vector *sum) {
    for (int c = 0; c < 3; c++)
        sum->c[c] += r * bar->c[c];
}

/* The transpose of sum_some_rows(): G becomes rows^T S_bar, or that much more. `mixed`, n and `more` are constants. */
CO_SIMD_INLINE void transpose_some_rows(const double *rows, int mixed, int32_t n_points, const vector *S_bar, int n,
                                        int more, vector *G) {
    const vector bar0 = S_bar[0], bar1 = S_bar[n > 1 ? 1 : 0], bar2 = S_bar[n > 2 ? 2 : 0], bar3 = S_bar[n > 3 ? 3 : 0],
                 bar4 = S_bar[n > 4 ? 4 : 0];
    for (int32_t p = 0; p < n_points; p++) {
        vector sum = more ? G[p] : (vector){{lane_all(0), lane_all(0), lane_all(0)}};
        const double *row = entries(rows, mixed, p * CO_JET);
        add_entry(entry(row, mixed, 0), &bar0, &sum);
        if (n > 1)
            add_entry(entry(row, mixed, 1), &bar1, &sum);
        if (n > 2)
            add_entry(entry(row, mixed, 2), &bar2, &sum);
        if (n > 3)
            add_entry(entry(row, mixed, 3), &bar3, &sum);
        if (n > 4)
            add_entry(entry(row, mixed, 4), &bar4, &sum);
        G[p] = sum;
    }
}

/* n is a constant where this is called. */
CO_SIMD_INLINE void transpose_rows_of(const double *rows, int mixed, int32_t n_points, const vector *S_bar, int n,
                                      int more, vector *G) {
    if (mixed && more)
        transpose_some_rows(rows, 1, n_points, S_bar, n, 1, G);
    else if (mixed)
        transpose_some_rows(rows, 1, n_points, S_bar, n, 0, G);
    else if (more)
        transpose_some_rows(rows, 0, n_points, S_bar, n, 1, G);
    else
        transpose_some_rows(rows, 0, n_points, S_bar, n, 0, G);
}

/* Not inlined, as sum_rows(). */
__attribute__((noinline)) static void transpose_rows(const double *rows, int mixed, int32_t n_points, lane (*S_bar)[3],
                                                     int n, int more, lane (*G)[3]) {
    const vector *bar = (const vector *)(const void *)S_bar;
    vector *to = (vector *)(void *)G;
    if (n == 1)
        transpose_rows_of(rows, mixed, n_points, bar, 1, more, to);
    else if (n == 2)
        transpose_rows_of(rows, mixed, n_points, bar, 2, more, to);
    else if (n == 3 || JETS_TOGETHER == 3)
        transpose_rows_of(rows, mixed, n_points, bar, 3, more, to);
    else if (n == 4)
        transpose_rows_of(rows, mixed, n_points, bar, 4, more, to);
    else
        transpose_rows_of(rows, mixed, n_points, bar, 5, more, to);
}

/* The transpose of jets(): G becomes rows^T S_bar, or that much more. */
CO_SIMD_INLINE void transpose_jets(const double *rows, int mixed, int32_t n_points, lane S_bar[CO_JET][3], int first,
                                   int last, int more, lane (*G)[3]) {
    for (int k = first; k <= last; k += JETS_TOGETHER)
        transpose_rows(entries(rows, mixed, k), mixed, n_points, S_bar + k, jets_from(k, last), more || k > first, G);
}

#endif
