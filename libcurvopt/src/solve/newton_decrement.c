/* What is left to gain at a cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/newton_decrement.h"

#include "base/memory.h"
#include "linalg/vector.h"

#include <math.h>
#include <stdlib.h>

static const double HESSIAN_NOISE = 1e-9; /* of its mean diagonal: what differences leave unknown (kernel_hessian.h) */

int32_t co_newton_decrement_factorize(co_level *l, const co_iterate *now, int exact, int *positive,
                                      curvopt_error *error) {
    int32_t status = co_level_factorize(l, now, exact, positive, error);
    if (status == CURVOPT_OK && !*positive)
        status = co_newton_system_factorize(
            &l->model, HESSIAN_NOISE * co_sparse_hessian_mean_diagonal(&l->model.hessian), positive, error);
    return status;
}

int32_t co_newton_decrement_by_factor(co_level *l, const co_iterate *now, double *decrement, curvopt_error *error) {
    size_t n = (size_t)l->reduction.n_variables;
    double *step = CO_NEW(double, n);
    int32_t status = step ? co_newton_system_solve(&l->model, now->gradient, step, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        *decrement = 0.5 * co_vector_dot(n, now->gradient, step);
    free(step);
    return status;
}

int32_t co_newton_decrement(co_level *l, const co_iterate *now, double *decrement, int *by_hessian,
                            curvopt_error *error) {
    int positive = 1;
    *decrement = 0;
    if (by_hessian)
        *by_hessian = 1;
    if (l->reduction.n_variables == 0)
        return CURVOPT_OK;
    int32_t status = co_newton_decrement_factorize(l, now, 1, &positive, error);
    if (by_hessian)
        *by_hessian = positive;
    if (status == CURVOPT_OK && !positive)
        status = co_newton_decrement_factorize(l, now, 0, &positive, error);
    l->has_factor = 0;
    if (status == CURVOPT_OK && positive)
        return co_newton_decrement_by_factor(l, now, decrement, error);
    *decrement = (double)NAN;
    return status;
}
