/* A clock for the durations of runs: POSIX's monotonic one. C11's timespec_get knows the time of day alone, which jumps
 * when it is set, by hand or by the network. SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 199309L /* for clock_gettime, which C11 does not have */
#include "base/clock.h"

#include <time.h>

double co_clock_seconds(void) {
    struct timespec t = {0};
    clock_gettime(CLOCK_MONOTONIC, &t); /* cannot fail: every Linux has this clock */
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
