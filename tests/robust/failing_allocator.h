/* Allocation that fails on demand: the linker sends the library's calls here (--wrap). SPDX-License-Identifier:
 * GPL-3.0-or-later */
#ifndef TEST_FAILING_ALLOCATOR_H
#define TEST_FAILING_ALLOCATOR_H

#include <stdatomic.h>

extern atomic_long allocations, live; /* calls so far; blocks that are not freed */
extern long fail_at;                  /* number of the allocation that fails; -1: none */
extern int failed_in_cholmod; /* the last failure was one of CHOLMOD's, which gets over some of its own: we call neither
                                 malloc nor realloc of a block within a solver */

#endif
