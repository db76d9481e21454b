/* The machine's multiply-add rate, by chains that do not wait for each other: what a kernel could reach at most.
 * Compiled once per instruction set, like the library's sweeps. SPDX-License-Identifier: GPL-3.0-or-later */
#include "peak.h"

#include "base/instruction_set.h"
#include "base/simd.h"

enum { CHAINS = 12 }; /* latency times units, and some */

/* Floating-point operations; *sink keeps the work from being left out. */
double CO_NAME_OF_SET(peak)(long rounds, double *sink) {
    lane x[CHAINS], factor = lane_all(0.999999), shift = lane_all(1e-6);
    for (int i = 0; i < CHAINS; i++)
        x[i] = lane_all(1 + 0.01 * i);
    for (long k = 0; k < rounds; k++)
        for (int i = 0; i < CHAINS; i++)
            x[i] = x[i] * factor + shift;
    for (int i = 0; i < CHAINS; i++)
        for (int l = 0; l < CO_LANES; l++)
            *sink += x[i][l];
    return 2.0 * CHAINS * CO_LANES * (double)rounds;
}
