/* Sparse factorizations against dense ones: solutions, inertia, and when the count of negative eigenvalues is refused;
 * and that factorizing wakes no threads. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "linalg/sparse_cholesky.h"

#include <dirent.h>

/* A symmetric matrix by its lower triangle, zeros left out. */
typedef struct triangle {
    int32_t n;
    int32_t *start, *row;
    double *value;
} triangle;

static triangle triangle_of(int32_t n, const double *dense) {
    triangle t = {n, calloc((size_t)n + 1, sizeof(int32_t)), calloc((size_t)n * (size_t)n, sizeof(int32_t)),
                  calloc((size_t)n * (size_t)n, sizeof(double))};
    CHECK_TRUE(t.start && t.row && t.value);
    for (int32_t j = 0; j < n; j++) {
        t.start[j + 1] = t.start[j];
        for (int32_t i = j; i < n; i++)
            if (i == j || dense[i * n + j] != 0) {
                t.row[t.start[j + 1]] = i;
                t.value[t.start[j + 1]++] = dense[i * n + j];
            }
    }
    return t;
}

static void triangle_free(triangle *t) {
    free(t->start);
    free(t->row);
    free(t->value);
}

/* The factor that is kept of an indefinite matrix gives the same, and a Cholesky factor takes its place. */
static void check_indefinite(co_sparse_cholesky *f, int32_t n, double shift, int32_t negative, const double *b,
                             const double *x) {
    curvopt_error error;
    int32_t same = -7;
    int positive = -7;
    double *y = calloc((size_t)n, sizeof *y);
    CHECK_TRUE(y != NULL);
    for (int k = 0; k < 2; k++) {
        CHECK_OK(co_sparse_cholesky_factorize_indefinite(f, shift, &same, &error), &error);
        CHECK_INT(same, negative);
        CHECK_OK(co_sparse_cholesky_solve(f, b, y, &error), &error);
        for (int32_t i = 0; i < n; i++)
            CHECK_NEAR(y[i], x[i], 1e-9 * (1 + fabs(x[i])));
        CHECK_OK(co_sparse_cholesky_factorize(f, shift + 1e6, &positive, &error), &error);
        CHECK_INT(positive, 1);
        CHECK_OK(co_sparse_cholesky_solve(f, b, y, &error), &error);
        for (int32_t i = 0; i < n; i++)
            CHECK_NEAR(1e6 * y[i], b[i], 1e-3 * (1 + fabs(b[i])));
    }
    free(y);
}

/* The count of a dense matrix, and A^-1 b into x if it is known. */
static int32_t count(int32_t n, const double *dense, double shift, const double *b, double *x) {
    triangle t = triangle_of(n, dense);
    co_sparse_cholesky *f;
    curvopt_error error;
    int32_t negative = -7;
    CHECK_OK(co_sparse_cholesky_create(n, t.start, t.row, t.value, NULL, NULL, &f, &error), &error);
    CHECK_OK(co_sparse_cholesky_count_negative(f, shift, b ? 1 : 0, b, x, &negative, &error), &error);
    if (b && negative >= 0)
        check_indefinite(f, n, shift, negative, b, x);
    co_sparse_cholesky_destroy(f);
    triangle_free(&t);
    return negative;
}

/* dense [n][n] = Q diag(value) Q with Q the reflection I - 2 u u^T, u a random unit vector. */
static void with_eigenvalues(int32_t n, const double *value, uint64_t seed, double *dense) {
    double u[64], square = 0;
    CHECK_TRUE(n <= 64);
    for (int32_t i = 0; i < n; i++) {
        u[i] = check_random(&seed);
        square += u[i] * u[i];
    }
    for (int32_t i = 0; i < n; i++)
        for (int32_t j = 0; j < n; j++) {
            double sum = 0;
            for (int32_t k = 0; k < n; k++)
                sum += ((i == k) - 2 * u[i] * u[k] / square) * value[k] * ((j == k) - 2 * u[j] * u[k] / square);
            dense[i * n + j] = sum;
        }
    for (int32_t i = 0; i < n; i++)
        for (int32_t j = 0; j < i; j++)
            dense[j * n + i] = dense[i * n + j];
}

static void test_counts_are_those_of_the_eigenvalues(void **state) {
    enum { N = 40 };
    static double dense[N * N];
    double value[N], b[N], x[N];
    (void)state;
    for (int32_t wanted = 0; wanted <= N; wanted += 5)
        for (uint64_t seed = 1; seed <= 5; seed++) {
            uint64_t s = seed;
            for (int32_t i = 0; i < N; i++) {
                value[i] = (i < wanted ? -1 : 1) * pow(10, 3 * check_random(&s)); /* 1e-3 .. 1e3 */
                b[i] = check_random(&s);
            }
            with_eigenvalues(N, value, seed, dense);
            CHECK_INT(count(N, dense, 0, b, x), wanted);
            for (int32_t i = 0; i < N; i++) {
                double sum = -b[i];
                for (int32_t j = 0; j < N; j++)
                    sum += dense[i * N + j] * x[j];
                CHECK_NEAR(sum, 0, 1e-7);
            }
            CHECK_INT(count(N, dense, 1.1e3, NULL, NULL), 0);
            CHECK_INT(count(N, dense, -1.1e3, NULL, NULL), N);
        }
}

