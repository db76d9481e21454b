/* Processor time of the process. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEST_CPU_TIME_H
#define TEST_CPU_TIME_H

#include <time.h>
#ifdef _WIN32
#include <windows.h>
#endif

/* Seconds on all threads. Microsoft's clock() tells the time since the process began instead. */
static inline double cpu_seconds(void) {
#ifdef _WIN32
    FILETIME created, ended, kernel = {0}, user = {0};
    GetProcessTimes(GetCurrentProcess(), &created, &ended, &kernel, &user);
    return 429.4967296 * ((double)kernel.dwHighDateTime + (double)user.dwHighDateTime) + /* units of 100 ns */
           1e-7 * ((double)kernel.dwLowDateTime + (double)user.dwLowDateTime);
#else
    return (double)clock() / CLOCKS_PER_SEC;
#endif
}

#endif
