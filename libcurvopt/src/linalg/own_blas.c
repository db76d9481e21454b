/* The routines of the BLAS and of LAPACK that CHOLMOD's supernodal code and we call, for platforms where no BLAS is at
 * hand: what is linked then is this file (CURVOPT_OWN_BLAS). All of the work is in one product of matrices; the
 * triangular routines halve themselves until they are small (Elmroth, Gustavson, Jonsson, Kågström, "Recursive blocked
 * algorithms and hybrid data structures for dense matrix library software", SIAM Review 46(1), 2004).
 *
 * Only the cases that are called are there: lower triangles, no unit diagonals. Conjugates are transposes. What it
 * costs beside OpenBLAS: notes/96-blas-of-the-cross-builds.md. SPDX-License-Identifier: GPL-3.0-or-later */
#include "linalg/own_blas.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

typedef double vector __attribute__((vector_size(32), aligned(8)));
enum {
    ROWS = 8,     /* of the product's tile that is kept in registers */
    COLUMNS = 4,  /* the same */
    BLOCK_M = 64, /* rows of a packed block of A: 64 x 256 doubles lie in a cache of 256 KiB */
    BLOCK_K = 256,
    SMALL = 24 /* unknowns below which triangles are not halved */
};

/* A matrix by columns; op: element (i, j) is a[i * row + j * column]. */
typedef struct operand {
    const double *a;
    ptrdiff_t row, column;
} operand;

static operand operand_of(char transposed, const double *a, int ld) {
    return transposed == 'N' ? (operand){a, 1, ld} : (operand){a, ld, 1};
}

static operand from(operand x, ptrdiff_t i, ptrdiff_t j) {
    return (operand){x.a + i * x.row + j * x.column, x.row, x.column};
}

/* Rows i.. of m of A's block, ROWS at a time, zeros after the last. */
static void pack_rows(operand x, int m, int k, int width, double *to) {
    for (int i = 0; i < m; i += width)
        for (int p = 0; p < k; p++)
            for (int r = 0; r < width; r++)
                *to++ = i + r < m ? x.a[(i + r) * x.row + p * x.column] : 0;
}

/* c [m][n] += alpha times the product of a packed panel of ROWS rows and one of COLUMNS columns. */
static inline __attribute__((always_inline)) void tile(int k, double alpha, const double *a, const double *b, double *c,
                                                       ptrdiff_t ld, int m, int n) {
    vector sum[COLUMNS][2] = {{{0}}};
    for (int p = 0; p < k; p++, a += ROWS, b += COLUMNS) {
        const vector a0 = *(const vector *)a, a1 = *(const vector *)(a + 4);
        for (int j = 0; j < COLUMNS; j++) {
            sum[j][0] += a0 * b[j];
            sum[j][1] += a1 * b[j];
        }
    }
    for (int j = 0; j < n; j++)
        for (int i = 0; i < m; i++)
            c[i + j * ld] += alpha * sum[j][i / 4][i % 4];
}

static inline __attribute__((always_inline)) void tiles(int m, int n, int k, double alpha, const double *a,
                                                        const double *b, double *c, ptrdiff_t ld) {
    for (int j = 0; j < n; j += COLUMNS)
        for (int i = 0; i < m; i += ROWS)
            tile(k, alpha, a + (ptrdiff_t)i * k, b + (ptrdiff_t)j * k, c + i + j * ld, ld, m - i < ROWS ? m - i : ROWS,
                 n - j < COLUMNS ? n - j : COLUMNS);
}

#ifdef CO_HAVE_X86_KERNELS
__attribute__((target("avx2,fma"))) static void tiles_avx2(int m, int n, int k, double alpha, const double *a,
                                                           const double *b, double *c, ptrdiff_t ld) {
    tiles(m, n, k, alpha, a, b, c, ld);
}
#endif

static void tiles_portable(int m, int n, int k, double alpha, const double *a, const double *b, double *c,
                           ptrdiff_t ld) {
    tiles(m, n, k, alpha, a, b, c, ld);
}

