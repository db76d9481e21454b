/* One level of a run: a cage, its function, its matrices, the review of its steps, and the iterate that moves.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LEVEL_H
#define CO_SOLVE_LEVEL_H

#include "energy/adaptive_quadrature.h"
#include "optimize/step_control.h"
#include "solve/level_hessian.h"
#include "solve/level_objective.h"
#include "solve/step_review.h"

struct co_level;

/* Told of every step that stands; nonzero cancels. */
typedef int (*co_level_report_fn)(const struct co_level *level, const co_step_record *record, void *user);

/* A shape while it forms once more (level_even.h). */
typedef struct co_formed {
    double *x;     /* [n_variables] without walls; NULL: no shape forms once more */
    double energy; /* without spacing */
} co_formed;

typedef struct co_level {
    int32_t number; /* 1 .. options.levels */
    co_motion motion;
    int is_final;   /* what is found here is the run's result: nothing follows that moves it */
    int is_forming; /* the shape has not formed yet: the first stage */
    int is_lost;    /* the surface is folded where no review saw it in time, and the level has ended */
    co_iterate now; /* where the level stands */
    co_formed formed;
    co_level_objective objective;
    co_level_hessian hessian;
    co_step_review review;
    const double *reached;    /* variables that it ends with if it is cancelled; NULL: it has not begun */
    double working_tolerance; /* of quadrature on the way */
    double tolerance;         /* of quadrature of the figures at the end */
    int32_t failed;           /* status of a callback, which cannot return it */
    curvopt_error *error;     /* the caller's, for callbacks */
    int keeps_factor;         /* the preconditioner is not made anew when next asked for */
    int spent;                /* iterations that earlier turns of the same level of the run took */
    co_outcome before;        /* what earlier stages did */
    co_level_report_fn report;
    void *user;
} co_level;

static inline size_t co_level_n(const co_level *level) { /* of variables */
    return co_level_objective_n(&level->objective);
}

static inline int co_level_is_cancelled(const co_level *level) {
    return co_run_context_is_cancelled(level->objective.run);
}

/* Whether callbacks have nothing more to do: the run is to end, or one of them has failed. */
static inline int co_level_is_over(const co_level *level) {
    return level->failed != CURVOPT_OK || co_level_is_cancelled(level);
}

static inline int co_level_is_rough(const co_level *level) {
    return level->objective.assembly.coarsest == CO_ROUGH_RULE;
}

/* Borrows run, mesh and start [3 n_vertices, the user's units]; constraints are copied. As curvopt_minimize. */
int32_t co_level_create(const co_run_context *run, const curvopt_mesh *mesh, const co_symmetry *symmetry,
                        const co_constraints *constraints, co_motion motion, const double *start, int32_t number,
                        co_level **out, curvopt_error *error);
void co_level_destroy(co_level *level);
/* The level goes on from another cage, as co_level_objective_move. It has not begun there. */
int32_t co_level_move(co_level *level, const co_symmetry *symmetry, const co_constraints *constraints,
                      const double *start, int *fits, curvopt_error *error);
/* The matrix of where the level stands, factored, to be kept. When cancelled in time, the one before is. ERROR_MEMORY.
 */
int32_t co_level_refresh_factor(co_level *level, curvopt_error *error);

/* Rules, value and gradient at the start; refuses a cage that has none. */
int32_t co_level_begin(co_level *level, curvopt_error *error);
/* The same by the rules of another level of the same mesh and symmetry, which have been resolved there. ERROR_MEMORY.
 */
int32_t co_level_begin_by_rules_of(co_level *level, const co_level *other, curvopt_error *error);
/* What a step by the matrix of the first stage is predicted to bring where the level has begun, in parts of the
 * function; INFINITY if there is none. The stage begins by that matrix. ERROR_MEMORY. */
int32_t co_level_first_gain(co_level *level, double *gain, curvopt_error *error);
/* The longest displacement of a vertex since then, in mean edges. */
double co_level_moved(co_level *level);
/* From a stationary point some way along the direction in which the Hessian is most negative; *left: whether there is
 * one that leads down. For levels that are not solved afterwards. ERROR_MEMORY. */
int32_t co_level_leave_saddle(co_level *level, int *left, curvopt_error *error);

/* What follows is for whoever solves a level. */

/* The level as optimizers see it; borrows the level. Its report tells level->report. */
co_objective co_level_function(co_level *level);
/* Tells level->report where the level stands, of no step. Nonzero: the level is over, or the caller wants no more. */
int co_level_tell(co_level *level);
/* Value and gradient, also when the run is to end. level: a co_level, for callbacks; the status is its `failed`. */
void co_level_evaluate(void *level, co_iterate *at);
/* As co_step_review_check. A level whose iterate does not stand is lost. */
int32_t co_level_check(co_level *level, co_iterate *at, co_step_verdict *verdict, curvopt_error *error);
/* Whether cages are to be even: where vertices may lie anywhere in the surface. */
int co_level_wants_even(const co_level *level);
/* Spacing, where it is wanted, by what it is worth here. */
void co_level_weigh_spacing(co_level *level);
/* Where numbers are held: to them, or as far as a step leads. As co_level_objective_aim. */
int32_t co_level_aim(co_level *level, int *is_there, int *changed, curvopt_error *error);

#endif
