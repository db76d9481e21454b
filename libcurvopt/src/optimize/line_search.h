/* A step length that satisfies the strong Wolfe conditions. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_OPTIMIZE_LINE_SEARCH_H
#define CO_OPTIMIZE_LINE_SEARCH_H

#include "base/tuning.h"
#include "optimize/objective.h"

typedef struct co_line_search {
    const co_tuning *tuning;
    double step;     /* in: first trial; out: step taken */
    double max_step; /* never exceeded */
    int evaluations; /* out */
} co_line_search;

/* From `from` along d (slope = gradient.d < 0) to `to` (its arrays allocated by the caller). Nonzero if found. A step
 * at max_step needs sufficient decrease only. */
int co_line_search_wolfe(const co_objective *f, const co_iterate *from, const double *d, co_line_search *search,
                         co_iterate *to);

#endif
