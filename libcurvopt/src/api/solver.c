/* Exported functions of a solver that stays. SPDX-License-Identifier: GPL-3.0-or-later */
#include "api/api.h"
#include "mesh/similarity.h"
#include "solve/live.h"

#include <string.h>

int32_t curvopt_solver_create(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                              curvopt_solver **out, curvopt_error *error) {
    if (!out)
        return co_api_null(error, "out");
    *out = NULL;
    curvopt_options own;
    int32_t status = co_api_take_cage(mesh, xyz, options, &own, error);
    return status == CURVOPT_OK ? co_live_create(mesh, xyz, &own, co_tuning_of_runs(), out, error) : status;
}

void curvopt_solver_destroy(curvopt_solver *solver) {
    co_live_destroy(solver);
}

int32_t curvopt_solver_set_places(curvopt_solver *solver, const double *places, curvopt_error *error) {
    if (!solver || !places)
        return co_api_null(error, solver ? "places" : "solver");
    return co_live_set_places(solver, places, error);
}

int32_t curvopt_solver_set_options(curvopt_solver *solver, const curvopt_options *options, curvopt_error *error) {
    if (!solver)
        return co_api_null(error, "solver");
    curvopt_options own;
    int32_t status = co_api_take_options(options, &own, error);
    return status == CURVOPT_OK ? co_live_set_options(solver, &own, error) : status;
}

int32_t curvopt_solver_set_positions(curvopt_solver *solver, const double *xyz, curvopt_error *error) {
    if (!solver)
        return co_api_null(error, "solver");
    return co_live_set_positions(solver, xyz, error);
}

int32_t curvopt_solver_solve(curvopt_solver *solver, int32_t settle, curvopt_progress_fn progress, void *user,
                             const curvopt_cancel *cancel, curvopt_error *error) {
    if (!solver)
        return co_api_null(error, "solver");
    if (settle != 0 && settle != 1)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "settle is %d; it must be 0 or 1", settle);
    return co_live_solve(solver, settle, progress, user, cancel, error);
}

void curvopt_solver_get_positions(const curvopt_solver *solver, double *xyz) {
    memcpy(xyz, solver->xyz, sizeof(double) * 3 * (size_t)solver->mesh->info.n_vertices);
}

void curvopt_solver_get_summary(const curvopt_solver *solver, curvopt_summary *summary, size_t size) {
    const curvopt_summary *own = &solver->run->result->summary;
    co_api_copy_out(summary, size, own, sizeof *own);
}

void curvopt_solver_get_energies(const curvopt_solver *solver, curvopt_energies *start, curvopt_energies *end,
                                 size_t size) {
    const curvopt_result *result = solver->run->result;
    if (start)
        co_api_copy_out(start, size, &result->start, sizeof result->start);
    if (end)
        co_api_copy_out(end, size, &result->end, sizeof result->end);
}

void curvopt_solver_get_report(const curvopt_solver *solver, curvopt_level_report *report, size_t size) {
    co_api_copy_out(report, size, &solver->run->result->level[0], sizeof(curvopt_level_report));
}
