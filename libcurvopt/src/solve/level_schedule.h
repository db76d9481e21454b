/* The schedule of a level: which method runs when, with which tolerances, and when it ends.
 *
 * The schedule is data, made once from the facts of a level. What it works on is behind callbacks: in a run a level, in
 * tests a toy.
 *
 *   forming     L-BFGS, preconditioned by the Gauss-Newton matrix and, at third order, by coarse rules, leads to the
 *               shape; not near a minimum, nor on normals alone. Once more from the start where faces have folded
 *   settling    on the last level, L-BFGS, preconditioned by the Hessian, and by finer rules; not on normals, where the
 *               shape nearly stands. Where the shape was not formed here, by the Gauss-Newton matrix
 *   end         where nothing follows the level: damped Newton, in rounds, until the decrement is met
 *
 * The decrement is met where it is at most co_level_schedule.stationary of the energy. The certificate comes after the
 * level.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LEVEL_SCHEDULE_H
#define CO_SOLVE_LEVEL_SCHEDULE_H

#include "base/status.h"
#include "optimize/step_control.h"

/* Most rounds of the end after the first. */
enum { CO_LEVEL_SCHEDULE_ROUNDS = 5 };

/* What a schedule depends on. */
typedef struct co_level_facts {
    int is_last;         /* of the run's levels */
    int is_final;        /* what is found is the run's result */
    int is_on_normals;   /* only the shape may change */
    int has_hessian;     /* the method uses second derivatives, and there are variables */
    int is_rough;        /* the shape forms by rules too coarse for a result, through hundreds of steps as a rule */
    int expects_plateau; /* the level starts near a saddle: that is not to be taken for the shape */
    int has_repulsion;   /* what comes close to what is another thing after few steps */
    int is_near;         /* the level starts near its minimum, with a matrix that was good there */
    int stops_short;     /* the end is not wanted */
    int closely;         /* what was found by matrices that are off by a little was not stationary */
    double decrement;    /* with is_near: relative decrement at which the level has settled */
    int max_iterations;  /* the user's, of the level */
    double gradient_tolerance;
    double decrement_tolerance; /* of what is final */
    double max_step;            /* in mean edges */
} co_level_facts;

typedef struct co_level_schedule {
    int forms, settles, ends;  /* which of the stages there are; one follows if the one before it ended well */
    co_method_options forming; /* of the first stage */
    co_method_options options; /* of the others; its iterations are those of all together */
    double stationary;         /* relative decrement that meets the certificate */
} co_level_schedule;

co_level_schedule co_level_schedule_make(const co_level_facts *facts, const co_tuning *tuning);

/* What a schedule works on: a function, an iterate, quadrature rules. */
typedef struct co_scheduled {
    void *context;
    /* Runs a method from the iterate; `before`: what earlier stages did, for the report. */
    int32_t (*run)(void *context, co_method method, const co_method_options *options, const co_outcome *before,
                   co_outcome *outcome, curvopt_error *error);
    /* Refines the rules by which the shape was formed. */
    int32_t (*refine)(void *context, curvopt_error *error);
    /* Reviews the iterate with the accuracy that the figures at the end need. */
    int32_t (*review_for_figures)(void *context, co_step_verdict *verdict, curvopt_error *error);
    /* Newton decrement at the iterate. */
    int32_t (*decrement)(void *context, double *left, curvopt_error *error);
    double (*value)(void *context);
    /* Once a shape has formed: whether it is to form once more, because faces have folded or pinched on the way; the
     * iterate is the first one again, and the function keeps faces from that. */
    int32_t (*begin_even)(void *context, int *begun, curvopt_error *error);
    /* Where it has: the function is what it was, and the iterate the better shape. */
    void (*end_even)(void *context);
} co_scheduled;

/* Runs the schedule. The iterate ends where the result is. *outcome counts all stages. */
int32_t co_level_schedule_run(const co_level_schedule *schedule, const co_scheduled *on, co_outcome *outcome,
                              curvopt_error *error);

#endif
