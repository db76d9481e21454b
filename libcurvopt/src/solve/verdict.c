/* The verdict on where a run ended. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/verdict.h"

#include "base/constants.h"
#include "solve/certificate.h"
#include "solve/level_figures.h"
#include "solve/newton_decrement.h"

#include <math.h>

enum { LARGEST_CERTIFIED = CURVOPT_MAX_CERTIFIED_VERTICES }; /* vertices */

/* What is asked for besides: the shape without its symmetries, everything without them. */
static int32_t verify_without_symmetry(co_run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    int32_t status = co_certificate_count_negative(&r->context, mesh, &r->constraints, CO_MOTION_NORMALS, r->at.xyz,
                                                   &summary->free_negative_directions, error);
    return status == CURVOPT_OK ? co_certificate_count_negative(&r->context, mesh, &r->constraints, CO_MOTION_ALL,
                                                                r->at.xyz, &summary->all_negative_directions, error)
                                : status;
}

/* What can be said of the shape: by the level itself where that moves along normals, else by another one. */
static int32_t check_shape(co_run *r, co_level *l, co_level *normals, co_certificate_shape *shape,
                           curvopt_error *error) {
    co_level *other = NULL;
    int32_t status = CURVOPT_OK;
    if (l->motion != CO_MOTION_NORMALS && !normals)
        status = co_certificate_level(&r->context, l->objective.mesh, &r->at.symmetry, &r->constraints, r->at.xyz, l,
                                      &other, error);
    if (status == CURVOPT_OK)
        status = co_certificate_check_shape(normals ? normals
                                            : other ? other
                                                    : l,
                                            r->context.options->verify, shape, error);
    co_level_destroy(other);
    return status;
}

/* Relative distance of a held number from what it is to be that is none. */
static const double HELD = 1e-8;

/* Whether the run has not come to the numbers that are held. */
static int misses_numbers(const co_run *r) {
    int misses = 0;
    for (int s = 0; s < CURVOPT_N_SCALARS; s++)
        misses |= !(fabs(r->at.residual[s]) <= HELD);
    return misses;
}

/* Whether energy and springs have come to 0 but for rounding: nothing is less, whatever a matrix of rounding says. */
static int is_flat(const co_run *r) {
    return fabs(r->at.energies.objective) + fabs(r->at.penalty - r->context.least) <= CO_FLAT_ENERGY;
}

/* Whether a result that is touched and minimized again has the same problem: near the input it is another one's. */
static int goes_back(const co_run *r) {
    return r->context.options->strength == 1 && r->context.options->within == 0;
}

int32_t co_run_certify(co_run *r, co_level *l, co_level *normals, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    const int is_own = l->motion == CO_MOTION_NORMALS && !normals; /* the level whose shape is checked */
    co_certificate_shape shape;
    if (r->context.held) /* a level that was tried and left may have had others */
        *r->context.held = l->objective.numbers.numbers;
    co_level_objective_evaluate(&l->objective, &l->now); /* by the rules that co_level_finish() has settled on */
    int32_t status = check_shape(r, l, normals, &shape, error);
    if (status != CURVOPT_OK || co_run_context_is_cancelled(&r->context)) /* what was found stands; no verdict */
        return status;
    summary->newton_decrement = shape.decrement;
    if (l->motion != CO_MOTION_NORMALS || isnan(shape.decrement))
        status = co_newton_decrement(&l->hessian, &l->now, is_own && isnan(shape.decrement), &summary->newton_decrement,
                                     error);
    if (status != CURVOPT_OK)
        return status;
    summary->shape_decrement = shape.decrement;
    summary->difference_decrement = shape.difference_decrement;
    summary->negative_directions = shape.negative_directions;
    const double value = r->at.energies.objective + r->at.penalty;
    summary->verdict = is_flat(r) ? CURVOPT_VERDICT_MINIMUM
                                  : co_certificate_verdict(r->context.tuning, value, summary->newton_decrement, &shape);
    if (misses_numbers(r))
        summary->verdict = CURVOPT_VERDICT_NOT_STATIONARY;
    summary->touch_rise = shape.touch_rise;
    summary->is_delicate = summary->verdict == CURVOPT_VERDICT_MINIMUM && !is_flat(r) && goes_back(r) &&
                           !(shape.touch_rise <= r->context.tuning->delicate_rise * fabs(value));
    return r->context.options->verify ? verify_without_symmetry(r, l->objective.mesh, error) : CURVOPT_OK;
}

int co_run_wants_verdict(const co_run *r) {
    return !r->context.options->joshi_sequin && r->at.report.stop != CURVOPT_STOP_CANCELLED &&
           r->result->mesh->info.n_vertices <= LARGEST_CERTIFIED;
}

int co_run_is_unfinished(const co_run *r, const co_level *l) {
    const int stop = r->at.report.stop, verdict = r->result->summary.verdict;
    return l->hessian.exists && co_run_wants_verdict(r) &&
           (stop == CURVOPT_STOP_CONVERGED || stop == CURVOPT_STOP_STALLED) &&
           (verdict == CURVOPT_VERDICT_NOT_STATIONARY ||
            (verdict == CURVOPT_VERDICT_SADDLE && l->motion == CO_MOTION_NORMALS)); /* not by what slides */
}
