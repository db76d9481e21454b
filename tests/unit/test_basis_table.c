/* Quadrature points and basis rows of kinds of faces. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "surface/basis_point.h"
#include "surface/basis_table_cache.h"
#include "surface/face_rule.h"
#include "surface/patches.h"

#include <stdlib.h>

static const int32_t surfaces[] = {CURVOPT_SURFACE_LIMIT, CURVOPT_SURFACE_PLANE, CURVOPT_SURFACE_POLYNOMIAL};
enum { N_SURFACES = sizeof surfaces / sizeof *surfaces, MOST_POINTS = 6 * 9 + 1 };

static co_basis_table *table_of(int32_t surface, int32_t valence, int32_t rule) {
    co_basis_table *table;
    curvopt_error error;
    CHECK_OK(co_basis_table_create(surface, valence, rule, &table, &error), &error);
    CHECK_INT(table->kind, valence);
    return table;
}

/* Deep in the rings of the unblended surface, derivatives with respect to the characteristic map are differences of
 * nearly equal numbers. Faces are moved to the origin before rows are applied, so that this costs
 * nothing. Third derivatives, which the limit surface has no finite energy of there, are not made. */
static void check_rows_sum(const co_basis_table *t) {
    double tolerance = t->kind == 4 || t->surface == CURVOPT_SURFACE_POLYNOMIAL ? 2e-14 : 1e-8;
    const int n = t->kind != 4 && t->surface == CURVOPT_SURFACE_LIMIT ? CO_JET_SECOND : CO_JET;
    for (int32_t s = 0; s < t->n_samples; s++) {
        for (int k = n; k < CO_JET; k++)
            CHECK_TRUE(isnan(t->rows[s * t->n_points * CO_JET + k]));
        for (int k = 0; k < n; k++) {
            double sum = 0, size = 0;
            for (int32_t p = 0; p < t->n_points; p++) {
                sum += t->rows[(s * t->n_points + p) * CO_JET + k];
                size += fabs(t->rows[(s * t->n_points + p) * CO_JET + k]);
            }
            CHECK_NEAR(sum, k == 0, tolerance * fmax(size, 1));
        }
    }
}

static void test_rows_of_positions_sum_to_one_and_of_derivatives_to_zero(void **state) {
    (void)state;
    for (int s = 0; s < N_SURFACES; s++)
        for (int32_t valence = 3; valence <= 9; valence += valence > 4 ? 2 : 1)
            for (int32_t rule = 0; rule < 2; rule++) {
                co_basis_table *t = table_of(surfaces[s], valence, rule);
                check_rows_sum(t);
                CHECK_TRUE((t->blend != NULL) == (valence != 4 && surfaces[s] == CURVOPT_SURFACE_PLANE));
                co_basis_table_destroy(t);
            }
}

static void test_regular_weights_sum_to_one(void **state) {
    (void)state;
    for (int32_t rule = 0; rule < CO_LADDER_RULES; rule++) {
        co_basis_table *t = table_of(CURVOPT_SURFACE_LIMIT, 4, rule);
        double area = 0, curvature = 0;
        for (int32_t s = 0; s < t->n_samples; s++) {
            area += t->area_weight[s];
            curvature += t->weight[s];
            CHECK_NEAR(t->jacobian_scale[s], 1, 0);
        }
        CHECK_NEAR(area, 1, 1e-13);
        CHECK_NEAR(curvature, 1, 1e-13);
        co_basis_table_destroy(t);
    }
}

/* The integral of u^a v^b over a regular face, positions being (u, v) themselves. */
static void test_regular_rules_integrate_polynomials_over_the_face(void **state) {
    (void)state;
    for (int32_t rule = 0; rule < CO_LADDER_RULES; rule++) {
        co_basis_table *t = table_of(CURVOPT_SURFACE_LIMIT, 4, rule);
        double sum = 0;
        for (int32_t s = 0; s < t->n_samples; s++) {
            double u = 0, v = 0;
            for (int32_t p = 0; p < 16; p++) {
                u += t->rows[(s * 16 + p) * CO_JET] * (t->support[p] % 4 - 1);
                v += t->rows[(s * 16 + p) * CO_JET] * (t->support[p] / 4 - 1); /* 4 j + i */
            }
            sum += t->area_weight[s] * pow(u, 5) * pow(v, 4);
        }
        CHECK_NEAR(sum, 1.0 / 30, 1e-13);
        co_basis_table_destroy(t);
    }
}

