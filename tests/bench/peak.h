/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_PEAK_H
#define BENCH_PEAK_H

double peak_portable(long rounds, double *sink);
double peak_avx2(long rounds, double *sink);
double peak_avx512(long rounds, double *sink);

#endif
