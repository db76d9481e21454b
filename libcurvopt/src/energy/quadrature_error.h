/* Shares of patches in the energies, and what they are off. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_QUADRATURE_ERROR_H
#define CO_ENERGY_QUADRATURE_ERROR_H

#include "energy/functional.h"

/* A patch's share in every term and in the area. */
typedef struct co_patch_terms {
    double term[CURVOPT_N_TERMS]; /* third order multiplied by the whole area */
    double area;
} co_patch_terms;

/* What shares are measured against: the objective of these weights, or every term; `whole` is a sum of shares. */
typedef struct co_quadrature_error_measure {
    const double *weights;
    int every_term;
    co_patch_terms whole;
} co_quadrature_error_measure;

/* Of the objective with these weights [CURVOPT_N_TERMS]: x - y. */
double co_quadrature_error_difference(const double *weights, const co_patch_terms *x, const co_patch_terms *y);
/* |x - y| relative to the whole: the objective's, or the worst term's. */
double co_quadrature_error_relative(const co_quadrature_error_measure *measure, const co_patch_terms *x,
                                    const co_patch_terms *y);

/* What patches are off, together. Errors of different sign cancel; those of the rules that others are held against need
 * not, and are no larger than what the last step changed. */
typedef struct co_quadrature_error {
    double net, doubt;
} co_quadrature_error;

/* A patch is off by `difference` by the finest rule that it was held against, which was the last of several: it changed
 * the value by `doubt`. */
void co_quadrature_error_add(co_quadrature_error *sum, double difference, double doubt);
void co_quadrature_error_join(co_quadrature_error *sum, const co_quadrature_error *other);
/* |net| and a fifth of the doubts. */
double co_quadrature_error_claimed(const co_quadrature_error *sum);

#endif