/* A saddle with a tiny pivot, of which elimination without pivots loses all but its own pair: one eigenvalue of the
 * lower block's sign, one positive and one negative. The numbers are those of one order of elimination, so each order
 * is tried, and both signs of the block: the factors are the same for either, so that one sign of D must be wrong. */
static void test_counts_that_rounding_decides_are_refused(void **state) {
    static const int order[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    int refused = 0;
    (void)state;
    for (int k = 0; k < 6; k++)
        for (int tenth = 0; tenth < 9; tenth++)
            for (int sign = -1; sign <= 1; sign += 2) {
                const double first = 3 + 0.1 * tenth, a[3][3] = {{1e-20, 1, first}, {1, sign, 0.2}, {first, 0.2, sign}};
                double dense[9];
                for (int i = 0; i < 9; i++)
                    dense[i] = a[order[k][i / 3]][order[k][i % 3]];
                int32_t negative = count(3, dense, 0, NULL, NULL);
                if (negative < 0)
                    refused++;
                else
                    CHECK_INT(negative, sign < 0 ? 2 : 1);
            }
    CHECK_BETWEEN(refused, 36, 108); /* at least where the tiny pivot comes first */
}

/* Too close to singular for anyone to say: an eigenvalue of a few roundings; a thousand times larger it is known. */
static void test_counts_next_to_singular_are_refused(void **state) {
    enum { N = 30 };
    static double dense[N * N];
    double value[N];
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2) {
        for (int32_t i = 0; i < N; i++)
            value[i] = i < 3 ? -1 - i : 1 + i;
        value[N - 1] = sign * 1e-16;
        with_eigenvalues(N, value, 3, dense);
        CHECK_INT(count(N, dense, 0, NULL, NULL), -1);
        value[N - 1] = sign * 1e-10;
        with_eigenvalues(N, value, 3, dense);
        CHECK_INT(count(N, dense, 0, NULL, NULL), 3 + (sign < 0));
    }
}

/* No limit on growth alone: a small pivot that costs no digits is fine, and so is a matrix of any scale. */
static void test_small_pivots_alone_are_no_reason(void **state) {
    const double pair[4] = {1e-5, 1, 1, 1e-5}, tiny[4] = {1e-100, 0, 0, -1e-100}, huge[4] = {1e100, 0, 0, -1e100};
    const double singular[4] = {0, 0, 0, 1}, nan_entry[4] = {(double)NAN, 0, 0, 1};
    (void)state;
    CHECK_INT(count(2, pair, 0, NULL, NULL), 1);
    CHECK_INT(count(2, tiny, 0, NULL, NULL), 1);
    CHECK_INT(count(2, huge, 0, NULL, NULL), 1);
    CHECK_INT(count(2, singular, 0, NULL, NULL), -1);
    CHECK_INT(count(2, nan_entry, 0, NULL, NULL), -1);
}

#ifndef THREADS_OF_EMULATOR /* qemu's own */
#define THREADS_OF_EMULATOR 0
#endif

static int threads_of_this_process(void) {
#ifdef _WIN32 /* has no /proc; the matrix is factored all the same */
    return 1;
#else
    DIR *folder = opendir("/proc/self/task");
    CHECK_TRUE(folder != NULL);
    int n = 0;
    while (readdir(folder))
        n++;
    closedir(folder);
    return n - 2 - THREADS_OF_EMULATOR; /* 2: . and .. */
#endif
}

static void test_factorizing_wakes_no_threads(void **state) {
    enum { N = 600 };
    double *dense = calloc((size_t)N * N, sizeof *dense);
    curvopt_error error;
    co_sparse_cholesky *f;
    int positive = 0;
    (void)state;
    CHECK_TRUE(dense != NULL);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++)
            dense[i * N + j] = i == j ? N : 1; /* one supernode: loops over all of it */
    triangle t = triangle_of(N, dense);
    int before = threads_of_this_process();
    CHECK_OK(co_sparse_cholesky_create(N, t.start, t.row, t.value, NULL, NULL, &f, &error), &error);
    CHECK_OK(co_sparse_cholesky_factorize(f, 0, &positive, &error), &error);
    CHECK_TRUE(positive);
    CHECK_INT(threads_of_this_process(), before);
    CHECK_INT(before, 1);
    CHECK_OK(co_sparse_cholesky_factorize(f, -2 * N, &positive, &error), &error);
    CHECK_TRUE(!positive);
    co_sparse_cholesky_destroy(f);
    triangle_free(&t);
    free(dense);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_factorizing_wakes_no_threads), /* before any other could */
        cmocka_unit_test(test_counts_are_those_of_the_eigenvalues),
        cmocka_unit_test(test_counts_that_rounding_decides_are_refused),
        cmocka_unit_test(test_counts_next_to_singular_are_refused),
        cmocka_unit_test(test_small_pivots_alone_are_no_reason),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
