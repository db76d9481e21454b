/* Threads that sleep between tasks. SPDX-License-Identifier: GPL-3.0-or-later */
#define _GNU_SOURCE /* NOLINT: for sched_getaffinity */
#include "base/thread_pool.h"

#include "base/clock.h"
#include "base/memory.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>
#ifdef _WIN32
#include <windows.h>
#else
#include <signal.h>
#include <unistd.h>
#endif

/* A thread that waits looks for so long before it sleeps: most passes follow each other sooner than a thread falls
 * asleep and wakes. Half as long after each time in vain, and twice as long after each with success, between these
 * limits: where other programs use the processors, the thread that it waits for does not run meanwhile
 * (libcurvopt/notes/32-waiting-threads.md). */
static const double LOOKING_SECONDS = 1e-4, LEAST_LOOKING_SECONDS = 2e-6;
enum { LOOKS_AT_A_TIME = 32 };

typedef struct worker {
    co_thread_pool *pool;
    int32_t number; /* 1 .. n_workers; 0 is the calling thread */
    pthread_t thread;
    double looking; /* seconds for which it looks for the next task before it sleeps */
} worker;

struct co_thread_pool {
    int32_t n_threads;  /* wanted, with the calling one */
    int32_t n_workers;  /* threads that were started */
    int is_started;     /* or the start was tried */
    int is_ending;      /* set with the last task_number */
    int may_look;       /* each thread has a processor */
    double looking;     /* seconds for which the caller looks for the end of a task before it sleeps */
    atomic_int is_busy; /* a task runs */
    pthread_mutex_t mutex;
    pthread_cond_t begins, ends; /* of a task */
    atomic_uint task_number;     /* goes up by 1 when a task begins */
    atomic_int n_running;        /* workers that have not ended it */
    co_thread_task *task;
    void *context;
    worker *worker; /* [n_threads - 1] */
};

int32_t co_thread_pool_processors(void) {
#if defined(CO_THREAD_POOL_PROCESSORS) /* a build whose default is another */
    const long n = CO_THREAD_POOL_PROCESSORS;
#elif defined(_WIN32)
    SYSTEM_INFO info;
    GetSystemInfo(&info);
    const long n = (long)info.dwNumberOfProcessors;
#else
    long n = 0;
#if defined(__linux__)
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0)
        n = CPU_COUNT(&set);
#endif
    if (n < 1) /* more than 1024 processors, or another system */
        n = sysconf(_SC_NPROCESSORS_ONLN);
#endif
    return n < 1 ? 1 : n > 1024 ? 1024 : (int32_t)n;
}

int32_t co_thread_pool_create(int32_t n_threads, co_thread_pool **out, curvopt_error *error) {
    co_thread_pool *p = *out = CO_NEW(co_thread_pool, 1);
    if (!p)
        return co_status_no_memory(error);
    const int32_t n_processors = co_thread_pool_processors();
    p->n_threads = n_threads > 0 ? n_threads : n_processors;
    p->may_look = p->n_threads <= n_processors;
    p->looking = LOOKING_SECONDS;
    p->worker = CO_NEW(worker, p->n_threads - 1);
    if (!p->worker)
        goto no_worker;
    if (pthread_mutex_init(&p->mutex, NULL) != 0)
        goto no_mutex;
    if (pthread_cond_init(&p->begins, NULL) != 0)
        goto no_begins;
    if (pthread_cond_init(&p->ends, NULL) == 0)
        return CURVOPT_OK;
    pthread_cond_destroy(&p->begins);
no_begins:
    pthread_mutex_destroy(&p->mutex);
no_mutex:
    free(p->worker);
no_worker:
    free(p);
    *out = NULL;
    return co_status_no_memory(error);
}

int32_t co_thread_pool_size(const co_thread_pool *p) {
    return p ? p->n_threads : 1;
}

static inline void relax(void) {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("yield");
#endif
}

void co_thread_pool_pause(int looks) {
    if ((looks + 1) % LOOKS_AT_A_TIME)
        relax();
    else
        sched_yield();
}

static int is_next(const co_thread_pool *p, unsigned last) {
    return atomic_load_explicit(&p->task_number, memory_order_acquire) != last;
}

static int has_ended(const co_thread_pool *p) {
    return atomic_load_explicit(&p->n_running, memory_order_acquire) == 0;
}

/* Until the task after number `last`, or where that is NULL the end of the present one; for *seconds at most. Threads
 * without a processor of their own would take it from each other, and do not look. */