/* Jacobian of sample s where the two-ring is the characteristic map. */
static double jacobian_of(const co_basis_table *t, const double *xy, int32_t s) {
    double d[2][2] = {{0}};
    for (int32_t p = 0; p < t->n_points; p++)
        for (int k = 0; k < 2; k++)
            for (int c = 0; c < 2; c++)
                d[k][c] += t->rows[(s * t->n_points + p) * CO_JET + 1 + k] * (double)xy[2 * t->support[p] + c];
    return d[0][0] * d[1][1] - d[0][1] * d[1][0];
}

static void characteristic_map(int32_t valence, double *xy) {
    co_stam_disc disc;
    curvopt_error error;
    CHECK_OK(co_stam_disc_create(valence, &disc, &error), &error);
    co_stam_characteristic_map(&disc, xy);
    co_stam_disc_free(&disc);
}

/* The Jacobian is a polynomial of degree 5 each way in every cell, 10 in all, and rings repeat exactly, so that all
 * rules of degree 11 and more in all rings must agree, whatever their number of rings; the polynomial surface
 * reproduces its own map. */
static void test_rules_agree_on_the_characteristic_maps_area(void **state) {
    (void)state;
    static const int32_t exact[] = {CURVOPT_SURFACE_LIMIT, CURVOPT_SURFACE_POLYNOMIAL};
    for (int32_t valence = 3; valence <= 9; valence += valence == 3 ? 2 : 1) {
        double xy[2 * MOST_POINTS];
        double first = 0;
        characteristic_map(valence, xy);
        for (int i = 0; i < 4; i++) {
            co_basis_table *t = table_of(exact[i / 2], valence, (i / 2 ? 5 : 4) + i % 2);
            double area = 0;
            for (int32_t s = 0; s < t->n_samples; s++)
                area += t->area_weight[s] * jacobian_of(t, xy, s);
            first = i == 0 ? area : first;
            CHECK_TRUE(area > 0);
            CHECK_NEAR(area / first, 1, 1e-12);
            co_basis_table_destroy(t);
        }
    }
}

/* The last ring stands for all rings inside it, a geometric series: area shrinks by lambda^2 a ring, squared
 * curvature's integral by mu^2 / lambda^2 on `limit` and like the area where the surface is smooth. */
static void test_last_ring_stands_for_all_inside_it(void **state) {
    (void)state;
    for (int s = 0; s < N_SURFACES; s++)
        for (int32_t valence = 3; valence <= 7; valence += 2) {
            co_stam_disc disc;
            curvopt_error error;
            CHECK_OK(co_stam_disc_create(valence, &disc, &error), &error);
            double area = disc.lambda * disc.lambda, curvature = disc.mu * disc.mu / area;
            double expected = surfaces[s] == CURVOPT_SURFACE_LIMIT ? (1 - area) / (1 - curvature) : 1;
            co_basis_table *t = table_of(surfaces[s], valence, 1);
            CHECK_NEAR(t->weight[0], t->area_weight[0], 0);
            CHECK_NEAR(t->weight[t->n_samples - 1] / t->area_weight[t->n_samples - 1], expected, 1e-12);
            co_basis_table_destroy(t);
            co_stam_disc_free(&disc);
        }
}

/* Derivatives are with respect to the characteristic map, whose Jacobian is then 1; scaled by what it is in the cell,
 * it has the same range in every ring. */
static void test_jacobian_scale_undoes_the_shrinking(void **state) {
    (void)state;
    double xy[2 * MOST_POINTS];
    double low = INFINITY, high = 0;
    characteristic_map(6, xy);
    co_basis_table *fine = table_of(CURVOPT_SURFACE_LIMIT, 6, 3), *t = table_of(CURVOPT_SURFACE_LIMIT, 6, 1);
    for (int32_t s = 0; s < 3 * co_square_rule_size(10); s++) { /* the first ring of that rule */
        low = fmin(low, fine->jacobian_scale[s]);
        high = fmax(high, fine->jacobian_scale[s]);
    }
    CHECK_BETWEEN(high / low, 1, 2); /* rings shrink by more */
    for (int32_t s = 0; s < t->n_samples; s++) {
        CHECK_NEAR(jacobian_of(t, xy, s), 1, 1e-11);
        CHECK_BETWEEN(t->jacobian_scale[s], 0.999 * low, 1.001 * high);
    }
    co_basis_table_destroy(t);
    co_basis_table_destroy(fine);
}

