/* The schedule of a level: which method runs when, with which tolerances, and when it ends.
 *
 * The schedule is data, made once from the facts of a level. What it works on is behind callbacks: in a run a level, in
 * tests a toy.
 *
 *   first       L-BFGS, preconditioned by the Gauss-Newton matrix, leads to the shape in a few steps
 *   then, where the Gauss-Newton matrix sees badly how the cage lies in the shape (vertices slide in the surface):
 *   NONE        nothing: the next level does better at once
 *   FINER_RULES the first stage goes on by quadrature rules as fine as the figures at the end need
 *   SLIDE       second order, last level: vertices slide by L-BFGS with the Hessian as its preconditioner, and only
 *               until the decrement is met: that matrix has many negative directions that slide vertices, and to
 *               follow them further gains 1e-5 at the price of ever finer quadrature
 *   NEWTON      third order: damped Newton, in rounds, until the decrement is met
 *
 * The decrement is met where it is at most co_level_schedule.stationary of the energy. The certificate, which looks at
 * the shape as well, comes after the level.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LEVEL_SCHEDULE_H
#define CO_SOLVE_LEVEL_SCHEDULE_H

#include "base/status.h"
#include "optimize/step_control.h"

/* Most rounds of NEWTON after the first. */
enum { CO_LEVEL_SCHEDULE_ROUNDS = 5 };

typedef enum co_end_game { CO_END_NONE, CO_END_FINER_RULES, CO_END_SLIDE, CO_END_NEWTON } co_end_game;

/* What a schedule depends on. */
typedef struct co_level_facts {
    int is_first;        /* of the run's levels */
    int is_last;         /* of the run's levels */
    int has_hessian;     /* the method uses second derivatives, and there are variables */
    int is_third_order;  /* the energy */
    int is_linear;       /* the surface is linear in the cage, so that there is an exact Hessian; `plane` is not */
    int32_t n_variables; /* of the level */
    int expects_saddle;  /* a saddle of the shape will be looked for: sliding would hide it */
    int expects_plateau; /* the level starts near a saddle: the first stage is not to take that for its end */
    int max_iterations;  /* the user's, of the level */
    double gradient_tolerance;
    double decrement_tolerance; /* of the last level */
    double max_step;            /* in mean edges */
} co_level_facts;

typedef struct co_level_schedule {
    const co_tuning *tuning;
    int max_iterations;        /* of all stages together */
    int has_hessian;           /* without one, the first stage is all */
    co_method_options first;   /* L-BFGS, first stage */
    co_end_game end;           /* what follows once the first stage has settled */
    co_method_options newton;  /* NEWTON */
    co_method_options between; /* NEWTON: L-BFGS between two rounds */
    int rounds;                /* NEWTON: most, while the certificate is not met; 0: Newton's method runs once */
    co_method_options slide;   /* SLIDE: L-BFGS by the Hessian */
    co_method_options slow;    /* SLIDE: L-BFGS by the Gauss-Newton matrix, if sliding does not meet the certificate */
    int goes_on_slowly;        /* SLIDE: whether `slow` asks for more than `first` did */
    double stationary;         /* relative decrement that meets the certificate */
} co_level_schedule;

co_level_schedule co_level_schedule_make(const co_level_facts *facts, const co_tuning *tuning);

/* What can be gone back to. */
typedef enum co_milestone { CO_MILESTONE_START, CO_MILESTONE_BEST } co_milestone;

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
    /* Whether L-BFGS is preconditioned by the Hessian, instead of by the Gauss-Newton matrix. */
    void (*use_hessian)(void *context, int on);
    double (*value)(void *context);
    double (*min_jacobian)(void *context);
    void (*remember)(void *context, co_milestone place);
    /* Back to a place; START also restores the rules of then. ERROR_MEMORY. */
    int32_t (*go_to)(void *context, co_milestone place, curvopt_error *error);
} co_scheduled;

/* Runs the schedule. The iterate ends where the result is. *outcome counts all stages. */
int32_t co_level_schedule_run(const co_level_schedule *schedule, const co_scheduled *on, co_outcome *outcome,
                              curvopt_error *error);

#endif
