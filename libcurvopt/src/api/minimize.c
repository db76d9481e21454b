/* Exported functions that minimize. SPDX-License-Identifier: GPL-3.0-or-later */
#include "api/api.h"
#include "base/memory.h"
#include "solve/moving_level.h"
#include "solve/multilevel.h"

#include <stdlib.h>
#include <string.h>

int32_t curvopt_cancel_create(curvopt_cancel **out, curvopt_error *error) {
    if (!out)
        return co_api_null(error, "out");
    *out = CO_NEW(curvopt_cancel, 1);
    return *out ? CURVOPT_OK : co_status_no_memory(error);
}

void curvopt_cancel_request(curvopt_cancel *cancel) {
    atomic_store_explicit(&cancel->requested, 1, memory_order_relaxed);
}

void curvopt_cancel_destroy(curvopt_cancel *cancel) {
    free(cancel);
}

int32_t curvopt_find_moving_level(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                                  int32_t *level, curvopt_error *error) {
    if (!level)
        return co_api_null(error, "level");
    curvopt_options own;
    int32_t status = co_api_take_cage(mesh, xyz, options, &own, error);
    return status == CURVOPT_OK ? co_moving_level_of_run(mesh, xyz, &own, level, error) : status;
}

int32_t curvopt_minimize(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                         curvopt_progress_fn progress, void *user, const curvopt_cancel *cancel, curvopt_result **out,
                         curvopt_error *error) {
    if (!out)
        return co_api_null(error, "out");
    *out = NULL;
    curvopt_options own;
    int32_t status = co_api_take_cage(mesh, xyz, options, &own, error);
    if (status != CURVOPT_OK)
        return status;
    return co_multilevel_minimize(mesh, xyz, &own, co_tuning_of_runs(), progress, user, cancel, out, error);
}

void curvopt_result_destroy(curvopt_result *result) {
    co_run_result_destroy(result);
}

const curvopt_mesh *curvopt_result_mesh(const curvopt_result *result) {
    return result->mesh;
}

void curvopt_result_get_positions(const curvopt_result *result, double *xyz) {
    memcpy(xyz, result->xyz, sizeof(double) * 3 * (size_t)result->mesh->info.n_vertices);
}

void curvopt_result_get_summary(const curvopt_result *result, curvopt_summary *summary, size_t size) {
    co_api_copy_out(summary, size, &result->summary, sizeof result->summary);
}

void curvopt_result_get_touching(const curvopt_result *result, int32_t *pairs) {
    if (result->summary.n_touching)
        memcpy(pairs, result->touching, sizeof *pairs * 2 * (size_t)result->summary.n_touching);
}

void curvopt_result_get_energies(const curvopt_result *result, curvopt_energies *start, curvopt_energies *end,
                                 size_t size) {
    if (start)
        co_api_copy_out(start, size, &result->start, sizeof result->start);
    if (end)
        co_api_copy_out(end, size, &result->end, sizeof result->end);
}

int32_t curvopt_result_get_level(const curvopt_result *result, int32_t index, curvopt_level_report *report, size_t size,
                                 curvopt_error *error) {
    if (!result || !report)
        return co_api_null(error, result ? "report" : "result");
    if (index < 0 || index >= result->summary.n_levels)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "level %d of %d", index, result->summary.n_levels);
    co_api_copy_out(report, size, &result->level[index], sizeof result->level[index]);
    return CURVOPT_OK;
}
