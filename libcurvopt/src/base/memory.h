/* Allocation with checked sizes. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_MEMORY_H
#define CO_BASE_MEMORY_H

#include <stddef.h>

#ifdef _WIN32
#define CO_MEMORY_ALIGNMENT 16
#else
#define CO_MEMORY_ALIGNMENT 64 /* a cache line */
#endif

/* `count` zeroed elements of `size` bytes; NULL when the product overflows or memory is out. Never NULL for count 0.
 * Free with free(). */
void *co_memory_zeroed(size_t count, size_t size);
/* `count` elements of `size` bytes, aligned to CO_MEMORY_ALIGNMENT for vector loads and not zeroed; NULL as above. Free
 * with free(). */
void *co_memory_aligned(size_t count, size_t size);
/* Block p (NULL: none yet), moved to one of `count` elements of `size` bytes; what is new is not zeroed. NULL when the
 * product overflows or memory is out, and then p is still there. Never NULL for count 0. Free with free(). */
void *co_memory_resize(void *p, size_t count, size_t size);

/* p = CO_NEW(type, n): typed allocation, so that element size and pointer cannot disagree. */
#define CO_NEW(type, count)         ((type *)co_memory_zeroed((size_t)(count), sizeof(type)))
#define CO_NEW_ALIGNED(type, count) ((type *)co_memory_aligned((size_t)(count), sizeof(type)))
/* q = CO_RESIZED(p, n): a block of n elements like *p with what p held; p must not be used again unless q is NULL. */
#define CO_RESIZED(p, count) co_memory_resize((p), (size_t)(count), sizeof *(p))

#endif
