/* Nearness to the input cage. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_STRENGTH_H
#define CO_SOLVE_STRENGTH_H

#include "constraints/constraints.h"
#include "energy/adaptive_quadrature.h"
#include "solve/run_context.h"

/* Whether options.strength or options.within keep a surface near its input. */
int co_strength_stays_near(const curvopt_options *options);
/* Adds to the constraints of the input cage xyz [3 n_vertices] the springs that these ask for. `assembly` is the
 * cage's, and has been resolved there. On failure there are no constraints any more. ERROR_MEMORY. */
int32_t co_strength_hold(const co_run_context *run, const curvopt_mesh *mesh, const double *xyz,
                         const co_assembly *assembly, co_constraints *constraints, curvopt_error *error);

#endif
