/* A pool of threads: every thread does its part once, sums keep their order, tasks inside tasks are serial, and threads
 * that cannot be started are done without. SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 199309L /* NOLINT: for nanosleep */
#include "check.h"
#include "cpu_time.h"

#include "base/ordered_sum.h"
#include "base/thread_pool.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>

enum { MOST_THREADS = 9, TASKS = 2000 };

static atomic_int n_created, n_allowed = 1000;

int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument);

/* Fails when as many threads as are allowed have been created. */
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument) {
    if (atomic_fetch_add(&n_created, 1) >= atomic_load(&n_allowed))
        return 11; /* EAGAIN */
    return __real_pthread_create(thread, attributes, start, argument);
}

static co_thread_pool *create(int32_t n_threads) {
    co_thread_pool *pool;
    curvopt_error error;
    CHECK_OK(co_thread_pool_create(n_threads, &pool, &error), &error);
    assert_int_equal(co_thread_pool_size(pool), n_threads);
    return pool;
}

/* Which threads took part in a task. Assertions are the main thread's: cmocka jumps out of them. */
typedef struct attendance {
    co_thread_pool *pool;
    atomic_int times[MOST_THREADS], n_threads, inner;
} attendance;

static void attend(void *context, int32_t thread, int32_t n_threads) {
    attendance *a = context;
    atomic_fetch_add(&a->times[thread], 1);
    atomic_store(&a->n_threads, n_threads);
}

static void test_each_thread_takes_part_once(void **state) {
    (void)state;
    for (int n = 1; n <= MOST_THREADS; n++) {
        attendance a = {.pool = create(n)};
        for (int k = 0; k < TASKS; k++)
            co_thread_pool_run(a.pool, attend, &a);
        co_thread_pool_destroy(a.pool);
        assert_int_equal(a.n_threads, n);
        for (int k = 0; k < n; k++)
            assert_int_equal(a.times[k], TASKS);
    }
}

typedef struct steps {
    size_t n;
    int times[1000];
    double chunk[CO_ORDERED_SUM_CHUNKS];
} steps;

static void count_steps(void *context, size_t begin, size_t end) {
    steps *s = context;
    for (size_t k = begin; k < end; k++)
        s->times[k]++;
}

static void test_loops_do_each_step_once(void **state) {
    static steps s;
    (void)state;
    for (int threads = 1; threads <= MOST_THREADS; threads++) {
        co_thread_pool *pool = create(threads);
        for (size_t n = 0; n < 1000; n = n < 20 ? n + 1 : n * 2 + 13) {
            s = (steps){.n = n};
            co_thread_pool_for(pool, n, count_steps, &s);
            for (size_t k = 0; k < 1000; k++)
                assert_int_equal(s.times[k], k < n);
        }
        co_thread_pool_destroy(pool);
    }
    s = (steps){.n = 1000};
    co_thread_pool_for(NULL, 1000, count_steps, &s);
    assert_int_equal(s.times[999], 1);
}

static void sum_chunks(void *context, size_t begin, size_t end) {
    steps *s = context;
    for (int k = (int)begin; k < (int)end; k++) {
        s->chunk[k] = 0;
        for (size_t i = co_ordered_sum_begin(s->n, k); i < co_ordered_sum_begin(s->n, k + 1); i++)
            s->chunk[k] += 1 / (1 + (double)i); /* rounded otherwise in another order */
    }
}

static void test_sums_have_the_same_bits(void **state) {
    static steps s;
    double of_one = 0;
    (void)state;
    for (int threads = 1; threads <= MOST_THREADS; threads++) {
        co_thread_pool *pool = create(threads);
        double sum = 0;
        s = (steps){.n = 100003};
        co_ordered_sum_run(pool, s.n, sum_chunks, &s);
        for (int k = 0; k < CO_ORDERED_SUM_CHUNKS; k++)
            sum += s.chunk[k];
        of_one = threads == 1 ? sum : of_one;
        assert_memory_equal(&sum, &of_one, sizeof sum);
        co_thread_pool_destroy(pool);
    }
}

static void count_inner(void *context, int32_t thread, int32_t n_threads) {
    attendance *a = context;
    if (thread == 0 && n_threads == 1)
        atomic_fetch_add(&a->inner, 1);
}

static void nest(void *context, int32_t thread, int32_t n_threads) {
    attendance *a = context;
    (void)thread;
    (void)n_threads;
    co_thread_pool_run(a->pool, count_inner, a);
}

static void test_a_task_inside_a_task_is_serial(void **state) {
    attendance a = {.pool = create(4)};
    (void)state;
    co_thread_pool_run(a.pool, nest, &a);
    assert_int_equal(a.inner, 4);
    co_thread_pool_run(a.pool, attend, &a);
    assert_int_equal(a.n_threads, 4);
    co_thread_pool_destroy(a.pool);
}

static void test_fewer_threads_do_the_same_work(void **state) {
    static steps s;
    (void)state;
    for (int allowed = 0; allowed < 4; allowed++) {
        attendance a = {.pool = create(5)};
        atomic_store(&n_created, 0);
        atomic_store(&n_allowed, allowed);
        co_thread_pool_run(a.pool, attend, &a);
        assert_int_equal(a.n_threads, allowed + 1);
        for (int k = 0; k < MOST_THREADS; k++)
            assert_int_equal(a.times[k], k <= allowed);
        s = (steps){.n = 100};
        co_thread_pool_for(a.pool, 100, count_steps, &s);
        for (int k = 0; k < 100; k++)
            assert_int_equal(s.times[k], 1);
        assert_int_equal(n_created, allowed + 1); /* it is not tried again at each task */
        atomic_store(&n_allowed, 1000);
        co_thread_pool_destroy(a.pool);
    }
}

static void test_threads_are_started_by_the_first_task(void **state) {
    (void)state;
    atomic_store(&n_created, 0);
    co_thread_pool *pool = create(3);
    assert_int_equal(n_created, 0);
    attendance a = {.pool = pool};
    co_thread_pool_run(pool, attend, &a);
    assert_int_equal(n_created, 2);
    co_thread_pool_destroy(pool);
    co_thread_pool_destroy(create(3)); /* none was started */
    co_thread_pool_destroy(NULL);
    assert_int_equal(co_thread_pool_size(NULL), 1);
    assert_true(co_thread_pool_processors() >= 1);
}

static void sleep_first(void *context, int32_t thread, int32_t n_threads) {
    (void)context;
    (void)n_threads;
    if (thread == 0)
        nanosleep(&(struct timespec){.tv_nsec = 300000000}, NULL);
}

/* Threads that wait take no processor time: 3 of them wait for 0.3 s. */
static void test_waiting_threads_sleep(void **state) {
    co_thread_pool *pool = create(4);
    (void)state;
    co_thread_pool_run(pool, sleep_first, NULL);
    const double before = cpu_seconds();
    co_thread_pool_run(pool, sleep_first, NULL);
    nanosleep(&(struct timespec){.tv_nsec = 300000000}, NULL);
    assert_true(cpu_seconds() - before < 0.05);
    co_thread_pool_destroy(pool);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_each_thread_takes_part_once),
        cmocka_unit_test(test_loops_do_each_step_once),
        cmocka_unit_test(test_sums_have_the_same_bits),
        cmocka_unit_test(test_a_task_inside_a_task_is_serial),
        cmocka_unit_test(test_fewer_threads_do_the_same_work),
        cmocka_unit_test(test_threads_are_started_by_the_first_task),
        cmocka_unit_test(test_waiting_threads_sleep),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
