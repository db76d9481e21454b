/* A level's minimum, in stages.
 *
 * The Gauss-Newton matrix leads to the shape in a few steps. What is left then is how the cage lies in it: vertices
 * slide in the surface, which that matrix sees badly. There the Hessian takes over. Second-order energies: as soon as
 * the shape stands, with the shift that it needs to be positive, and only until the certificate (newton_decrement.h) is
 * met; the Hessian has many negative directions that slide vertices, and following them further lowers the energy by
 * another 1e-5 at the price of ever worse quadrature. Third-order ones: at every level, by Newton's method proper with
 * the lifted matrix (sweep.c; tests/bench has what else was tried). SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level_schedule.h"

#include "base/memory.h"
#include "optimize/damped_newton.h"
#include "optimize/step_control.h"
#include "solve/newton_decrement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MEMORY = 12, RENEW_EVERY = 5, SLOW_STEPS = 15, QUICK_STEPS = 5 };
enum { MOST_SETTLING = 100, MOST_SLIDING = 30, MOST_ROUNDS = 5 };
/* Of the energy; between levels only what the next one would not do better at once. */
static const double COARSE_DECREMENT = 1e-5;
static const double COARSE_SETTLED = 1e-3, FINAL_SETTLED = 2e-6;
/* Of the energy, in QUICK_STEPS: the shape stands, and Newton's method takes over. With many variables its factors cost
 * more than all the rest, and it comes when the other method is done. On a last level that began with the shape of the
 * one before it comes after a single step, which is for what subdivision leaves in each vertex. */
static const double SHAPE_SETTLED = 0.1;
enum { MANY_VARIABLES = 5000 };
/* Of the energy: steps that slide vertices have settled; what is left to gain when they end. */
static const double SLIDING_SETTLED = 1e-5, STATIONARY = 8e-7, NOTHING = 1e-12, GREAT = 1e-2;
static const double DISTORTED = 0.5; /* of the least Jacobian */

typedef struct stages {
    co_level *level;
    co_lbfgs_options options;
    co_iterate *now;
    co_outcome *result;
} stages;

/* An optimizer from where the last stage ended, LMVM or, if `by` is not NULL, Newton's; the result counts what was done
 * before, too. */
static int32_t go_on_by(stages *s, const co_damped_newton_options *by, curvopt_error *error) {
    co_level *l = s->level;
    co_objective f = co_level_objective(l);
    l->iterations = s->result->iterations;
    l->evaluations = s->result->evaluations;
    int left = s->options.max_iterations - l->iterations;
    int32_t status;
    if (by) {
        co_damped_newton_options rest = *by;
        rest.max_iterations = left;
        status = co_damped_newton(&f, &rest, s->now, s->result, error);
    } else {
        co_lbfgs_options rest = s->options;
        rest.max_iterations = left;
        status = co_lbfgs(&f, &rest, s->now, s->result, error);
    }
    s->result->iterations += l->iterations;
    s->result->evaluations += l->evaluations;
    return status == CURVOPT_OK ? l->failed : status;
}

static int32_t go_on(stages *s, curvopt_error *error) {
    return go_on_by(s, NULL, error);
}

static int has_settled(const stages *s) {
    return s->result->stop == CURVOPT_STOP_CONVERGED || s->result->stop == CURVOPT_STOP_SETTLED;
}

/* The figures at the end are wanted as accurate as the tolerance says, not only within the multiple that rules are left
 * alone for: where that takes finer ones, the stage goes on by these. */
static int32_t go_on_by_finer_rules(stages *s, curvopt_error *error) {
    co_level *l = s->level;
    l->assembly.met = 0;
    if (co_level_check(l, s->now) == CO_STEP_CHANGED)
        return go_on(s, error);
    return l->failed;
}

/* What a certificate would say. */
typedef struct certificate {
    double left;  /* to gain */
    int positive; /* the Hessian */
} certificate;

