/* Our BLAS against loops as in its definition, for the cases that CHOLMOD and we call: lower
 * triangles, no unit diagonals. Sizes stand on both sides of where triangles are halved and blocks are cut; what lies
 * outside the matrices, and above triangles, stays. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "linalg/own_blas.h"

#include <float.h>

enum { LARGEST = 300, PAD = 3, LD = LARGEST + PAD };

static const int sizes[] = {0, 1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 24, 25, 49, 65, 97};
enum { N_SIZES = sizeof sizes / sizeof *sizes };
static const double factors[] = {0, 1, -1, 0.75};
enum { N_FACTORS = 4 };

static double a[LD * LD], b[LD * LD], c[LD * LD], expected[LD * LD];

/* Reproducible numbers between -1 and 1. */
static void fill(double *x, unsigned seed) {
    for (int i = 0; i < LD * LD; i++) {
        seed = seed * 1664525U + 1013904223U;
        x[i] = (double)seed / 2147483648.0 - 1;
    }
}

/* A well-conditioned triangle; above it and outside of it stays NaN, which no routine may read. */
static void fill_triangle(int n, unsigned seed) {
    fill(b, seed);
    for (int i = 0; i < LD * LD; i++)
        a[i] = NAN;
    for (int j = 0; j < n; j++)
        for (int i = j; i < n; i++)
            a[i + j * LD] = i == j ? 2 + b[i + j * LD] : b[i + j * LD] / n;
}

static void same(const double *got, double scale) {
    for (int i = 0; i < LD * LD; i++)
        if (!(fabs(got[i] - expected[i]) <= 8 * DBL_EPSILON * scale))
            CHECK_NEAR(got[i], expected[i], 8 * DBL_EPSILON * scale);
}

static double at(char transposed, const double *x, int i, int j) {
    return transposed == 'N' ? x[i + j * LD] : x[j + i * LD];
}

/* expected [m][n] = beta c + alpha op(a) op(b), of the lower triangle alone if so wanted; NaN in c is lost by beta 0.
 */
static void reference(char ta, char tb, int m, int n, int k, double alpha, double beta, const double *x,
                      const double *y, int lower) {
    for (int j = 0; j < n; j++)
        for (int i = lower ? j : 0; i < m; i++) {
            double sum = 0;
            for (int p = 0; p < k; p++)
                sum += at(ta, x, i, p) * at(tb, y, p, j);
            expected[i + j * LD] = (beta == 0 ? 0 : beta * expected[i + j * LD]) + alpha * sum;
        }
}

static const int ld = LD, one = 1;

static void check_gemm(char ta, char tb, int m, int n, int k, double alpha, double beta) {
    fill(c, 3);
    memcpy(expected, c, sizeof c);
    reference(ta, tb, m, n, k, alpha, beta, a, b, 0);
    dgemm_(&ta, &tb, &m, &n, &k, &alpha, a, &ld, b, &ld, &beta, c, &ld, 1, 1);
    same(c, k + 1);
}

static void test_products(void **state) {
    (void)state;
    fill(a, 1), fill(b, 2);
    for (int flags = 0; flags < 4; flags++) {
        const char ta = "NTNC"[flags], tb = "NNCT"[flags];
        for (int m = 0; m < N_SIZES; m++)
            for (int n = 0; n < N_SIZES; n += 2)
                for (int k = 0; k < N_SIZES; k += 3)
                    check_gemm(ta, tb, sizes[m], sizes[n], sizes[k], factors[(m + n) % 4], factors[(m + k) % 4]);
        check_gemm(ta, tb, 70, 20, 300, -1, 1); /* more than one block each way */
    }
}

static void test_products_with_themselves(void **state) {
    (void)state;
    fill(a, 1), fill(b, 2);
    for (int flag = 0; flag < 3; flag++)
        for (int n = 0; n < N_SIZES; n++)
            for (int k = 0; k < N_SIZES; k++) {
                const char trans = "NTC"[flag], other = trans == 'N' ? 'T' : 'N';
                const double alpha = factors[(n + k) % 4], beta = factors[n % 4];
                fill(c, 3);
                memcpy(expected, c, sizeof c);
                reference(trans, other, sizes[n], sizes[n], sizes[k], alpha, beta, a, a, 1);
                dsyrk_("L", &trans, &sizes[n], &sizes[k], &alpha, a, &ld, &beta, c, &ld, 1, 1);
                same(c, sizes[k] + 1);
                fill(c, 4);
                memcpy(expected, c, sizeof c);
                reference(trans, other, sizes[n], sizes[n], sizes[k], alpha, beta, a, b, 1);
                reference(trans, other, sizes[n], sizes[n], sizes[k], alpha, 1, b, a, 1);
                dsyr2k_("L", &trans, &sizes[n], &sizes[k], &alpha, a, &ld, b, &ld, &beta, c, &ld, 1, 1);
                same(c, 2 * sizes[k] + 1);
            }
}

