/* Limited-memory variable metric minimization (L-BFGS). SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_OPTIMIZE_LBFGS_H
#define CO_OPTIMIZE_LBFGS_H

#include "base/status.h"
#include "optimize/step_control.h"

/* From `now` (value and gradient filled in) to the last accepted iterate, in place. With a preconditioner it converges
 * by the decrement, too, when that was small in tuning.lbfgs_small_steps steps in a row. ERROR_MEMORY only. */
int32_t co_lbfgs(const co_objective *f, const co_method_options *options, co_iterate *now, co_outcome *outcome,
                 curvopt_error *error);

#endif
