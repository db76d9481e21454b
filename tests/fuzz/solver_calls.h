/* Calls of a solver that stays, in any order. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEST_FUZZ_SOLVER_CALLS_H
#define TEST_FUZZ_SOLVER_CALLS_H

#include "curvopt.h"
#include "reader.h"

enum { SOLVER_MOST_VERTICES = 40 };

/* On xyz [3 n_vertices]; what is refused has a message, what is not is finite. */
void call_solver(reader *r, const curvopt_mesh *mesh, int32_t n_vertices, const double *xyz,
                 const curvopt_options *options);

#endif
