/* The routines of the BLAS and of LAPACK that CHOLMOD's supernodal code and we call, once per instruction set.
 *
 * Matrices lie by columns, `ld` apart. Triangles are lower ones, without unit diagonals. Every sum is added up in an
 * order that hangs on the matrices' sizes alone, so that all processors have the same bits
 * (libcurvopt/notes/98-other-platforms.md). SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_BLAS_ROUTINES_H
#define CO_LINALG_BLAS_ROUTINES_H

#include <stddef.h>

/* A matrix or its transpose: element (i, j) is a[i * row + j * column]. */
typedef struct co_blas_operand {
    const double *a;
    ptrdiff_t row, column;
} co_blas_operand;

typedef struct co_blas_routines {
    /* C [m][n] += alpha A [m][k] B [k][n] */
    void (*multiply_add)(int m, int n, int k, double alpha, co_blas_operand a, co_blas_operand b, double *c,
                         ptrdiff_t ld);
    /* The same, of a square C's lower triangle alone. */
    void (*multiply_add_lower)(int n, int k, double alpha, co_blas_operand a, co_blas_operand b, double *c,
                               ptrdiff_t ld);
    /* B [n][m] := L^-1 B, transposed: L^-T B */
    void (*solve_left)(int transposed, int n, int m, const double *l, ptrdiff_t ld, double *b, ptrdiff_t ldb);
    /* B [m][n] := B L^-T */
    void (*solve_right)(int m, int n, const double *l, ptrdiff_t ld, double *b, ptrdiff_t ldb);
    /* A := its Cholesky factor. 0, or the number of the first column, from 1, whose pivot is not positive. */
    int (*factor)(int n, double *a, ptrdiff_t ld);
    /* y [m] += alpha A x [n], transposed: y [n] += alpha A^T x [m] */
    void (*multiply_vector)(int transposed, int m, int n, double alpha, const double *a, ptrdiff_t ld, const double *x,
                            double *y);
    /* x := L^-1 x, transposed: L^-T x */
    void (*solve_vector)(int transposed, int n, const double *l, ptrdiff_t ld, double *x);
} co_blas_routines;

#endif
