/* Whether a cage stands already. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/standing_start.h"

#include "base/memory.h"
#include "solve/newton_decrement.h"

#include <math.h>
#include <stdlib.h>

/* Longest displacement of a vertex by a step of Gauss and Newton's method, in mean edges. */
static int32_t step_of(co_level *l, double *length, curvopt_error *error) {
    double *d = CO_NEW(double, co_level_objective_n(&l->objective));
    int positive = 0;
    int32_t status =
        d ? co_newton_decrement_factorize(&l->hessian, &l->now, 0, &positive, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK && positive)
        status = co_level_hessian_solve(&l->hessian, l->now.gradient, d, error);
    if (status == CURVOPT_OK && positive)
        *length = co_level_objective_length(&l->objective, d);
    free(d);
    return status;
}

/* What a first step over everything brings at most where a cage stands, in parts of the energy. One touch may raise
 * that by many times the mean of touches, in a single place. */
static double most_gain(const co_level *all) {
    const co_tuning *t = all->objective.run->tuning;
    if (!all->hessian.has_factor)
        return t->standing_gain;
    const double rise = co_level_hessian_touch_rise(&all->hessian) / fabs(all->now.value);
    return rise <= t->standing_gain ? fmax(t->standing_gain, t->standing_touches * rise) : t->standing_gain;
}

int32_t co_standing_start_look(co_level *all, const co_symmetry *symmetry, const co_constraints *constraints,
                               const double *start, int *stands, curvopt_error *error) {
    const co_run_context *run = all->objective.run;
    co_level *l = NULL;
    double gain, length = (double)INFINITY;
    *stands = 0;
    int32_t status = co_level_first_gain(all, &gain, error);
    if (status != CURVOPT_OK || !(gain <= most_gain(all)))
        return status;
    status = co_level_create(run, all->objective.mesh, symmetry, constraints, CO_MOTION_NORMALS, start, all->number, &l,
                             error);
    if (status == CURVOPT_OK) {
        l->working_tolerance = l->tolerance * run->tuning->working_forming;
        status = co_level_begin(l, error);
    }
    if (status == CURVOPT_OK && l->hessian.exists)
        status = step_of(l, &length, error);
    co_level_destroy(l);
    *stands = status == CURVOPT_OK && length <= run->tuning->standing_step;
    return status;
}
