/* A level's minimum, in stages. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_STAGES_H
#define CO_STAGES_H

#include "level.h"

/* From `now`, in place. level->report is told of every step. As curvopt_minimize. */
int32_t co_stages_solve(co_level *level, co_iterate *now, co_outcome *result, curvopt_error *error);

#endif
