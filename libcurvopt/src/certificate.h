/* Whether a cage is a stationary point, and of what kind. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CERTIFICATE_H
#define CO_CERTIFICATE_H

#include "model.h"

typedef struct co_certificate {
    double newton_decrement; /* half of gradient . H^-1 gradient */
    int32_t negative_directions;
    int32_t verdict; /* curvopt_verdict */
} co_certificate;

/* At normalized positions x with this value and gradient [3 n_vertices]. `shift` is added to the Hessian's diagonal, so
 * that its invariances (rigid motion, scaling, for Willmore Moebius maps) do not count as negative. ERROR_MEMORY. */
int32_t co_certify(co_model *model, co_gauge gauge, const double *x, double value, const double *gradient, double shift,
                   co_certificate *out, curvopt_error *error);

#endif
