/* The linear system of Newton's method over the variables of a dof_map, factored.
 *
 * The sparse matrix is sparse_hessian.h's. Three parts are dense. Of an objective that is a function of a few integrals
 * (the area A and the third-order integral T by which it is multiplied; numbers that are held, or that spontaneous
 * curvature is a function of) the Hessian also has
 * G D G^T, with their gradients G and the function's second derivatives D by them. Where numbers are held, positions go
 * back to their values along given ways W, and the Hessian H of the function that is left is Z^T H Z with
 * Z = 1 - W (A^T W)^-1 A^T, A the gradients of the constraints (Abadie, Carpentier, "Generalization of the Wolfe
 * reduced gradient method to the case of nonlinear constraints", 1969). Motions that leave the objective as it is
 * (rigid ones, scaling, the ways) are made stiff, or rounding would decide whether they are soft or negative; along
 * normals, where the objective sees what is left of them, infinitely so: solutions are orthogonal to them.
 * Together the matrix is M = H + U C U^T with two dozen columns U at most and a diagonal C; it is
 * solved by the formula of Sherman, Morrison and Woodbury, and its inertia follows from Haynsworth's (1968):
 * In(M) = In(H) + In(-C^-1 - U^T H^-1 U) - In(-C^-1).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_NEWTON_SYSTEM_H
#define CO_HESSIAN_NEWTON_SYSTEM_H

#include "hessian/gauge.h"
#include "hessian/sparse_hessian.h"
#include "linalg/sparse_cholesky.h"

/* Integrals that an objective may be a function of: numbers, by curvopt_scalar, and T. */
enum { CO_NEWTON_SYSTEM_INTEGRALS = CURVOPT_N_SCALARS + 1, CO_NEWTON_SYSTEM_THIRD = CURVOPT_N_SCALARS };
/* These, and the Hessian's products with the ways. */
enum { CO_NEWTON_SYSTEM_PARTS = CO_NEWTON_SYSTEM_INTEGRALS + CURVOPT_N_SCALARS };
enum { CO_NEWTON_SYSTEM_MOTIONS = CO_GAUGE_MOTIONS + CURVOPT_N_SCALARS };
enum { CO_NEWTON_SYSTEM_DENSE = CO_NEWTON_SYSTEM_PARTS + CO_NEWTON_SYSTEM_MOTIONS };

/* Numbers that are held, and how. */
typedef struct co_newton_held {
    const co_held_numbers *numbers;
    double *way;                          /* [numbers->n][n_variables] W */
    double multiplier[CURVOPT_N_SCALARS]; /* of each constraint, where the matrix is wanted */
} co_newton_held;

typedef struct co_newton_system {
    co_assembly *assembly;      /* the caller's */
    const co_newton_held *held; /* the caller's; NULL: nothing is held */
    co_sparse_hessian hessian;
    co_sparse_cholesky *factor;
    double *dense;  /* [CO_NEWTON_SYSTEM_DENSE + 1][n_variables] U, and room for a right-hand side */
    double *solved; /* [CO_NEWTON_SYSTEM_DENSE + 1][n_variables] H^-1 of these */
    double *full;   /* [2][3 n_vertices] work */
    double *part;   /* [CO_NEWTON_SYSTEM_PARTS][n_variables] G, and H W */
    int has_part[CO_NEWTON_SYSTEM_INTEGRALS];                              /* which of G count */
    double second[CO_NEWTON_SYSTEM_INTEGRALS][CO_NEWTON_SYSTEM_INTEGRALS]; /* D */
    double slope[CURVOPT_N_SCALARS][CURVOPT_N_SCALARS];                    /* of each constraint by the numbers */
    double *motion;         /* [CO_NEWTON_SYSTEM_MOTIONS + 1][n_variables] orthonormal, and work */
    int n_motions;          /* the last of the columns */
    int leaves_motions_out; /* the caller's: solutions have no part of them; else they are stiff */
    const double *left_out; /* [n_left_out][n_variables] the caller's motions, orthonormal; NULL: the gauge's at x */
    int n_left_out;
    double stiffness;                                               /* of motions: as the rest is in the mean */
    int n_dense;                                                    /* columns of U in use */
    double weight[CO_NEWTON_SYSTEM_DENSE];                          /* diagonal of C; INFINITY: left out */
    double inverse[CO_NEWTON_SYSTEM_DENSE][CO_NEWTON_SYSTEM_DENSE]; /* (C^-1 + U^T H^-1 U)^-1 */
    double *exact;        /* [n_entries] the Hessian, for a mixture; made when first needed */
    double *gauss_newton; /* [n_entries] the Gauss-Newton matrix, for a mixture; made when first needed */
    double mix;           /* part of the Gauss-Newton matrix in the mixture */
    const double *metric; /* [n_entries] the caller's: a shift is a multiple of this matrix; NULL: of the unit matrix */
    double unit_shift;    /* the caller's: with a metric, the multiple of the unit matrix that is added besides */
    double *damped;       /* [n_entries] the sparse matrix with a shift by the metric: what is factored */
    int coarser;          /* rules of the matrix that was assembled last, as in co_second_kind */
} co_newton_system;

