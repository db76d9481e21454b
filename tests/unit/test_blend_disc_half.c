/* Wide half discs at poles on boundaries. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"
#include "surface/basis_point.h"
#include "surface/basis_table_cache.h"
#include "surface/blend_disc_half.h"
#include "surface/blend_fit_half.h"
#include "surface/patches.h"

#include <string.h>

enum { POLYNOMIAL = CURVOPT_SURFACE_POLYNOMIAL, LARGEST = CO_BLEND_DISC_LARGEST };

static co_patches patches_at(const curvopt_mesh *mesh, const double *xyz) {
    co_patches patches;
    curvopt_error error;
    CHECK_OK(co_patches_create(mesh, xyz, NULL, POLYNOMIAL, LARGEST, NULL, &patches, &error), &error);
    return patches;
}

/* The half discs' fit, if the cage has one half disc; NULL if it has none. Frees the cage, but not the patches. */
static const co_blend_disc_fit *only_fit(cage c, co_patches *p) {
    curvopt_mesh *mesh = cage_mesh(&c);
    *p = patches_at(mesh, c.xyz);
    CHECK_BETWEEN(p->wide.n_discs, 0, 1);
    const co_blend_disc_fit *fit = p->wide.n_discs ? co_blend_disc_fit_of(&p->wide, p->wide.disc) : NULL;
    CHECK_TRUE(!fit || fit->is_half);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
    return fit;
}

static void check_width(cage c, int width, int steps) {
    co_patches p;
    const co_blend_disc_fit *fit = only_fit(c, &p);
    CHECK_INT(fit ? fit->width : 1, width);
    if (fit)
        CHECK_INT(fit->steps, steps);
    co_patches_free(&p);
}

static void test_width_is_a_power_of_2_up_to_a_quarter_of_the_distance(void **state) {
    (void)state;
    static const int of[][2] = {{7, 1}, {8, 2}, {15, 2}, {16, 4}, {31, 4}, {32, 8}, {40, 8}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++)
        check_width(cage_half_star(3, of[i][0]), of[i][1], 0);
    check_width(cage_half_star(6, 16), 4, 0);
}

static void test_a_net_that_was_natural_some_steps_ago_has_a_map_of_so_many(void **state) {
    (void)state;
    for (int32_t n = 3; n <= 6; n++)
        for (int times = 1; times <= 3; times++)
            check_width(cage_refined(cage_half_star(n, 4), times), 1 << times, times);
}

static void test_some_poles_have_none(void **state) {
    (void)state;
    check_width(cage_half_star(1, 16), 1, 0); /* functions of u have no bounded derivatives there */
    check_width(cage_half_star(2, 16), 1, 0); /* regular */
    check_width(cage_half_star(CO_FAN_MOST_HALF, 8), 2, 0);
    check_width(cage_half_star(CO_FAN_MOST_HALF + 1, 8), 1, 0);
}

static cage half_star_to_the_power(int32_t n, int32_t m, double power) {
    cage c = cage_half_star(n, m);
    for (int32_t v = 1; v < c.n_vertices; v++) {
        const double scale = pow(hypot(c.xyz[3 * v], c.xyz[3 * v + 1]), power - 1);
        c.xyz[3 * v] *= scale;
        c.xyz[3 * v + 1] *= scale;
    }
    return c;
}

static void test_crowded_points_make_none(void **state) {
    (void)state;
    for (int32_t n = 3; n <= 6; n++) {
        check_width(half_star_to_the_power(n, 8, 2.0 / n), 1, 0);
        check_width(half_star_to_the_power(n, 32, 2.0 / n), 1, 0);
    }
    cage flat = cage_half_star(3, 8); /* edges of length 0 */
    for (int32_t i = 0; i < 3 * flat.n_vertices; i++)
        flat.xyz[i] = 1;
    check_width(flat, 1, 0);
}

/* A longest edge of 1.8 shortest ones is allowed to rounding, whichever side it is on. */
static void test_spacing_of_the_curve(void **state) {
    (void)state;
    for (int side = 0; side < 2; side++)
        for (int too_long = 0; too_long < 2; too_long++) {
            cage c = cage_half_star(3, 8);
            const double edge = 1.8 + 1e-3 * too_long - 1e-3 * !too_long;
            for (int32_t v = 0; v < c.n_vertices; v++) {
                c.xyz[3 * v + 2] = 0;
                if (side ? c.xyz[3 * v] < -2.9 : c.xyz[3 * v] > 2.9)
                    c.xyz[3 * v] += (edge - 1) * (side ? -1 : 1);
            }
            co_patches p;
            const co_blend_disc_fit *fit = only_fit(c, &p);
            CHECK_INT(fit != NULL, !too_long);
            co_patches_free(&p);
        }
}

