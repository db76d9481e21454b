/* Whether a cage is a stationary point, and of what kind.
 *
 * The report (section 3.3) verifies its minima by Newton's method. Here the Hessian is factored once: its inertia tells
 * minima from saddles, and the Newton decrement (Boyd, Vandenberghe, "Convex optimization", 2004, section 9.5) what a
 * Newton step could still gain.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "certificate.h"

#include "memory.h"
#include "minimand.h"

#include <math.h>
#include <stdlib.h>

static const double STATIONARY = 1e-6; /* Newton decrement, of the energy */
enum { LARGEST_COUNT = 5000 };         /* vertices up to which negative directions are counted: that factor is slower */

static int32_t decrement_of(co_model *model, size_t n, const double *gradient, double *decrement,
                            curvopt_error *error) {
    double *step = CO_NEW(double, n);
    int32_t status = step ? co_model_solve(model, gradient, step, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        *decrement = 0.5 * co_vector_dot(n, gradient, step);
    free(step);
    return status;
}

int32_t co_certify(co_model *model, co_gauge gauge, const double *x, double value, const double *gradient, double shift,
                   co_certificate *out, curvopt_error *error) {
    size_t n = (size_t)model->hessian.reduction->n_variables;
    int positive = 0;
    *out = (co_certificate){.newton_decrement = (double)NAN, .negative_directions = -1};
    int32_t status = co_model_assemble(model, x, 1, gauge, error);
    if (status == CURVOPT_OK)
        status = co_model_factorize(model, shift, &positive, error);
    if (status != CURVOPT_OK)
        return status;
    if (positive) {
        out->negative_directions = 0;
    } else {
        if (model->hessian.reduction->n_variables <= 3 * LARGEST_COUNT)
            status = co_model_count_negative(model, shift, &out->negative_directions, error);
        if (status == CURVOPT_OK)
            status = co_model_assemble(model, x, 0, gauge, error);
        if (status == CURVOPT_OK)
            status = co_model_factorize(model, shift, &positive, error);
    }
    if (status == CURVOPT_OK && positive)
        status = decrement_of(model, n, gradient, &out->newton_decrement, error);
    if (status == CURVOPT_OK && positive)
        out->verdict = out->newton_decrement > STATIONARY * fabs(value) ? CURVOPT_VERDICT_NOT_STATIONARY
                       : out->negative_directions == 0                  ? CURVOPT_VERDICT_MINIMUM
                                                                        : CURVOPT_VERDICT_SADDLE;
    return status;
}
