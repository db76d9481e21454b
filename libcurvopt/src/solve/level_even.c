/* A level whose faces fold while its shape forms. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level_even.h"

#include "base/memory.h"
#include "mesh/jacobian.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A result keeps its Jacobian with so much of what it had, or with so much. */
static const double KEPT_PART = 0.5, KEPT = 0.3;
/* A shape with walls may have so much of the energy of the one without. */
static const double MOST_ENERGY = 1.1;

static int32_t least_jacobian(co_level *l, const double *x, double *out, curvopt_error *error) {
    co_level_objective *o = &l->objective;
    co_level_objective_place(o, x);
    return co_jacobian_least(o->mesh, o->held.left_out, co_level_objective_cage(o), out, error);
}

static int may_begin(const co_level *l) {
    return l->is_forming && co_level_wants_even(l) && !l->objective.assembly.functional.has_third;
}

int32_t co_level_begin_even(void *level, int *begun, curvopt_error *error) {
    co_level *l = level;
    const size_t n = co_level_n(l);
    double before;
    *begun = 0;
    if (!may_begin(l))
        return CURVOPT_OK;
    int32_t status = least_jacobian(l, l->review.first, &before, error);
    if (status == CURVOPT_OK)
        status = least_jacobian(l, l->now.x, &l->formed.jacobian, error);
    if (status != CURVOPT_OK || l->formed.jacobian >= fmin(KEPT_PART * before, KEPT))
        return status;
    l->formed.x = CO_NEW(double, n);
    if (!l->formed.x)
        return co_status_no_memory(error);
    memcpy(l->formed.x, l->now.x, n * sizeof *l->now.x);
    l->formed.energy = co_level_objective_energy(&l->objective, &l->now);
    memcpy(l->now.x, l->review.first, n * sizeof *l->now.x);
    co_level_evaluate(l, &l->now);
    co_step_review_begin(&l->review, l->now.x, l->now.found[CO_FOUND_DEFECT]);
    *begun = 1;
    co_level_objective_place(&l->objective, l->now.x);
    return co_level_objective_wall_corners(&l->objective, error);
}

int32_t co_level_end_even(void *level, curvopt_error *error) {
    co_level *l = level;
    double jacobian;
    co_corner_walls_free(&l->objective.corners);
    const int32_t status = least_jacobian(l, l->now.x, &jacobian, error);
    const double energy = co_level_objective_energy(&l->objective, &l->now);
    if (status == CURVOPT_OK && !(jacobian > l->formed.jacobian && energy <= MOST_ENERGY * l->formed.energy)) {
        memcpy(l->review.safe, l->formed.x, co_level_n(l) * sizeof *l->now.x);
        co_step_review_take_back(&l->review, &l->now);
        if (isfinite(l->now.value)) /* as it is not where the run is cancelled in the middle of it */
            co_level_weigh_spacing(l);
    }
    free(l->formed.x);
    l->formed.x = NULL;
    return status;
}
