/* Static assignment of work to threads, with stealing. Each thread gets the same pieces in every pass over the faces,
 * so that what it wrote in one pass is still in its own cache in the next. A thread that is done early takes pieces
 * from the others: neither pieces of unequal cost nor a busy core hold anyone up
 * (notes/31-work-sharing-between-threads.md).
 *
 * Example: 10 pieces, 3 threads. Thread 0 owns 0 1 2, thread 1 owns 3 4 5, thread 2 owns 6 7 8 9. Thread 0, done with
 * its three, asks thread 1's counter, then thread 2's, and takes the next piece of each that is left there.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_WORK_SHARING_H
#define CO_BASE_WORK_SHARING_H

#include <stdatomic.h>
#include <stdint.h>

/* Counter of one thread. It fills two cache lines, so that no two threads write to the same one. */
typedef struct co_work_sharing {
    _Atomic int32_t taken;   /* number of the thread's own pieces that have been taken, by whichever thread */
    int32_t other_lines[31]; /* padding to 128 bytes */
} co_work_sharing;

/* Resets the counters sharing [n_threads]; to be called before the threads' task begins. */
static inline void co_work_sharing_start(co_work_sharing *sharing, int32_t n_threads) {
    for (int32_t k = 0; k < n_threads; k++)
        atomic_init(&sharing[k].taken, 0);
}

/* A thread of a task (thread_pool.h), as co_work_sharing_next() sees it. */
typedef struct co_work_sharing_thread {
    int32_t thread, n_threads; /* the task's; at most as many threads as there are counters */
    int32_t helped;            /* 0 at first: number of threads whose own pieces this one has found all taken */
} co_work_sharing_thread;

/* Takes a piece 0 .. n - 1 that nobody has taken yet and returns its number; -1 if there is none. To be called by every
 * thread of the task. */
static inline int32_t co_work_sharing_next(co_work_sharing *sharing, int32_t n, co_work_sharing_thread *me) {
    const int64_t threads = me->n_threads;
    for (; me->helped < threads; me->helped++) {
        int64_t whose = ((int64_t)me->thread + me->helped) % threads;
        int32_t begin = (int32_t)(n * whose / threads), end = (int32_t)(n * (whose + 1) / threads);
        int32_t taken = atomic_fetch_add_explicit(&sharing[whose].taken, 1, memory_order_relaxed);
        if (taken < end - begin)
            return begin + taken;
    }
    return -1;
}

#endif
