/* The objective of a distributed cage, its gradient and its Hessian, on PETSc's vectors.
 *
 * As inside the library: where nothing is fixed the objective is that of the cage moved to centroid 0 and scaled to
 * root mean square radius 1, and the gradient knows of it; where vertices are fixed, that of the frame that the input
 * cage gives, and motion that is not allowed is projected out of vectors before the objective sees them: it costs
 * nothing, the gradient has none of it, and whatever of it an optimizer makes does not count (objective_positions).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_OBJECTIVE_H
#define CURVOPT_TAO_OBJECTIVE_H

#include "subdomain.h"

#include <petscmat.h>

typedef struct objective {
    const subdomain *on;
    const curvopt_options *options; /* surface not AUTO, threads at least 1 */
    curvopt_problem *problem;
    curvopt_hessian *hessian;      /* NULL until it is asked for */
    int third;                     /* the objective has third-order terms */
    double *project;               /* [9 n_own] what of its motion each own vertex is allowed, a projector; NULL: all */
    double *anchor;                /* [3 n_own] from where motion counts */
    int framed;                    /* positions are taken as they are: something is fixed */
    double *gradients;             /* [3][3 n_vertices] gradients of this rank's faces */
    double *xyz;                   /* [3 n_vertices] normalized */
    double *own;                   /* [3 n_own] positions that were looked at last, but for what is not allowed */
    double *base;                  /* [3 n_own] positions that steps are measured from; NULL: they are not */
    double longest;                /* step of a vertex beyond which the value is infinite */
    int32_t *rules;                /* [n_faces] */
    double *errors;                /* [n_faces] of the last comparison with finer rules */
    curvopt_sums sums;             /* of the whole surface, where it was evaluated last */
    double centroid[3], radius;    /* of that cage, in the vector's units */
    double error_net, error_gross; /* of the last comparison, of the objective */
    double cpu_seconds;            /* this rank's, in the library's functions */
    double least_seconds;          /* of the clock, for a value and gradient from call to return */
    int32_t evaluations;           /* of value and gradient */
} objective;

/* Whether a curvopt_term is of third order; whether any with a weight is. */
int objective_is_third_order(int term);
int objective_has_third_order(const curvopt_options *options);

/* The frame of positions: mean, and root mean square distance from it, of all vertices. own [3 n_own] */
PetscErrorCode objective_frame(const subdomain *on, const double *own, double centroid[3], double *radius);

/* Collective, *refused: a status of the library, the same on all ranks, with message [COLLECTIVE_MESSAGE]. options:
 * kept.
 */
PetscErrorCode objective_create(const subdomain *on, const curvopt_options *options, objective *out, int *refused,
                                char *message);
PetscErrorCode objective_free(objective *o);

/* From now on a value is infinite where a vertex is further than max_step mean edges from where it is at x: no line
 * search leaps over what quadrature would have seen. */
PetscErrorCode objective_limit_steps(objective *o, Vec x, double max_step);
/* Steps are measured from x. */
PetscErrorCode objective_set_base(objective *o, Vec x);

/* Value at x, and the gradient unless it is NULL. */
PetscErrorCode objective_evaluate(objective *o, Vec x, double *value, Vec gradient);
/* All terms at x, by the present rules, and the error by the next ones: o->sums and o->errors. */
PetscErrorCode objective_compare(objective *o, Vec x, double *value, double *relative_error);
/* Finer rules on the faces with the largest of the errors just found, so that the others keep half of the tolerance;
 * *raised: on how many. */
PetscErrorCode objective_refine_rules(objective *o, double tolerance, PetscInt *raised);
/* Both until the error is below the tolerance, or rules are at their finest. */
PetscErrorCode objective_resolve(objective *o, Vec x, double tolerance, double *value, double *relative_error);

/* o->own and o->xyz from x, the second normalized. */
PetscErrorCode objective_place(objective *o, Vec x);
/* Positions that x stands for, into own [3 n_own]: with only such motion from the anchor as is allowed. */
void objective_positions(const objective *o, const double *x, double *own);
/* What of a motion [3 n_own] is allowed, in place. */
void objective_project(const objective *o, double *own);
/* projectors [9 n_own], taken over: motion that is allowed from x on. */
PetscErrorCode objective_constrain(objective *o, Vec x, double *projectors);

/* Second derivatives at x: *full applies the Hessian, dense part and projection included; *preconditioner (MATAIJ) is
 * the Gauss-Newton matrix, shifted as the library shifts it, so that it is positive. Made when they are NULL, and the
 * caller's to destroy. */
PetscErrorCode objective_hessian(objective *o, Vec x, Mat *full, Mat *preconditioner);
/* Of *full, what is sparse, with this shift; the caller's to destroy. */
PetscErrorCode objective_sparse(Mat full, double shift, Mat *sparse);
/* The shift of *preconditioner, where the objective has this value and o->radius is the cage's. */
double objective_shift(const objective *o, double value);

#endif
