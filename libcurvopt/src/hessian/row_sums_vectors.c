/* Weighted sums of rows of numbers. Compiled once per instruction set, with CO_LANES and CO_INSTRUCTION_SET set.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/row_sums.h"

#include "base/simd.h"

enum { VECTORS = 4 /* of sums, which stay in registers */ };

/* n vectors of the sum, n constant: one after the other, but the last one, which begins at `last`. */
CO_SIMD_INLINE void add_up_part(const co_row_sum *s, size_t length, const double *rows, int n, ptrdiff_t last,
                                double *to) {
    lane sum[VECTORS];
    for (int k = 0; k < n; k++)
        sum[k] = lane_all(0);
    for (size_t e = 0; e < s->n; e++) {
        const int32_t row = s->row[s->point[e]];
        if (row < 0)
            continue;
        const lane weight = lane_all(s->weight[e]);
        const double *from = rows + (size_t)row * length;
        for (int k = 0; k < n; k++)
            sum[k] += weight * *(const unaligned_lane *)(from + (k + 1 < n ? (ptrdiff_t)k * CO_LANES : last));
    }
    for (int k = 0; k < n; k++)
        *(unaligned_lane *)(to + (k + 1 < n ? (ptrdiff_t)k * CO_LANES : last)) = sum[k];
}

/* The last vector may begin before the one before it ends. */
static void add_up(const co_row_sum *s, size_t length, const double *rows, double *to) {
    size_t left = length;
    for (; left > VECTORS * CO_LANES; left -= VECTORS * CO_LANES) {
        add_up_part(s, length, rows, VECTORS, (VECTORS - 1) * CO_LANES, to);
        rows += VECTORS * CO_LANES;
        to += VECTORS * CO_LANES;
    }
    const ptrdiff_t last = (ptrdiff_t)left - CO_LANES;
    switch ((left + CO_LANES - 1) / CO_LANES) {
    case 1:
        add_up_part(s, length, rows, 1, last, to);
        break;
    case 2:
        add_up_part(s, length, rows, 2, last, to);
        break;
    case 3:
        add_up_part(s, length, rows, 3, last, to);
        break;
    default:
        add_up_part(s, length, rows, VECTORS, last, to);
    }
}

const co_row_sums CO_NAME_OF_SET(co_row_sums) = {.add_up = add_up};
