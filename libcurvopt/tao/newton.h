/* What TAO's solvers are told of the objective, and the report's verification. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#ifndef CURVOPT_TAO_NEWTON_H
#define CURVOPT_TAO_NEWTON_H

#include "level.h"

/* A solver of `type` unless the options database, with this prefix, names another one; value, gradient and, for
 * Newton's methods, the assembled Hessian at x are the energy's. */
PetscErrorCode newton_create_solver(energy *e, const char *prefix, const char *type, Vec x, Tao *out);

/* The report's verification: Newton's method with a Hessian from finite differences of the gradient, from x, which
 * stays as it is. *decrease: of the energy; *negative: whether the Hessian is negative somewhere at the end. */
PetscErrorCode newton_verify(energy *e, const char *prefix, Vec x, double *decrease, int *negative);

#endif
