/* The Newton decrement by conjugate gradients. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/conjugate_decrement.h"

#include "base/memory.h"
#include "linalg/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* They end at this part of the first residual, in the preconditioner's norm: the decrement's error is its square. */
static const double RESIDUAL = 1e-3;
enum { MOST_PRODUCTS = 60 };

/* vectors [4 n] */
static int32_t iterate(const co_linear_system *system, const double *gradient, double *vectors, double *decrement,
                       curvopt_error *error) {
    size_t n = system->n;
    double *r = vectors, *s = r + n, *d = s + n, *h = d + n, sum = 0;
    memcpy(r, gradient, n * sizeof *r);
    int32_t status = system->precondition(system->context, r, s, error);
    double rs = co_vector_dot(n, r, s), first = rs;
    memcpy(d, s, n * sizeof *d);
    for (int k = 0; status == CURVOPT_OK && k < MOST_PRODUCTS && rs > RESIDUAL * RESIDUAL * first; k++) {
        system->multiply(system->context, d, h);
        double curvature = co_vector_dot(n, d, h);
        if (!(curvature > 0)) {
            *decrement = (double)NAN;
            return CURVOPT_OK;
        }
        double step = rs / curvature, before = rs;
        sum += 0.5 * step * rs; /* of gradient.x: conjugate directions add up */
        co_vector_add(n, -step, h, r);
        status = system->precondition(system->context, r, s, error);
        rs = co_vector_dot(n, r, s);
        for (size_t i = 0; i < n; i++)
            d[i] = s[i] + rs / before * d[i];
    }
    *decrement = sum;
    return status;
}

int32_t co_conjugate_decrement(const co_linear_system *system, const double *gradient, double *decrement,
                               curvopt_error *error) {
    double *vectors = CO_NEW(double, 4 * system->n);
    if (!vectors)
        return co_status_no_memory(error);
    int32_t status = iterate(system, gradient, vectors, decrement, error);
    free(vectors);
    return status;
}
