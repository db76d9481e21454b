/* Newton's method, its matrix damped. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_OPTIMIZE_DAMPED_NEWTON_H
#define CO_OPTIMIZE_DAMPED_NEWTON_H

#include "base/status.h"
#include "optimize/step_control.h"

/* From `now` (value and gradient filled in) to the last accepted iterate, in place; f has what Newton's method needs.
 * ERROR_MEMORY only. */
int32_t co_damped_newton(const co_objective *f, const co_method_options *options, co_iterate *now, co_outcome *outcome,
                         curvopt_error *error);

#endif
