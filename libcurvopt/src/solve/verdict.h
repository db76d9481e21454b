/* The verdict on where a run ended. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_VERDICT_H
#define CO_SOLVE_VERDICT_H

#include "solve/run.h"

/* Whether the present level's result is one to look at more closely. */
int co_run_wants_verdict(const co_run *run);
/* The verdict on the level's result, into the summary. `normals`: a level of motion along normals there, begun by the
 * level's rules; NULL: one is made where it is needed. As co_level_create. */
int32_t co_run_certify(co_run *run, co_level *level, co_level *normals, curvopt_error *error);
/* Newton's method has ended by matrices that are off by a little, or by a step that was small by its shift, and by the
 * Hessian that is not stationary, or a saddle of the shape (libcurvopt/notes/52-when-newtons-method-has-converged.md).
 */
int co_run_is_unfinished(const co_run *run, const co_level *level);

#endif
