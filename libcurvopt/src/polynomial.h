/* The `polynomial` surface: near an extraordinary vertex S is blended into one polynomial over the characteristic map,
 *     S' = (1 - w(u) w(v)) S + w(u) w(v) P(chi(u, v)),
 * P the least-squares fit of S on the faces round the vertex. Linear in the two-ring, so that the surface is as exact a
 * function of the cage as the limit surface is; third derivatives are square integrable.
 *
 * Follows: Levin, "Modified subdivision surfaces with continuous curvature", SIGGRAPH 2006 (blending a subdivision
 * surface into a polynomial over the characteristic map); Ying, Zorin 2004. Differs: blended over whole faces and by a
 * product of one-dimensional weights, so that three rings of parameters stay as they are; degree and weights by
 * experiment (tests/bench/README.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_POLYNOMIAL_H
#define CO_POLYNOMIAL_H

#include "blend.h"
#include "irregular.h"

enum { CO_POLYNOMIAL_DEGREE = 5, CO_POLYNOMIAL_TERMS = (CO_POLYNOMIAL_DEGREE + 1) * (CO_POLYNOMIAL_DEGREE + 2) / 2 };

typedef struct co_polynomial {
    int32_t n_points; /* of the two-ring */
    co_real *map;     /* [2 n_points] control points of the characteristic map chi */
    co_real *fit;     /* [CO_POLYNOMIAL_TERMS][n_points] coefficients of P, by co_polynomial_monomials' order */
} co_polynomial;

/* Does not change which ring `disc` is at; it must be at ring 1. */
int32_t co_polynomial_create(co_disc *disc, co_polynomial *out, curvopt_error *error);
void co_polynomial_free(co_polynomial *polynomial);

/* Jets of all monomials of chi, from the jets x, y of its coordinates. */
void co_polynomial_monomials(const co_real x[CO_JET], const co_real y[CO_JET],
                             co_real out[CO_POLYNOMIAL_TERMS][CO_JET]);

#endif
