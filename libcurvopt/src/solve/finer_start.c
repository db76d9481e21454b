/* Where a finer level begins if vertices are held. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/finer_start.h"

#include "base/memory.h"
#include "constraints/given_constraints.h"
#include "energy/assembly.h"
#include "mesh/fill.h"
#include "solve/run_start.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a surface that is far from folded. */
static const double EVEN_JACOBIAN = 0.3;

static size_t n_of(const curvopt_mesh *m) {
    return 3 * (size_t)m->info.n_vertices;
}

static int may_follow(const co_run *r) {
    return r->constraints.freedom && !r->constraints.springs.stiffness && !r->context.options->no_crossings &&
           !r->context.held && !co_given_constraints_move_cage(&r->constraints);
}

/* Vertices that nothing holds, and that are in no limit point that is held. */
static void find_free(const curvopt_mesh *m, const co_constraints *all, uint8_t *is_free) {
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        is_free[v] = all->freedom[v] == CO_FREEDOM_ALL;
    for (int32_t h = 0; h < m->info.n_corners; h++) {
        const int32_t f = m->corner_face[h];
        for (int32_t k = m->face_start[f]; all->of_limit[m->corner_vertex[h]] && k < m->face_start[f + 1]; k++)
            is_free[m->corner_vertex[k]] = 0;
    }
}

/* moved [3 n_vertices]: where all follow. */
static int32_t follow(co_run *r, const curvopt_mesh *fine, const double *before, const double *xyz, double *moved,
                      curvopt_error *error) {
    co_constraints all = {0};
    uint8_t *is_free = CO_NEW(uint8_t, fine->info.n_vertices);
    int32_t status = is_free ? co_constraints_all(fine, &r->constraints, r->context.options->boundary, &all, error)
                             : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        find_free(fine, &all, is_free);
        for (size_t i = 0; i < n_of(fine); i++)
            moved[i] = xyz[i] - before[i];
        status = co_mesh_fill(fine, is_free, r->threads, &r->cancel, moved, error);
    }
    for (size_t i = 0; status == CURVOPT_OK && i < n_of(fine); i++)
        moved[i] = is_free[i / 3] ? before[i] + moved[i] : xyz[i];
    co_constraints_free(&all);
    free(is_free);
    return status;
}

/* *better: whether `moved` has less of the objective than xyz, and is no nearer to a fold. */
static int32_t compare(co_run *r, const curvopt_mesh *fine, const double *xyz, const double *moved, int *better,
                       curvopt_error *error) {
    const co_request request = {.is_normalized = 1};
    co_assembly assembly;
    co_values values, of_moved;
    const int32_t status = co_run_create_assembly(r, fine, xyz, &assembly, error);
    if (status != CURVOPT_OK)
        return status;
    co_assembly_evaluate(&assembly, xyz, &request, &values);
    co_assembly_evaluate(&assembly, moved, &request, &of_moved);
    *better =
        of_moved.objective < values.objective && of_moved.min_jacobian >= fmin(values.min_jacobian, EVEN_JACOBIAN);
    co_assembly_free(&assembly);
    return CURVOPT_OK;
}

int32_t co_finer_start_choose(co_run *r, const curvopt_mesh *fine, const double *before, double *xyz,
                              curvopt_error *error) {
    int better = 0;
    if (!may_follow(r) || memcmp(before, xyz, n_of(fine) * sizeof *xyz) == 0)
        return CURVOPT_OK;
    double *moved = CO_NEW(double, n_of(fine));
    int32_t status = moved ? follow(r, fine, before, xyz, moved, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = compare(r, fine, xyz, moved, &better, error);
    if (status == CURVOPT_OK && better)
        memcpy(xyz, moved, n_of(fine) * sizeof *xyz);
    free(moved);
    return status == CO_CANCELLED ? CURVOPT_OK : status;
}
