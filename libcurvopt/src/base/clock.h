/* A clock for the durations of runs. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_CLOCK_H
#define CO_BASE_CLOCK_H

/* Seconds since some moment, the same one for the whole process; never less than at an earlier call, whatever is done
 * to the system's time of day meanwhile. Only differences mean anything. */
double co_clock_seconds(void);

#endif
