/* Preloaded into one rank, lets one of its allocations fail: number FAILING_RANK_AT, from 1 on, of those that
 * curvopt-tao and libcurvopt make; what MPI and PETSc allocate for themselves is not counted. At the end the file
 * FAILING_RANK_COUNT gets how many there were.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);

static atomic_long calls;
static long fails_at; /* 0: none; set before any thread is made */

__attribute__((constructor)) static void begin(void) {
    const char *at = getenv("FAILING_RANK_AT");
    fails_at = at ? atol(at) : 0;
    atomic_store(&calls, 0);
}

__attribute__((destructor)) static void end(void) {
    const char *path = getenv("FAILING_RANK_COUNT");
    FILE *f = path ? fopen(path, "w") : NULL;
    if (f) {
        fprintf(f, "%ld\n", atomic_load(&calls));
        fclose(f);
    }
}

/* dladdr() allocates nothing. */
static int fails(const void *caller) {
    Dl_info info;
    if (!dladdr(caller, &info) || !info.dli_fname)
        return 0;
    const char *slash = strrchr(info.dli_fname, '/'), *name = slash ? slash + 1 : info.dli_fname;
    if (strncmp(name, "libcurvopt", 10) != 0 && strcmp(name, "curvopt-tao") != 0)
        return 0;
    return atomic_fetch_add(&calls, 1) + 1 == fails_at;
}

void *malloc(size_t size) {
    return fails(__builtin_return_address(0)) ? NULL : __libc_malloc(size);
}

void *calloc(size_t count, size_t size) {
    return fails(__builtin_return_address(0)) ? NULL : __libc_calloc(count, size);
}

void *aligned_alloc(size_t alignment, size_t size) {
    return fails(__builtin_return_address(0)) ? NULL : __libc_memalign(alignment, size);
}
