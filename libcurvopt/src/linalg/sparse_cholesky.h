/* Sparse Cholesky factorization: CHOLMOD, behind what we need of it. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_SPARSE_CHOLESKY_H
#define CO_LINALG_SPARSE_CHOLESKY_H

#include "base/cancel.h"
#include "base/status.h"
#include "base/thread_pool.h"

#include <stddef.h>

typedef struct co_sparse_cholesky co_sparse_cholesky;

/* Orders and analyzes the symmetric matrix whose lower triangle is column_start [n + 1], row and value, by columns with
 * ascending rows. The arrays are borrowed: they must outlive the factor, and only values may change. Large factors
 * are made by `threads`, with the same bits for any number of them; what takes long ends by `cancel`, with
 * CO_CANCELLED, and then there is no factor. Both are the caller's, or NULL. ERROR_MEMORY. */
int32_t co_sparse_cholesky_create(int32_t n, int32_t *column_start, int32_t *row, double *value,
                                  co_thread_pool *threads, co_cancel *cancel, co_sparse_cholesky **out,
                                  curvopt_error *error);
void co_sparse_cholesky_destroy(co_sparse_cholesky *factor);
/* Factors matrix + shift * identity with the present values. *positive tells whether that is positive definite; if it
 * is not, there is no factor to solve with. About n^1.5 operations for the Hessian of a cage of n vertices.
 * ERROR_MEMORY. */
int32_t co_sparse_cholesky_factorize(co_sparse_cholesky *factor, double shift, int *positive, curvopt_error *error);
/* Factors matrix + shift * identity as L D L^T without pivots, whether it is positive definite or not, to solve with.
 * *n_negative: negative entries of D, as many as negative eigenvalues but for rounding, which nothing bounds here; -1
 * if a pivot is zero. ERROR_MEMORY. */
int32_t co_sparse_cholesky_factorize_indefinite(co_sparse_cholesky *factor, double shift, int32_t *n_negative,
                                                curvopt_error *error);
/* Negative eigenvalues of matrix + shift * identity, by Sylvester's law of inertia from an L D L^T factorization
 * without pivots. *n_negative is -1, unknown, if a pivot is zero or if rounding errors may have changed the count: the
 * errors and the distance to a singular matrix are estimated afterwards. On the way solves for n_right right-hand
 * sides: right, solved [n_right][n], undefined if the count is unknown. Leaves no factor for solving. Costs one
 * simplicial factorization and 6 + n_right solutions. ERROR_MEMORY. */
int32_t co_sparse_cholesky_count_negative(co_sparse_cholesky *factor, double shift, int n_right, const double *right,
                                          double *solved, int32_t *n_negative, curvopt_error *error);
/* x [n] = solution of (matrix + shift) x = b [n]; x may be b. ERROR_MEMORY. */
int32_t co_sparse_cholesky_solve(co_sparse_cholesky *factor, const double *b, double *x, curvopt_error *error);

#endif
