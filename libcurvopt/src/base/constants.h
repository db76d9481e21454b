/* Numbers of mathematics. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_CONSTANTS_H
#define CO_BASE_CONSTANTS_H

/* pi to the 33 decimals that long double needs on any machine, and rounded to double; C11 itself names no constant. */
#define CO_PI_LONG 3.14159265358979323846264338327950288L
#define CO_PI      ((double)CO_PI_LONG)

#endif
