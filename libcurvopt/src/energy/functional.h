/* The energies as weighted sums of six integrals, and two more integrals of the whole surface.
 *
 * With the first and second fundamental forms in an orthonormal tangent frame, C = grad h (symmetric, Codazzi), the
 * derivative of normal curvature along direction theta is A1 cos + B1 sin + A3 cos 3 theta + B3 sin 3 theta, and with
 * F1 = A1 - i B1, F3 = A3 - i B3, q = (h11 - h22) / 2 + i h12 every third-order energy here is a combination of
 * |F1|^2, |F3|^2 and X = Re(F1 F3 q^2) / |q|^2.
 *
 * At an umbilic, q = 0, X is bounded but has no limit, and its gradient none either. It is replaced by
 *     X_eps = Re(F1 F3 q^2) |q|^2 / (|q|^4 + eps^4),
 * smooth everywhere, with |X_eps - X| <= |F1 F3| eps^4 / (|q|^4 + eps^4): the fourth power keeps the error below 1e-6
 * of |F1 F3| wherever k1 and k2 differ by a tenth of the surface's mean curvature or more, where X cancels
 * most of |F1|^2 + |F3|^2 in MVS. eps = CO_UMBILIC / (root mean square distance of the cage's vertices from
 * their centroid), so energies stay invariant.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_FUNCTIONAL_H
#define CO_ENERGY_FUNCTIONAL_H

#include "base/status.h"

/* Length at radius 1, 2e-2, 0 to 1: where curvatures differ by less than this, X is smoothed
 * (libcurvopt/notes/15-umbilics.md). */
#define CO_UMBILIC 2e-2

/* eps^4 of the regularization for a cage of this root mean square radius, in the units of positions. */
static inline double co_functional_eps4(double radius) {
    const double eps = CO_UMBILIC / radius;
    return eps * eps * eps * eps;
}

/* Integrals that the element kernels sum up. */
typedef enum co_integral {
    CO_INT_AREA,   /* dA */
    CO_INT_H2,     /* |h|^2 = k1^2 + k2^2 */
    CO_INT_K,      /* Gauss curvature */
    CO_INT_F1,     /* |F1|^2 */
    CO_INT_F3,     /* |F3|^2 */
    CO_INT_X,      /* X, regularized */
    CO_INT_MEAN,   /* H = -(h11 + h22) / 2: positive on a convex surface whose normals point outwards */
    CO_INT_VOLUME, /* x.n / 3, if it is wanted; else 0 */
    CO_N_INTEGRALS
} co_integral;

/* Weights of an integrand over 1, h2, K, F1, F3, X, H, x.n / 3. |gauss| <= 2 h2, so that the second order of an energy
 * is never negative; mean and volume are 0 there. */
typedef struct co_integrand {
    double area, h2, gauss, f1, f3, x, mean, volume;
} co_integrand;

/* Objective = second + area * third, each an integrand. */
typedef struct co_functional {
    co_integrand second;
    co_integrand third;
    int has_second, has_third;
} co_functional;

/* to += factor * from */
void co_integrand_add(co_integrand *to, double factor, const co_integrand *from);
/* Whether a term (curvopt_term) has derivatives of curvature. Its integral is then multiplied by the area. */
int co_functional_is_third_order(int term);
co_functional co_functional_of_weights(const double weights[CURVOPT_N_TERMS]);
/* The weight of X in a term: 0 unless it jumps at umbilics. */
double co_functional_weight_of_x(int term);
/* All terms from the integrals; third-order ones are NAN unless `with_third`. */
void co_functional_terms(const double integral[CO_N_INTEGRALS], int with_third, double term[CURVOPT_MAX_TERMS]);
/* The integral of one integrand. */
double co_functional_integrate(const co_integrand *integrand, const double integral[CO_N_INTEGRALS]);
/* Density of the objective of a wave h cos(wavenumber s) on a surface of this area that is plane but for it, over the
 * mean of the square of its height. */
double co_functional_of_wave(const co_functional *functional, double wavenumber, double area);
/* The value of the objective. */
double co_functional_value(const co_functional *functional, const double integral[CO_N_INTEGRALS]);

#endif
