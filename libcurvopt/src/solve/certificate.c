/* Whether a cage is a stationary point, and of what kind. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/certificate.h"

#include "base/constants.h"
#include "base/memory.h"
#include "linalg/vector.h"
#include "mesh/similarity.h"
#include "solve/conjugate_decrement.h"
#include "solve/newton_decrement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What products with the Hessian by differences need. */
typedef struct differences {
    co_level *level;
    double *trial;    /* [n] */
    double *gradient; /* [n] */
} differences;

/* With what slides on normals: that is stiff in the Newton system, not left out of its matrix. */
static void whole_gradient_at(co_level *l, double *z, double *gradient) {
    co_iterate at = {.x = z, .gradient = gradient};
    const int n_sliding = l->objective.n_sliding;
    l->objective.n_sliding = 0;
    co_level_objective_evaluate(&l->objective, &at);
    l->objective.n_sliding = n_sliding;
}

/* out = Hessian v, by a central difference; shifted, and rigid motions and scaling left out, as of the Newton system
 * whose decrement it is to confirm. */
static void multiply(void *context, const double *v, double *out) {
    const differences *d = context;
    co_level *l = d->level;
    const co_level_objective *o = &l->objective;
    size_t n = co_level_objective_n(o);
    double step = CO_DIFFERENCE_STEP * o->edge / co_dof_map_longest(&o->reduction, v);
    memcpy(d->trial, l->now.x, n * sizeof *d->trial);
    co_vector_add(n, step, v, d->trial);
    whole_gradient_at(l, d->trial, out);
    co_vector_add(n, -2 * step, v, d->trial);
    whole_gradient_at(l, d->trial, d->gradient);
    for (size_t i = 0; i < n; i++)
        out[i] = (out[i] - d->gradient[i]) / (2 * step);
    co_vector_add(n, co_level_hessian_least_shift(&l->hessian, l->now.value), v, out);
    co_newton_system_remove_motions(&l->hessian.system, out);
}

static int32_t precondition(void *context, const double *v, double *out, curvopt_error *error) {
    const differences *d = context;
    return co_level_hessian_solve(&d->level->hessian, v, out, error);
}

static int32_t difference_decrement(co_level *l, double *decrement, curvopt_error *error) {
    size_t n = co_level_objective_n(&l->objective);
    double *work = CO_NEW(double, 2 * n);
    differences d = {.level = l, .trial = work, .gradient = work + n};
    const co_linear_system system = {.context = &d, .n = n, .multiply = multiply, .precondition = precondition};
    int32_t status =
        work ? co_conjugate_decrement(&system, l->now.gradient, decrement, error) : co_status_no_memory(error);
    free(work);
    return status;
}

int32_t co_certificate_level(const co_run_context *run, const curvopt_mesh *m, const co_symmetry *symmetry,
                             const co_constraints *constraints, const double *xyz, const co_level *solved,
                             co_level **out, curvopt_error *error) {
    int32_t status =
        co_level_create(run, m, symmetry, constraints, CO_MOTION_NORMALS, xyz, run->options->levels, out, error);
    if (status != CURVOPT_OK)
        return status;
    return solved ? co_level_begin_by_rules_of(*out, solved, error) : co_level_begin(*out, error);
}

int32_t co_certificate_check_shape(co_level *l, int differences, co_certificate_shape *out, curvopt_error *error) {
    int positive;
    *out = (co_certificate_shape){.negative_directions = 0};
    if (co_level_objective_n(&l->objective) == 0)
        return CURVOPT_OK;
    int32_t status = co_newton_decrement_factorize(&l->hessian, &l->now, 1, &positive, error);
    if (status != CURVOPT_OK)
        return status;
    out->touch_rise = co_level_hessian_touch_rise(&l->hessian);
    out->decrement = out->difference_decrement = (double)NAN;
    l->hessian.has_factor = positive;
    if (!positive)
        return co_level_hessian_count_negative(&l->hessian, &l->now, 1, &out->negative_directions, &out->decrement,
                                               error);
    status = co_newton_decrement_by_factor(&l->hessian, &l->now, &out->decrement, error);
    if (status == CURVOPT_OK && differences)
        status = difference_decrement(l, &out->difference_decrement, error);
    return status;
}

int32_t co_certificate_count_negative(const co_run_context *run, const curvopt_mesh *m,
                                      const co_constraints *constraints, co_motion motion, const double *xyz,
                                      int32_t *n_negative, curvopt_error *error) {
    co_symmetry none = {0};
    co_level *level = NULL;
    double decrement;
    int32_t status = co_symmetry_none(m, &none, error);
    if (status == CURVOPT_OK)
        status = co_level_create(run, m, &none, constraints, motion, xyz, run->options->levels, &level, error);
    if (status == CURVOPT_OK)
        status = co_level_begin(level, error);
    if (status == CURVOPT_OK)
        status = co_level_hessian_count_negative(&level->hessian, &level->now, 0, n_negative, &decrement, error);
    co_level_destroy(level);
    co_symmetry_free(&none);
    return status;
}

int32_t co_certificate_verdict(const co_tuning *t, double objective, double decrement,
                               const co_certificate_shape *shape) {
    double most = t->certificate_stationary * fabs(objective);
    if (shape->negative_directions < 0 || isnan(decrement))
        return CURVOPT_VERDICT_UNKNOWN;
    if (!(decrement <= most))
        return CURVOPT_VERDICT_NOT_STATIONARY;
    if (shape->negative_directions > 0)
        return CURVOPT_VERDICT_SADDLE;
    return shape->decrement <= most ? CURVOPT_VERDICT_MINIMUM : CURVOPT_VERDICT_NOT_STATIONARY;
}
