/* The BLAS and LAPACK routines that CHOLMOD calls and own_blas.c has, by the names and arguments of Fortran: Dongarra,
 * Du Croz, Hammarling, Duff, "A set of level 3 basic linear algebra subprograms", ACM TOMS 16(1), 1990. CHOLMOD gives
 * no lengths of character arguments. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_OWN_BLAS_H
#define CO_LINALG_OWN_BLAS_H

#include "linalg/blas.h"

extern void dsyrk_(const char *uplo, const char *trans, const int *n, const int *k, const double *alpha,
                   const double *a, const int *lda, const double *beta, double *c, const int *ldc);
extern void dtrsm_(const char *side, const char *uplo, const char *trans, const char *diagonal, const int *m,
                   const int *n, const double *alpha, const double *a, const int *lda, double *b, const int *ldb);
extern void dpotrf_(const char *uplo, const int *n, double *a, const int *lda, int *info);
extern void dgemv_(const char *trans, const int *m, const int *n, const double *alpha, const double *a, const int *lda,
                   const double *x, const int *step_x, const double *beta, double *y, const int *step_y);
extern void dtrsv_(const char *uplo, const char *trans, const char *diagonal, const int *n, const double *a,
                   const int *lda, double *x, const int *step);
extern void zgemm_(void), zgemv_(void), zherk_(void), zpotrf_(void), ztrsm_(void), ztrsv_(void);

#endif
