/* The energies as weighted sums of six integrals. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/functional.h"

#include <math.h>

/* Integrands of the terms. Third-order ones follow Moreton and Sequin 1992 for MVS, Joshi and Sequin's report, eq. 7,
 * for MVS_cross, and Joshi's thesis (2008) for the mean over directions. */
static const co_integrand term_integrand[CURVOPT_N_TERMS] = {
    [CURVOPT_TERM_WILLMORE] = {.h2 = 1},
    [CURVOPT_TERM_MVS] = {.f1 = 1, .f3 = 1, .x = 2},
    [CURVOPT_TERM_MVS_CROSS] = {.f1 = 10.0 / 9, .f3 = 2, .x = 4.0 / 3},
    [CURVOPT_TERM_VARIATION] = {.f1 = 4.0 / 3, .f3 = 4},
    [CURVOPT_TERM_MEHLUM_TARROU] = {.f1 = 1, .f3 = 1},
    [CURVOPT_TERM_AREA] = {.area = 1},
    [CURVOPT_TERM_MEAN] = {.h2 = 0.25, .gauss = 0.5}, /* H^2 = (h2 + 2 K) / 4 */
};

int co_functional_is_third_order(int term) {
    const co_integrand *w = &term_integrand[term];
    return w->f1 != 0 || w->f3 != 0 || w->x != 0;
}

double co_functional_weight_of_x(int term) {
    return term_integrand[term].x;
}

/* The parts of a term of second and of third order; no term has both. */
static double second_order(const co_integrand *w, const double integral[CO_N_INTEGRALS]) {
    return w->area * integral[CO_INT_AREA] + w->h2 * integral[CO_INT_H2] + w->gauss * integral[CO_INT_K];
}

static double third_order(const co_integrand *w, const double integral[CO_N_INTEGRALS]) {
    return w->f1 * integral[CO_INT_F1] + w->f3 * integral[CO_INT_F3] + w->x * integral[CO_INT_X];
}

double co_functional_integrate(const co_integrand *w, const double integral[CO_N_INTEGRALS]) {
    return second_order(w, integral) + third_order(w, integral) + w->mean * integral[CO_INT_MEAN] +
           w->volume * integral[CO_INT_VOLUME];
}

void co_integrand_add(co_integrand *to, double factor, const co_integrand *from) {
    to->area += factor * from->area;
    to->h2 += factor * from->h2;
    to->gauss += factor * from->gauss;
    to->f1 += factor * from->f1;
    to->f3 += factor * from->f3;
    to->x += factor * from->x;
    to->mean += factor * from->mean;
    to->volume += factor * from->volume;
}

co_functional co_functional_of_weights(const double weights[CURVOPT_N_TERMS]) {
    co_functional f = {0};
    for (int t = 0; t < CURVOPT_N_TERMS; t++) {
        co_integrand_add(co_functional_is_third_order(t) ? &f.third : &f.second, weights[t], &term_integrand[t]);
        if (weights[t] > 0)
            *(co_functional_is_third_order(t) ? &f.has_third : &f.has_second) = 1;
    }
    return f;
}

void co_functional_terms(const double integral[CO_N_INTEGRALS], int with_third, double term[CURVOPT_MAX_TERMS]) {
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        term[t] = !co_functional_is_third_order(t) ? second_order(&term_integrand[t], integral)
                  : with_third                     ? integral[CO_INT_AREA] * third_order(&term_integrand[t], integral)
                                                   : (double)NAN;
    for (int t = CURVOPT_N_TERMS; t < CURVOPT_MAX_TERMS; t++)
        term[t] = (double)NAN;
}

/* With u the height, h11 = u'' and C111 = u''' are all there is: F1 = 3/4 u''', F3 = 1/4 u''', X = F1 F3. */
double co_functional_of_wave(const co_functional *f, double k, double area) {
    double second = f->second.area / 2 + f->second.h2 * k * k;
    double third = 9.0 / 16 * f->third.f1 + 1.0 / 16 * f->third.f3 + 3.0 / 16 * f->third.x;
    return k * k * (second + area * third * k * k * k * k);
}

double co_functional_value(const co_functional *f, const double integral[CO_N_INTEGRALS]) {
    double value = 0;
    if (f->has_second)
        value += co_functional_integrate(&f->second, integral);
    if (f->has_third)
        value += integral[CO_INT_AREA] * co_functional_integrate(&f->third, integral);
    return value;
}