/* The triangle times the solution is the right side: with the zeros above it that the routines do not read. */
static void multiply_back(char side, char trans, int m, int n, double *x) {
    static double product[LD * LD];
    memcpy(product, x, sizeof product);
    for (int j = 0; j < n; j++)
        for (int i = 0; i < m; i++) {
            double sum = 0;
            for (int p = 0; p < (side == 'L' ? m : n); p++) {
                const int r = side == 'L' ? i : p, s = side == 'L' ? p : j; /* of op(L) */
                const int row = trans == 'N' ? r : s, column = trans == 'N' ? s : r;
                if (row >= column)
                    sum += a[row + column * LD] * (side == 'L' ? x[p + j * LD] : x[i + p * LD]);
            }
            product[i + j * LD] = sum;
        }
    memcpy(x, product, sizeof product);
}

static void check_trsm(char side, char trans, int m, int n, double alpha) {
    fill_triangle(side == 'L' ? m : n, 5);
    fill(c, 6);
    memcpy(expected, c, sizeof c);
    for (int j = 0; j < n; j++)
        for (int i = 0; i < m; i++)
            expected[i + j * LD] *= alpha;
    dtrsm_(&side, "L", &trans, "N", &m, &n, &alpha, a, &ld, c, &ld, 1, 1, 1, 1);
    multiply_back(side, trans, m, n, c);
    same(c, 30);
}

static void test_triangular_systems(void **state) {
    (void)state;
    for (int i = 0; i < N_SIZES; i++)
        for (int j = 0; j < N_SIZES; j += 2) {
            check_trsm('L', 'N', sizes[i], sizes[j], factors[1 + i % 3]);
            check_trsm('L', 'T', sizes[i], sizes[j], factors[1 + j % 3]);
            check_trsm('L', 'C', sizes[i], sizes[j], 1);
            check_trsm('R', 'C', sizes[i], sizes[j], factors[1 + i % 3]);
            check_trsm('R', 'T', sizes[i], sizes[j], 1);
        }
}

static void test_one_right_side(void **state) {
    (void)state;
    for (int i = 0; i < N_SIZES; i++)
        for (int flag = 0; flag < 3; flag++) {
            const char trans = "NTC"[flag];
            fill_triangle(sizes[i], 7);
            fill(c, 8);
            memcpy(expected, c, sizeof c);
            dtrsv_("L", &trans, "N", &sizes[i], a, &ld, c, &one, 1, 1, 1);
            multiply_back('L', trans, sizes[i], 1, c);
            same(c, 30);
        }
}

static void check_gemv(char trans, int m, int n, double alpha, double beta) {
    const int length = trans == 'N' ? m : n, depth = trans == 'N' ? n : m;
    fill(c, 9);
    memcpy(expected, c, sizeof c);
    for (int i = 0; i < length; i++) {
        double sum = 0;
        for (int p = 0; p < depth; p++)
            sum += at(trans, a, i, p) * b[p];
        expected[i] = (beta == 0 ? 0 : beta * expected[i]) + alpha * sum;
    }
    dgemv_(&trans, &m, &n, &alpha, a, &ld, b, &one, &beta, c, &one, 1);
    same(c, depth + 1);
}

static void test_matrix_times_vector(void **state) {
    (void)state;
    fill(a, 1), fill(b, 2);
    for (int i = 0; i < N_SIZES; i++)
        for (int j = 0; j < N_SIZES; j++)
            for (int flag = 0; flag < 3; flag++)
                check_gemv("NTC"[flag], sizes[i], sizes[j], factors[i % 4], factors[j % 4]);
}

/* L times its transpose is the matrix. With a pivot that is not positive the number of its column comes back. */
static void test_factors(void **state) {
    (void)state;
    for (int i = 0; i < N_SIZES; i++) {
        const int n = sizes[i];
        int info = -1;
        fill_triangle(n, 10);
        for (int k = 0; k < LD * LD; k++)
            c[k] = NAN;
        for (int s = 0; s < n; s++)
            for (int r = s; r < n; r++) {
                double sum = 0;
                for (int p = 0; p <= s; p++)
                    sum += a[r + p * LD] * a[s + p * LD];
                c[r + s * LD] = sum;
            }
        memcpy(b, c, sizeof c);
        dpotrf_("L", &n, c, &ld, &info, 1);
        CHECK_INT(info, 0);
        for (int s = 0; s < n; s++)
            for (int r = s; r < n; r++)
                CHECK_NEAR(c[r + s * LD], a[r + s * LD], 1e-13);
        for (int bad = 0; bad < n; bad += 1 + n / 5) {
            memcpy(c, b, sizeof c);
            c[bad + bad * LD] = bad % 2 ? NAN : -1;
            dpotrf_("L", &n, c, &ld, &info, 1);
            CHECK_INT(info, bad + 1);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_products),
        cmocka_unit_test(test_products_with_themselves),
        cmocka_unit_test(test_triangular_systems),
        cmocka_unit_test(test_one_right_side),
        cmocka_unit_test(test_matrix_times_vector),
        cmocka_unit_test(test_factors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
