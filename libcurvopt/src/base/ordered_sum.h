/* Sums in parallel whose value does not depend on the number of threads: over fixed chunks, then over these in order.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_ORDERED_SUM_H
#define CO_BASE_ORDERED_SUM_H

#include <stddef.h>

/* Summands below which waking a second thread costs more than it brings. */
enum { CO_ORDERED_SUM_CHUNKS = 64, CO_ORDERED_SUM_WORTH_THREADS = 4096 };

/* Where chunk 0 .. CO_ORDERED_SUM_CHUNKS of n summands begins; the last is the end. */
static inline size_t co_ordered_sum_begin(size_t n, int chunk) {
    return n * (size_t)chunk / CO_ORDERED_SUM_CHUNKS;
}

#endif