/* C [m][n] += alpha A [m][k] B [k][n], where both are packed by blocks of fixed size: no memory is asked for. */
static void multiply_add(int m, int n, int k, double alpha, operand a, operand b, double *c, ptrdiff_t ld) {
    enum { BLOCK_N = 16 };
    double packed_a[BLOCK_M * BLOCK_K], packed_b[BLOCK_N * BLOCK_K];
    void (*run)(int, int, int, double, const double *, const double *, double *, ptrdiff_t) = tiles_portable;
#ifdef CO_HAVE_X86_KERNELS
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        run = tiles_avx2;
#endif
    for (int p = 0; p < k; p += BLOCK_K) {
        const int depth = k - p < BLOCK_K ? k - p : BLOCK_K;
        for (int i = 0; i < m; i += BLOCK_M) {
            const int height = m - i < BLOCK_M ? m - i : BLOCK_M;
            pack_rows(from(a, i, p), height, depth, ROWS, packed_a);
            for (int j = 0; j < n; j += BLOCK_N) {
                const int width = n - j < BLOCK_N ? n - j : BLOCK_N;
                const operand columns = from(b, p, j);
                pack_rows((operand){columns.a, columns.column, columns.row}, width, depth, COLUMNS, packed_b);
                run(height, width, depth, alpha, packed_a, packed_b, c + i + j * ld, ld);
            }
        }
    }
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
    multiply_add(*m, *n, *k, *alpha, operand_of(*trans_a, a, *lda), operand_of(*trans_b, b, *ldb), c, *ldc);
}

/* The lower triangle of C [n][n] += alpha A B. */
static void multiply_add_lower(int n, int k, double alpha, operand a, operand b, double *c, ptrdiff_t ld) {
    double block[SMALL * SMALL] = {0};
    if (n > SMALL) {
        const int half = n / 2;
        multiply_add_lower(half, k, alpha, a, b, c, ld);
        multiply_add(n - half, half, k, alpha, from(a, half, 0), b, c + half, ld);
        multiply_add_lower(n - half, k, alpha, from(a, half, 0), from(b, 0, half), c + half + half * ld, ld);
        return;
    }
    multiply_add(n, n, k, alpha, a, b, block, n);
    for (int j = 0; j < n; j++)
        for (int i = j; i < n; i++)
            c[i + j * ld] += block[i + j * n];
}

void dsyrk_(const char *uplo, const char *trans, const int *n, const int *k, const double *alpha, const double *a,
            const int *lda, const double *beta, double *c, const int *ldc) {
    const operand x = operand_of(*trans, a, *lda);
    (void)uplo;
    scale(*n, *n, *beta, c, *ldc, 1);
    multiply_add_lower(*n, *k, *alpha, x, (operand){x.a, x.column, x.row}, c, *ldc);
}

void dsyr2k_(const char *uplo, const char *trans, const int *n, const int *k, const double *alpha, const double *a,
             const int *lda, const double *b, const int *ldb, const double *beta, double *c, const int *ldc,
             size_t n_uplo, size_t n_trans) {
    const operand x = operand_of(*trans, a, *lda), y = operand_of(*trans, b, *ldb);
    const operand x_t = {x.a, x.column, x.row}, y_t = {y.a, y.column, y.row};
    (void)uplo, (void)n_uplo, (void)n_trans;
    scale(*n, *n, *beta, c, *ldc, 1);
    multiply_add_lower(*n, *k, *alpha, x, y_t, c, *ldc);
    multiply_add_lower(*n, *k, *alpha, y, x_t, c, *ldc);
}

/* X := L^-1 X, or L^-T X: L [n][n], X [n][m] whose elements are row and column apart. */
static void solve_lower(int transposed, int n, int m, const double *l, ptrdiff_t ld, double *x, ptrdiff_t row,
                        ptrdiff_t column) {
    for (int step = 0; step < n; step++) {
        const int i = transposed ? n - 1 - step : step, first = transposed ? i + 1 : 0, end = transposed ? n : i;
        for (int j = 0; j < m; j++) {
            double sum = x[i * row + j * column];
            for (int p = first; p < end; p++)
                sum -= (transposed ? l[p + i * ld] : l[i + p * ld]) * x[p * row + j * column];
            x[i * row + j * column] = sum / l[i + i * ld];
        }
    }
}

/* B [n][m] := L^-1 B or L^-T B */
static void solve_left(int transposed, int n, int m, const double *l, ptrdiff_t ld, double *b, ptrdiff_t ldb) {
    const int half = n / 2;
    if (n <= SMALL) {
        solve_lower(transposed, n, m, l, ld, b, 1, ldb);
        return;
    }
    const double *below = l + half, *last = l + half + half * ld;
    if (transposed) {
        solve_left(1, n - half, m, last, ld, b + half, ldb);
        multiply_add(half, m, n - half, -1, (operand){below, ld, 1}, (operand){b + half, 1, ldb}, b, ldb);
        solve_left(1, half, m, l, ld, b, ldb);
    } else {
        solve_left(0, half, m, l, ld, b, ldb);
        multiply_add(n - half, m, half, -1, (operand){below, 1, ld}, (operand){b, 1, ldb}, b + half, ldb);
        solve_left(0, n - half, m, last, ld, b + half, ldb);
    }
}

