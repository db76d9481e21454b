/* Spontaneous curvature. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/spontaneous_curvature.h"

/* m - 1. */
static const double REFERENCE = 2;

co_spontaneous_curvature co_spontaneous_curvature_of(const double weights[CURVOPT_N_TERMS], double curvature) {
    return (co_spontaneous_curvature){.curvature = curvature,
                                      .weight = 4 * weights[CURVOPT_TERM_WILLMORE] + weights[CURVOPT_TERM_MEAN],
                                      .measure = -1,
                                      .length = 1};
}

int co_spontaneous_curvature_is_seen(const double weights[CURVOPT_N_TERMS]) {
    return weights[CURVOPT_TERM_WILLMORE] > 0 || weights[CURVOPT_TERM_MEAN] > 0;
}

/* to += factor times a number over the power of a length that it is. */
static void add_number(const co_spontaneous_curvature *s, double orientation, int scalar, double factor,
                       const double integral[CO_N_INTEGRALS], co_held_residual *to) {
    const co_held_numbers one = {
        .n = 1, .orientation = orientation, .held = {{.scalar = scalar, .measure = s->measure, .unit = 1}}};
    if (scalar == s->measure) { /* over itself */
        to->value += factor;
        return;
    }
    const co_held_residual number = co_held_numbers_residual(&one, 0, integral);
    to->value += factor * number.value;
    for (int i = 0; i < CURVOPT_N_SCALARS; i++) {
        to->slope[i] += factor * number.slope[i];
        for (int j = 0; j < CURVOPT_N_SCALARS; j++)
            to->second[i][j] += factor * number.second[i][j];
    }
}

static double of_area(const co_spontaneous_curvature *s) {
    return s->weight * s->curvature * s->curvature / 4;
}

double co_spontaneous_curvature_reference(const co_spontaneous_curvature *s, double area) {
    return s->curvature == 0 ? 0 : REFERENCE * of_area(s) * (s->area > 0 ? s->area : area);
}

co_spontaneous_part co_spontaneous_curvature_add(const co_spontaneous_curvature *s, double radius,
                                                 const double integral[CO_N_INTEGRALS]) {
    co_spontaneous_part part = {.reference = 0};
    if (s->curvature == 0)
        return part;
    const double length = s->measure < 0 ? s->length * radius : s->length, turn = s->curvature * length;
    const double orientation = s->orientation != 0 ? s->orientation : integral[CO_INT_VOLUME] < 0 ? -1 : 1;
    add_number(s, orientation, CURVOPT_SCALAR_MEAN_CURVATURE, -s->weight * turn, integral, &part.added);
    add_number(s, orientation, CURVOPT_SCALAR_AREA, of_area(s) * length * length, integral, &part.added);
    part.reference = co_spontaneous_curvature_reference(s, length * length * integral[CO_INT_AREA]);
    return part;
}

double co_spontaneous_curvature_add_integrands(const co_spontaneous_curvature *s, double radius,
                                               const double integral[CO_N_INTEGRALS], co_integrand *integrand) {
    const co_spontaneous_part part = co_spontaneous_curvature_add(s, radius, integral);
    double scaling = 0;
    for (int i = 0; i < CURVOPT_N_SCALARS; i++) {
        co_integrand number = {0};
        co_held_numbers_add(i, part.added.slope[i], &number);
        scaling += co_held_numbers_degree(i) * co_functional_integrate(&number, integral);
        co_integrand_add(integrand, 1, &number);
    }
    return scaling;
}
