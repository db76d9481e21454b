/* How far a surface's second fundamental form at a point is from a wanted one, with first and second derivatives.
 *
 * With tangents T_1, T_2 of a point of the surface and its second derivatives S_11, S_12, S_22 by the same parameters,
 * n the unit vector of T_1 x T_2, and the wanted tensor A in the plane across a unit vector m,
 *
 *     D(T_a, T_b) = -n . S_ab - A(Q T_a, Q T_b) ,
 *
 * Q being the least turn that takes n to m, or to -m where that is nearer: so A has its curvatures in any tangent
 * plane, and turning the plane makes none of them smaller. Half of |D|^2, by the surface's metric, depends on the
 * surface alone and not on its parameters (libcurvopt/notes/125-soft-curvatures.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_SECOND_FORM_H
#define CO_HESSIAN_SECOND_FORM_H

/* T_1, T_2, S_11, S_12, S_22, three coordinates each. */
enum { CO_SECOND_FORM_VALUES = 15 };

typedef struct co_second_form {
    double normal[3]; /* m */
    double tensor[9]; /* A, symmetric, 0 along m; positive where the surface bends away from n */
} co_second_form;

/* |D|^2 / 2, not finite where tangents span no plane. gradient [15] and hessian [15][15] are its derivatives unless
 * NULL; where not `exact` that is Gauss and Newton's matrix, which is positive semidefinite. */
double co_second_form_off(const co_second_form *wanted, const double values[CO_SECOND_FORM_VALUES], double *gradient,
                          double *hessian, int exact);

#endif