/* B [m][n] := B L^-T */
static void solve_right(int m, int n, const double *l, ptrdiff_t ld, double *b, ptrdiff_t ldb) {
    const int half = n / 2;
    if (n <= SMALL) {
        for (int j = 0; j < n; j++) {
            double *at = b + j * ldb;
            for (int p = 0; p < j; p++)
                for (int i = 0; i < m; i++)
                    at[i] -= l[j + p * ld] * b[i + p * ldb];
            for (int i = 0; i < m; i++)
                at[i] /= l[j + j * ld];
        }
        return;
    }
    solve_right(m, half, l, ld, b, ldb);
    multiply_add(m, n - half, half, -1, (operand){b, 1, ldb}, (operand){l + half, ld, 1}, b + half * ldb, ldb);
    solve_right(m, n - half, l + half + half * ld, ld, b + half * ldb, ldb);
}

void dtrsm_(const char *side, const char *uplo, const char *trans, const char *diagonal, const int *m, const int *n,
            const double *alpha, const double *a, const int *lda, double *b, const int *ldb) {
    (void)uplo, (void)diagonal;
    scale(*m, *n, *alpha, b, *ldb, 0);
    if (*side == 'L')
        solve_left(*trans != 'N', *m, *n, a, *lda, b, *ldb);
    else
        solve_right(*m, *n, a, *lda, b, *ldb);
}

/* 0, or the number of the first column whose pivot is not positive. */
static int factor(int n, double *a, ptrdiff_t ld) {
    const int half = n / 2;
    if (n > SMALL) {
        double *below = a + half, *last = a + half + half * ld;
        int failed = factor(half, a, ld);
        if (failed)
            return failed;
        solve_right(n - half, half, a, ld, below, ld);
        multiply_add_lower(n - half, half, -1, (operand){below, 1, ld}, (operand){below, ld, 1}, last, ld);
        failed = factor(n - half, last, ld);
        return failed ? failed + half : 0;
    }
    for (int j = 0; j < n; j++) {
        if (!(a[j + j * ld] > 0))
            return j + 1;
        a[j + j * ld] = sqrt(a[j + j * ld]);
        for (int i = j + 1; i < n; i++)
            a[i + j * ld] /= a[j + j * ld];
        for (int k = j + 1; k < n; k++)
            for (int i = k; i < n; i++)
                a[i + k * ld] -= a[i + j * ld] * a[k + j * ld];
    }
    return 0;
}

void dpotrf_(const char *uplo, const int *n, double *a, const int *lda, int *info) {
    (void)uplo;
    *info = factor(*n, a, *lda);
}

void dgemv_(const char *trans, const int *m, const int *n, const double *alpha, const double *a, const int *lda,
            const double *x, const int *step_x, const double *beta, double *y, const int *step_y) {
    const ptrdiff_t ld = *lda, dx = *step_x, dy = *step_y;
    const int length = *trans == 'N' ? *m : *n;
    for (int i = 0; i < length && *beta != 1; i++)
        y[i * dy] = *beta == 0 ? 0 : *beta * y[i * dy];
    for (int j = 0; j < *n; j++) {
        double sum = 0;
        if (*trans == 'N') {
            const double factor_of_column = *alpha * x[j * dx];
            for (int i = 0; i < *m; i++)
                y[i * dy] += factor_of_column * a[i + j * ld];
        } else {
            for (int i = 0; i < *m; i++)
                sum += a[i + j * ld] * x[i * dx];
            y[j * dy] += *alpha * sum;
        }
    }
}

void dtrsv_(const char *uplo, const char *trans, const char *diagonal, const int *n, const double *a, const int *lda,
            double *x, const int *step) {
    (void)uplo, (void)diagonal;
    if (*trans == 'N') { /* by columns, as they lie in memory */
        for (int j = 0; j < *n; j++) {
            const double pivot = x[j * *step] /= a[j + (ptrdiff_t)j * *lda];
            for (int i = j + 1; i < *n; i++)
                x[i * *step] -= pivot * a[i + (ptrdiff_t)j * *lda];
        }
    } else {
        solve_lower(1, *n, 1, a, *lda, x, *step, 0);
    }
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
