/* Shares of patches in the energies, and what they are off. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/quadrature_error.h"

#include <math.h>

static const double LUCK = 0.2; /* of what the finest rules may be off themselves, and of errors that seem to cancel */

double co_quadrature_error_difference(const double *weights, const co_patch_terms *x, const co_patch_terms *y) {
    double sum = 0;
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        if (weights[t] > 0)
            sum += weights[t] * (x->term[t] - y->term[t]);
    return sum;
}

double co_quadrature_error_relative(const co_quadrature_error_measure *m, const co_patch_terms *x,
                                    const co_patch_terms *y) {
    const co_patch_terms zero = {.area = 0};
    double worst = fabs(co_quadrature_error_difference(m->weights, x, y) /
                        co_quadrature_error_difference(m->weights, &m->whole, &zero));
    for (int t = 0; m->every_term && t < CURVOPT_N_TERMS; t++) {
        double difference = fabs((x->term[t] - y->term[t]) / m->whole.term[t]);
        if (difference > worst) /* false for terms that this surface does not have */
            worst = difference;
    }
    return worst;
}

void co_quadrature_error_add(co_quadrature_error *sum, double difference, double doubt) {
    sum->net += difference;
    sum->doubt += fabs(doubt);
}

void co_quadrature_error_join(co_quadrature_error *sum, const co_quadrature_error *other) {
    sum->net += other->net;
    sum->doubt += other->doubt;
}

double co_quadrature_error_claimed(const co_quadrature_error *sum) {
    return fabs(sum->net) + LUCK * sum->doubt;
}
