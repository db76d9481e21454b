/* What TAO's solvers are told of the objective. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_TAO_SOLVER_H
#define CURVOPT_TAO_TAO_SOLVER_H

#include "objective.h"

#include <petsctao.h>

/* A solver of `type` unless the options database, with this prefix, names another one; value, gradient and, for
 * Newton's methods, the assembled Hessian at x are the objective's. */
PetscErrorCode tao_solver_create(objective *o, const char *prefix, const char *type, Vec x, Tao *out);

/* Defaults in the options database, for a linear solver with this prefix of so many unknowns in all. Preconditioned by
 * the Cholesky factor of the whole matrix, on every rank the same, while that is small: then iterations do not depend
 * on the number of ranks. Else by incomplete factors of each rank's block. */
PetscErrorCode tao_solver_set_preconditioner(const char *prefix, PetscInt whole);

#endif
