/* Where a finer level begins if vertices are held (libcurvopt/notes/126-where-levels-begin.md).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_FINER_START_H
#define CO_SOLVE_FINER_START_H

#include "solve/run.h"

/* Held vertices of the finer cage xyz [3 n_vertices] have been put back, from where they were `before`, and stand out
 * alone. All others follow as a thin plate, if by the first rules the cage has less of the objective then, and is no
 * nearer to a fold. Not with springs, which may end somewhere, nor where nothing may cross, nor where the cage is
 * placed or numbers are held. If it is cancelled nothing has moved. ERROR_MEMORY, and as curvopt_problem_create. */
int32_t co_finer_start_choose(co_run *run, const curvopt_mesh *fine, const double *before, double *xyz,
                              curvopt_error *error);

#endif
