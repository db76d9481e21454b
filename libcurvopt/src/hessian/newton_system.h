/* The linear system of Newton's method over the variables of a dof_map, factored.
 *
 * The sparse matrix is sparse_hessian.h's. Two parts are dense. Of an objective S + A T, second order plus area times
 * third order, the Hessian also has grad A grad T^T + grad T grad A^T. Motions that leave the objective as it is (rigid
 * ones, scaling) are made stiff, or rounding would decide whether they are soft or negative. Together the matrix
 * is M = H + U C U^T with a dozen columns U; it is solved by the formula of Sherman, Morrison and Woodbury, and its
 * inertia follows from Haynsworth's (1968): In(M) = In(H) + In(-C^-1 - U^T H^-1 U) - In(-C^-1).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_NEWTON_SYSTEM_H
#define CO_HESSIAN_NEWTON_SYSTEM_H

#include "hessian/gauge.h"
#include "hessian/sparse_hessian.h"
#include "linalg/sparse_cholesky.h"

enum { CO_NEWTON_SYSTEM_DENSE = CO_GAUGE_MOTIONS + 2 };

typedef struct co_newton_system {
    co_assembly *assembly; /* the caller's */
    co_sparse_hessian hessian;
    co_sparse_cholesky *factor;
    double *dense;    /* [CO_NEWTON_SYSTEM_DENSE + 1][n_variables] U, and room for a right-hand side */
    double *solved;   /* [CO_NEWTON_SYSTEM_DENSE + 1][n_variables] H^-1 of these */
    double *full;     /* [2][3 n_vertices] work */
    int n_dense;      /* columns of U in use */
    int n_pair;       /* 2 if the first two columns are grad A and grad T, else 0 */
    double stiffness; /* entry in C of the other columns, which are orthonormal */
    double inverse[CO_NEWTON_SYSTEM_DENSE][CO_NEWTON_SYSTEM_DENSE]; /* (C^-1 + U^T H^-1 U)^-1 */
    double *exact;        /* [n_entries] the Hessian, for a mixture; made when first needed */
    double *gauss_newton; /* [n_entries] the Gauss-Newton matrix, for a mixture; made when first needed */
    double mix;           /* part of the Gauss-Newton matrix in the mixture */
} co_newton_system;

/* Assembly and dofs must outlive the system; dofs has variables. ERROR_SIZE, ERROR_MEMORY. */
int32_t co_newton_system_create(co_assembly *assembly, const co_dof_map *dofs, co_newton_system *out,
                                curvopt_error *error);
void co_newton_system_free(co_newton_system *system);
/* Makes the matrix at normalized positions x [3 n_vertices]: Gauss-Newton's, positive semidefinite, or the Hessian. The
 * factor is lost. ERROR_MEMORY. */
int32_t co_newton_system_assemble(co_newton_system *system, const double *x, const co_second_kind *kind, co_gauge gauge,
                                  curvopt_error *error);
/* For co_newton_system_mix(), after the Hessian was assembled: sets its values aside, and puts those of the
 * Gauss-Newton matrix at the same x in their place. The caller may add to them. ERROR_MEMORY. */
int32_t co_newton_system_begin_gauss_newton(co_newton_system *system, const double *x, curvopt_error *error);
/* Then sets the values of the Gauss-Newton matrix aside, too. */
void co_newton_system_end_gauss_newton(co_newton_system *system);
/* The sparse matrix becomes (1 - mix) times the Hessian's plus mix times the Gauss-Newton matrix, 0 <= mix <= 1. The
 * dense columns, which are of first derivatives, stay. */
void co_newton_system_mix(co_newton_system *system, double mix);
double co_newton_system_mean_diagonal(const co_newton_system *system);
/* Factors M + shift. *positive: whether that and its sparse part H + shift are positive definite; if not it cannot
 * solve. (Where the dense columns alone make M positive, this says no: what is damped gets a larger shift, and the
 * decrement is by the Gauss-Newton matrix.) ERROR_MEMORY. */
int32_t co_newton_system_factorize(co_newton_system *system, double shift, int *positive, curvopt_error *error);
/* x = (M + shift)^-1 b, [n_variables]; x may be b. ERROR_MEMORY. */
int32_t co_newton_system_solve(co_newton_system *system, const double *b, double *x, curvopt_error *error);
/* out += the part of M v that makes motions stiff. */
void co_newton_system_add_stiffness(const co_newton_system *system, const double *v, double *out);
/* Negative eigenvalues of M + shift; -1 if it is singular to rounding. On the way x = (M + shift)^-1 b, [n_variables],
 * undefined if the count is -1. ERROR_MEMORY. */
int32_t co_newton_system_count_negative(co_newton_system *system, double shift, const double *b, double *x,
                                        int32_t *n_negative, curvopt_error *error);

#endif
