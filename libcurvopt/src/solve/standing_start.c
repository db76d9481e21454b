/* Whether a cage stands already. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/standing_start.h"

#include "base/memory.h"
#include "solve/newton_decrement.h"

#include <math.h>
#include <stdlib.h>

/* Whether the cage may be the result of another run: none that this one has just made. */
static int may_stand(const co_run *r, const co_level *l) {
    return l->number == 1 && r->context.options->spacing == CURVOPT_SPACING_EVEN && !r->context.held && !r->is_live &&
           r->sliding.n_sliding == 0 && !r->prospect.expects_plateau && l->hessian.exists;
}

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

/* The same along the normals of the run's first cage. */
static int32_t step_along_normals(const co_run *r, double *length, curvopt_error *error) {
    co_level *l = NULL;
    *length = (double)INFINITY;
    int32_t status = co_level_create(&r->context, r->result->mesh, &r->at.symmetry, &r->constraints, CO_MOTION_NORMALS,
                                     r->at.start, 1, &l, error);
    if (status == CURVOPT_OK) {
        l->working_tolerance = l->tolerance * r->context.tuning->working_third;
        status = co_level_begin(l, error);
    }
    if (status == CURVOPT_OK && l->hessian.exists)
        status = step_of(l, length, error);
    co_level_destroy(l);
    return status;
}

int32_t co_standing_start_look(const co_run *r, co_level *l, int *stands, curvopt_error *error) {
    const co_tuning *t = r->context.tuning;
    double gain, length;
    *stands = 0;
    if (!may_stand(r, l))
        return CURVOPT_OK;
    int32_t status = co_level_first_gain(l, &gain, error);
    if (status != CURVOPT_OK || !(gain <= t->standing_gain))
        return status;
    status = step_along_normals(r, &length, error);
    *stands = status == CURVOPT_OK && length <= t->standing_step;
    return status;
}
