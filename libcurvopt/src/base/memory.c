/* Allocation with checked sizes. SPDX-License-Identifier: GPL-3.0-or-later */
#define _DEFAULT_SOURCE /* NOLINT: for madvise */

#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>

#define CACHE_LINE ((size_t)64)

#ifdef __linux__
#include <sys/mman.h>
#define PAGE ((size_t)4096) /* the least that the system has; for advice alone */
/* A huge page on most processors, and the least size of a block that has some (notes/36-cancelling.md). */
#define HUGE_PAGE        ((size_t)2 << 20)
#define WORTH_HUGE_PAGES (8 * HUGE_PAGE)

/* Huge pages for a block, where the system gives these on request: a factor of 1.4 GB is given back in hundredths of a
 * second, not in tenths. This is advice: where it is not taken, pages are small. */
static void advise_huge_pages(void *p, size_t bytes) {
    const size_t before = (PAGE - (uintptr_t)p % PAGE) % PAGE;
    if (p && bytes >= WORTH_HUGE_PAGES)
        (void)madvise((char *)p + before, (bytes - before) / PAGE * PAGE, MADV_HUGEPAGE);
}
#endif

void *co_memory_zeroed(size_t count, size_t size) {
    void *p = calloc(count ? count : 1, size); /* calloc checks the product */
#ifdef __linux__
    advise_huge_pages(p, count * size);
#endif
    return p;
}

void *co_memory_aligned(size_t count, size_t size) {
    if (count == 0)
        count = 1;
    if (count > (SIZE_MAX - CACHE_LINE) / size)
        return NULL;
    size_t bytes = (count * size + CACHE_LINE - 1) / CACHE_LINE * CACHE_LINE;
#ifdef _WIN32 /* its C library aligns to 16 bytes what free() takes: notes/97-vectors-on-windows.md */
    return malloc(bytes);
#elif defined __linux__
    const size_t alignment = bytes >= WORTH_HUGE_PAGES ? HUGE_PAGE : CACHE_LINE;
    void *p = bytes <= SIZE_MAX - alignment ? aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment)
                                            : NULL;
    advise_huge_pages(p, bytes);
    return p;
#else
    return aligned_alloc(CACHE_LINE, bytes);
#endif
}

void *co_memory_resize(void *p, size_t count, size_t size) {
    if (count == 0)
        count = 1;
    if (count > SIZE_MAX / size)
        return NULL;
    return realloc(p, count * size); /* unlike calloc, it cannot check the product itself */
}
