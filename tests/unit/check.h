/* Checks that say what was expected, what came, and what would have passed. SPDX-License-Identifier: GPL-3.0-or-later
 */
#ifndef TEST_CHECK_H
#define TEST_CHECK_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "curvopt.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* |got - expected| <= tolerance; NAN never passes. */
#define CHECK_NEAR(got, expected, tolerance)                                                                           \
    check_near((double)(got), (double)(expected), (double)(tolerance), #got, __FILE__, __LINE__)
/* low <= got <= high */
#define CHECK_BETWEEN(got, low, high)                                                                                  \
    check_between((double)(got), (double)(low), (double)(high), #got, __FILE__, __LINE__)
#define CHECK_INT(got, expected) check_integer((long long)(got), (long long)(expected), #got, __FILE__, __LINE__)
#define CHECK_TRUE(condition)    check_true((condition) != 0, #condition, __FILE__, __LINE__)
#define CHECK_TEXT(got, part)    check_text((got), (part), #got, __FILE__, __LINE__)
/* A call that must succeed; `error` (curvopt_error *) gives the message if it does not. */
#define CHECK_OK(status, error) check_status((status), CURVOPT_OK, (error), NULL, __FILE__, __LINE__)
/* A call that must be refused with this code, this element, and a message that contains `part`. */
#define CHECK_REFUSED(status, error, code, element, part)                                                              \
    check_refused((status), (error), (code), (element), (part), __FILE__, __LINE__)

static inline void check_near(double got, double expected, double tolerance, const char *what, const char *file,
                              int line) {
    if (fabs(got - expected) <= tolerance)
        return;
    print_error("%s: expected %.17g, got %.17g, off by %.3g, tolerance %.3g\n", what, expected, got,
                fabs(got - expected), tolerance);
    _fail(file, line);
    abort(); /* never reached, which analyzers want to hear */
}

static inline void check_between(double got, double low, double high, const char *what, const char *file, int line) {
    if (got >= low && got <= high)
        return;
    print_error("%s: expected %.17g to %.17g, got %.17g\n", what, low, high, got);
    _fail(file, line);
    abort();
}

static inline void check_integer(long long got, long long expected, const char *what, const char *file, int line) {
    if (got == expected)
        return;
    print_error("%s: expected %lld, got %lld\n", what, expected, got);
    _fail(file, line);
    abort();
}

static inline void check_true(int holds, const char *what, const char *file, int line) {
    if (holds)
        return;
    print_error("does not hold: %s\n", what);
    _fail(file, line);
    abort();
}

static inline void check_text(const char *got, const char *part, const char *what, const char *file, int line) {
    if (got && strstr(got, part))
        return;
    print_error("%s: expected something with \"%s\", got \"%s\"\n", what, part, got ? got : "(null)");
    _fail(file, line);
    abort();
}

static inline void check_status(int32_t got, int32_t expected, const curvopt_error *error, const char *part,
                                const char *file, int line) {
    if (got != expected) {
        print_error("status: expected %d, got %d: %s\n", (int)expected, (int)got,
                    error && got != CURVOPT_OK ? error->message : "");
        _fail(file, line);
        abort();
    }
    if (part)
        check_text(error->message, part, "message", file, line);
}

static inline void check_refused(int32_t got, const curvopt_error *error, int32_t code, int32_t element,
                                 const char *part, const char *file, int line) {
    check_status(got, code, error, part, file, line);
    check_integer(error->code, code, "error.code", file, line);
    check_integer(error->element, element, "error.element", file, line);
    check_true(memchr(error->message, 0, sizeof error->message) != NULL, "message is terminated", file, line);
}

/* Whether the longer version of a test is wanted: CURVOPT_LONG=1 in the environment. */
static inline bool long_tests(void) {
    const char *wanted = getenv("CURVOPT_LONG");
    return wanted && strcmp(wanted, "1") == 0;
}

/* Numbers in -1..1 that are the same everywhere (Marsaglia's xorshift). */
static inline double check_random(uint64_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (double)(*state >> 11) / 4503599627370496.0 - 1;
}

/* The exponent p of error ~ h^p from errors at h and h / 2. */
static inline double check_order(double coarse_error, double fine_error) {
    return log2(coarse_error / fine_error);
}

#endif
