/* Allocation that fails on demand. SPDX-License-Identifier: GPL-3.0-or-later */
#include "failing_allocator.h"

#include "check.h"

#include <stdlib.h>
#include <string.h>

atomic_long allocations, live;
long fail_at = -1;
int failed_in_cholmod;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void __real_free(void *p);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);
void __wrap_free(void *p);

static int fails(void) {
    return atomic_fetch_add(&allocations, 1) == fail_at;
}

static void *counted(void *p) {
    if (p)
        atomic_fetch_add(&live, 1);
    return p;
}

void *__wrap_malloc(size_t size) {
    failed_in_cholmod |= atomic_load(&allocations) == fail_at;
    return fails() ? NULL : counted(__real_malloc(size));
}

void *__wrap_calloc(size_t count, size_t size) {
    return fails() ? NULL : counted(__real_calloc(count, size));
}

void *__wrap_realloc(void *old, size_t size) {
    if (fails()) {
        failed_in_cholmod |= old != NULL;
        return NULL;
    }
    void *p = __real_realloc(old, size);
    return old ? p : counted(p);
}

#ifndef _WIN32 /* its C library has no aligned_alloc */
void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);

void *__wrap_aligned_alloc(size_t alignment, size_t size) {
    return fails() ? NULL : counted(__real_aligned_alloc(alignment, size));
}
#endif

void __wrap_free(void *p) {
    if (p)
        atomic_fetch_sub(&live, 1);
    __real_free(p);
}

#ifndef FAILURES_APART /* more than 1 in qemu, where each would take 2000 s */
#ifdef __SANITIZE_ADDRESS__
#define FAILURES_APART 5 /* six times as slow; without the sanitizer all are tried */
#else
#define FAILURES_APART 1
#endif
#endif
enum { FIRST_FAILURES = 30 }; /* of each run, all of them, whatever FAILURES_APART is */

void fail_every_allocation(failing_run *run, void *context, long least) {
    curvopt_error error;
    CHECK_OK(run(context, &error), &error); /* whatever libraries keep for good is there now */
    long blocks = atomic_load(&live), n = 0, met;
    const int apart = FAILURES_APART;
    int has_failed;
    do {
        memset(&error, 0, sizeof error);
        atomic_store(&allocations, 0);
        failed_in_cholmod = 0;
        fail_at = n;
        int32_t status = run(context, &error);
        fail_at = -1;
        met = atomic_load(&allocations);
        if (met > n && !(status == CURVOPT_OK && failed_in_cholmod))
            CHECK_REFUSED(status, &error, CURVOPT_ERROR_MEMORY, -1, "memory");
        else
            CHECK_OK(status, &error);
        CHECK_INT(atomic_load(&live), blocks);
        has_failed = met > n;
        n += n < FIRST_FAILURES ? 1 : apart;
    } while (has_failed);
    CHECK_TRUE(n > least); /* a lower bound on what was tried: the wrapping works */
}
