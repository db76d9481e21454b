/* The flag that ends a run, as whatever takes long sees it (notes/36-cancelling.md).
 *
 * Between two steps a run ends as soon as the flag is raised, and then chooses its best iterate and resolves its
 * figures. What takes long looks at co_cancel_is_due() instead, which grants all of that a tenth of a second: on most
 * cages the run ends in order, and on large ones it is cut off.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_CANCEL_H
#define CO_BASE_CANCEL_H

#include "base/clock.h"
#include "curvopt.h"

#include <stdatomic.h>
#include <stdint.h>

struct curvopt_cancel {
    atomic_int requested;
};

/* Status of what was not finished because it was cancelled. It goes up like an error, so that everything is freed on
 * the way, but has no message; solve/ turns it into a result, api/ into CURVOPT_ERROR_CANCELLED, and no exported
 * function returns it. */
enum { CO_CANCELLED = -1 };

/* Seconds from when a run sees the flag until it is cut off (notes/36-cancelling.md); more where sanitizers slow all
 * down. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define CO_CANCEL_GRACE 2.0
#else
#define CO_CANCEL_GRACE 0.1
#endif

/* The flag of one run. */
typedef struct co_cancel {
    const curvopt_cancel *flag; /* NULL: nobody can cancel */
    _Atomic int64_t seen;       /* microseconds of co_clock_seconds() at which co_cancel_is_due() saw it; 0: not yet */
} co_cancel;

/* The flag of a call that has nothing to save: what takes long ends as soon as it is raised, without any grace. */
static inline void co_cancel_start_at_once(co_cancel *cancel, const curvopt_cancel *flag) {
    cancel->flag = flag;
    atomic_store(&cancel->seen, INT64_MIN / 2);
}

static inline int co_cancel_is_requested(const curvopt_cancel *flag) {
    return flag && atomic_load_explicit(&flag->requested, memory_order_relaxed);
}

/* Whether what takes long is to end; may be called by several threads. The clock is read only once the flag is raised.
 * NULL: never. */
static inline int co_cancel_is_due(co_cancel *cancel) {
    if (!cancel || !co_cancel_is_requested(cancel->flag))
        return 0;
    const int64_t now = (int64_t)(1e6 * co_clock_seconds()) + 1;
    int64_t seen = 0;
    if (atomic_compare_exchange_strong(&cancel->seen, &seen, now))
        return 0;
    return now - seen > (int64_t)(1e6 * CO_CANCEL_GRACE);
}

#endif