static void look(const co_thread_pool *p, const unsigned *last, double *seconds) {
    if (!p->may_look)
        return;
    for (const double begin = co_clock_seconds(); co_clock_seconds() - begin < *seconds;)
        for (int k = 0; k < LOOKS_AT_A_TIME; k++) {
            if (last ? is_next(p, *last) : has_ended(p)) {
                *seconds = *seconds < LOOKING_SECONDS / 2 ? 2 * *seconds : LOOKING_SECONDS;
                return;
            }
            relax();
        }
    *seconds = *seconds > 2 * LEAST_LOOKING_SECONDS ? *seconds / 2 : LEAST_LOOKING_SECONDS;
}

/* Waits for the task after number `last`, and returns its number. */
static unsigned next_task(worker *me, unsigned last) {
    co_thread_pool *p = me->pool;
    look(p, &last, &me->looking);
    pthread_mutex_lock(&p->mutex);
    while (!is_next(p, last))
        pthread_cond_wait(&p->begins, &p->mutex);
    pthread_mutex_unlock(&p->mutex);
    return last + 1;
}

static void *work(void *argument) {
    worker *me = argument;
    co_thread_pool *p = me->pool;
    for (unsigned number = 0;;) {
        number = next_task(me, number);
        if (p->is_ending)
            return NULL;
        p->task(p->context, me->number, p->n_workers + 1);
        pthread_mutex_lock(&p->mutex);
        const int is_last = atomic_fetch_sub_explicit(&p->n_running, 1, memory_order_release) == 1;
        pthread_mutex_unlock(&p->mutex);
        if (is_last)
            pthread_cond_signal(&p->ends);
    }
}

/* Starts the workers. Signals stay with the program's own threads. */
static void start(co_thread_pool *p) {
    p->is_started = 1;
#ifndef _WIN32
    sigset_t all, before;
    sigfillset(&all);
    const int is_masked = pthread_sigmask(SIG_SETMASK, &all, &before) == 0;
#endif
    while (p->n_workers < p->n_threads - 1) {
        worker *w = &p->worker[p->n_workers];
        *w = (worker){.pool = p, .number = p->n_workers + 1, .looking = LOOKING_SECONDS};
        if (pthread_create(&w->thread, NULL, work, w) != 0)
            break;
        p->n_workers++;
    }
#ifndef _WIN32
    if (is_masked)
        pthread_sigmask(SIG_SETMASK, &before, NULL);
#endif
}

/* Wakes the workers for what stands in the pool. */
static void begin(co_thread_pool *p) {
    pthread_mutex_lock(&p->mutex);
    atomic_store_explicit(&p->n_running, p->n_workers, memory_order_relaxed);
    atomic_fetch_add_explicit(&p->task_number, 1, memory_order_release);
    pthread_mutex_unlock(&p->mutex);
    pthread_cond_broadcast(&p->begins); /* after: whoever wakes finds the mutex free */
}

static void wait_for_workers(co_thread_pool *p) {
    look(p, NULL, &p->looking);
    pthread_mutex_lock(&p->mutex);
    while (!has_ended(p))
        pthread_cond_wait(&p->ends, &p->mutex);
    pthread_mutex_unlock(&p->mutex);
}

void co_thread_pool_destroy(co_thread_pool *p) {
    if (!p)
        return;
    p->is_ending = 1;
    begin(p);
    for (int32_t k = 0; k < p->n_workers; k++)
        pthread_join(p->worker[k].thread, NULL);
    pthread_cond_destroy(&p->ends);
    pthread_cond_destroy(&p->begins);
    pthread_mutex_destroy(&p->mutex);
    free(p->worker);
    free(p);
}

void co_thread_pool_run(co_thread_pool *p, co_thread_task *task, void *context) {
    if (!p || p->n_threads < 2 || atomic_exchange_explicit(&p->is_busy, 1, memory_order_acquire)) {
        task(context, 0, 1);
        return;
    }
    if (!p->is_started)
        start(p);
    p->task = task;
    p->context = context;
    if (p->n_workers > 0)
        begin(p);
    task(context, 0, p->n_workers + 1);
    if (p->n_workers > 0)
        wait_for_workers(p);
    atomic_store_explicit(&p->is_busy, 0, memory_order_release);
}

typedef struct loop {
    co_thread_loop *body;
    void *context;
    size_t n;
} loop;

static void run_part(void *context, int32_t thread, int32_t n_threads) {
    const loop *l = context;
    const size_t begin = l->n * (size_t)thread / (size_t)n_threads;
    const size_t end = l->n * ((size_t)thread + 1) / (size_t)n_threads;
    if (begin < end)
        l->body(l->context, begin, end);
}

void co_thread_pool_for(co_thread_pool *p, size_t n, co_thread_loop *body, void *context) {
    loop l = {.body = body, .context = context, .n = n};
    co_thread_pool_run(p, run_part, &l);
}
