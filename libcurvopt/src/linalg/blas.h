/* The routines of the BLAS and of LAPACK that we call, by the names and arguments of Fortran: Dongarra, Du Croz,
 * Hammarling, Duff, "A set of level 3 basic linear algebra subprograms", ACM TOMS 16(1), 1990; Anderson et al., "LAPACK
 * users' guide", 3rd ed. 1999. Matrices by columns; lengths of character arguments come last, as gfortran has them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
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
/* C [n][n] = alpha A A^T + beta C, one triangle; A is [n][k] for trans "N". */
extern void dsyrk_(const char *uplo, const char *trans, const int *n, const int *k, const double *alpha,
                   const double *a, const int *lda, const double *beta, double *c, const int *ldc, size_t, size_t);
/* B [m][n] = alpha op(A)^-1 B for side "L", alpha B op(A)^-1 for "R"; A is a triangle. */
extern void dtrsm_(const char *side, const char *uplo, const char *trans, const char *diagonal, const int *m,
                   const int *n, const double *alpha, const double *a, const int *lda, double *b, const int *ldb,
                   size_t, size_t, size_t, size_t);
/* A [n][n], one triangle: its Cholesky factor. info: 0, or the number of the first pivot that is not positive. */
extern void dpotrf_(const char *uplo, const int *n, double *a, const int *lda, int *info, size_t);
/* y = alpha op(A) x + beta y; A is [m][n]. */
extern void dgemv_(const char *trans, const int *m, const int *n, const double *alpha, const double *a, const int *lda,
                   const double *x, const int *step_x, const double *beta, double *y, const int *step_y, size_t);
/* x [n] = op(A)^-1 x; A is a triangle. */
extern void dtrsv_(const char *uplo, const char *trans, const char *diagonal, const int *n, const double *a,
                   const int *lda, double *x, const int *step, size_t, size_t, size_t);

#endif
