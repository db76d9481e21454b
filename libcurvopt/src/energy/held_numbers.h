/* Numbers of a whole surface that are held: volume, area, total mean curvature. SPDX-License-Identifier:
 * GPL-3.0-or-later
 *
 * Where nothing of the cage is held, energies do not depend on its size, and a number that is held counts over the
 * power of a length that it is: lengths are measured by another number. With v = V / A^1.5, for example, the constraint
 * is c = (v - v*) / v* = 0. */
#ifndef CO_ENERGY_HELD_NUMBERS_H
#define CO_ENERGY_HELD_NUMBERS_H

#include "energy/functional.h"

typedef struct co_held_number {
    int scalar;    /* curvopt_scalar */
    int measure;   /* curvopt_scalar by which lengths are measured; -1: none, they are absolute */
    double target; /* of the number, over the power of a length */
    double unit;   /* c = (number - target) / unit */
    double rate;   /* how much the target changes with what the user wants, in units of that */
} co_held_number;

typedef struct co_held_numbers {
    int n;
    double orientation; /* -1: normals point inwards, and volume and mean curvature count negative; else 1 */
    co_held_number held[CURVOPT_N_SCALARS]; /* [n] */
} co_held_numbers;

/* One constraint at a surface. */
typedef struct co_held_residual {
    double value;                    /* c */
    double slope[CURVOPT_N_SCALARS]; /* its derivatives by the surface's numbers, by curvopt_scalar */
    double second[CURVOPT_N_SCALARS][CURVOPT_N_SCALARS];
} co_held_residual;

/* The power of a length that a number (curvopt_scalar) is. */
int co_held_numbers_degree(int scalar);
/* Whether one of them is total mean curvature, which is more work. */
int co_held_numbers_has_mean(const co_held_numbers *numbers);
/* NAN where a number that lengths are measured by is not positive. */
co_held_residual co_held_numbers_residual(const co_held_numbers *numbers, int k, const double integral[CO_N_INTEGRALS]);
/* integrand += factor times the integrand of a number. */
void co_held_numbers_add(int scalar, double factor, co_integrand *integrand);

#endif
