/* Allocation with checked sizes. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_MEMORY_H
#define CO_BASE_MEMORY_H

#include <stddef.h>

/* `count` zeroed elements of `size` bytes; NULL when the product overflows or memory is out. Never NULL for count 0.
 * Free with free(). */
void *co_memory_zeroed(size_t count, size_t size);
/* The same, aligned to a cache line for vector loads, not zeroed. Free with free(). */
void *co_memory_aligned(size_t count, size_t size);

/* p = CO_NEW(type, n): typed allocation, so that element size and pointer cannot disagree. */
#define CO_NEW(type, count)         ((type *)co_memory_zeroed((size_t)(count), sizeof(type)))
#define CO_NEW_ALIGNED(type, count) ((type *)co_memory_aligned((size_t)(count), sizeof(type)))

#endif
