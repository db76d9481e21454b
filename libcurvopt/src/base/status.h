/* Status codes and the caller's message. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_STATUS_H
#define CO_BASE_STATUS_H

#include "curvopt.h"

#ifdef _WIN32 /* there "printf" means Microsoft's formats */
#define CO_PRINTF gnu_printf
#else
#define CO_PRINTF printf
#endif

/* Fills `error` (may be NULL) with a printf-formatted sentence and returns `code`, for `return co_status_fail(...)`. */
__attribute__((format(CO_PRINTF, 4, 5))) int32_t co_status_fail(curvopt_error *error, int32_t code, int32_t element,
                                                                const char *format, ...);
/* The one sentence for a failed allocation. Inline, so that analyzers see what it returns. */
static inline int32_t co_status_no_memory(curvopt_error *error) {
    co_status_fail(error, CURVOPT_ERROR_MEMORY, -1, "out of memory");
    return CURVOPT_ERROR_MEMORY;
}

#endif
