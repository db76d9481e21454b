/* Directions of negative curvature. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/negative_curvature.h"

#include "linalg/vector.h"

#include <math.h>
#include <string.h>

/* A vector without symmetries: multiples of the golden section are well spread. */
static void fill_without_symmetry(size_t n, double *d) {
    for (size_t i = 0; i < n; i++)
        d[i] = fmod(0.6180339887498949 * (double)(i + 1), 1) - 0.5;
}

int32_t co_negative_curvature_direction(const co_shifted_inverse *inverse, const co_tuning *tuning,
                                        const double *gradient, double *d, double *work, int *found,
                                        curvopt_error *error) {
    size_t n = inverse->n;
    double curvature = 0;
    *found = 0;
    fill_without_symmetry(n, d);
    for (int step = 0; step < tuning->inverse_iterations; step++) {
        double norm = co_vector_norm(n, d);
        for (size_t i = 0; i < n; i++)
            d[i] /= norm;
        memcpy(work, d, n * sizeof *d);
        int32_t status = inverse->solve(inverse->context, d, d, error);
        if (status != CURVOPT_OK)
            return status;
        curvature = 1 / co_vector_dot(n, work, d) - inverse->shift;
    }
    if (co_vector_dot(n, d, gradient) > 0)
        for (size_t i = 0; i < n; i++)
            d[i] = -d[i];
    *found = curvature < -inverse->least;
    return CURVOPT_OK;
}

int co_negative_curvature_step(const co_objective *f, const co_negative_curvature_options *o, const double *d,
                               double *trial, co_iterate *now) {
    size_t n = f->n;
    double least = o->gain * fabs(now->value);
    double scale = o->max_step / f->step_length(f->context, d);
    for (int k = 0; k < 2 * o->tuning->trials; k++, scale *= k % 2 ? -1 : -0.5) {
        co_iterate at = {.x = trial};
        memcpy(trial, now->x, n * sizeof *trial);
        co_vector_add(n, scale, d, trial);
        f->evaluate(f->context, &at);
        if (at.value < now->value - least) {
            memcpy(now->x, trial, n * sizeof *trial);
            f->evaluate(f->context, now);
            return 1;
        }
    }
    return 0;
}
