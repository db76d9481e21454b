/* Shares of patches in the energies, and what they are off. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SHARE_H
#define CO_SHARE_H

#include "functional.h"

/* A patch's share in every term and in the area. */
typedef struct co_share {
    double term[CURVOPT_N_TERMS]; /* third order multiplied by the whole area */
    double area;
} co_share;

/* What shares are measured against: the objective of these weights, or every term; `whole` is a sum of shares. */
typedef struct co_share_measure {
    const double *weights;
    int every_term;
    co_share whole;
} co_share_measure;

/* Of the objective with these weights [CURVOPT_N_TERMS]: x - y. */
double co_share_difference(const double *weights, const co_share *x, const co_share *y);
/* |x - y| relative to the whole: the objective's, or the worst term's. */
double co_share_relative(const co_share_measure *measure, const co_share *x, const co_share *y);

/* What patches are off, together. Errors of different sign cancel; those of the rules that others are held against need
 * not, and are no larger than what the last step changed. */
typedef struct co_error_sum {
    double net, doubt;
} co_error_sum;

/* A patch is off by `difference` by the finest rule that it was held against, which was the last of several: it changed
 * the value by `doubt`. */
void co_error_add(co_error_sum *sum, double difference, double doubt);
void co_error_join(co_error_sum *sum, const co_error_sum *other);
/* |net| and a fifth of the doubts. */
double co_error_claimed(const co_error_sum *sum);

#endif