/* Assembly and dofs must outlive the system; dofs has variables. couplings: as co_sparsity_create. ERROR_SIZE,
 * ERROR_MEMORY. */
int32_t co_newton_system_create(co_assembly *assembly, const co_dof_map *dofs, const co_couplings *couplings,
                                co_newton_system *out, curvopt_error *error);
void co_newton_system_free(co_newton_system *system);
/* Makes the matrix at normalized positions x [3 n_vertices]: Gauss-Newton's, positive semidefinite, or the Hessian. The
 * factor is lost. ERROR_MEMORY. */
int32_t co_newton_system_assemble(co_newton_system *system, const double *x, const co_second_kind *kind, co_gauge gauge,
                                  curvopt_error *error);
/* Of the matrix that was assembled last, at the same x: motions of this gauge are made stiff instead. The factor is
 * lost. */
void co_newton_system_change_gauge(co_newton_system *system, const double *x, co_gauge gauge);
/* For co_newton_system_mix(), after the Hessian was assembled: sets its values aside, and puts those of the
 * Gauss-Newton matrix at the same x in their place. The caller may add to them. ERROR_MEMORY. */
int32_t co_newton_system_begin_gauss_newton(co_newton_system *system, const double *x, curvopt_error *error);
/* Then sets the values of the Gauss-Newton matrix aside, too. */
void co_newton_system_end_gauss_newton(co_newton_system *system);
/* The sparse matrix becomes (1 - mix) times the Hessian's plus mix times the Gauss-Newton matrix, 0 <= mix <= 1. The
 * dense columns, which are of first derivatives, stay. */
void co_newton_system_mix(co_newton_system *system, double mix);
double co_newton_system_mean_diagonal(const co_newton_system *system);
/* Factors M + shift (of the metric, if there is one). *positive: whether that is positive definite, and its sparse part
 * H + shift, too; if not it cannot solve. (Where the dense columns alone make M positive, this says no: what is damped
 * gets a larger shift, and the decrement is by the Gauss-Newton matrix.) Where numbers are held, H may have as many
 * negative eigenvalues as these are, and with spontaneous curvature two more. ERROR_MEMORY. */
int32_t co_newton_system_factorize(co_newton_system *system, double shift, int *positive, curvopt_error *error);
/* x = (M + shift)^-1 b, [n_variables]; x may be b. ERROR_MEMORY. */
int32_t co_newton_system_solve(co_newton_system *system, const double *b, double *x, curvopt_error *error);
/* Takes motions out of v [n_variables]: its part orthogonal to them. */
void co_newton_system_remove_motions(const co_newton_system *system, double *v);
/* Negative eigenvalues of M + shift, whatever the metric; -1 if it is singular to rounding. On the way x = (M +
 * shift)^-1 b, [n_variables], undefined if the count is -1. ERROR_MEMORY. */
int32_t co_newton_system_count_negative(co_newton_system *system, double shift, const double *b, double *x,
                                        int32_t *n_negative, curvopt_error *error);

#endif
