/* A level of a run. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/run_level.h"

#include "base/memory.h"
#include "constraints/given_constraints.h"
#include "mesh/subdivide.h"
#include "solve/held_scalars.h"
#include "solve/run_start.h"
#include "solve/slide.h"
#include "solve/symmetry_reduction.h"
#include "solve/tangent_choice.h"
#include "solve/verdict.h"

#include <stdlib.h>
#include <string.h>

int co_run_level_ends_run(const co_run *r, int32_t number) {
    return co_run_context_is_last(&r->context, number) || co_run_stopped_early(r);
}

/* What holds the result, where no crossings are wanted. */
static int32_t note_touching(co_run *r, co_level *l, curvopt_error *error) {
    const co_run_context *run = &r->context;
    co_level_objective *o = &l->objective;
    curvopt_summary *summary = &r->result->summary;
    if (!o->repulsion.mesh)
        return CURVOPT_OK;
    free(r->result->touching);
    co_level_objective_place(o, l->now.x);
    int32_t status = co_no_crossings_touching(&o->repulsion, o->positions, &r->result->touching, &summary->n_touching,
                                              &summary->clearance, error);
    summary->clearance *= o->is_framed ? run->radius : co_run_size_unit(&run->size, l->now.found[CO_FOUND_SIZE]);
    return status;
}

/* The figures of the run's end, and the verdict. */
static int32_t judge(co_run *r, co_level *l, curvopt_error *error) {
    int32_t status = co_run_report_end(r, l, error);
    if (status == CURVOPT_OK)
        status = note_touching(r, l, error);
    return status == CURVOPT_OK && co_run_wants_verdict(r) ? co_run_certify(r, l, NULL, error) : status;
}

int32_t co_run_level_solve(co_run *r, int32_t number, curvopt_error *error) {
    co_level *level = NULL;
    r->lost_steps = 0; /* of the level before, where vertices slide first */
    int32_t status = co_run_take_shape(r, error);
    if (status == CURVOPT_OK)
        status = co_slide_level(r, number, error);
    if (status == CURVOPT_OK)
        status = co_tangent_choice_make(r, number, error);
    if (status == CURVOPT_OK) /* which these may have moved */
        status = co_run_take_shape(r, error);
    if (number == 1)
        r->result->summary.n_sliding = r->sliding.n_sliding;
    if (status == CURVOPT_OK && !r->is_asked_to_stop)
        status = co_symmetry_reduction_solve(r, number, &level, error);
    co_sliding_measure(&r->sliding, r->at.xyz);
    const int ends = level && co_run_level_ends_run(r, number);
    if (status == CURVOPT_OK && ends)
        status = judge(r, level, error);
    if (status == CURVOPT_OK && ends && co_run_is_unfinished(r, level)) {
        status = co_run_solve_on(r, level, error);
        if (status == CURVOPT_OK)
            status = judge(r, level, error);
    }
    r->result->level[number - 1] = r->at.report;
    if (status == CO_CANCELLED) /* there is no verdict */
        status = CURVOPT_OK;
    if (status == CURVOPT_OK && r->no_crossings.exceptions.failed != CURVOPT_OK)
        status = co_status_no_memory(error);
    co_level_destroy(level);
    return status;
}

int32_t co_run_level_subdivide(co_run *r, curvopt_error *error) {
    curvopt_mesh *fine = NULL;
    co_sparse_rows rows = {0};
    double *xyz = NULL, *start = NULL;
    int32_t status = co_subdivide_cage(r->result->mesh, r->at.xyz, &fine, &rows, &xyz, error);
    if (status == CURVOPT_OK) {
        start = CO_NEW(double, 3 * (size_t)rows.n_rows);
        status = start ? CURVOPT_OK : co_status_no_memory(error);
    }
    if (status == CURVOPT_OK)
        status = co_constraints_subdivide(r->result->mesh, fine, &rows, xyz, &r->constraints, error);
    if (status == CURVOPT_OK && co_chains_hold_any(&r->constraints.chains))
        status = co_given_constraints_place(fine, &r->constraints, r->context.options->boundary, xyz, error);
    if (status == CURVOPT_OK)
        status = co_symmetry_subdivide(&r->at.symmetry, error);
    if (status == CURVOPT_OK)
        status = co_run_restrict_symmetry(r, fine, error);
    if (status == CURVOPT_OK)
        status = co_sliding_subdivide(r->result->mesh, &r->sliding, error);
    if (status == CURVOPT_OK && r->context.options->no_crossings)
        status = co_no_crossings_subdivide(r->result->mesh, fine, xyz, r->threads, r->context.cancel, &r->no_crossings,
                                           error);
    if (status != CURVOPT_OK) {
        free(xyz);
        free(start);
        co_mesh_destroy(fine);
    } else {
        memcpy(start, xyz, sizeof(double) * 3 * (size_t)rows.n_rows);
        free(r->at.xyz);
        free(r->at.start);
        free(r->at.turn);
        r->at.turn = NULL;
        co_mesh_destroy(r->result->mesh);
        r->at.xyz = xyz;
        r->at.start = start;
        r->result->mesh = fine;
    }
    co_sparse_rows_free(&rows);
    return status;
}
