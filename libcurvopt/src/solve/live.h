/* A solver that stays: one level of a cage, solved again and again while its targets move.
 *
 * What is kept: the mesh, basis tables and threads as long as the solver; with the arrangement of the constraints, the
 * energy's patches, the pattern of the matrices and their symbolic factors; from one solution to the next the
 * quadrature rules, the last factor and where the level stands.
 *
 *     targets moved --> linear response by the last factor --> told --> rules reviewed --> L-BFGS by that factor
 *          --> passing: where it stands
 *          --> settled: the factor made anew, L-BFGS or Newton to the end, motion along normals, verdict
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LIVE_H
#define CO_SOLVE_LIVE_H

#include "solve/live_state.h"

/* As curvopt_solver_create: options are the library's, with AUTO resolved. */
int32_t co_live_create(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                       const co_tuning *tuning, curvopt_solver **out, curvopt_error *error);
void co_live_destroy(curvopt_solver *solver);
/* As curvopt_solver_set_options, curvopt_solver_set_places, curvopt_solver_set_positions, curvopt_solver_solve. */
int32_t co_live_set_options(curvopt_solver *solver, const curvopt_options *options, curvopt_error *error);
int32_t co_live_set_places(curvopt_solver *solver, const double *places, curvopt_error *error);
int32_t co_live_set_positions(curvopt_solver *solver, const double *xyz, curvopt_error *error);
int32_t co_live_solve(curvopt_solver *solver, int32_t settle, curvopt_progress_fn progress, void *user,
                      const curvopt_cancel *cancel, curvopt_error *error);

#endif
