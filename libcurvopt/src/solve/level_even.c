/* A level whose faces fold while its shape forms. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level_even.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A shape keeps its Jacobian with so much of what it had, or with so much. */
static const double KEPT_PART = 0.5, KEPT = 0.3;
/* A shape with walls may have so much of the energy of the one without. */
static const double MOST_ENERGY = 1.1;

/* On the first level, where there is no shape yet; finer ones have little to fold for. */
static int may_begin(const co_level *l) {
    return l->number == 1 && l->is_forming && co_level_wants_even(l) && !l->objective.assembly.functional.has_third;
}

static void go_to(co_level *l, const double *x) {
    memcpy(l->now.x, x, co_level_n(l) * sizeof *x);
    co_level_evaluate(l, &l->now);
}

static void forget(co_level *l) {
    free(l->formed.x);
    l->formed = (co_formed){0};
}

static int32_t remember(co_level *l, curvopt_error *error) {
    const size_t n = co_level_n(l);
    l->formed = (co_formed){.x = CO_NEW(double, n), .energy = co_level_objective_energy(&l->objective, &l->now)};
    if (!l->formed.x)
        return co_status_no_memory(error);
    memcpy(l->formed.x, l->now.x, n * sizeof *l->now.x);
    return CURVOPT_OK;
}

int32_t co_level_begin_even(void *level, int *begun, curvopt_error *error) {
    co_level *l = level;
    const double jacobian = l->now.found[CO_FOUND_MIN_JACOBIAN];
    *begun = 0;
    if (!may_begin(l) || jacobian >= KEPT)
        return CURVOPT_OK;
    const int32_t status = remember(l, error);
    if (status != CURVOPT_OK)
        return status;
    go_to(l, l->review.first);
    if (!(jacobian < KEPT_PART * l->now.found[CO_FOUND_MIN_JACOBIAN])) {
        go_to(l, l->formed.x);
        forget(l);
        return CURVOPT_OK;
    }
    *begun = 1;
    co_step_review_begin(&l->review, l->now.x, l->now.found[CO_FOUND_DEFECT]);
    co_level_objective_place(&l->objective, l->now.x);
    return co_level_objective_wall_corners(&l->objective, error);
}

void co_level_end_even(void *level) {
    co_level *l = level;
    const double energy = co_level_objective_energy(&l->objective, &l->now);
    co_corner_walls_free(&l->objective.corners);
    if (!(energy <= MOST_ENERGY * l->formed.energy)) {
        memcpy(l->review.safe, l->formed.x, co_level_n(l) * sizeof *l->now.x);
        co_step_review_take_back(&l->review, &l->now);
        if (isfinite(l->now.value)) /* as it is not where the run is cancelled in the middle of it */
            co_level_weigh_spacing(l);
    }
    forget(l);
}
