/* The products of kernel_rows.h by vectors of a width: included there once for each, with PART_LANES, a divisor of
 * CO_LANES, and PART(name), that name for the width. All widths add in the same order, so that bits are the same.
 * SPDX-License-Identifier: GPL-3.0-or-later */

enum { PART(PARTS) = CO_LANES / PART_LANES };
typedef double PART(part) __attribute__((vector_size(8 * PART_LANES)));
typedef double PART(memory) __attribute__((vector_size(8 * PART_LANES), may_alias));

/* A vector's three coordinates, a part of each. */
typedef struct PART(vector) {
    PART(part) c[3];
} PART(vector);

CO_SIMD_INLINE PART(part) PART(get)(const lane *x, int part) {
    return ((const PART(memory) *)(const void *)x)[part];
}

/* Entry i of some rows. */
CO_SIMD_INLINE PART(part) PART(entry)(const double *rows, int mixed, int32_t i, int part) {
    const PART(part) zero = {0};
    return mixed ? PART(get)((const lane *)(const void *)rows + i, part) : rows[i] - zero;
}

CO_SIMD_INLINE void PART(sum_part)(const double *rows, int mixed, int32_t n_points, lane (*P)[3], int n, int part,
                                   PART(part) (*S)[3][PART(PARTS)]) {
    PART(part) sum[JETS_TOGETHER][3];
    for (int k = 0; k < n; k++)
        for (int c = 0; c < 3; c++)
            sum[k][c] = (PART(part)){0};
    for (int32_t p = 0; p < n_points; p++)
        for (int k = 0; k < n; k++)
            for (int c = 0; c < 3; c++)
                sum[k][c] += PART(entry)(rows, mixed, p * CO_JET + k, part) * PART(get)(&P[p][c], part);
    for (int k = 0; k < n; k++) /* one by one: with memcpy() compilers would keep the sums in memory */
        for (int c = 0; c < 3; c++)
            S[k][c][part] = sum[k][c];
}

/* Lanes are put together in registers: what was written in parts is read as a whole only after it has left for memory.
 */
CO_SIMD_INLINE void PART(sum_all_parts)(const double *rows, int mixed, int32_t n_points, lane (*P)[3], int n,
                                        lane (*S)[3]) {
    PART(part) parts[JETS_TOGETHER][3][PART(PARTS)];
    for (int part = 0; part < PART(PARTS); part++)
        PART(sum_part)(rows, mixed, n_points, P, n, part, parts);
    for (int k = 0; k < n; k++)
        for (int c = 0; c < 3; c++)
            S[k][c] = PART(join)(parts[k][c]);
}

/* n is a constant. */
CO_SIMD_INLINE void PART(sum_some)(const double *rows, int mixed, int32_t n_points, lane (*P)[3], int n, lane (*S)[3]) {
    if (mixed)
        PART(sum_all_parts)(rows, 1, n_points, P, n, S);
    else
        PART(sum_all_parts)(rows, 0, n_points, P, n, S);
}

static KEEPS_REGISTERS void PART(sum_rows)(const double *rows, int mixed, int32_t n_points, lane (*P)[3], int n,
                                           lane (*S)[3]) {
    if (n == 1)
        PART(sum_some)(rows, mixed, n_points, P, 1, S);
    else if (n == 2)
        PART(sum_some)(rows, mixed, n_points, P, 2, S);
    else if (n == 3 || JETS_TOGETHER == 3)
        PART(sum_some)(rows, mixed, n_points, P, 3, S);
    else if (n == 4)
        PART(sum_some)(rows, mixed, n_points, P, 4, S);
    else
        PART(sum_some)(rows, mixed, n_points, P, 5, S);
}

CO_SIMD_INLINE PART(vector) PART(get_vector)(const lane x[3], int part) {
    return (PART(vector)){{PART(get)(x, part), PART(get)(x + 1, part), PART(get)(x + 2, part)}};
}

CO_SIMD_INLINE void PART(add_entry)(PART(part) r, const PART(vector) * bar, PART(vector) * sum) {
    for (int c = 0; c < 3; c++)
        sum->c[c] += r * bar->c[c];
}

/* `mixed`, n, `more` and `part` are constants. */
CO_SIMD_INLINE void PART(transpose_part)(const double *rows, int mixed, int32_t n_points, lane (*S_bar)[3], int n,
                                         int more, int part, lane (*G)[3]) {
    const PART(vector) bar0 = PART(get_vector)(S_bar[0], part), bar1 = PART(get_vector)(S_bar[n > 1 ? 1 : 0], part),
                       bar2 = PART(get_vector)(S_bar[n > 2 ? 2 : 0], part),
                       bar3 = PART(get_vector)(S_bar[n > 3 ? 3 : 0], part),
                       bar4 = PART(get_vector)(S_bar[n > 4 ? 4 : 0], part);
    for (int32_t p = 0; p < n_points; p++) {
        PART(vector) sum = {{{0}, {0}, {0}}};
        if (more)
            sum = PART(get_vector)(G[p], part);
        const double *row = entries(rows, mixed, p * CO_JET);
        PART(add_entry)(PART(entry)(row, mixed, 0, part), &bar0, &sum);
        if (n > 1)
            PART(add_entry)(PART(entry)(row, mixed, 1, part), &bar1, &sum);
        if (n > 2)
            PART(add_entry)(PART(entry)(row, mixed, 2, part), &bar2, &sum);
        if (n > 3)
            PART(add_entry)(PART(entry)(row, mixed, 3, part), &bar3, &sum);
        if (n > 4)
            PART(add_entry)(PART(entry)(row, mixed, 4, part), &bar4, &sum);
        for (int c = 0; c < 3; c++)
            ((PART(memory) *)(void *)&G[p][c])[part] = sum.c[c];
    }
}

CO_SIMD_INLINE void PART(transpose_all_parts)(const double *rows, int mixed, int32_t n_points, lane (*S_bar)[3], int n,
                                              int more, lane (*G)[3]) {
    for (int part = 0; part < PART(PARTS); part++)
        PART(transpose_part)(rows, mixed, n_points, S_bar, n, more, part, G);
}

/* n is a constant. */
CO_SIMD_INLINE void PART(transpose_some)(const double *rows, int mixed, int32_t n_points, lane (*S_bar)[3], int n,
                                         int more, lane (*G)[3]) {
    if (mixed && more)
        PART(transpose_all_parts)(rows, 1, n_points, S_bar, n, 1, G);
    else if (mixed)
        PART(transpose_all_parts)(rows, 1, n_points, S_bar, n, 0, G);
    else if (more)
        PART(transpose_all_parts)(rows, 0, n_points, S_bar, n, 1, G);
    else
        PART(transpose_all_parts)(rows, 0, n_points, S_bar, n, 0, G);
}

static KEEPS_REGISTERS void PART(transpose_rows)(const double *rows, int mixed, int32_t n_points, lane (*S_bar)[3],
                                                 int n, int more, lane (*G)[3]) {
    if (n == 1)
        PART(transpose_some)(rows, mixed, n_points, S_bar, 1, more, G);
    else if (n == 2)
        PART(transpose_some)(rows, mixed, n_points, S_bar, 2, more, G);
    else if (n == 3 || JETS_TOGETHER == 3)
        PART(transpose_some)(rows, mixed, n_points, S_bar, 3, more, G);
    else if (n == 4)
        PART(transpose_some)(rows, mixed, n_points, S_bar, 4, more, G);
    else
        PART(transpose_some)(rows, mixed, n_points, S_bar, 5, more, G);
}
