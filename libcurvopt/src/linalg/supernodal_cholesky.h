/* Numbers of a supernodal Cholesky factor: L L^T = A + shift, with the structure of supernodes.h.
 *
 * By columns, each of which gets what earlier supernodes subtract from it when it is its turn (Ng, Peyton, "Block
 * sparse Cholesky algorithms on advanced uniprocessor computers", SIAM J. Sci. Comput. 14(5), 1993). Wide supernodes
 * are cut into panels. Threads take panels one after the other, in an order in which none comes before what it needs,
 * and wait for what is not finished; sums come in the same order for any number of threads
 * (libcurvopt/notes/43-threads-of-the-factor.md). SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_SUPERNODAL_CHOLESKY_H
#define CO_LINALG_SUPERNODAL_CHOLESKY_H

#include "base/cancel.h"
#include "base/thread_pool.h"
#include "linalg/supernodes.h"

typedef struct co_supernodal_cholesky co_supernodal_cholesky;

/* Plans the factor of the symmetric matrix whose lower triangle is column_start [n + 1] and row. structure,
 * threads and cancel are borrowed; the last two may be NULL. ERROR_MEMORY, CO_CANCELLED. */
int32_t co_supernodal_cholesky_create(const co_supernodes *structure, const int *column_start, const int *row,
                                      co_thread_pool *threads, co_cancel *cancel, co_supernodal_cholesky **out,
                                      curvopt_error *error);
void co_supernodal_cholesky_destroy(co_supernodal_cholesky *plan);
/* Fills l [value_start[n_supernodes]] with the factor of the matrix with these values, plus shift on the diagonal.
 * *positive: whether it is positive definite; if not, l is undefined. CO_CANCELLED. */
int32_t co_supernodal_cholesky_factorize(co_supernodal_cholesky *plan, const double *value, double shift, double *l,
                                         int *positive);
/* x [n] = solution by the factor l of b [n]; x may be b. CO_CANCELLED. */
int32_t co_supernodal_cholesky_solve(co_supernodal_cholesky *plan, const double *l, const double *b, double *x);

#endif