static void test_every_rule_is_finer_than_the_one_before(void **state) {
    (void)state;
    for (int s = 0; s < N_SURFACES; s++)
        for (int32_t valence = 3; valence <= 5; valence++) {
            int32_t before = 0;
            for (int32_t rule = 0; rule < 3; rule++) {
                co_basis_table *t = table_of(surfaces[s], valence, rule);
                CHECK_TRUE(t->n_samples > before);
                before = t->n_samples;
                co_basis_table_destroy(t);
            }
        }
}

static void test_point_rows_sum_like_the_tables(void **state) {
    (void)state;
    co_basis_table_cache limit_tables = {.surface = CURVOPT_SURFACE_LIMIT}; /* of which single points keep nothing */
    static const double places[][2] = {{1, 1}, {0.7, 0.2}, {0.5, 0.5}, {0.01, 0.3}, {1e-5, 2e-5}, {0, 0.25}};
    for (int32_t valence = 3; valence <= 9; valence++)
        for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
            double rows[MOST_POINTS * CO_JET], weight[CO_JET];
            int32_t n = valence == 4 ? 16 : 6 * valence + 1;
            curvopt_error error;
            CHECK_OK(co_basis_point(&limit_tables, valence, places[i][0], places[i][1], rows, weight, &error), &error);
            for (int k = 0; k < CO_JET; k++) {
                double sum = 0, size = 0;
                for (int32_t p = 0; p < n; p++) {
                    sum += rows[p * CO_JET + k];
                    size += fabs(rows[p * CO_JET + k]);
                }
                double shrink = fmax(places[i][0], places[i][1]) / 2; /* at most the side of its ring's cells */
                CHECK_NEAR(sum, k == 0, 1e-14 * size + 4e-16 * pow(shrink, -co_jet_order_u[k] - co_jet_order_v[k]));
            }
        }
}

static void test_derivatives_at_the_extraordinary_vertex_do_not_exist(void **state) {
    (void)state;
    co_basis_table_cache limit_tables = {.surface = CURVOPT_SURFACE_LIMIT}; /* of which single points keep nothing */
    double rows[31 * CO_JET], weight[CO_JET], sum = 0;
    curvopt_error error;
    CHECK_OK(co_basis_point(&limit_tables, 5, 0, 0, rows, weight, &error), &error);
    for (int32_t p = 0; p < 31; p++) {
        sum += rows[p * CO_JET];
        for (int k = 1; k < CO_JET; k++)
            CHECK_TRUE(isnan(rows[p * CO_JET + k]));
    }
    CHECK_NEAR(sum, 1, 1e-15);
    CHECK_NEAR(rows[0], 0.5, 1e-15); /* n / (n + 5) */
}

static void test_cache_builds_a_table_once(void **state) {
    (void)state;
    co_basis_table_cache cache;
    const co_basis_table *first, *again, *other;
    curvopt_error error;
    co_basis_table_cache_create(CURVOPT_SURFACE_LIMIT, &cache);
    CHECK_OK(co_basis_table_cache_get(&cache, 5, 1, &first, &error), &error);
    CHECK_OK(co_basis_table_cache_get(&cache, 5, 1, &again, &error), &error);
    CHECK_OK(co_basis_table_cache_get(&cache, 5, 0, &other, &error), &error);
    CHECK_TRUE(first == again && first != other);
    CHECK_INT(first->kind, 5);
    co_basis_table_cache_free(&cache);
}

/* Rows of any point of a face of a wide disc are those of the table at the table's points; the values, that is, for the
 * table's derivatives are with respect to the characteristic map. */
