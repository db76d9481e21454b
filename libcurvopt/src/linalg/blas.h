/* The two BLAS routines that we call, of the BLAS that CHOLMOD brings: Dongarra, Du Croz, Hammarling, Duff, "A set of
 * level 3 basic linear algebra subprograms", ACM TOMS 16(1), 1990. Matrices by columns; lengths of character arguments
 * come last, as gfortran has them. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_BLAS_H
#define CO_LINALG_BLAS_H

#include <stddef.h>

/* C [m][n] = alpha op(A) op(B) + beta C */
extern void dgemm_(const char *trans_a, const char *trans_b, const int *m, const int *n, const int *k,
                   const double *alpha, const double *a, const int *lda, const double *b, const int *ldb,
                   const double *beta, double *c, const int *ldc, size_t, size_t);
/* C [n][n] = alpha (A B^T + B A^T) + beta C, one triangle; A and B are [n][k] for trans "N". */
extern void dsyr2k_(const char *uplo, const char *trans, const int *n, const int *k, const double *alpha,
                    const double *a, const int *lda, const double *b, const int *ldb, const double *beta, double *c,
                    const int *ldc, size_t, size_t);

#endif
