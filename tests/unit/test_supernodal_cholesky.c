/* Factors by supernodes: their product is the matrix, their solutions solve it, threads do not change a bit, and they
 * can be cancelled. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "linalg/supernodal_cholesky.h"

enum { AT_A_NODE = 3, REACH = 2 };

/* A symmetric matrix by its lower triangle. */
typedef struct matrix {
    int n;
    int *start, *row;
    double *value;
} matrix;

/* Of a grid of nodes with three variables each, coupled as far as REACH; one with random entries, and a diagonal that
 * is larger than the rest of the row. width 1, height large: a band; one node further coupled to all others. */
static matrix matrix_of_grid(int width, int height, int with_hub, uint64_t seed) {
    const int n_nodes = width * height + (with_hub != 0), n = AT_A_NODE * n_nodes;
    const size_t most = (size_t)n * AT_A_NODE * ((2 * REACH + 1) * (2 * REACH + 1) + 1);
    matrix a = {n, calloc((size_t)n + 1, sizeof(int)), calloc(most, sizeof(int)), calloc(most, sizeof(double))};
    double *sum = calloc((size_t)n, sizeof *sum);
    CHECK_TRUE(a.start && a.row && a.value && sum);
    for (int j = 0; j < n; j++) {
        const int at = j / AT_A_NODE, x = at % width, y = at / width;
        a.start[j + 1] = a.start[j];
        for (int i = j; i < n; i++) {
            const int to = i / AT_A_NODE, is_hub = with_hub && to == n_nodes - 1;
            if (!is_hub && to != at && (abs(to % width - x) > REACH || to / width - y > REACH))
                continue;
            CHECK_TRUE((size_t)a.start[j + 1] < most);
            const double value = check_random(&seed);
            a.row[a.start[j + 1]] = i;
            a.value[a.start[j + 1]++] = value;
            sum[i] += fabs(value);
            sum[j] += fabs(value);
        }
    }
    for (int j = 0; j < n; j++)
        a.value[a.start[j]] = 1 + sum[j];
    free(sum);
    return a;
}

static void matrix_free(matrix *a) {
    free(a->start);
    free(a->row);
    free(a->value);
}

/* A factor with its plan. */
typedef struct factor {
    cholmod_common common;
    co_supernodes s;
    co_thread_pool *threads;
    co_supernodal_cholesky *plan;
    double *l;
} factor;

static void factor_create(const matrix *a, int32_t n_threads, co_cancel *cancel, factor *f) {
    curvopt_error error;
    *f = (factor){.threads = NULL};
    cholmod_start(&f->common);
    if (n_threads > 1)
        CHECK_OK(co_thread_pool_create(n_threads, &f->threads, &error), &error);
    CHECK_OK(co_supernodes_create(a->n, a->start, a->row, &f->common, &f->s, &error), &error);
    CHECK_OK(co_supernodal_cholesky_create(&f->s, a->start, a->row, f->threads, cancel, &f->plan, &error), &error);
    f->l = calloc(f->s.value_start[f->s.n_supernodes], sizeof *f->l);
    CHECK_TRUE(f->l != NULL);
}

static void factor_free(factor *f) {
    co_supernodal_cholesky_destroy(f->plan);
    co_supernodes_free(&f->s);
    co_thread_pool_destroy(f->threads);
    cholmod_finish(&f->common);
    free(f->l);
}

static void factorize(factor *f, const matrix *a, double shift, int wanted) {
    int positive = -7;
    CHECK_INT(co_supernodal_cholesky_factorize(f->plan, a->value, shift, f->l, &positive), CURVOPT_OK);
    CHECK_INT(positive, wanted);
}

/* out [n][n], in the factor's order: L, zero where there is no room for it. */
static void expand(const factor *f, double *out) {
    const co_supernodes *s = &f->s;
    for (int k = 0; k < s->n_supernodes; k++)
        for (int j = 0; j < co_supernodes_width(s, k); j++)
            for (int i = j; i < co_supernodes_n_rows(s, k); i++)
                out[(size_t)co_supernodes_rows(s, k)[i] * (size_t)s->n + (size_t)(s->column[k] + j)] =
                    f->l[s->value_start[k] + (size_t)j * (size_t)co_supernodes_n_rows(s, k) + (size_t)i];
}

