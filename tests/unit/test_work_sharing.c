/* Pieces dealt out to threads: each is done once, whatever the threads do meanwhile, and threads that nothing delays do
 * the same ones again. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "base/work_sharing.h"

#include <stdlib.h>
#include <time.h>

enum { MOST_THREADS = 7, MOST_PIECES = 1000 };

/* Thread that did each piece; every one but thread `quick` waits before its first, -1: none does. */
static void deal_out(int32_t n, int threads, int quick, int *done_by, int *times) {
    co_work_sharing deal[MOST_THREADS];
    co_work_sharing_start(deal, threads);
    memset(times, 0, sizeof *times * MOST_PIECES);
#pragma omp parallel num_threads(threads)
    {
        int32_t k, helped = 0;
        if (quick >= 0 && omp_get_thread_num() != quick)
            nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
        while ((k = co_work_sharing_next(deal, n, &helped)) >= 0) {
            assert_in_range(k, 0, n - 1);
#pragma omp atomic
            times[k]++;
            done_by[k] = omp_get_thread_num();
        }
    }
}

static void test_every_piece_is_done_once(void **state) {
    static int done_by[MOST_PIECES], times[MOST_PIECES];
    (void)state;
    for (int threads = 1; threads <= MOST_THREADS; threads++)
        for (int32_t n = 0; n <= MOST_PIECES; n = n < 20 ? n + 1 : n * 2 + 13)
            for (int quick = -1; quick < threads; quick += threads) {
                deal_out(n, threads, quick, done_by, times);
                for (int32_t k = 0; k < n; k++)
                    assert_int_equal(times[k], 1);
            }
}

static void test_early_threads_help(void **state) {
    static int done_by[MOST_PIECES], times[MOST_PIECES];
    int by_quick = 0;
    (void)state;
    deal_out(MOST_PIECES, 2, 1, done_by, times);
    for (int k = 0; k < MOST_PIECES / 2; k++)
        by_quick += done_by[k] == 1;
    assert_in_range(by_quick, MOST_PIECES / 4, MOST_PIECES);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_piece_is_done_once),
        cmocka_unit_test(test_early_threads_help),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
