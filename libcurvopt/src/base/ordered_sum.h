/* Parallel sums whose value does not depend on the number of threads: each of 64 fixed chunks is summed by one thread,
 * then the chunks' sums are added in order (notes/31-work-sharing-between-threads.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_ORDERED_SUM_H
#define CO_BASE_ORDERED_SUM_H

#include "base/thread_pool.h"

#include <stddef.h>

enum {
    CO_ORDERED_SUM_CHUNKS = 64, /* many more than threads, so that these end together */
};

/* Number of the first of n summands in a chunk. Chunks 0 .. CO_ORDERED_SUM_CHUNKS - 1 exist; for CO_ORDERED_SUM_CHUNKS
 * the result is n. */
static inline size_t co_ordered_sum_begin(size_t n, int chunk) {
    return n * (size_t)chunk / CO_ORDERED_SUM_CHUNKS;
}

/* Calls sum_chunks(context, first, end) for all chunks, on several threads where n summands are worth it. */
static inline void co_ordered_sum_run(co_thread_pool *pool, size_t n, co_thread_loop *sum_chunks, void *context) {
    co_thread_pool_for(co_thread_pool_if_worth(pool, n), CO_ORDERED_SUM_CHUNKS, sum_chunks, context);
}

#endif
