/* Whether a cage stands already. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/standing_start.h"

#include "base/memory.h"
#include "linalg/vector.h"
#include "solve/newton_decrement.h"

#include <math.h>
#include <stdlib.h>

/* Whether the cage may be the result of another run: none that this one has just made. */
static int may_stand(const co_run *r, int32_t number) {
    return number == 1 && r->context.options->spacing == CURVOPT_SPACING_EVEN && !r->context.held && !r->is_live &&
           r->sliding.n_sliding == 0 && !r->prospect.expects_plateau;
}

/* Whether a step of Gauss and Newton's method is short, and the energy stays what it is. */
static int32_t look(co_level *l, int *stands, curvopt_error *error) {
    const co_tuning *t = l->objective.run->tuning;
    const size_t n = co_level_objective_n(&l->objective);
    double *d = CO_NEW(double, n);
    int positive = 0;
    int32_t status =
        d ? co_newton_decrement_factorize(&l->hessian, &l->now, 0, &positive, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK && positive)
        status = co_level_hessian_solve(&l->hessian, l->now.gradient, d, error);
    if (status == CURVOPT_OK && positive)
        *stands = co_level_objective_length(&l->objective, d) <= t->standing_step &&
                  0.5 * co_vector_dot(n, d, l->now.gradient) <= t->standing_gain * fabs(l->now.value);
    free(d);
    return status;
}

int32_t co_standing_start_look(const co_run *r, int32_t number, int *stands, curvopt_error *error) {
    const co_tuning *t = r->context.tuning;
    co_level *l = NULL;
    *stands = 0;
    if (!may_stand(r, number))
        return CURVOPT_OK;
    int32_t status = co_level_create(&r->context, r->result->mesh, &r->at.symmetry, &r->constraints, CO_MOTION_NORMALS,
                                     r->at.start, number, &l, error);
    if (status == CURVOPT_OK) {
        l->working_tolerance = l->tolerance * t->working_third;
        status = co_level_begin(l, error);
    }
    if (status == CURVOPT_OK && l->hessian.exists && co_level_objective_n(&l->objective))
        status = look(l, stands, error);
    co_level_destroy(l);
    return status;
}
