/* What an optimizer sees of a problem: vectors and callbacks, no geometry. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_OPTIMIZE_OBJECTIVE_H
#define CO_OPTIMIZE_OBJECTIVE_H

#include <stddef.h>

/* What an objective says of a step that an optimizer has accepted. */
typedef enum co_step_verdict {
    CO_STEP_KEEP,    /* the step stands */
    CO_STEP_CHANGED, /* the step stands; the function itself has changed, so what was learnt of it is void */
    CO_STEP_REJECT,  /* the step is taken back: `now` is the iterate to go back to; take shorter steps */
    CO_STEP_STOP     /* the step is taken back likewise, and the method ends */
} co_step_verdict;

static inline int co_step_stands(co_step_verdict verdict) {
    return verdict == CO_STEP_KEEP || verdict == CO_STEP_CHANGED;
}

enum { CO_N_FINDINGS = 5 };

typedef struct co_iterate {
    double *x;                   /* [n] */
    double *gradient;            /* [n] */
    double value;                /* the function at x */
    double found[CO_N_FINDINGS]; /* what else the objective found at x; it goes where the iterate goes */
} co_iterate;

/* How far Newton's matrix M = (1 - mix) H + mix G + shift is from the Hessian H. G, the Gauss-Newton matrix, is
 * positive semidefinite, and close to H where what is minimized, a sum of squares, is small. */
typedef struct co_damping {
    double shift; /* multiple of the unit matrix */
    double mix;   /* 0 to 1 */
} co_damping;

/* What made a step: curvopt_step. */
typedef enum co_method { CO_METHOD_NONE, CO_METHOD_LBFGS, CO_METHOD_NEWTON } co_method;

/* A step as it is reported; numbers that a method does not have are NAN. */
typedef struct co_step_record {
    co_method method;
    int iteration;     /* accepted steps, this one included */
    int evaluations;   /* of the function, so far */
    int rejected;      /* steps that were taken back, so far */
    double length;     /* by the objective's step_length() */
    double predicted;  /* decrease by the quadratic model */
    double gain_ratio; /* actual decrease over the predicted one */
    double shift;      /* of the matrix that the step is by */
} co_step_record;

typedef struct co_objective {
    void *context;
    size_t n;
    /* Value, gradient and findings at `at->x`; the value is not finite where the function is not defined. */
    void (*evaluate)(void *context, co_iterate *at);
    /* Length of a step d in the units of the step cap. */
    double (*step_length)(void *context, const double *d);
    /* Reviews an accepted step from `before` to `now`. It may move `now` along directions that do not change the
     * function, its gradient with it, or replace it by an earlier iterate. */
    co_step_verdict (*review_step)(void *context, const co_iterate *before, co_iterate *now, int iteration);
    /* An initial inverse Hessian, or NULL: out [n] = M^-1 in [n], M symmetric positive definite; in and out may be the
     * same. Nonzero if that failed. */
    int (*precondition)(void *context, const double *in, double *out);
    /* Makes M that of `now`: the Gauss-Newton matrix, or the Hessian; if that cannot be done there is none.
     * `step_excess` is how many times too long the last direction was, 0 at first: where it is large, M should be
     * stiffer. */
    void (*update_preconditioner)(void *context, const co_iterate *now, double step_excess, int by_hessian);
    /* The Hessian at `now`, for Newton's method, else NULL; if not `closely` one that may be off by a little. `before`
     * is NULL, or where the last step began: the matrix may then be a better guide after such a step, and is the
     * Hessian in the limit of short ones. Nonzero if that failed. */
    int (*assemble)(void *context, const co_iterate *now, const double *before, int closely);
    /* M is that matrix, damped, if that is *positive definite. Nonzero if that failed. */
    int (*factorize)(void *context, const co_damping *damping, int *positive);
    /* The least shift: curvature that is not told from none at `now`. */
    double (*least_shift)(void *context, const co_iterate *now);
    /* A direction d [n], of any length, in which the matrix is negative, its sign such that the function does not rise
     * at first; 0 if there is none. M is lost. */
    int (*negative_curvature)(void *context, const co_iterate *now, double *d);
    /* Told of every step that stands; nonzero cancels. */
    int (*report)(void *context, const co_iterate *now, const co_step_record *record);
} co_objective;

#endif
