/* What optimizers share: how long steps may be, whether they still lead anywhere, how a method ended.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_OPTIMIZE_STEP_CONTROL_H
#define CO_OPTIMIZE_STEP_CONTROL_H

#include "base/tuning.h"
#include "optimize/objective.h"

/* Of the value: below, a decrease is rounding for the most part. */
#define CO_KNOWN_DECREASE 1e-11

/* What a method is asked for. Tolerances are relative to |value|. */
typedef struct co_method_options {
    const co_tuning *tuning;
    int max_iterations;
    double gradient_tolerance;  /* converged when |gradient| is no more than this */
    double decrement_tolerance; /* converged when the model, being positive, promises no more than this */
    double settled_decrease;    /* settled when settled_steps steps bring less than this; plain L-BFGS never settles */
    int settled_steps;
    double max_step;        /* longest step, by the objective's step_length() */
    int small_steps;        /* in a row, that promise so little, before L-BFGS has converged; 0: tuning's */
    int memory;             /* pairs that L-BFGS keeps */
    int by_hessian;         /* L-BFGS' preconditioner is the Hessian, not the Gauss-Newton matrix */
    int is_scaled;          /* that preconditioner is, where it is too soft */
    int update_every;       /* steps between updates of L-BFGS' preconditioner */
    int keeps_matrix;       /* Newton's method goes on by a matrix whose last step came true */
    double saddle_decrease; /* Newton's method leaves a saddle for no less */
    int closely; /* Newton's method asks for matrices closely from the first one on, and a step that is small by its
                    shift is not its end: for where the certificate was not met */
} co_method_options;

/* How a method ended. */
typedef struct co_outcome {
    int stop;        /* curvopt_stop */
    int iterations;  /* steps that stand */
    int evaluations; /* of the function */
    int rejected;    /* steps that were taken back */
    int restarts;    /* times a history was dropped */
} co_outcome;

typedef struct co_step_control {
    const co_tuning *tuning;
    double max_step;  /* the longest step that is allowed at all, by the objective's step_length() */
    double cap;       /* the longest that is allowed now: it falls where steps are taken back */
    double mark;      /* value when co_step_control_has_settled() looked last */
    int quiet_steps;  /* steps in a row whose decrease is rounding */
    int last_stands;  /* whether the last step stands */
    double length;    /* of the step that is to be taken: for the record, NAN if not known */
    double predicted; /* decrease by the model, likewise */
    double shift;     /* of its matrix, likewise */
} co_step_control;

co_step_control co_step_control_begin(const co_tuning *tuning, double max_step, const co_iterate *now);
/* Has `trial` reviewed, reports it, and lets it change places with `now`, which becomes the iterate before. *verdict is
 * the review's. A stop reason, or -1 to go on. */
int co_step_control_take(co_step_control *control, const co_objective *f, co_method method, co_iterate *now,
                         co_iterate *trial, co_outcome *outcome, co_step_verdict *verdict);
/* Whether the last `steps` steps brought less than `decrease` times |value|; looked at once in so many. A step that was
 * taken back is not among them, and says nothing of the function. Where the value has risen by as much, the function
 * has changed, and nothing is known yet of what steps bring. */
int co_step_control_has_settled(co_step_control *control, const co_iterate *now, int iterations, int steps,
                                double decrease);
/* Methods let iterates change places: `now` back into the arrays that it came in. */
void co_iterate_hand_back(size_t n, co_iterate *now, double *x, double *gradient);

#endif
