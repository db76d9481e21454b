/* Threads that sleep between tasks (notes/32-waiting-threads.md).
 *
 * A pool belongs to one problem or one run, which hands it down. Its threads are started by the first task, and joined
 * when the pool is destroyed. Where the system refuses threads the work goes on with those that it gave.
 *
 * Example: co_thread_pool_for(pool, 10, body, context) with 3 threads calls body(context, 0, 3) on the calling thread,
 * body(context, 3, 6) and body(context, 6, 10) on the two others, and returns when all three have returned.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_THREAD_POOL_H
#define CO_BASE_THREAD_POOL_H

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

typedef struct co_thread_pool co_thread_pool;

enum { CO_THREAD_POOL_WORTH = 4096 /* steps of a few operations each from which a second thread is used */ };

/* What each thread 0 .. n_threads - 1 does; 0 is the calling one. */
typedef void co_thread_task(void *context, int32_t thread, int32_t n_threads);

/* Steps begin .. end - 1 of a loop. */
typedef void co_thread_loop(void *context, size_t begin, size_t end);

/* Number of processors that this process may use; at least 1. */
int32_t co_thread_pool_processors(void);

/* A pool of n_threads, the calling one included; 0: as many as processors. ERROR_MEMORY. */
int32_t co_thread_pool_create(int32_t n_threads, co_thread_pool **out, curvopt_error *error);
/* Joins the threads. Accepts NULL. */
void co_thread_pool_destroy(co_thread_pool *pool);

/* The largest n_threads that a task can get. NULL: 1. */
int32_t co_thread_pool_size(const co_thread_pool *pool);

/* Calls the task on every thread, and returns when all have ended. With pool NULL, and where the pool is busy (a task
 * inside a task, a second calling thread), the calling thread does it alone: task(context, 0, 1). */
void co_thread_pool_run(co_thread_pool *pool, co_thread_task *task, void *context);

/* The pool where n steps of a few operations each are worth its waking, or NULL: bits are the same either way. */
static inline co_thread_pool *co_thread_pool_if_worth(co_thread_pool *pool, size_t n) {
    return n >= CO_THREAD_POOL_WORTH ? pool : NULL;
}

/* Steps 0 .. n - 1, an equal part of them for each thread in order: a thread has the same ones in every loop over n. */
void co_thread_pool_for(co_thread_pool *pool, size_t n, co_thread_loop *body, void *context);

/* To be called by a thread of a task that waits for another one, each time that it has looked in vain: looks 0, 1 ...
 * It rests, and at times lets other threads have the processor. */
void co_thread_pool_pause(int looks);

#endif
