/* Which patches get another quadrature rule. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/marking.h"

#include <math.h>
#include <stdlib.h>

double co_marking_error_per_cost(double error, double cost) {
    return isnan(error) ? (double)INFINITY : error / cost;
}

static int by_error_per_cost(const void *a, const void *b) {
    const co_marking_candidate *x = a, *y = b;
    if (x->error_per_cost != y->error_per_cost)
        return x->error_per_cost > y->error_per_cost ? 1 : -1;
    return (x->error > y->error) - (x->error < y->error);
}

double co_marking_threshold(co_marking_candidate *candidates, int32_t n, double unmarked, double tie) {
    int32_t kept = 0;
    double sum = 0;
    qsort(candidates, (size_t)n, sizeof *candidates, by_error_per_cost);
    while (kept < n && sum + candidates[kept].error <= unmarked)
        sum += candidates[kept++].error;
    return kept == n ? (double)INFINITY : candidates[kept].error_per_cost * (1 - tie);
}