static void test_without_positions_there_are_none(void **state) {
    (void)state;
    cage c = cage_half_star(3, 8);
    curvopt_mesh *mesh = cage_mesh(&c);
    co_patches without = patches_at(mesh, NULL), with = patches_at(mesh, c.xyz), again = patches_at(mesh, c.xyz);
    CHECK_INT(without.wide.n_discs, 0);
    CHECK_INT(with.wide.n_discs, 1);
    CHECK_TRUE(co_blend_disc_half_are_same(&with.wide, &again.wide));
    CHECK_TRUE(!co_blend_disc_half_are_same(&with.wide, &without.wide));
    CHECK_TRUE(!co_blend_disc_half_are_same(&without.wide, &with.wide));
    CHECK_TRUE(co_blend_disc_half_are_same(&without.wide, &without.wide));
    co_patches_free(&without);
    co_patches_free(&with);
    co_patches_free(&again);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* A strip of 2 m faces across has no room for half discs that reach its other side. */
static void test_other_boundaries_leave_less_room(void **state) {
    (void)state;
    for (int32_t across = 7; across <= 8; across++) {
        cage c = cage_half_star(3, 20);
        curvopt_mesh *mesh = cage_mesh(&c), *part;
        int32_t n = 0, n_used = 0, *faces = calloc(4 * (size_t)c.n_faces, sizeof *faces),
                *number = calloc((size_t)c.n_vertices, sizeof *number),
                *sizes = calloc((size_t)c.n_faces, sizeof *sizes);
        double *xyz = calloc(3 * (size_t)c.n_vertices, sizeof *xyz);
        curvopt_error error;
        CHECK_TRUE(faces && number && sizes && xyz);
        for (int32_t f = 0; f < c.n_faces; f++) {
            if (f / 400 == 1 ? f % 20 >= across || f / 20 % 20 >= across : (f / 400 ? f % 20 : f / 20 % 20) >= across)
                continue;
            sizes[n] = 4;
            for (int k = 0; k < 4; k++) {
                int32_t v = c.vertices[4 * f + k];
                if (number[v] == 0) {
                    memcpy(xyz + 3 * (size_t)n_used, c.xyz + 3 * (size_t)v, 3 * sizeof *xyz);
                    number[v] = ++n_used;
                }
                faces[4 * n + k] = number[v] - 1;
            }
            n++;
        }
        CHECK_OK(curvopt_mesh_create(n_used, n, sizes, faces, &part, &error), &error);
        co_patches p = patches_at(part, xyz);
        CHECK_INT(p.wide.n_discs, across == 8);
        co_patches_free(&p);
        curvopt_mesh_destroy(part);
        curvopt_mesh_destroy(mesh);
        cage_free(&c);
        free(faces);
        free(number);
        free(sizes);
        free(xyz);
    }
}

static void test_points_of_the_polynomial_are_affine_in_the_disc(void **state) {
    (void)state;
    co_patches p;
    const co_blend_disc_fit *f = only_fit(cage_half_star(5, 16), &p);
    CHECK_TRUE(f && f->n_sets == 1 && f->n_points == co_blend_fit_half_n_points(5, 4));
    for (int a = 0; f && a < CO_BLEND_DISC_TERMS; a++) {
        double sum = 0;
        for (int32_t i = 0; i < f->n_points; i++)
            sum += f->matrix[a * f->n_points + i];
        CHECK_NEAR(sum, a < CO_BLEND_FIT_FUNCTIONS, 1e-12);
    }
    co_patches_free(&p);
}

/* x.A^T y = y.A x for the map from the cage to derived points and coefficients. */
static void test_gradients_go_back_by_the_transpose(void **state) {
    (void)state;
    cage c = cage_half_star(4, 8);
    curvopt_mesh *mesh = cage_mesh(&c);
    co_patches p = patches_at(mesh, c.xyz);
    const size_t n = 3 * (size_t)p.n_points, own = 3 * (size_t)p.n_cage;
    double *points = calloc(n, sizeof *points), *slope = calloc(n, sizeof *slope), *back = calloc(n, sizeof *back);
    double there = 0, here = 0;
    CHECK_TRUE(points && slope && back && p.wide.n_discs == 1);
    memcpy(points, c.xyz, own * sizeof *points);
    for (size_t i = own; i < n; i++)
        slope[i] = sin(1.3 * (double)i);
    double *spent = calloc(n, sizeof *spent);
    CHECK_TRUE(spent != NULL);
    memcpy(spent, slope, n * sizeof *spent);
    co_patches_derive(&p, points);
    co_patches_add_derived(&p, spent, back);
    for (size_t i = 0; i < n; i++) {
        there += slope[i] * points[i];
        here += i < own ? back[i] * c.xyz[i] : 0;
    }
    CHECK_TRUE(fabs(there) > 0.1);
    CHECK_NEAR(here, there, 1e-12 * fabs(there));
    free(points);
    free(slope);
    free(spent);
    free(back);
    co_patches_free(&p);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Every face's rows sum to 1 in places, to 0 in derivatives; and Hessians expect all points that tables have. */
static void test_rows_sum_to_one(void **state) {
    (void)state;
    enum { N = 3, WIDTH = 2 };
    for (int32_t s = 0; s < N; s++)
        for (int face = 0; face < WIDTH * WIDTH; face++) {
            const int32_t kind = co_fan_make_half(N, s, WIDTH, 1, face % WIDTH, face / WIDTH);
            CHECK_INT(co_fan_wide_sector(kind), s);
            CHECK_INT(co_fan_wide_width(kind), WIDTH);
            CHECK_INT(co_fan_half_steps(kind), 1);
            for (int rule = 0; rule < 3; rule++) {
                co_basis_table *t;
                curvopt_error error;
                CHECK_OK(co_basis_table_create(POLYNOMIAL, kind, rule, &t, &error), &error);
                for (int32_t p = 0; p < t->n_own; p++)
                    CHECK_TRUE(co_patches_own_is_used(CURVOPT_SURFACE_POLYNOMIAL, kind, t->support[p]));
                for (int32_t i = 0; i < t->n_samples; i++)
                    for (int k = 0; k < CO_JET; k++) {
                        double sum = 0, size = 1;
                        for (int32_t p = 0; p < t->n_points; p++) {
                            sum += t->rows[(i * t->n_points + p) * CO_JET + k];
                            size = fmax(size, fabs(t->rows[(i * t->n_points + p) * CO_JET + k]));
                        }
                        CHECK_NEAR(sum, k == 0, 1e-13 * size);
                    }
                co_basis_table_destroy(t);
            }
        }
}

/* Along the curve the rows are those of its B-spline, whatever the polynomial: face 1 of the first sector's row. */
static void test_rows_along_the_curve_are_its_own(void **state) {
    (void)state;
    const int32_t kind = co_fan_make_half(3, 0, 2, 0, 1, 0), n = co_patches_size(kind);
    co_basis_table_cache cache;
    co_basis_table_cache_create(POLYNOMIAL, &cache);
    double *rows = calloc((size_t)n * CO_JET, sizeof *rows), weight[CO_JET];
    curvopt_error error;
    CHECK_TRUE(rows != NULL);
    for (int i = 1; i < 5; i++) {
        double basis[4][4];
        CHECK_OK(co_basis_point(&cache, kind, 0.2 * i, 0, rows, weight, &error), &error);
        co_bspline_cubic(0.2 * i, basis);
        for (int32_t p = 12; p < n; p++)
            CHECK_NEAR(rows[p * CO_JET], 0, 1e-14);
        for (int32_t p = 0; p < 4; p++) { /* with phantoms written out */
            CHECK_NEAR(rows[(4 + p) * CO_JET] + 2 * rows[p * CO_JET], (double)basis[p][0], 1e-14);
            CHECK_NEAR(rows[(8 + p) * CO_JET] - rows[p * CO_JET], 0, 1e-14);
        }
    }
    free(rows);
    co_basis_table_cache_free(&cache);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_width_is_a_power_of_2_up_to_a_quarter_of_the_distance),
        cmocka_unit_test(test_a_net_that_was_natural_some_steps_ago_has_a_map_of_so_many),
        cmocka_unit_test(test_some_poles_have_none),
        cmocka_unit_test(test_crowded_points_make_none),
        cmocka_unit_test(test_spacing_of_the_curve),
        cmocka_unit_test(test_without_positions_there_are_none),
        cmocka_unit_test(test_other_boundaries_leave_less_room),
        cmocka_unit_test(test_points_of_the_polynomial_are_affine_in_the_disc),
        cmocka_unit_test(test_gradients_go_back_by_the_transpose),
        cmocka_unit_test(test_rows_sum_to_one),
        cmocka_unit_test(test_rows_along_the_curve_are_its_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
