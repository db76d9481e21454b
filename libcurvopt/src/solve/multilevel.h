/* Optimize, subdivide, repeat. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_MULTILEVEL_H
#define CO_SOLVE_MULTILEVEL_H

#include "solve/run.h"

/* As curvopt_minimize, whose arguments have been checked; options->surface is not AUTO. */
int32_t co_multilevel_minimize(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                               const co_tuning *tuning, curvopt_progress_fn progress, void *user,
                               const curvopt_cancel *cancel, curvopt_result **out, curvopt_error *error);

#endif
