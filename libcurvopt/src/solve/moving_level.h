/* The first level of a run at which a vertex may move. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_MOVING_LEVEL_H
#define CO_SOLVE_MOVING_LEVEL_H

#include "constraints/constraints.h"

/* constraints: those of the cage at xyz [3 n_vertices], faces that are left out among them, without the boundary's.
 * *level: 1 .. levels, 0 if there is none. Nothing is subdivided where that is 1. ERROR_SIZE, ERROR_MEMORY. */
int32_t co_moving_level_find(const curvopt_mesh *mesh, const double *xyz, const co_constraints *constraints,
                             int32_t boundary, int32_t levels, int32_t *level, curvopt_error *error);

/* The same from the options of a run: curvopt_find_moving_level. */
int32_t co_moving_level_of_run(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                               int32_t *level, curvopt_error *error);

#endif
