/* The Newton decrement without a Hessian: preconditioned conjugate gradients on products with it (Hestenes, Stiefel,
 * "Methods of conjugate gradients for solving linear systems", 1952). SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_CONJUGATE_DECREMENT_H
#define CO_SOLVE_CONJUGATE_DECREMENT_H

#include "base/status.h"

#include <stddef.h>

/* A symmetric matrix by its products, and a preconditioner. */
typedef struct co_linear_system {
    void *context;
    size_t n;
    void (*multiply)(void *context, const double *v, double *out);
    /* out = P^-1 v, [n] both. ERROR_MEMORY. */
    int32_t (*precondition)(void *context, const double *v, double *out, curvopt_error *error);
} co_linear_system;

/* Half of gradient.H^-1 gradient, which grows with every iteration; NAN where a direction of negative curvature is met.
 * ERROR_MEMORY. */
int32_t co_conjugate_decrement(const co_linear_system *system, const double *gradient, double *decrement,
                               curvopt_error *error);

#endif
