/* Allocation that fails on demand: the linker sends the library's calls here (--wrap). SPDX-License-Identifier:
 * GPL-3.0-or-later */
#ifndef TEST_FAILING_ALLOCATOR_H
#define TEST_FAILING_ALLOCATOR_H

#include "curvopt.h"

#include <stdatomic.h>

extern atomic_long allocations, live; /* calls so far; blocks that are not freed */
extern long fail_at;                  /* number of the allocation that fails; -1: none */
extern int failed_in_cholmod; /* the last failure was one of CHOLMOD's, which gets over some of its own: we call neither
                                 malloc nor realloc of a block within a solver */

/* Something to try; the same every time. */
typedef int32_t failing_run(void *context, curvopt_error *error);

/* Fails allocation 0, 1, 2, ... of a run (in qemu the first 30 and every 17th, under the address sanitizer
 * the first 30 and every third) until one gets by without meeting the
 * one that would fail; at least so many. Every failure is reported as ERROR_MEMORY and leaves as many blocks as there
 * were. CHOLMOD gets over some of its own failures (it gives memory back by reallocating, and tries another ordering):
 * such runs, and no others, may come to their end. */
void fail_every_allocation(failing_run *run, void *context, long least);

#endif
