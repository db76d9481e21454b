/* Sparse rows against dense matrices. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "linalg/sparse_rows.h"

enum { M = 7, N = 5, K = 6 };

/* About every third entry, none in row 2. */
static co_sparse_rows random_rows(int32_t n_rows, int32_t n_columns, uint64_t seed, double *dense) {
    co_sparse_rows rows;
    curvopt_error error;
    size_t n = 0;
    CHECK_OK(co_sparse_rows_allocate(&rows, n_rows, n_columns, (size_t)(n_rows * n_columns), &error), &error);
    for (int32_t r = 0; r < n_rows; r++) {
        for (int32_t c = n_columns - 1; c >= 0; c--) { /* descending: order must not matter */
            double x = check_random(&seed);
            dense[r * n_columns + c] = 0;
            if (r == 2 || check_random(&seed) > -0.3)
                continue;
            dense[r * n_columns + c] = x;
            rows.column[n] = c;
            rows.value[n++] = x;
        }
        rows.start[r + 1] = n;
    }
    CHECK_TRUE(n > 5);
    return rows;
}

static void fill_random(double *x, int n, uint64_t seed) {
    for (int i = 0; i < n; i++)
        x[i] = check_random(&seed);
}

static void test_apply_is_the_matrix_product(void **state) {
    (void)state;
    double dense[M * N], in[3 * N], out[3 * M];
    co_sparse_rows a = random_rows(M, N, 11, dense);
    fill_random(in, 3 * N, 5);
    co_sparse_rows_apply(&a, in, out);
    for (int r = 0; r < M; r++)
        for (int c = 0; c < 3; c++) {
            double sum = 0;
            for (int k = 0; k < N; k++)
                sum += dense[r * N + k] * in[3 * k + c];
            CHECK_NEAR(out[3 * r + c], sum, 1e-15);
        }
    co_sparse_rows_free(&a);
}

static void test_transposed_is_the_adjoint(void **state) {
    (void)state;
    double dense[M * N], x[3 * N], y[3 * M], ax[3 * M], aty[3 * N] = {0}, left = 0, right = 0;
    co_sparse_rows a = random_rows(M, N, 23, dense);
    fill_random(x, 3 * N, 6);
    fill_random(y, 3 * M, 7);
    co_sparse_rows_apply(&a, x, ax);
    co_sparse_rows_add_transposed(&a, y, aty);
    co_sparse_rows_add_transposed(&a, y, aty); /* adds: twice makes double */
    for (int i = 0; i < 3 * M; i++)
        left += ax[i] * y[i];
    for (int i = 0; i < 3 * N; i++)
        right += x[i] * aty[i];
    CHECK_NEAR(right, 2 * left, 1e-14);
    CHECK_TRUE(fabs(left) > 1e-3);
    co_sparse_rows_free(&a);
}

static void test_transpose_has_rows_for_columns(void **state) {
    (void)state;
    double dense[M * N], found[M * N] = {0};
    co_sparse_rows a = random_rows(M, N, 23, dense), t;
    curvopt_error error;
    CHECK_OK(co_sparse_rows_transpose(&a, &t, &error), &error);
    CHECK_INT(t.n_rows, N);
    CHECK_INT(t.n_columns, M);
    CHECK_INT(t.start[N], a.start[M]);
    for (int r = 0; r < N; r++)
        for (size_t e = t.start[r]; e < t.start[r + 1]; e++) {
            CHECK_TRUE(e == t.start[r] || t.column[e] > t.column[e - 1]);
            found[t.column[e] * N + r] = t.value[e];
        }
    for (int i = 0; i < M * N; i++)
        CHECK_TRUE(found[i] == dense[i]);
    co_sparse_rows_free(&a);
    co_sparse_rows_free(&t);
}

static void test_product_is_the_matrix_product_in_ascending_columns(void **state) {
    (void)state;
    double dense_a[M * N], dense_b[N * K], dense_c[M * K] = {0};
    co_sparse_rows a = random_rows(M, N, 31, dense_a), b = random_rows(N, K, 37, dense_b), c;
    curvopt_error error;
    CHECK_OK(co_sparse_rows_multiply(&a, &b, &c, &error), &error);
    CHECK_INT(c.n_rows, M);
    CHECK_INT(c.n_columns, K);
    for (int r = 0; r < M; r++)
        for (size_t e = c.start[r]; e < c.start[r + 1]; e++) {
            CHECK_TRUE(e == c.start[r] || c.column[e] > c.column[e - 1]);
            dense_c[r * K + c.column[e]] = c.value[e];
        }
    CHECK_INT(c.start[2], c.start[3]); /* an empty row stays empty */
    for (int r = 0; r < M; r++)
        for (int k = 0; k < K; k++) {
            double sum = 0;
            for (int i = 0; i < N; i++)
                sum += dense_a[r * N + i] * dense_b[i * K + k];
            CHECK_NEAR(dense_c[r * K + k], sum, 1e-15);
        }
    co_sparse_rows_free(&a);
    co_sparse_rows_free(&b);
    co_sparse_rows_free(&c);
}

static void test_absurd_size_is_out_of_memory(void **state) {
    (void)state;
    co_sparse_rows rows;
    curvopt_error error;
    CHECK_REFUSED(co_sparse_rows_allocate(&rows, 1, 1, SIZE_MAX / 2, &error), &error, CURVOPT_ERROR_MEMORY, -1,
                  "memory");
    CHECK_TRUE(!rows.start && !rows.column && !rows.value);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_apply_is_the_matrix_product),
        cmocka_unit_test(test_transposed_is_the_adjoint),
        cmocka_unit_test(test_transpose_has_rows_for_columns),
        cmocka_unit_test(test_product_is_the_matrix_product_in_ascending_columns),
        cmocka_unit_test(test_absurd_size_is_out_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