/* The product of the factors is the matrix with its shift. */
static void check_product(const factor *f, const matrix *a, double shift) {
    const size_t n = (size_t)a->n;
    double *l = calloc(n * n, sizeof *l), *wanted = calloc(n * n, sizeof *wanted);
    CHECK_TRUE(l && wanted);
    expand(f, l);
    for (int j = 0; j < a->n; j++)
        for (int e = a->start[j]; e < a->start[j + 1]; e++)
            wanted[(size_t)a->row[e] * n + (size_t)j] = wanted[(size_t)j * n + (size_t)a->row[e]] =
                a->value[e] + (a->row[e] == j ? shift : 0);
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j <= i; j++) {
            double sum = 0;
            for (size_t k = 0; k <= j; k++)
                sum += l[i * n + k] * l[j * n + k];
            CHECK_NEAR(sum, wanted[(size_t)f->s.permutation[i] * n + (size_t)f->s.permutation[j]], 1e-11);
        }
    free(l);
    free(wanted);
}

static void check_solution(factor *f, const matrix *a, double shift) {
    uint64_t seed = 5;
    double *b = calloc((size_t)a->n, sizeof *b), *x = calloc((size_t)a->n, sizeof *x);
    CHECK_TRUE(b && x);
    for (int i = 0; i < a->n; i++)
        b[i] = x[i] = check_random(&seed);
    CHECK_INT(co_supernodal_cholesky_solve(f->plan, f->l, x, x), CURVOPT_OK);
    for (int j = 0; j < a->n; j++)
        for (int e = a->start[j]; e < a->start[j + 1]; e++) {
            const double value = a->value[e] + (a->row[e] == j ? shift : 0);
            b[a->row[e]] -= value * x[j];
            if (a->row[e] != j)
                b[j] -= value * x[a->row[e]];
        }
    for (int i = 0; i < a->n; i++)
        CHECK_NEAR(b[i], 0, 1e-12);
    free(b);
    free(x);
}

/* Grids with several supernodes and several panels, bands, and single ones; each factored twice. */
static void test_the_product_is_the_matrix(void **state) {
    static const int sizes[7][3] = {{1, 1, 0},   {1, 40, 0}, {12, 12, 0}, {9, 14, 1},
                                    {16, 16, 0}, {5, 5, 1},  {2, 100, 1}};
    (void)state;
    for (int k = 0; k < 7; k++) {
        matrix a = matrix_of_grid(sizes[k][0], sizes[k][1], sizes[k][2], 1 + (uint64_t)k);
        factor f;
        factor_create(&a, 1, NULL, &f);
        for (int twice = 0; twice < 2; twice++) {
            factorize(&f, &a, 0.5 * twice, 1);
            check_product(&f, &a, 0.5 * twice);
            check_solution(&f, &a, 0.5 * twice);
        }
        factor_free(&f);
        matrix_free(&a);
    }
}

/* Columns of a node are found to be alike, so that supernodes begin and end with nodes. */
static void test_variables_of_a_node_stay_together(void **state) {
    matrix a = matrix_of_grid(14, 11, 0, 3);
    factor f;
    (void)state;
    factor_create(&a, 1, NULL, &f);
    for (int k = 0; k < f.s.n_supernodes; k++)
        CHECK_INT(f.s.column[k] % AT_A_NODE, 0);
    for (int i = 0; i < a.n; i += AT_A_NODE) {
        CHECK_INT(f.s.permutation[i] % AT_A_NODE, 0);
        for (int c = 1; c < AT_A_NODE; c++)
            CHECK_INT(f.s.permutation[i + c], f.s.permutation[i] + c);
    }
    CHECK_TRUE(f.s.n_supernodes > 1);
    factor_free(&f);
    matrix_free(&a);
}

