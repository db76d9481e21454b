/* Pieces dealt out to threads: each is done once, whatever the threads do meanwhile, and threads that nothing delays do
 * the same ones again. SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 199309L /* NOLINT: for nanosleep */
#include "check.h"

#include "base/thread_pool.h"
#include "base/work_sharing.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>

enum { MOST_THREADS = 7, MOST_PIECES = 1000 };

/* Thread that did each piece; every one but thread `quick` waits before its first until that one has taken three
 * quarters of all, -1: none does. */
typedef struct dealing {
    co_work_sharing deal[MOST_THREADS];
    int32_t n, quick;
    atomic_int n_quick; /* pieces that it has taken */
    int done_by[MOST_PIECES];
    atomic_int times[MOST_PIECES];
} dealing;

static void take_pieces(void *context, int32_t thread, int32_t n_threads) {
    dealing *d = context;
    co_work_sharing_thread me = {.thread = thread, .n_threads = n_threads};
    int32_t k;
    while (d->quick >= 0 && thread != d->quick && atomic_load(&d->n_quick) < 3 * d->n / 4)
        nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL);
    while ((k = co_work_sharing_next(d->deal, d->n, &me)) >= 0) {
        if (k >= d->n)
            abort();
        atomic_fetch_add(&d->times[k], 1);
        d->done_by[k] = thread;
        atomic_fetch_add(&d->n_quick, thread == d->quick);
    }
}

static void deal_out(int32_t n, int threads, int quick, dealing *d) {
    co_thread_pool *pool;
    curvopt_error error;
    CHECK_OK(co_thread_pool_create(threads, &pool, &error), &error);
    co_work_sharing_start(d->deal, threads);
    d->n = n;
    d->quick = quick;
    atomic_store(&d->n_quick, 0);
    for (int k = 0; k < MOST_PIECES; k++)
        atomic_store(&d->times[k], 0);
    co_thread_pool_run(pool, take_pieces, d);
    co_thread_pool_destroy(pool);
}

static void test_every_piece_is_done_once(void **state) {
    static dealing d;
    (void)state;
    for (int threads = 1; threads <= MOST_THREADS; threads++)
        for (int32_t n = 0; n <= MOST_PIECES; n = n < 20 ? n + 1 : n * 2 + 13)
            for (int quick = -1; quick < threads; quick += threads) {
                deal_out(n, threads, quick, &d);
                for (int32_t k = 0; k < n; k++)
                    assert_int_equal(atomic_load(&d.times[k]), 1);
            }
}

static void test_early_threads_help(void **state) {
    static dealing d;
    int by_quick = 0;
    (void)state;
    deal_out(MOST_PIECES, 2, 1, &d);
    for (int k = 0; k < MOST_PIECES / 2; k++)
        by_quick += d.done_by[k] == 1;
    assert_in_range(by_quick, MOST_PIECES / 4, MOST_PIECES);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_piece_is_done_once),
        cmocka_unit_test(test_early_threads_help),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
