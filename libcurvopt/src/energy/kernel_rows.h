/* Products of a sample's rows with points, S = R x, and of their transpose with adjoints: most of what a kernel does.
 * Included by element_kernel.c only, as kernel_gradient.h is. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KERNEL_ROWS_H
#define CO_ENERGY_KERNEL_ROWS_H

#include "base/simd.h"
#include "surface/basis_table.h"

/* Where a sample's rows begin. `mixed` is a constant where this is called: of co_basis_table. */
CO_SIMD_INLINE const double *rows_of(const co_basis_table *t, int mixed, int32_t sample) {
    return t->rows + (size_t)sample * (size_t)t->n_points * CO_JET * (mixed ? CO_LANES : 1);
}
/* Entry i of some rows. */
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

/* Not inlined: loops then have all registers. Inlined they share them with what surrounds them, and were a fifth slower
 * (libcurvopt/notes/94-where-the-time-goes.md). */
#define KEEPS_REGISTERS __attribute__((noinline))

/* Vectors as wide as they are; and by 256 bits at most, which AMD's Zen 4 multiplies and adds faster than 512 where no
 * products are fused with sums (libcurvopt/notes/94-where-the-time-goes.md). */
#define PART_LANES CO_LANES
#define PART(name) whole_##name
CO_SIMD_INLINE lane whole_join(const lane part[1]) {
    return part[0];
}
#include "energy/kernel_row_products.h"
#undef PART
#undef PART_LANES

#if CO_LANES == 8
#define PART_LANES 4
#define PART(name) half_##name
typedef double half_lane __attribute__((vector_size(32)));
CO_SIMD_INLINE lane half_join(const half_lane part[2]) {
    return __builtin_shufflevector(part[0], part[1], 0, 1, 2, 3, 4, 5, 6, 7);
}
#include "energy/kernel_row_products.h"
#undef PART
#undef PART_LANES

CO_SIMD_INLINE int halves_are_faster(void) {
#ifdef __x86_64__
    return __builtin_cpu_is("amdfam19h");
#else
    return 0;
#endif
}
#endif

/* S [0..n - 1] from the rows' entries for these. */
CO_SIMD_INLINE void sum_rows(const double *rows, int mixed, int32_t n_points, lane (*P)[3], int n, lane (*S)[3]) {
#if CO_LANES == 8
    if (halves_are_faster()) {
        half_sum_rows(rows, mixed, n_points, P, n, S);
        return;
    }
#endif
    whole_sum_rows(rows, mixed, n_points, P, n, S);
}

/* S [first..last] of one sample from its rows. */
CO_SIMD_INLINE void jets(const double *rows, int mixed, int32_t n_points, lane (*P)[3], int first, int last,
                         lane S[CO_JET][3]) {
    for (int k = first; k <= last; k += JETS_TOGETHER)
        sum_rows(entries(rows, mixed, k), mixed, n_points, P, jets_from(k, last), S + k);
}

/* The transpose of sum_rows(): G becomes rows^T S_bar, or that much more. */
CO_SIMD_INLINE void transpose_rows(const double *rows, int mixed, int32_t n_points, lane (*S_bar)[3], int n, int more,
                                   lane (*G)[3]) {
#if CO_LANES == 8
    if (halves_are_faster()) {
        half_transpose_rows(rows, mixed, n_points, S_bar, n, more, G);
        return;
    }
#endif
    whole_transpose_rows(rows, mixed, n_points, S_bar, n, more, G);
}

/* The transpose of jets(): G becomes rows^T S_bar, or that much more. */
CO_SIMD_INLINE void transpose_jets(const double *rows, int mixed, int32_t n_points, lane S_bar[CO_JET][3], int first,
                                   int last, int more, lane (*G)[3]) {
    for (int k = first; k <= last; k += JETS_TOGETHER)
        transpose_rows(entries(rows, mixed, k), mixed, n_points, S_bar + k, jets_from(k, last), more || k > first, G);
}

#endif
