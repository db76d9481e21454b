/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_PEAK_H
#define BENCH_PEAK_H

typedef double peak_function(long rounds, double *sink);
peak_function peak_portable, peak_avx2, peak_avx512;

#endif