static void test_points_of_wide_discs_are_those_of_the_table(void **state) {
    enum { GAUSS = 6, RULE = 2 };
    const int32_t kind = co_fan_make_wide(5, 3, 1, 2), n = co_patches_size(kind);
    co_square_rule rule;
    co_basis_table_cache cache;
    curvopt_error error;
    double weight[CO_JET], *rows = calloc((size_t)n * CO_JET, sizeof *rows);
    (void)state;
    CHECK_TRUE(rows != NULL);
    co_basis_table *table = table_of(CURVOPT_SURFACE_POLYNOMIAL, kind, RULE);
    co_square_rule_make(GAUSS, &rule);
    CHECK_INT(table->n_samples, rule.n);
    CHECK_INT(table->n_points, CO_RING_REGULAR + CO_BLEND_FIT_TERMS); /* no means */
    co_basis_table_cache_create(CURVOPT_SURFACE_POLYNOMIAL, &cache);
    for (int s = 0; s < rule.n; s++) {
        CHECK_OK(co_basis_point(&cache, kind, rule.point[s][0], rule.point[s][1], rows, weight, &error), &error);
        for (int32_t p = 0; p < table->n_points; p++)
            CHECK_NEAR(rows[table->support[p] * CO_JET], table->rows[(s * table->n_points + p) * CO_JET], 1e-14);
    }
    co_basis_table_cache_free(&cache);
    co_basis_table_destroy(table);
    free(rows);
}

/* Rows of any point of a disc of width 1 are those without a disc on `limit`; they sum to 1 and 0 on both surfaces. */
static void test_points_of_discs_of_width_1(void **state) {
    (void)state;
    static const double places[][2] = {{1, 1}, {0.7, 0.2}, {0.01, 0.3}, {0, 0}};
    enum { VALENCE = 60 };
    const int32_t kind = co_fan_make_wide(VALENCE, 1, 0, 0), n = co_fan_n_points(VALENCE), all = co_patches_size(kind);
    double *plain = calloc((size_t)n * CO_JET, sizeof *plain), *disc = calloc((size_t)all * CO_JET, sizeof *disc);
    CHECK_TRUE(plain && disc);
    for (int surface = CURVOPT_SURFACE_LIMIT; surface <= CURVOPT_SURFACE_POLYNOMIAL; surface += 2)
        for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
            double weight[CO_JET], u = places[i][0], v = places[i][1];
            co_basis_table_cache cache;
            curvopt_error error;
            co_basis_table_cache_create(surface, &cache);
            CHECK_OK(co_basis_point(&cache, VALENCE, u, v, plain, weight, &error), &error);
            CHECK_OK(co_basis_point(&cache, kind, u, v, disc, weight, &error), &error);
            for (int k = 0; k < (u + v > 0 ? CO_JET : 1); k++) {
                double sum = 0, size = 0;
                for (int32_t p = 0; p < all; p++) {
                    sum += disc[p * CO_JET + k];
                    size += fabs(disc[p * CO_JET + k]);
                    if (surface == CURVOPT_SURFACE_LIMIT)
                        CHECK_NEAR(disc[p * CO_JET + k], p < n ? plain[p * CO_JET + k] : 0, 0);
                }
                CHECK_NEAR(sum, k == 0, 1e-13 * size);
            }
            co_basis_table_cache_free(&cache);
        }
    free(plain);
    free(disc);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows_of_positions_sum_to_one_and_of_derivatives_to_zero),
        cmocka_unit_test(test_regular_weights_sum_to_one),
        cmocka_unit_test(test_regular_rules_integrate_polynomials_over_the_face),
        cmocka_unit_test(test_rules_agree_on_the_characteristic_maps_area),
        cmocka_unit_test(test_last_ring_stands_for_all_inside_it),
        cmocka_unit_test(test_jacobian_scale_undoes_the_shrinking),
        cmocka_unit_test(test_every_rule_is_finer_than_the_one_before),
        cmocka_unit_test(test_point_rows_sum_like_the_tables),
        cmocka_unit_test(test_derivatives_at_the_extraordinary_vertex_do_not_exist),
        cmocka_unit_test(test_cache_builds_a_table_once),
        cmocka_unit_test(test_points_of_wide_discs_are_those_of_the_table),
        cmocka_unit_test(test_points_of_discs_of_width_1),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