static void test_threads_do_not_change_a_bit(void **state) {
    matrix a = matrix_of_grid(40, 40, 0, 7);
    factor one;
    (void)state;
    factor_create(&a, 1, NULL, &one);
    factorize(&one, &a, 0, 1);
    CHECK_TRUE(one.s.operations > 1e7); /* worth threads */
    for (int32_t n_threads = 2; n_threads <= 5; n_threads++) {
        factor more;
        factor_create(&a, n_threads, NULL, &more);
        for (int k = 0; k < 3; k++) {
            memset(more.l, 0xff, sizeof *more.l * more.s.value_start[more.s.n_supernodes]);
            factorize(&more, &a, 0, 1);
            for (int s = 0; s < one.s.n_supernodes; s++) { /* above diagonals threads leave what they like */
                const int rows = co_supernodes_n_rows(&one.s, s);
                for (int j = 0; j < co_supernodes_width(&one.s, s); j++) {
                    const size_t at = one.s.value_start[s] + (size_t)j * (size_t)rows + (size_t)j;
                    CHECK_INT(memcmp(one.l + at, more.l + at, sizeof(double) * (size_t)(rows - j)), 0);
                }
            }
        }
        factor_free(&more);
    }
    factor_free(&one);
    matrix_free(&a);
}

/* What is not positive definite is found, wherever it is, with one thread and more; the plan goes on. */
static void test_what_is_not_positive_is_found(void **state) {
    matrix a = matrix_of_grid(24, 24, 0, 9);
    (void)state;
    for (int32_t n_threads = 1; n_threads <= 3; n_threads++) {
        factor f;
        factor_create(&a, n_threads, NULL, &f);
        for (int j = 0; j < a.n; j += 97) {
            const double kept = a.value[a.start[j]];
            a.value[a.start[j]] = j % 2 ? -1 : (double)NAN;
            factorize(&f, &a, 0, 0);
            a.value[a.start[j]] = kept;
        }
        factorize(&f, &a, -1e4, 0);
        factorize(&f, &a, 0, 1);
        check_solution(&f, &a, 0);
        factor_free(&f);
    }
    matrix_free(&a);
}

static void test_a_flag_ends_all_of_it(void **state) {
    matrix a = matrix_of_grid(30, 30, 0, 11);
    factor f;
    co_cancel cancel = {0};
    curvopt_cancel *flag;
    curvopt_error error;
    int positive;
    (void)state;
    CHECK_OK(curvopt_cancel_create(&flag, &error), &error);
    for (int32_t n_threads = 1; n_threads <= 2; n_threads++) {
        cancel.flag = NULL;
        factor_create(&a, n_threads, &cancel, &f);
        factorize(&f, &a, 0, 1);
        curvopt_cancel_request(flag);
        co_cancel_start_at_once(&cancel, flag);
        co_supernodal_cholesky *plan;
        double *x = calloc((size_t)a.n, sizeof *x);
        CHECK_TRUE(x != NULL);
        CHECK_INT(co_supernodal_cholesky_create(&f.s, a.start, a.row, f.threads, &cancel, &plan, &error), CO_CANCELLED);
        CHECK_TRUE(plan == NULL);
        CHECK_INT(co_supernodal_cholesky_factorize(f.plan, a.value, 0, f.l, &positive), CO_CANCELLED);
        CHECK_INT(positive, 0);
        CHECK_INT(co_supernodal_cholesky_solve(f.plan, f.l, x, x), CO_CANCELLED);
        cancel.flag = NULL;
        factorize(&f, &a, 0, 1);
        check_solution(&f, &a, 0);
        free(x);
        factor_free(&f);
    }
    curvopt_cancel_destroy(flag);
    matrix_free(&a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_product_is_the_matrix),   cmocka_unit_test(test_variables_of_a_node_stay_together),
        cmocka_unit_test(test_threads_do_not_change_a_bit), cmocka_unit_test(test_what_is_not_positive_is_found),
        cmocka_unit_test(test_a_flag_ends_all_of_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
