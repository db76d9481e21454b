/* The answer of a level to targets that have moved.
 *
 * With g(z, p) the gradient over the variables z, p the places of what is held, and H its derivative by z, a minimum
 * moves by dz = -H^-1 (dg/dp) dp to first order (the implicit function theorem). The product with dp is a difference of
 * two gradients; H is the factor that the level has from its last solution, or from near it. Where p moves far the way
 * is cut into parts, and after each Newton steps by the same factor lead back. Where p moves hardly, g(z, p + dp) is
 * straight enough, and one Newton step from there does at half of the cost.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level_response.h"

#include "base/constants.h"
#include "base/memory.h"
#include "linalg/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Newton steps after each part of a long way. */
enum { STEPS_BACK = 2 };

typedef struct response {
    co_level *level;
    double *from, *to; /* [3 n_vertices] offsets of the dof map */
    double *guess;     /* [n_variables] where the response leads */
    double *gradient;  /* [n_variables] there, or of a difference */
    double *step;      /* [n_variables] */
    curvopt_error *error;
} response;

/* What is held comes to a part of the way. */
static void place(response *r, double part) {
    co_dof_map *dofs = &r->level->objective.reduction;
    for (size_t i = 0; i < 3 * (size_t)dofs->n_vertices; i++)
        dofs->offset[i] = part == 1 ? r->to[i] : r->from[i] + part * (r->to[i] - r->from[i]);
}

/* step = -H^-1 of r->gradient, times scale. */
static int32_t solve(response *r, double scale) {
    co_level_objective *o = &r->level->objective;
    const size_t n = co_level_objective_n(o);
    for (size_t k = 0; k < n; k++)
        r->step[k] = -scale * r->gradient[k];
    int32_t status = co_level_hessian_solve(&r->level->hessian, r->step, r->step, r->error);
    co_level_objective_restrict(o, r->step);
    return status;
}

/* now.x += step if that lowers now.value. */
static void try_step(response *r) {
    co_level *l = r->level;
    const size_t n = co_level_objective_n(&l->objective);
    co_iterate trial = {.x = r->guess, .gradient = r->gradient};
    memcpy(r->guess, l->now.x, n * sizeof *r->guess);
    co_vector_add(n, 1, r->step, r->guess);
    co_level_objective_evaluate(&l->objective, &trial);
    if (!(trial.value < l->now.value))
        return;
    memcpy(l->now.x, r->guess, n * sizeof *r->guess);
    memcpy(l->now.gradient, r->gradient, n * sizeof *r->gradient);
    l->now.value = trial.value;
    memcpy(l->now.found, trial.found, sizeof trial.found);
}

/* A Newton step from `now`, which is evaluated. */
static int32_t step_back(response *r) {
    co_level *l = r->level;
    const size_t n = co_level_objective_n(&l->objective);
    memcpy(r->gradient, l->now.gradient, n * sizeof *r->gradient);
    int32_t status = solve(r, 1);
    if (status == CURVOPT_OK)
        try_step(r);
    return status;
}

/* Where what is held has moved hardly. */
static int32_t follow_straight(response *r) {
    place(r, 1);
    co_level_objective_evaluate(&r->level->objective, &r->level->now);
    return step_back(r);
}

/* From one part of the way to the next, where `now` is then evaluated. */
static int32_t follow(response *r, double from, double to, double length) {
    co_level *l = r->level;
    const size_t n = co_level_objective_n(&l->objective);
    const double small = fmin(1, CO_DIFFERENCE_STEP / ((to - from) * length));
    co_iterate shifted = {.x = l->now.x, .gradient = r->gradient};
    place(r, from);
    co_level_objective_evaluate(&l->objective, &l->now);
    place(r, from + small * (to - from));
    co_level_objective_evaluate(&l->objective, &shifted);
    co_vector_add(n, -1, l->now.gradient, r->gradient);
    int32_t status = solve(r, 1 / small);
    place(r, to);
    co_level_objective_evaluate(&l->objective, &l->now);
    if (status == CURVOPT_OK)
        try_step(r);
    return status;
}

/* The longest displacement of what is held, in mean edges. */
static double length_of(const response *r) {
    const co_level_objective *o = &r->level->objective;
    double most = 0;
    for (size_t v = 0; v < (size_t)o->mesh->info.n_vertices; v++) {
        double square = 0;
        for (size_t i = 3 * v; i < 3 * v + 3; i++)
            square += (r->to[i] - r->from[i]) * (r->to[i] - r->from[i]);
        most = fmax(most, square);
    }
    return sqrt(most) / o->edge;
}

/* *followed: `now` is evaluated with what is held at its places. */
static int32_t follow_all(response *r, int *followed) {
    const co_tuning *t = r->level->objective.run->tuning;
    const double length = length_of(r);
    const int parts = (int)fmin(t->near_parts, fmax(1, ceil(length / t->near_reach)));
    int32_t status = CURVOPT_OK;
    if (length == 0)
        return CURVOPT_OK;
    *followed = 1;
    if (length <= t->near_straight)
        return follow_straight(r);
    for (int k = 0; k < parts && status == CURVOPT_OK; k++) {
        status = follow(r, (double)k / parts, (k + 1.0) / parts, length);
        for (int step = 0; step < STEPS_BACK && k + 1 < parts && status == CURVOPT_OK; step++)
            status = step_back(r);
    }
    return status;
}

int32_t co_level_response(co_level *l, const co_symmetry *symmetry, const co_constraints *constraints,
                          const double *start, int *fits, curvopt_error *error) {
    co_level_objective *o = &l->objective;
    const size_t n = co_level_objective_n(o), n_xyz = 3 * (size_t)o->mesh->info.n_vertices;
    double *work = CO_NEW(double, 2 * n_xyz + 3 * n);
    response r = {.level = l, .from = work, .error = error};
    int followed = 0;
    *fits = 0;
    if (!work)
        return co_status_no_memory(error);
    r.to = work + n_xyz;
    r.guess = r.to + n_xyz;
    r.gradient = r.guess + n;
    r.step = r.gradient + n;
    if (o->reduction.offset)
        memcpy(r.from, o->reduction.offset, n_xyz * sizeof *r.from);
    int32_t status = co_level_move(l, symmetry, constraints, start, fits, error);
    if (status == CURVOPT_OK && *fits && o->reduction.offset && l->hessian.has_factor && !o->run->held) {
        memcpy(r.to, o->reduction.offset, n_xyz * sizeof *r.to);
        status = follow_all(&r, &followed);
        place(&r, 1);
    }
    if (status == CURVOPT_OK && *fits && !followed)
        co_level_objective_evaluate(o, &l->now);
    if (status == CURVOPT_OK && *fits && isfinite(l->now.value))
        l->reached = l->now.x;
    free(work);
    return status;
}
