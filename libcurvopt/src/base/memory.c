/* Allocation with checked sizes. SPDX-License-Identifier: GPL-3.0-or-later */
#define _DEFAULT_SOURCE /* NOLINT: for madvise */

#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>

#define CACHE_LINE ((size_t)64)

#ifdef __linux__
#include <sys/mman.h>
/* A huge page on most processors, and the least size of a block that has some (notes/36-cancelling.md). */
#define HUGE_PAGE        ((size_t)2 << 20)
#define WORTH_HUGE_PAGES (8 * HUGE_PAGE)
#endif

void *co_memory_zeroed(size_t count, size_t size) {
    return calloc(count ? count : 1, size); /* calloc checks the product */
}

#ifdef __linux__
/* In huge pages, where the system gives these on request: a factor of 1.4 GB is given back in hundredths of a second,
 * not in tenths. NULL: memory is out. */
static void *huge_pages(size_t bytes) {
    const size_t whole = (bytes + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
    void *p = aligned_alloc(HUGE_PAGE, whole);
    if (p)
        (void)madvise(p, whole, MADV_HUGEPAGE); /* advice: where it is not taken, pages are small */
    return p;
}
#endif

void *co_memory_aligned(size_t count, size_t size) {
    if (count == 0)
        count = 1;
    if (count > (SIZE_MAX - CACHE_LINE) / size)
        return NULL;
    size_t bytes = (count * size + CACHE_LINE - 1) / CACHE_LINE * CACHE_LINE;
#ifdef _WIN32 /* its C library aligns to 16 bytes what free() takes: notes/97-vectors-on-windows.md */
    return malloc(bytes);
#else
#ifdef __linux__
    if (bytes >= WORTH_HUGE_PAGES && bytes <= SIZE_MAX - HUGE_PAGE)
        return huge_pages(bytes);
#endif
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