/* Steps by the Hessian until they have settled, or, where that is INFINITY, some more; and where they end. */
static int32_t hessian_steps(stages *s, double settled, certificate *end, curvopt_error *error) {
    *end = (certificate){.left = (double)NAN};
    s->options.settled_decrease = settled;
    int32_t status = go_on(s, error);
    if (status == CURVOPT_OK && has_settled(s))
        status = go_on_by_finer_rules(s, error);
    if (status == CURVOPT_OK && has_settled(s))
        status = co_newton_decrement(s->level, s->now, &end->left, &end->positive, error);
    return status;
}

static double least_jacobian(const stages *s) {
    co_level_evaluate(s->level, s->now->x, NULL);
    return s->level->last.min_jacobian;
}

/* Where sliding has come nearest to the certificate. */
typedef struct nearest {
    double *x;   /* [n_variables] */
    double left; /* to gain there */
    int done;    /* it is met */
} nearest;

/* So many steps more, and not more than the user's limit. */
static void allow(stages *s, const co_lbfgs_options *user, int steps) {
    int most = s->result->iterations + steps;
    s->options.max_iterations = most < user->max_iterations ? most : user->max_iterations;
}

/* Steps by the Hessian until the certificate is met, or, where that is positive and every step a great one, to the end.
 * Cages that are much more distorted than before do not count. Without a history: pairs of steps as different as these
 * make the metric worse. */
static int32_t slide(stages *s, nearest *best, curvopt_error *error) {
    co_level *l = s->level;
    const co_lbfgs_options before = s->options;
    const double jacobian = least_jacobian(s), shift = l->shift;
    int32_t status = CURVOPT_OK;
    l->exact = 1;
    l->shift = 0;
    s->options.memory = 0;
    s->options.renew_every = 1;
    allow(s, &before, MOST_SETTLING);
    for (double settled = SLIDING_SETTLED;; settled = INFINITY) {
        int steps = s->result->iterations;
        double value = fabs(s->now->value), great = best->done ? GREAT * best->left : INFINITY;
        certificate end;
        status = hessian_steps(s, settled, &end, error);
        if (status != CURVOPT_OK || !has_settled(s))
            break;
        if (end.left < best->left && least_jacobian(s) >= DISTORTED * jacobian) {
            memcpy(best->x, s->now->x, sizeof(double) * (size_t)l->reduction.n_variables);
            best->left = end.left;
        }
        best->done |= best->left <= STATIONARY * value;
        if (settled < INFINITY)
            allow(s, &before, MOST_SLIDING);
        if (s->result->iterations == steps ||
            (best->done && !(end.positive && end.left > NOTHING * value && end.left <= great)))
            break;
    }
    l->exact = 0;
    l->shift = shift;
    s->options = before;
    return status;
}

static void go_to(stages *s, const double *x) {
    co_level *l = s->level;
    memcpy(s->now->x, x, sizeof(double) * (size_t)l->reduction.n_variables);
    memcpy(l->safe, x, sizeof(double) * (size_t)l->reduction.n_variables);
    s->now->value = co_level_evaluate(l, s->now->x, s->now->gradient);
}

/* Where sliding does not get there: slowly, from where it began and by the rules of then; or what it came to, if that
 * is nearer. */
static int32_t settle_slowly(stages *s, const double *start, const uint8_t *rules, const nearest *best,
                             curvopt_error *error) {
    double left = (double)NAN;
    int32_t status = co_assembly_take_rules(&s->level->assembly, rules, error);
    if (status != CURVOPT_OK)
        return status;
    go_to(s, start);
    s->result->stop = CURVOPT_STOP_SETTLED;
    s->options.settled_steps = SLOW_STEPS;
    if (s->options.settled_decrease > FINAL_SETTLED) {
        s->options.settled_decrease = FINAL_SETTLED;
        status = go_on(s, error);
    }
    if (status == CURVOPT_OK && has_settled(s))
        status = co_newton_decrement(s->level, s->now, &left, NULL, error);
    if (status == CURVOPT_OK && best->left < left)
        go_to(s, best->x);
    return status;
}

