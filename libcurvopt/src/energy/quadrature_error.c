/* Terms of single patches by several quadrature rules, and how far each is off.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/quadrature_error.h"

#include "base/constants.h"
#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

/* No difference is no part, also of nothing: a flat surface has no energy. But for rounding, which no rule resolves. */
static double part_of(double difference, double whole) {
    return difference == 0 ? 0 : fabs(difference) / (fabs(whole) + CO_FLAT_ENERGY);
}

double co_quadrature_error_relative(const co_quadrature_error_measure *m, const co_patch_terms *x,
                                    const co_patch_terms *y) {
    const co_patch_terms zero = {.term = {0}};
    const co_quadrature_weights terms = {.term = m->weights.term};
    double worst = part_of(co_quadrature_error_difference(&m->weights, x, y),
                           co_quadrature_error_difference(&terms, &m->whole, &zero) + m->more);
    for (int t = 0; m->every_term && t < CURVOPT_N_TERMS; t++) {
        double difference = part_of(x->term[t] - y->term[t], m->whole.term[t]);
        if (difference > worst) /* false for terms that this surface does not have */
            worst = difference;
    }
    return worst;
}

void co_quadrature_error_join(co_quadrature_error *sum, const co_quadrature_error *other) {
    sum->net += other->net;
    sum->finest += other->finest;
}

double co_quadrature_error_claimed(const co_quadrature_error *sum) {
    return fabs(sum->net) + sum->finest;
}

int32_t co_quadrature_estimates_ensure(co_quadrature_estimates *e, size_t n, curvopt_error *error) {
    if (e->candidates)
        return CURVOPT_OK;
    *e = (co_quadrature_estimates){.used = CO_NEW(co_patch_terms, n),
                                   .finer = CO_NEW(co_patch_terms, n),
                                   .finest = CO_NEW(co_patch_terms, n),
                                   .has_third_rule = CO_NEW(uint8_t, n),
                                   .in_finest = CO_NEW(uint8_t, n),
                                   .error = CO_NEW(double, n),
                                   .error_per_cost = CO_NEW(double, n),
                                   .candidates = CO_NEW(co_marking_candidate, n)};
    if (e->used && e->finer && e->finest && e->has_third_rule && e->in_finest && e->error && e->error_per_cost &&
        e->candidates)
        return CURVOPT_OK;
    co_quadrature_estimates_free(e);
    return co_status_no_memory(error);
}

static void multiply_third_order(co_patch_terms *terms, double factor) {
    terms->jump *= factor;
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        if (co_functional_is_third_order(t))
            terms->term[t] *= factor;
}

void co_quadrature_estimates_use_best_area(co_quadrature_estimates *e, size_t n, double area) {
    double best = 0;
    for (size_t p = 0; p < n; p++)
        best += (e->has_third_rule[p] ? &e->finest[p] : &e->finer[p])->number[CURVOPT_SCALAR_AREA];
    for (size_t p = 0; p < n; p++) {
        multiply_third_order(&e->finer[p], best / area);
        if (e->has_third_rule[p])
            multiply_third_order(&e->finest[p], best / area);
    }
}

void co_quadrature_estimates_free(co_quadrature_estimates *e) {
    free(e->used);
    free(e->finer);
    free(e->finest);
    free(e->has_third_rule);
    free(e->in_finest);
    free(e->error);
    free(e->error_per_cost);
    free(e->candidates);
    *e = (co_quadrature_estimates){0};
}
