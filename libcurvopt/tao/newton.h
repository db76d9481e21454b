/* What TAO's solvers are told of the objective. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_NEWTON_H
#define CURVOPT_TAO_NEWTON_H

#include "energy.h"

#include <petsctao.h>

/* A solver of `type` unless the options database, with this prefix, names another one; value, gradient and, for
 * Newton's methods, the assembled Hessian at x are the energy's. */
PetscErrorCode newton_create_solver(energy *e, const char *prefix, const char *type, Vec x, Tao *out);

/* Defaults in the options database, for a linear solver with this prefix of so many unknowns in all: preconditioned by
 * each rank's block of the Gauss-Newton matrix, by its Cholesky factor, incomplete where a complete one would be large.
 */
PetscErrorCode newton_set_preconditioner(const char *prefix, PetscInt whole);

#endif
