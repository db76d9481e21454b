/* Small dense matrices: what makes each result what it is. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "linalg/small_dense.h"

enum { MOST = 12, STRIDE = 14 }; /* rows are wider than the matrix: what is beyond must stay as it is */

static void fill(int n, uint64_t *seed, double m[STRIDE][STRIDE]) {
    for (int i = 0; i < STRIDE; i++)
        for (int j = 0; j < STRIDE; j++)
            m[i][j] = i < n && j < n ? check_random(seed) : 77;
}

static void check_border(int n, double m[STRIDE][STRIDE]) {
    for (int i = 0; i < n; i++)
        for (int j = n; j < STRIDE; j++)
            CHECK_NEAR(m[i][j], 77, 0);
}

/* Entry (i, j) of the product of two [n][n], the first one transposed or not. */
static double entry(int n, double a[STRIDE][STRIDE], int transposed, double b[STRIDE][STRIDE], int i, int j) {
    double sum = 0;
    for (int k = 0; k < n; k++)
        sum += (transposed ? a[k][i] : a[i][k]) * b[k][j];
    return sum;
}

static void test_inverse_times_matrix_is_one(void **state) {
    double a[STRIDE][STRIDE], whole[STRIDE][STRIDE], inverse[STRIDE][STRIDE];
    uint64_t seed = 5;
    (void)state;
    for (int n = 1; n <= MOST; n++)
        for (int round = 0; round < 10; round++) {
            fill(n, &seed, a);
            fill(n, &seed, inverse);
            if (n > 1 && round < 5)
                a[0][0] = 0; /* only a pivot from another row will do */
            memcpy(whole, a, sizeof a);
            co_small_dense_invert(n, STRIDE, a[0], inverse[0]);
            double largest = 1;
            for (int i = 0; i < n * n; i++)
                largest = fmax(largest, fabs(inverse[i / n][i % n]));
            for (int i = 0; i < n; i++)
                for (int j = 0; j < n; j++)
                    CHECK_NEAR(entry(n, whole, 0, inverse, i, j), i == j, 1e-13 * largest);
            check_border(n, inverse);
        }
}

static void test_inverse_of_a_singular_matrix_is_not_finite(void **state) {
    double a[4] = {1, 2, 2, 4}, inverse[4];
    (void)state;
    co_small_dense_invert(2, 2, a, inverse);
    CHECK_TRUE(!isfinite(inverse[0]) || !isfinite(inverse[3]));
}

static void check_eigen(int n, double a[STRIDE][STRIDE]) {
    double whole[STRIDE][STRIDE], v[STRIDE][STRIDE], value[MOST], norm = 1e-300;
    uint64_t seed = 9;
    fill(n, &seed, v);
    memcpy(whole, a, sizeof whole);
    for (int i = 0; i < n * n; i++)
        norm = fmax(norm, fabs(a[i / n][i % n]));
    co_small_dense_eigen(n, STRIDE, a[0], value, v[0]);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            CHECK_NEAR(entry(n, v, 1, v, i, j), i == j, 1e-14 * n);
            CHECK_NEAR(entry(n, whole, 0, v, i, j), value[j] * v[i][j], 1e-14 * n * norm);
        }
    check_border(n, v);
}

static void test_eigenvectors(void **state) {
    double a[STRIDE][STRIDE];
    uint64_t seed = 11;
    (void)state;
    for (int n = 1; n <= MOST; n++)
        for (int round = 0; round < 8; round++) {
            fill(n, &seed, a);
            double scale = pow(10, 20 * (round - 4));
            for (int i = 0; i < n; i++)
                for (int j = 0; j <= i; j++)
                    a[i][j] = a[j][i] = scale * (round == 7 ? 1 : a[i][j]); /* the last one of rank 1 */
            check_eigen(n, a);
        }
}

/* Jacobi's rotations keep the small eigenvalues of a graded matrix, too, to digits of their own. */
static void test_small_eigenvalues_of_a_graded_matrix(void **state) {
    double a[3][3] = {{1, 1e-6, 0}, {1e-6, 1e-10, 1e-16}, {0, 1e-16, 1e-20}}, value[3], v[3][3], sum = 0, product = 1;
    (void)state;
    double determinant = co_small_dense_determinant_3(a);
    co_small_dense_eigen(3, 3, a[0], value, v[0]);
    for (int i = 0; i < 3; i++) {
        sum += value[i];
        product *= value[i];
    }
    CHECK_NEAR(sum, 1 + 1e-10, 1e-15);
    CHECK_NEAR(product / determinant, 1, 1e-9);
}

static void test_three_by_three(void **state) {
    const double a[9] = {2, -1, 3, 0, 5, 1, 4, 1, -2}, b[9] = {1, 2, 0, -3, 1, 4, 2, 2, 2}, x[3] = {1, -2, 3};
    const double product[9] = {11, 9, 2, -13, 7, 22, -3, 5, 0};
    double square[3][3] = {{2, -1, 3}, {0, 5, 1}, {4, 1, -2}}, out[9];
    (void)state;
    co_small_dense_multiply_3(a, b, out);
    for (int i = 0; i < 9; i++)
        CHECK_NEAR(out[i], product[i], 0);
    co_small_dense_apply_3(a, x, out);
    CHECK_NEAR(out[0], 13, 0);
    CHECK_NEAR(out[1], -7, 0);
    CHECK_NEAR(out[2], -4, 0);
    CHECK_NEAR(co_small_dense_determinant_3(square), -86, 0);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double sum = 0;
            for (int k = 0; k < 3; k++)
                sum += square[i][k] * co_small_dense_cofactor_3(square, j, k);
            CHECK_NEAR(sum, i == j ? -86 : 0, 0);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_inverse_times_matrix_is_one),
        cmocka_unit_test(test_inverse_of_a_singular_matrix_is_not_finite),
        cmocka_unit_test(test_eigenvectors),
        cmocka_unit_test(test_small_eigenvalues_of_a_graded_matrix),
        cmocka_unit_test(test_three_by_three),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
