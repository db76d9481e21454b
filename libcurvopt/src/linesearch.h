/* A step length that satisfies the strong Wolfe conditions. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINESEARCH_H
#define CO_LINESEARCH_H

#include "minimand.h"

typedef struct co_linesearch {
    double step;     /* in: first trial; out: step taken */
    double max_step; /* never exceeded */
    int evaluations; /* out */
} co_linesearch;

/* From `from` along d (slope = gradient.d < 0) to `to` (its arrays allocated by the caller). Nonzero if found. A step
 * at max_step needs sufficient decrease only. */
int co_linesearch_wolfe(const co_minimand *f, const co_iterate *from, const double *d, co_linesearch *search,
                        co_iterate *to);

#endif
