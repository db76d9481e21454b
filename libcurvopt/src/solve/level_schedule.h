/* The schedule of a level: which method runs when, with which tolerances, and when it ends.
 *
 * The schedule is data, made once from the facts of a level. What it works on is behind callbacks: in a run a level, in
 * tests a toy.
 *
 *   first       L-BFGS, preconditioned by the Gauss-Newton matrix, leads to the shape in a few steps; not on normals,
 *               where the shape nearly stands
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
    int expects_plateau; /* the level starts near a saddle: the first stage is not to take that for its end */
    int is_near;         /* the level starts near its minimum, with a matrix that was good there */
    int stops_short;     /* the first stage is all that is wanted */
    int closely;         /* what was found by matrices that are off by a little was not stationary */
    double decrement;    /* with is_near: relative decrement at which the first stage is at its end */
    int max_iterations;  /* the user's, of the level */
    double gradient_tolerance;
    double decrement_tolerance; /* of what is final */
    double max_step;            /* in mean edges */
} co_level_facts;

typedef struct co_level_schedule {
    int starts;                /* whether there is a first stage */
    co_method_options options; /* of all stages; its iterations are those of all together */
    int ends;                  /* whether the end follows once the first stage has settled */
    double stationary;         /* relative decrement that meets the certificate */
} co_level_schedule;

co_level_schedule co_level_schedule_make(const co_level_facts *facts, const co_tuning *tuning);

/* What a schedule works on: a function, an iterate, quadrature rules. */
typedef struct co_scheduled {
    void *context;
    /* Runs a method from the iterate; `before`: what earlier stages did, for the report. */
    int32_t (*run)(void *context, co_method method, const co_method_options *options, const co_outcome *before,
                   co_outcome *outcome, curvopt_error *error);
    /* Reviews the iterate with the accuracy that the figures at the end need. */
    int32_t (*review_for_figures)(void *context, co_step_verdict *verdict, curvopt_error *error);
    /* Newton decrement at the iterate. */
    int32_t (*decrement)(void *context, double *left, curvopt_error *error);
    double (*value)(void *context);
} co_scheduled;

/* Runs the schedule. The iterate ends where the result is. *outcome counts all stages. */
int32_t co_level_schedule_run(const co_level_schedule *schedule, const co_scheduled *on, co_outcome *outcome,
                              curvopt_error *error);

#endif
