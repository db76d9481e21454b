/* A function to minimize, a script for its callbacks, and a record of what the optimizer did.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEST_LBFGS_PROBLEM_H
#define TEST_LBFGS_PROBLEM_H

#include "optimize/lbfgs.h"
#include "optimize/step_control.h"

enum { MOST = 40 };

typedef enum shape { QUADRATIC, ROSENBROCK } shape;

/* A function, a script of what settle() and report() say, and a record of what the optimizer did. */
typedef struct problem {
    shape shape;
    int n;
    double condition;               /* of the quadratic */
    int only_along_gradient;        /* not defined anywhere else */
    int undefined_after;            /* not defined at all after so many steps; 0: always defined */
    co_step_verdict verdict;        /* said */
    int verdict_from, verdict_to;   /* by calls number from .. to - 1 of settle, counted from 1 */
    int cancel_at;                  /* iteration, or 0 */
    double x[MOST], g[MOST], value; /* the last settled iterate */
    double longest;                 /* trial step */
    double first_trial[MOST];       /* first trial step after the last settled iterate */
    int calls, settles, reports, tried;
    double told_value, promise; /* the value told last; of the step told last, predicted over actual decrease */
} problem;

typedef struct run {
    co_method_options options;
    co_outcome result;
    double x[MOST], g[MOST];
    co_iterate now;
} run;

extern const co_method_options usual_options;

double problem_evaluate(void *context, const double *x, double *gradient);
void problem_evaluate_at(void *context, co_iterate *at);
/* Largest coordinate. */
double problem_step_length(void *context, const double *d);
co_step_verdict problem_settle(void *context, const co_iterate *before, co_iterate *now, int iteration);
int problem_report(void *context, const co_iterate *now, const co_step_record *record);

/* How far d is from the line along the last settled gradient, relative to its length. */
double problem_off_gradient(const problem *p, const double *d);
/* From the usual start, with r->options, into r->result and r->now. */
void problem_minimize(problem *p, run *r);

#endif
