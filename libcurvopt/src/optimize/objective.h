/* What an optimizer sees of a problem: vectors and callbacks, no geometry. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_OPTIMIZE_OBJECTIVE_H
#define CO_OPTIMIZE_OBJECTIVE_H

#include <stddef.h>

typedef enum co_step_verdict {
    CO_STEP_KEEP,    /* the step stands */
    CO_STEP_CHANGED, /* the step stands; the function itself has changed, so what was learnt of it is void */
    CO_STEP_REJECT,  /* go back to the iterate before: it was put into x, value, gradient; take shorter steps */
    CO_STEP_STOP     /* go back likewise, and give up */
} co_step_verdict;

typedef struct co_iterate {
    double *x;        /* [n] */
    double *gradient; /* [n] */
    double value;
} co_iterate;

/* How far Newton's matrix M = (1 - mix) H + mix G + shift is from the Hessian H. G is positive semidefinite, and like H
 * where what is minimized, a sum of squares, is small: the Gauss-Newton matrix. */
typedef struct co_damping {
    double shift; /* times the unit matrix */
    double mix;   /* 0 to 1 */
} co_damping;

typedef struct co_objective {
    void *context;
    size_t n;
    /* Value and gradient [n] at x; not finite where the function is not defined. */
    double (*evaluate)(void *context, const double *x, double *gradient);
    /* Length of a step d in units in which the step cap is given. */
    double (*step_length)(void *context, const double *d);
    /* Looks at an accepted step; may move `now` along directions that do not change the function (then its gradient
     * moves along), or replace it by `before`. */
    co_step_verdict (*review_step)(void *context, const co_iterate *before, co_iterate *now, int iteration);
    /* An initial inverse Hessian, or NULL: out [n] = M^-1 in [n], M symmetric positive definite; in and out may be the
     * same. Nonzero if that failed. */
    int (*precondition)(void *context, const double *in, double *out);
    /* Makes M that of `now`; if that cannot be done there is none. `overshoot` is how many times too long the
     * last direction was, 0 at first: where it is large, M should be stiffer. */
    void (*update_preconditioner)(void *context, const co_iterate *now, double overshoot);
    /* For Newton's method, else NULL. The Hessian at `now`; before: NULL, or where the last step began, for a matrix
     * that is a better guide after such a step and the Hessian in the limit of short ones. Nonzero if that failed. */
    int (*assemble)(void *context, const co_iterate *now, const double *before);
    /* M is that matrix, damped, if that is *positive definite. Nonzero if that failed. */
    int (*factorize)(void *context, const co_damping *damping, int *positive);
    /* Curvature that is not told from none at `now`: the least shift. */
    double (*least_shift)(void *context, const co_iterate *now);
    /* A direction in which that matrix is negative, d [n] of any length, its sign such that the function does not rise
     * at first; 0 if there is none. M is lost. */
    int (*negative_curvature)(void *context, const co_iterate *now, double *d);
    /* After every settled step; nonzero cancels. */
    int (*report)(void *context, const co_iterate *now, int iteration, int evaluations);
} co_objective;

#endif