/* The last level of a second-order energy, after the shape has settled. */
static int32_t finish_second(stages *s, curvopt_error *error) {
    const co_assembly *a = &s->level->assembly;
    size_t n = (size_t)s->level->reduction.n_variables, n_patches = (size_t)a->patches.n_patches;
    double *start = CO_NEW(double, n);
    uint8_t *rules = CO_NEW(uint8_t, n_patches);
    nearest best = {.x = CO_NEW(double, n), .left = INFINITY};
    int32_t status = start && rules && best.x ? CURVOPT_OK : co_status_no_memory(error);
    if (status != CURVOPT_OK)
        goto done;
    memcpy(start, s->now->x, n * sizeof *start);
    memcpy(rules, a->rule, n_patches);
    status = slide(s, &best, error);
    if (status == CURVOPT_OK && s->result->stop != CURVOPT_STOP_CANCELLED) {
        if (best.done) {
            go_to(s, best.x);
            s->result->stop = CURVOPT_STOP_CONVERGED;
        } else if (s->result->iterations < s->options.max_iterations) {
            status = settle_slowly(s, start, rules, &best, error);
        }
    }
done:
    free(start);
    free(rules);
    free(best.x);
    return status;
}

/* Newton's method, from where the shape stands. */
static int32_t newton(stages *s, int settled_steps, curvopt_error *error) {
    const co_lbfgs_options *o = &s->options;
    co_damped_newton_options options = {.gradient_tolerance = o->gradient_tolerance,
                                        .decrement_tolerance = o->decrement_tolerance,
                                        .settled_decrease = o->settled_decrease,
                                        .settled_steps = settled_steps,
                                        .max_step = o->max_step};
    return go_on_by(s, &options, error);
}

/* Whether the figures at the end need other rules than the optimizer has. It has them then, where it is or a little way
 * back. */
static int needs_other_rules(stages *s) {
    s->level->assembly.met = 0;
    co_step_verdict verdict = co_level_check(s->level, s->now);
    return verdict == CO_STEP_CHANGED || verdict == CO_STEP_REJECT;
}

/* A third-order energy's level, after the shape has settled. At the end of the last one figures are wanted as accurate
 * as the tolerance says: where that takes finer rules, Newton's method goes on by these. A level that has settled on a
 * plateau is not at its end: while the certificate is not met, both methods go on, with more patience. */
static int32_t finish_third(stages *s, curvopt_error *error) {
    co_level *l = s->level;
    const int last = l->number == l->frame->options->levels;
    double left = INFINITY;
    s->options.settled_decrease = last ? FINAL_SETTLED : COARSE_SETTLED;
    s->options.settled_steps = SLOW_STEPS;
    for (int round = 0;; round++) {
        int32_t status = newton(s, last ? SLOW_STEPS : QUICK_STEPS, error);
        if (status != CURVOPT_OK || !last || !has_settled(s) || round == MOST_ROUNDS)
            return status;
        if (needs_other_rules(s))
            continue;
        if (l->failed != CURVOPT_OK || s->result->stop != CURVOPT_STOP_SETTLED)
            return l->failed;
        status = co_newton_decrement(l, s->now, &left, NULL, error);
        if (status != CURVOPT_OK || !(left > STATIONARY * fabs(s->now->value)))
            return status;
        s->options.settled_decrease /= 4;
        status = go_on(s, error);
        if (status != CURVOPT_OK || !has_settled(s))
            return status;
    }
}

/* The last steps may not have been looked at, and a fold may hide from two rules that follow each other: by the rules
 * that the figures at the end need, the best of the last iterate, the last that stood, and the first. */
