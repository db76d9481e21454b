/* Faces of several kinds in one block: what each would be in a block of its own. SPDX-License-Identifier:
 * GPL-3.0-or-later
 */
#include "base/memory.h"
#include "check.h"
#include "energy/element_kernel.h"
#include "mesh/fan.h"
#include "surface/basis_table_cache.h"
#include "surface/basis_table_mixed.h"

#include <stdlib.h>
#include <string.h>

enum { N_KINDS = CO_BLOCK_FACES, RULE = 1, POINTS = 16 + 21, SIZE = 3 * POINTS };

static const char *const names[] = {"portable", "avx2", "avx512"};

typedef struct block {
    int32_t points[POINTS * CO_BLOCK_FACES];
    double xyz[CO_BLOCK_FACES * POINTS * 3];
    _Alignas(64) double sums[CO_N_SUMS * CO_BLOCK_FACES];
    _Alignas(64) double gradients[POINTS * 6 * CO_BLOCK_FACES];
    _Alignas(64) double matrix[SIZE * (SIZE + 1) / 2 * CO_BLOCK_FACES];
} block;

/* Faces of discs of two valences and widths. */
static void make_tables(co_basis_table *table[N_KINDS]) {
    static const int kind[N_KINDS][4] = {{3, 2, 1, 0}, {3, 2, 0, 1}, {3, 2, 1, 1}, {5, 3, 2, 0},
                                         {5, 3, 1, 1}, {5, 3, 0, 2}, {6, 2, 1, 1}, {6, 2, 0, 1}};
    curvopt_error error;
    for (int k = 0; k < N_KINDS; k++) {
        int32_t fan = co_fan_make_wide(kind[k][0], kind[k][1], kind[k][2], kind[k][3]);
        CHECK_OK(co_basis_table_create(CURVOPT_SURFACE_POLYNOMIAL, fan, RULE, &table[k], &error), &error);
        CHECK_TRUE(co_basis_table_is_mixable(table[k]));
        CHECK_INT(table[k]->n_points, POINTS);
    }
}

/* A bump over the face, and coefficients that are nearly the same polynomial's. */
static void place(block *b, int32_t lanes) {
    const size_t n = (size_t)lanes;
    uint64_t seed = 99;
    for (int32_t l = 0; l < CO_BLOCK_FACES; l++)
        for (int32_t p = 0; p < POINTS; p++) {
            int32_t at = l * POINTS + p;
            double *x = b->xyz + 3 * at, u = p < 16 ? p % 4 : 0.3 * (p % 5), v = p < 16 ? p / 4 : 0.2 * (p % 7);
            b->points[co_lane_place((size_t)l, POINTS, n) + (size_t)p * n] = at;
            x[0] = u + 0.1 * check_random(&seed);
            x[1] = v + 0.1 * check_random(&seed);
            x[2] = 0.2 * u * u - 0.1 * v * v + 0.1 * check_random(&seed);
        }
}

static void run(const co_element_kernel *kernel, const co_basis_table *table, int third, int exact, block *b) {
    const co_integrand integrand = {.area = 0.2, .h2 = 0.3, .f1 = 0.5, .f3 = 0.7, .x = 0.4};
    size_t n = co_element_hessian_work(POINTS) * (size_t)kernel->lanes;
    double *work = co_memory_aligned(n * sizeof(double), 1);
    CHECK_TRUE(work != NULL);
    kernel->run(&(co_element_block){.table = table,
                                    .n_used = CO_BLOCK_FACES,
                                    .points = b->points,
                                    .xyz = b->xyz,
                                    .eps4 = 1e-6,
                                    .integrand = integrand,
                                    .third = third,
                                    .gradient = 1,
                                    .area_gradient = 1,
                                    .sums = b->sums,
                                    .gradients = b->gradients,
                                    .work = work});
    kernel->run_second(&(co_element_hessian){.table = table,
                                             .n_used = CO_BLOCK_FACES,
                                             .points = b->points,
                                             .xyz = b->xyz,
                                             .eps4 = 1e-6,
                                             .integrand = integrand,
                                             .third = third,
                                             .exact = exact,
                                             .matrix = b->matrix,
                                             .work = work});
    free(work);
}

/* The n values of a face in both. */
static void compare(const double *mixed, const double *own, size_t n, size_t lanes, size_t face) {
    const size_t first = co_lane_place(face, n, lanes);
    double largest = 0;
    for (size_t i = 0; i < n; i++)
        largest = fmax(largest, fabs(own[first + i * lanes]));
    CHECK_TRUE(largest > 0);
    for (size_t i = 0; i < n; i++)
        CHECK_NEAR(mixed[first + i * lanes] / largest, own[first + i * lanes] / largest, 1e-12);
}

static void check_kernel(const co_element_kernel *kernel, co_basis_table *const table[N_KINDS], block *mixed,
                         block *own) {
    co_basis_table *together;
    curvopt_error error;
    place(mixed, kernel->lanes);
    memcpy(own, mixed, sizeof *own);
    CHECK_OK(co_basis_table_mix((const co_basis_table *const *)table, N_KINDS, kernel->lanes, &together, &error),
             &error);
    for (int way = 0; way < 4; way++) {
        run(kernel, together, way % 2, way / 2, mixed);
        for (size_t face = 0; face < CO_BLOCK_FACES; face++) {
            run(kernel, table[face], way % 2, way / 2, own);
            compare(mixed->sums, own->sums, CO_N_SUMS, (size_t)kernel->lanes, face);
            compare(mixed->gradients, own->gradients, 6 * POINTS, (size_t)kernel->lanes, face);
            compare(mixed->matrix, own->matrix, SIZE * (SIZE + 1) / 2, (size_t)kernel->lanes, face);
        }
    }
    co_basis_table_destroy(together);
}

static void test_lanes_of_several_kinds_are_those_of_one(void **state) {
    (void)state;
    co_basis_table *table[N_KINDS];
    block *b = co_memory_aligned(2, sizeof *b);
    CHECK_TRUE(b != NULL);
    make_tables(table);
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        if (co_element_kernel_select(names[k]))
            check_kernel(co_element_kernel_select(names[k]), table, b,
                         (block *)(void *)((char *)b + (sizeof *b + 63) / 64 * 64));
    for (int k = 0; k < N_KINDS; k++)
        co_basis_table_destroy(table[k]);
    free(b);
}

static void test_faces_at_a_vertex_and_large_tables_are_not_mixed(void **state) {
    static const int32_t rule[3] = {RULE, RULE, 5};
    const int32_t fan[3] = {co_fan_make_wide(5, 3, 0, 0), CO_FAN_REGULAR, co_fan_make_wide(5, 3, 1, 0)};
    curvopt_error error;
    (void)state;
    for (int k = 0; k < 3; k++) {
        co_basis_table *table;
        CHECK_OK(co_basis_table_create(CURVOPT_SURFACE_POLYNOMIAL, fan[k], rule[k], &table, &error), &error);
        CHECK_TRUE(!co_basis_table_is_mixable(table));
        co_basis_table_destroy(table);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lanes_of_several_kinds_are_those_of_one),
        cmocka_unit_test(test_faces_at_a_vertex_and_large_tables_are_not_mixed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
