/* The routines of the BLAS and of LAPACK that CHOLMOD's supernodal code and we call, by Fortran's names. Why they are
 * our own: libcurvopt/notes/96-blas-of-our-own.md. Only the cases that are called are there: lower triangles, no unit
 * diagonals. Conjugates are transposes. SPDX-License-Identifier: GPL-3.0-or-later */
#include "linalg/own_blas.h"

#include "base/instruction_set.h"
#include "linalg/blas_routines.h"

#include <stdlib.h>

CO_DECLARE_SETS(co_blas_routines, co_blas_routines);

static const co_blas_routines *routines(void) {
    static const co_blas_routines *const sets[CO_N_INSTRUCTION_SETS] = CO_OBJECTS_OF_SETS(co_blas_routines);
    return sets[co_best_instruction_set()];
}

static co_blas_operand operand_of(char transposed, const double *a, int ld) {
    return transposed == 'N' ? (co_blas_operand){a, 1, ld} : (co_blas_operand){a, ld, 1};
}

static co_blas_operand transpose(co_blas_operand x) {
    return (co_blas_operand){x.a, x.column, x.row};
}

static void scale(int m, int n, double beta, double *c, ptrdiff_t ld, int lower) {
    for (int j = 0; j < n && beta != 1; j++)
        for (int i = lower ? j : 0; i < m; i++)
            c[i + j * ld] = beta == 0 ? 0 : beta * c[i + j * ld];
}

void dgemm_(const char *trans_a, const char *trans_b, const int *m, const int *n, const int *k, const double *alpha,
            const double *a, const int *lda, const double *b, const int *ldb, const double *beta, double *c,
            const int *ldc, size_t n_a, size_t n_b) {
    (void)n_a, (void)n_b;
    scale(*m, *n, *beta, c, *ldc, 0);
    routines()->multiply_add(*m, *n, *k, *alpha, operand_of(*trans_a, a, *lda), operand_of(*trans_b, b, *ldb), c, *ldc);
}

void dsyrk_(const char *uplo, const char *trans, const int *n, const int *k, const double *alpha, const double *a,
            const int *lda, const double *beta, double *c, const int *ldc, size_t n_uplo, size_t n_trans) {
    const co_blas_operand x = operand_of(*trans, a, *lda);
    (void)uplo, (void)n_uplo, (void)n_trans;
    scale(*n, *n, *beta, c, *ldc, 1);
    routines()->multiply_add_lower(*n, *k, *alpha, x, transpose(x), c, *ldc);
}

void dsyr2k_(const char *uplo, const char *trans, const int *n, const int *k, const double *alpha, const double *a,
             const int *lda, const double *b, const int *ldb, const double *beta, double *c, const int *ldc,
             size_t n_uplo, size_t n_trans) {
    const co_blas_operand x = operand_of(*trans, a, *lda), y = operand_of(*trans, b, *ldb);
    (void)uplo, (void)n_uplo, (void)n_trans;
    scale(*n, *n, *beta, c, *ldc, 1);
    routines()->multiply_add_lower(*n, *k, *alpha, x, transpose(y), c, *ldc);
    routines()->multiply_add_lower(*n, *k, *alpha, y, transpose(x), c, *ldc);
}

void dtrsm_(const char *side, const char *uplo, const char *trans, const char *diagonal, const int *m, const int *n,
            const double *alpha, const double *a, const int *lda, double *b, const int *ldb, size_t n_side,
            size_t n_uplo, size_t n_trans, size_t n_diagonal) {
    (void)uplo, (void)diagonal, (void)n_side, (void)n_uplo, (void)n_trans, (void)n_diagonal;
    scale(*m, *n, *alpha, b, *ldb, 0);
    if (*side == 'L')
        routines()->solve_left(*trans != 'N', *m, *n, a, *lda, b, *ldb);
    else
        routines()->solve_right(*m, *n, a, *lda, b, *ldb);
}

void dpotrf_(const char *uplo, const int *n, double *a, const int *lda, int *info, size_t n_uplo) {
    (void)uplo, (void)n_uplo;
    *info = routines()->factor(*n, a, *lda);
}

/* CHOLMOD's vectors have no gaps. */
static void expect_no_gaps(int step) {
    if (step != 1)
        abort();
}

void dgemv_(const char *trans, const int *m, const int *n, const double *alpha, const double *a, const int *lda,
            const double *x, const int *step_x, const double *beta, double *y, const int *step_y, size_t n_trans) {
    const int transposed = *trans != 'N';
    (void)n_trans;
    expect_no_gaps(*step_x);
    expect_no_gaps(*step_y);
    scale(transposed ? *n : *m, 1, *beta, y, 0, 0);
    routines()->multiply_vector(transposed, *m, *n, *alpha, a, *lda, x, y);
}

void dtrsv_(const char *uplo, const char *trans, const char *diagonal, const int *n, const double *a, const int *lda,
            double *x, const int *step, size_t n_uplo, size_t n_trans, size_t n_diagonal) {
    (void)uplo, (void)diagonal, (void)n_uplo, (void)n_trans, (void)n_diagonal;
    expect_no_gaps(*step);
    routines()->solve_vector(*trans != 'N', *n, a, *lda, x);
}

/* CHOLMOD names the complex ones in code that no real matrix reaches. */
#define NEVER_CALLED(name)                                                                                             \
    void name(void) {                                                                                                  \
        abort();                                                                                                       \
    }
NEVER_CALLED(zgemm_)
NEVER_CALLED(zgemv_)
NEVER_CALLED(zherk_)
NEVER_CALLED(zpotrf_)
NEVER_CALLED(ztrsm_)
NEVER_CALLED(ztrsv_)
