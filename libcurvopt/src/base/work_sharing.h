/* Dealing work out to threads so that each gets the same pieces every time: what it wrote in one pass over the faces is
 * then still in its own cache in the next, instead of in the other core's. Threads that are done early take pieces
 * from the others, so that neither pieces of unlike cost nor a busy core hold anyone up.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_WORK_SHARING_H
#define CO_BASE_WORK_SHARING_H

#include <omp.h>
#include <stdint.h>
#include <string.h>

/* How many of a thread's own pieces have been taken; a cache line each. */
typedef struct co_work_sharing {
    int32_t taken;
    int32_t other_lines[31];
} co_work_sharing;

/* Before a parallel region, n_threads of them. */
static inline void co_work_sharing_start(co_work_sharing *deal, int32_t n_threads) {
    memset(deal, 0, sizeof *deal * (size_t)n_threads);
}

/* A piece 0 .. n - 1 that is still to do, or -1; to be called in a parallel region. *helped: 0 before the first call;
 * how many threads' own pieces this one has seen to be taken. */
static inline int32_t co_work_sharing_next(co_work_sharing *deal, int32_t n, int32_t *helped) {
    const int64_t threads = omp_get_num_threads();
    for (; *helped < threads; ++*helped) {
        int64_t whose = (omp_get_thread_num() + *helped) % threads;
        int32_t begin = (int32_t)(n * whose / threads), end = (int32_t)(n * (whose + 1) / threads), taken;
#pragma omp atomic capture
        taken = deal[whose].taken++;
        if (taken < end - begin)
            return begin + taken;
    }
    return -1;
}

#endif
