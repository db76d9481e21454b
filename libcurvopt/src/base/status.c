/* Status codes and the caller's message. SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>

int32_t co_status_fail(curvopt_error *error, int32_t code, int32_t element, const char *format, ...) {
    if (!error)
        return code;
    error->code = code;
    error->element = element;
    va_list arguments;
    va_start(arguments, format);
    /* clang-tidy 14 forgets va_start when it has analyzed other files before. NOLINTNEXTLINE(clang-analyzer-valist*) */
    vsnprintf(error->message, sizeof error->message, format, arguments);
    va_end(arguments);
    return code;
}
