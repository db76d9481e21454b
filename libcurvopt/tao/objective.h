/* The objective of a cage that is shared out, its gradient and its Hessian, on PETSc's vectors.
 *
 * As inside the library: where nothing is held the objective is that of the cage moved to centroid 0 and scaled to root
 * mean square radius 1, and the gradient knows of it; where vertices are held, that of the frame that the input cage
 * gives, and motion that is not allowed is projected out of vectors before the objective sees them: it costs nothing,
 * the gradient has none of it, and whatever of it an optimizer makes does not count (energy_positions).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_ENERGY_H
#define CURVOPT_TAO_ENERGY_H

#include "subdomain.h"

#include <petscmat.h>

typedef struct energy {
    const portion *on;
    const curvopt_options *options; /* surface settled by the library, threads at least 1 */
    curvopt_problem *problem;
    curvopt_hessian *hessian;      /* NULL until it is asked for */
    int third;                     /* the objective has third-order terms */
    double *project;               /* [9 n_own] what of its motion each own vertex is allowed, a projector; NULL: all */
    double *anchor;                /* [3 n_own] from where motion counts */
    int framed;                    /* positions are taken as they are: something is held */
    double *shares;                /* [3][3 n_vertices] gradients of this rank's faces */
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
} energy;

/* The frame of positions: mean, and root mean square distance from it, of all vertices. own [3 n_own] */
PetscErrorCode energy_frame(const portion *on, const double *own, double centroid[3], double *radius);

/* Collective, and agreed on: a status of the library on all ranks alike, with message [AGREE_MESSAGE]. options: kept.
 */
PetscErrorCode energy_create(const portion *on, const curvopt_options *options, energy *out, int *refused,
                             char *message);
PetscErrorCode energy_free(energy *e);

/* From now on a value is infinite where a vertex is further than max_step mean edges from where it is at x: no line
 * search leaps over what quadrature would have seen. */
PetscErrorCode energy_limit_steps(energy *e, Vec x, double max_step);
/* Steps are measured from x. */
PetscErrorCode energy_set_base(energy *e, Vec x);

/* Value at x, and the gradient unless it is NULL. */
PetscErrorCode energy_evaluate(energy *e, Vec x, double *value, Vec gradient);
/* All terms at x, by the present rules, and the error by the next ones: e->sums and e->errors. */
PetscErrorCode energy_compare(energy *e, Vec x, double *value, double *relative_error);
/* Finer rules on the faces with the largest of the errors just found, so that the others keep half of the tolerance;
 * *raised: on how many. */
PetscErrorCode energy_refine_rules(energy *e, double tolerance, PetscInt *raised);
/* Both until the error is below the tolerance, or rules are at their finest. */
PetscErrorCode energy_resolve(energy *e, Vec x, double tolerance, double *value, double *relative_error);

/* e->own and e->xyz from x, the second normalized. */
PetscErrorCode energy_place(energy *e, Vec x);
/* Positions that x stands for, into own [3 n_own]: with only such motion from the anchor as is allowed. */
void energy_positions(const energy *e, const double *x, double *own);
/* What of a motion [3 n_own] is allowed, in place. */
void energy_project(const energy *e, double *own);
/* projectors [9 n_own], taken over: motion that is allowed from x on. */
PetscErrorCode energy_hold(energy *e, Vec x, double *projectors);

/* Second derivatives at x: *full applies the Hessian, dense part and projection included; *guide (MATAIJ) is the
 * Gauss-Newton matrix, shifted as the library shifts it, so that it is positive: to precondition with. Made when they
 * are NULL, and the caller's to destroy. */
PetscErrorCode energy_hessian(energy *e, Vec x, Mat *full, Mat *guide);
/* Of *full, what is sparse, with this shift; the caller's to destroy. */
PetscErrorCode energy_sparse(Mat full, double shift, Mat *sparse);
/* The shift of *guide, where the energy has this value and e->radius is the cage's. */
double energy_shift(const energy *e, double value);

#endif
