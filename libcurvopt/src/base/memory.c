/* Allocation with checked sizes. SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>

#define CACHE_LINE ((size_t)64)

void *co_memory_zeroed(size_t count, size_t size) {
    return calloc(count ? count : 1, size); /* calloc checks the product */
}

void *co_memory_aligned(size_t count, size_t size) {
    if (count == 0)
        count = 1;
    if (count > (SIZE_MAX - CACHE_LINE) / size)
        return NULL;
    size_t bytes = (count * size + CACHE_LINE - 1) / CACHE_LINE * CACHE_LINE;
#ifdef _WIN32 /* its C library aligns to 16 bytes what free() takes: notes/97-vectors-on-windows.md */
    return malloc(bytes);
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