static int32_t keep_best(co_level *l, co_iterate *now, int *stop, curvopt_error *error) {
    curvopt_energies energies;
    int resolved, changed;
    double *const others[2] = {l->safe, l->first};
    size_t bytes = sizeof(double) * (size_t)l->reduction.n_variables;
    co_dof_map_expand(&l->reduction, now->x, l->x);
    int32_t status = co_adaptive_quadrature_resolve(&l->assembly, l->x, l->tolerance, CO_TERMS_REPORT, &energies,
                                                    &resolved, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    double least = co_level_evaluate(l, now->x, NULL);
    for (int k = 0; k < 2; k++) {
        double value = co_level_evaluate(l, others[k], NULL);
        if (value < least || !isfinite(least)) {
            least = value;
            memcpy(now->x, others[k], bytes);
            if (others[k] == l->first && *stop != CURVOPT_STOP_CANCELLED)
                *stop = CURVOPT_STOP_UNRESOLVED;
        }
    }
    now->value = co_level_evaluate(l, now->x, now->gradient);
    return CURVOPT_OK;
}

/* Whether vertices are to slide as far as they may. Not before a saddle of the shape has been looked for: leaving it is
 * worth a few parts in 1e6 at first, which sliding hides. */
static int slides(const co_level *l) {
    return l->number == l->frame->options->levels && !l->assembly.functional.has_third && !l->frame->keeps_still;
}

/* Whether Newton's method takes over as soon as the shape stands. Of `plane`, which is not linear, there is no exact
 * Hessian, and it comes last. */
static int hands_over(const co_level *l) {
    return l->assembly.functional.has_third && l->assembly.surface != CURVOPT_SURFACE_PLANE;
}

/* Patience of a first stage that hands over to Newton's method. */
static void be_brief(const co_level *l, co_lbfgs_options *o) {
    int many = l->reduction.n_variables > MANY_VARIABLES;
    int at_once = !many && l->number > 1 && l->number == l->frame->options->levels;
    o->settled_steps = at_once ? 1 : QUICK_STEPS;
    o->settled_decrease = at_once ? (double)INFINITY : many ? COARSE_SETTLED : SHAPE_SETTLED;
}

static co_lbfgs_options first_options(const co_level *l) {
    const curvopt_options *o = l->frame->options;
    int last = l->number == o->levels, quick = slides(l) && !l->frame->is_patient;
    co_lbfgs_options options = {.memory = MEMORY,
                                .max_iterations = o->max_iterations,
                                .gradient_tolerance = o->gradient_tolerance,
                                .decrement_tolerance =
                                    last ? o->decrement_tolerance : fmax(o->decrement_tolerance, COARSE_DECREMENT),
                                .settled_decrease = last && !quick ? FINAL_SETTLED : COARSE_SETTLED,
                                .settled_steps = quick ? QUICK_STEPS : SLOW_STEPS,
                                .max_step = o->max_step,
                                .renew_every = RENEW_EVERY};
    if (hands_over(l))
        be_brief(l, &options);
    return options;
}

/* What ends a level, after the first stage. */
static int32_t finish(stages *s, curvopt_error *error) {
    const co_level *l = s->level;
    int last = l->number == l->frame->options->levels;
    if (l->assembly.functional.has_third)
        return last || hands_over(l) ? finish_third(s, error) : CURVOPT_OK;
    if (!last)
        return CURVOPT_OK;
    return slides(l) ? finish_second(s, error) : go_on_by_finer_rules(s, error);
}

int32_t co_level_schedule_solve(co_level *l, co_iterate *now, co_outcome *result, curvopt_error *error) {
    const curvopt_options *o = l->frame->options;
    stages s = {.level = l, .options = first_options(l), .now = now, .result = result};
    *result = (co_outcome){0};
    if (co_level_objective(l).report(l, now, 0, 0)) {
        result->stop = CURVOPT_STOP_CANCELLED;
        return CURVOPT_OK;
    }
    int32_t status = go_on(&s, error);
    if (status == CURVOPT_OK && l->has_model && has_settled(&s))
        status = finish(&s, error);
    if (co_run_context_is_cancelled(l->frame))
        result->stop = CURVOPT_STOP_CANCELLED;
    if (status == CURVOPT_OK && !o->as_report)
        status = keep_best(l, now, &result->stop, error);
    return status;
}
