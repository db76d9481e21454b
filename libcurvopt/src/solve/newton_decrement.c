/* What is left to gain at a cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/newton_decrement.h"

#include "base/memory.h"
#include "linalg/vector.h"

#include <math.h>
#include <stdlib.h>

/* Digits of the mean diagonal that rounding leaves unknown. The least shift, a part of the energy, may be below them
 * where the energy is nearly 0. */
static const double HESSIAN_NOISE = 1e-9;

int32_t co_newton_decrement_factorize(co_level_hessian *h, const co_iterate *now, int exact, int *positive,
                                      curvopt_error *error) {
    int32_t status = co_level_hessian_factorize_at(h, now, exact, positive, error);
    if (status != CURVOPT_OK || *positive)
        return status;
    double noise = HESSIAN_NOISE * co_sparse_hessian_mean_diagonal(&h->system.hessian);
    return co_newton_system_factorize(&h->system, noise, positive, error);
}

int32_t co_newton_decrement_by_factor(co_level_hessian *h, const co_iterate *now, double *decrement,
                                      curvopt_error *error) {
    size_t n = co_level_objective_n(h->objective);
    double *step = CO_NEW(double, n);
    int32_t status = step ? co_level_hessian_solve(h, now->gradient, step, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        *decrement = 0.5 * co_vector_dot(n, now->gradient, step);
    free(step);
    return status;
}

int32_t co_newton_decrement(co_level_hessian *h, const co_iterate *now, int is_indefinite, double *decrement,
                            curvopt_error *error) {
    int positive = 0;
    int32_t status = CURVOPT_OK;
    *decrement = 0;
    if (co_level_objective_n(h->objective) == 0)
        return CURVOPT_OK;
    if (!is_indefinite)
        status = co_newton_decrement_factorize(h, now, 1, &positive, error);
    if (status == CURVOPT_OK && !positive)
        status = co_newton_decrement_factorize(h, now, 0, &positive, error);
    h->has_factor = 0;
    if (status == CURVOPT_OK && positive)
        return co_newton_decrement_by_factor(h, now, decrement, error);
    *decrement = (double)NAN;
    return status;
}
