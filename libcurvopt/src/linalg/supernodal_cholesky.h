/* Numbers of a supernodal Cholesky factor: L L^T = A + shift, where columns of L with the same rows below them lie
 * together in one dense block, a supernode. Its structure is the caller's (CHOLMOD finds it).
 *
 * By columns, each of which gets what earlier supernodes subtract from it when it is its turn (Ng, Peyton, "Block
 * sparse Cholesky algorithms on advanced uniprocessor computers", SIAM J. Sci. Comput. 14(5), 1993). Wide supernodes
 * are cut into panels. Threads take panels one after the other, in an order in which none comes before what it needs,
 * and wait for what is not finished; sums come in the same order for any number of threads
 * (libcurvopt/notes/45-factor-of-our-own.md). SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_SUPERNODAL_CHOLESKY_H
#define CO_LINALG_SUPERNODAL_CHOLESKY_H

#include "base/cancel.h"
#include "base/status.h"
#include "base/thread_pool.h"

/* Structure of L. Block s has the rows row[row_start[s]] .. row[row_start[s + 1] - 1], ascending, first those of its
 * own columns column[s] .. column[s + 1] - 1; its values lie by columns at value_start[s], above the diagonal too. */
typedef struct co_supernodes {
    int n, n_supernodes;
    const int *column;      /* [n_supernodes + 1] */
    const int *row_start;   /* [n_supernodes + 1] */
    const int *row;         /* [row_start[n_supernodes]] */
    const int *value_start; /* [n_supernodes] */
    const int *permutation; /* [n] column k of L is column permutation[k] of A */
} co_supernodes;

typedef struct co_supernodal_cholesky co_supernodal_cholesky;

/* Plans the factor of the symmetric matrix whose lower triangle is column_start [n + 1] and row. The arrays of
 * `structure`, threads and cancel are borrowed, and may be NULL. ERROR_MEMORY, CO_CANCELLED. */
int32_t co_supernodal_cholesky_create(const co_supernodes *structure, const int *column_start, const int *row,
                                      co_thread_pool *threads, co_cancel *cancel, co_supernodal_cholesky **out,
                                      curvopt_error *error);
void co_supernodal_cholesky_destroy(co_supernodal_cholesky *plan);
/* Fills l with the factor of the matrix with these values, plus shift on the diagonal. *positive: whether it is
 * positive definite; if not, l is undefined. CO_CANCELLED. */
int32_t co_supernodal_cholesky_factorize(co_supernodal_cholesky *plan, const double *value, double shift, double *l,
                                         int *positive);
/* x [n] = solution by the factor l of b [n]; x may be b. CO_CANCELLED. */
int32_t co_supernodal_cholesky_solve(co_supernodal_cholesky *plan, const double *l, const double *b, double *x);

#endif
