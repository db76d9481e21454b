/* Numbers of a whole surface that are held. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/held_numbers.h"

#include "base/elementary.h"

#include <math.h>

static const co_integral integral_of[CURVOPT_N_SCALARS] = {[CURVOPT_SCALAR_VOLUME] = CO_INT_VOLUME,
                                                           [CURVOPT_SCALAR_AREA] = CO_INT_AREA,
                                                           [CURVOPT_SCALAR_MEAN_CURVATURE] = CO_INT_MEAN};

int co_held_numbers_degree(int scalar) {
    return scalar == CURVOPT_SCALAR_VOLUME ? 3 : scalar == CURVOPT_SCALAR_AREA ? 2 : 1;
}

static double sign_of(const co_held_numbers *n, int scalar) {
    return scalar == CURVOPT_SCALAR_AREA ? 1 : n->orientation;
}

co_held_residual co_held_numbers_residual(const co_held_numbers *n, int k, const double integral[CO_N_INTEGRALS]) {
    const co_held_number *h = &n->held[k];
    const int s = h->scalar, by = h->measure;
    const double number = sign_of(n, s) * integral[integral_of[s]];
    co_held_residual r = {.value = number};
    r.slope[s] = sign_of(n, s) / h->unit;
    if (by >= 0) { /* number * measure^power */
        const double measure = sign_of(n, by) * integral[integral_of[by]],
                     power = -(double)co_held_numbers_degree(s) / co_held_numbers_degree(by);
        const double scale = measure > 0 ? co_exp(power * co_log(measure)) : (double)NAN;
        const double rate = power * sign_of(n, by) / measure;
        r.value *= scale;
        r.slope[s] *= scale;
        r.slope[by] = rate * r.value / h->unit;
        r.second[s][by] = r.second[by][s] = rate * r.slope[s];
        r.second[by][by] = (power - 1) * power / (measure * measure) * r.value / h->unit;
    }
    r.value = (r.value - h->target) / h->unit;
    return r;
}

int co_held_numbers_has_mean(const co_held_numbers *n) {
    int has = 0;
    for (int k = 0; k < n->n; k++)
        has |=
            n->held[k].scalar == CURVOPT_SCALAR_MEAN_CURVATURE || n->held[k].measure == CURVOPT_SCALAR_MEAN_CURVATURE;
    return has;
}

void co_held_numbers_add(int scalar, double factor, co_integrand *integrand) {
    *(scalar == CURVOPT_SCALAR_VOLUME ? &integrand->volume
      : scalar == CURVOPT_SCALAR_AREA ? &integrand->area
                                      : &integrand->mean) += factor;
}
