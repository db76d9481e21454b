/* What a run begins with: constraints, exceptions, symmetries, figures of the input cage.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_RUN_START_H
#define CO_SOLVE_RUN_START_H

#include "solve/run.h"

/* From a run that has its options, tuning, tables and whom to tell to one that is about to solve its first level.
 * `mesh` is copied. Whatever the status, what it made is to be freed by co_run_free_parts(), and run->result by
 * co_run_result_destroy(). As curvopt_minimize; CO_CANCELLED. */
int32_t co_run_start(co_run *run, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error);
/* Frees what the run has, but for its result, its tables and threads. */
void co_run_free_parts(co_run *run);

/* Leaves of run->at.symmetry what can be kept beside the entries on `mesh`; refuses to give up chosen planes.
 * ERROR_GEOMETRY, ERROR_MEMORY. */
int32_t co_run_restrict_symmetry(co_run *run, const curvopt_mesh *mesh, curvopt_error *error);
/* The symmetries that are kept of the cage run->at.start. As curvopt_minimize. */
int32_t co_run_find_symmetry(co_run *run, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error);
/* Takes the present cage as that by which half discs are chosen. ERROR_MEMORY. */
int32_t co_run_take_shape(co_run *run, curvopt_error *error);
/* Energies of the present cage run->at.xyz, by an assembly of its own. As curvopt_problem_evaluate, CO_CANCELLED. */
int32_t co_run_evaluate(co_run *run, curvopt_energies *out, curvopt_error *error);
/* Where the result's half discs (blend_disc_half.h) are not those that the level began with, its figures are taken
 * again: they are to be those of the cage that the caller gets. As curvopt_minimize. */
int32_t co_run_report_end(co_run *run, const co_level *level, curvopt_error *error);
/* What the summary says by Hessians is not known. */
void co_run_forget_verdict(curvopt_summary *summary);

#endif
