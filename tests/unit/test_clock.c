/* The clock runs with real time, and forwards while the time of day is set back. The linker (--wrap) puts the functions
 * below in place of those that tell the time. SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 199309L
#include "check.h"

#include "base/clock.h"

#include <time.h>

int __real_clock_gettime(clockid_t clock, struct timespec *t);
time_t __real_time(time_t *t);
int __wrap_clock_gettime(clockid_t clock, struct timespec *t);
time_t __wrap_time(time_t *t);

/* An hour earlier with each call. */
static time_t set_back(void) {
    static time_t hours;
    return 3600 * ++hours;
}

#ifndef _WIN32 /* its C library has no timespec_get */
int __real_timespec_get(struct timespec *t, int base);
int __wrap_timespec_get(struct timespec *t, int base);

int __wrap_timespec_get(struct timespec *t, int base) {
    int result = __real_timespec_get(t, base);
    t->tv_sec -= set_back();
    return result;
}
#endif

int __wrap_clock_gettime(clockid_t clock, struct timespec *t) {
    int result = __real_clock_gettime(clock, t);
    if (clock == CLOCK_REALTIME)
        t->tv_sec -= set_back();
    return result;
}

time_t __wrap_time(time_t *t) {
    time_t now = __real_time(NULL) - set_back();
    if (t)
        *t = now;
    return now;
}

static void test_never_runs_backwards(void **state) {
    (void)state;
    double last = co_clock_seconds();
    for (int i = 0; i < 1000; i++) {
        double now = co_clock_seconds();
        CHECK_TRUE(now >= last);
        last = now;
    }
}

static void test_runs_in_seconds(void **state) {
    (void)state;
    double begin = co_clock_seconds();
    nanosleep(&(struct timespec){.tv_nsec = 30000000}, NULL);
    CHECK_BETWEEN(co_clock_seconds() - begin, 0.03, 20); /* a busy machine may wake us late */
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_never_runs_backwards),
                                       cmocka_unit_test(test_runs_in_seconds)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
