/* What is left to gain at a cage: the Newton decrement, half of gradient.H^-1 gradient (Boyd, Vandenberghe, "Convex
 * optimization", 2004, section 9.5). SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_NEWTON_DECREMENT_H
#define CO_SOLVE_NEWTON_DECREMENT_H

#include "solve/level_hessian.h"

/* The level's matrix becomes that of `now`, factored: the Hessian, or with `exact` 0 the Gauss-Newton matrix. Where the
 * energy is all but zero, the level's least shift is less than is known of the matrix: then with as much more.
 * *positive: as co_newton_system_factorize. ERROR_MEMORY. */
int32_t co_newton_decrement_factorize(co_level_hessian *hessian, const co_iterate *now, int exact, int *positive,
                                      curvopt_error *error);
/* By the factor that the matrix has. ERROR_MEMORY. */
int32_t co_newton_decrement_by_factor(co_level_hessian *hessian, const co_iterate *now, double *decrement,
                                      curvopt_error *error);
/* Over all variables: by the Hessian, or by the Gauss-Newton matrix where that has negative directions; NAN where
 * neither has a factor. `is_indefinite`: the Hessian is known to have no factor here. The factor is spent.
 * ERROR_MEMORY. */
int32_t co_newton_decrement(co_level_hessian *hessian, const co_iterate *now, int is_indefinite, double *decrement,
                            curvopt_error *error);

#endif
