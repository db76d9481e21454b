/* The limit surface near an extraordinary vertex. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "surface/stam.h"

#include <stdlib.h>

static const int valences[] = {3, 4, 5, 6, 7, 8, 12, 20};
enum { N_VALENCES = sizeof valences / sizeof *valences, MOST_POINTS = 6 * 20 + 1 };

static co_stam_disc disc_of(int32_t valence) {
    co_stam_disc disc;
    curvopt_error error;
    CHECK_OK(co_stam_disc_create(valence, &disc, &error), &error);
    CHECK_INT(disc.n_points, 6 * valence + 1);
    return disc;
}

/* out = S x, the two-ring's subdivision; x and out [n_points][width]. */
static void subdivide(const co_stam_disc *d, int width, const double *x, double *out) {
    for (int32_t i = 0; i < d->n_points; i++)
        for (int c = 0; c < width; c++) {
            double sum = 0;
            for (size_t e = d->refine.start[d->inner[i]]; e < d->refine.start[d->inner[i] + 1]; e++)
                sum += d->refine.value[e] * x[d->refine.column[e] * width + c];
            out[i * width + c] = sum;
        }
}

/* out = mask S */
static void subdivide_transposed(const co_stam_disc *d, const double *mask, double *out) {
    memset(out, 0, sizeof *out * (size_t)d->n_points);
    for (int32_t i = 0; i < d->n_points; i++)
        for (size_t e = d->refine.start[d->inner[i]]; e < d->refine.start[d->inner[i] + 1]; e++)
            out[d->refine.column[e]] += d->refine.value[e] * mask[i];
}

static void test_limit_masks_are_left_eigenvectors(void **state) {
    (void)state;
    for (int v = 0; v < N_VALENCES; v++) {
        co_stam_disc d = disc_of(valences[v]);
        double masks[3 * MOST_POINTS], image[MOST_POINTS], sum[3] = {0};
        co_stam_limit_masks(d.valence, masks);
        for (int m = 0; m < 3; m++) {
            const double *mask = masks + m * d.n_points;
            subdivide_transposed(&d, mask, image);
            for (int32_t i = 0; i < d.n_points; i++) {
                CHECK_NEAR(image[i], (m ? d.lambda : 1) * mask[i], 4e-15);
                sum[m] += mask[i];
            }
        }
        CHECK_NEAR(sum[0], 1, 2e-15);
        CHECK_NEAR(sum[1], 0, 2e-14);
        CHECK_NEAR(sum[2], 0, 2e-14);
        co_stam_disc_free(&d);
    }
}

static void test_characteristic_map_is_an_eigenvector(void **state) {
    (void)state;
    for (int v = 0; v < N_VALENCES; v++) {
        co_stam_disc d = disc_of(valences[v]);
        double xy[2 * MOST_POINTS], image[2 * MOST_POINTS];
        co_stam_characteristic_map(&d, xy);
        subdivide(&d, 2, xy, image);
        for (int32_t i = 0; i < 2 * d.n_points; i++)
            CHECK_NEAR(image[i], d.lambda * xy[i], 2e-15);
        CHECK_NEAR(xy[0], 0, 0);
        for (int32_t s = 0; s < d.valence; s++) {
            const double *p = xy + 2 * co_ring_two_ring_index(d.valence, s, 1, 0);
            CHECK_NEAR(hypot(p[0], p[1]), 1, 1e-15);
        }
        CHECK_NEAR(xy[2], 1, 1e-15); /* the first edge point lies on the x axis */
        co_stam_disc_free(&d);
    }
}

static void test_eigenvalues_of_known_valences(void **state) {
    (void)state;
    co_stam_disc three = disc_of(3), four = disc_of(4);
    CHECK_NEAR(three.lambda, (9 + sqrt(17)) / 32, 1e-16); /* c = -1/2 */
    CHECK_NEAR(four.lambda, 0.5, 2e-16);
    CHECK_NEAR(four.mu, 0.25, 1e-16);
    co_stam_disc_free(&three);
    co_stam_disc_free(&four);
}

static double dot(int32_t n, const double *a, const double *b, int stride) {
    double sum = 0;
    for (int32_t i = 0; i < n; i++)
        sum += a[i] * b[stride * i];
    return sum;
}

/* Removes the eigenvectors of 1 and lambda from x with their left eigenvectors. */
static void deflate(int32_t n, const double *masks, const double *xy, double *x) {
    double mean = dot(n, masks, x, 1);
    for (int32_t i = 0; i < n; i++)
        x[i] -= mean;
    for (int k = 0; k < 2; k++) {
        const double *mask = masks + (k + 1) * n;
        double part = dot(n, mask, x, 1) / dot(n, mask, xy + k, 2);
        for (int32_t i = 0; i < n; i++)
            x[i] -= part * xy[2 * i + k];
    }
}

static void test_mu_is_how_fast_the_rest_decays(void **state) {
    (void)state;
    for (int v = 0; v < 6; v++) {
        co_stam_disc d = disc_of(valences[v]);
        double masks[3 * MOST_POINTS], xy[2 * MOST_POINTS], x[MOST_POINTS], next[MOST_POINTS], growth = 0;
        uint64_t seed = 99;
        co_stam_limit_masks(d.valence, masks);
        co_stam_characteristic_map(&d, xy);
        for (int32_t i = 0; i < d.n_points; i++)
            x[i] = check_random(&seed);
        for (int step = 0; step < 300; step++) {
            deflate(d.n_points, masks, xy, x);
            double length = sqrt(dot(d.n_points, x, x, 1));
            for (int32_t i = 0; i < d.n_points; i++)
                x[i] /= length;
            subdivide(&d, 1, x, next);
            memcpy(x, next, sizeof *x * (size_t)d.n_points);
            if (step >= 200)
                growth += log(dot(d.n_points, x, x, 1)) / 2 / 100;
        }
        CHECK_NEAR(exp(growth) / d.mu, 1, d.valence == 4 ? 0.02 : 0.005);
        co_stam_disc_free(&d);
    }
}

/* Where a regular face's point (i, j) lies in the two-ring of its corner 0. */
static int32_t index_of_regular_point(int i, int j) {
    int x = i - 1, y = j - 1, sector = 0;
    while (x < 0 || y < 0) {
        int old = x;
        if (y < 0) {
            x = -y;
            y = old;
            sector--;
        } else {
            x = y;
            y = -old;
            sector++;
        }
    }
    return co_ring_two_ring_index(4, sector, x, y);
}

/* Rows of a cell of the disc's present ring at (s, t) of the cell, derivatives by the face's own parameters. */
static void cell_rows(const co_stam_disc *d, int cell, double s, double t, double *rows) {
    double points[16 * MOST_POINTS], vertex[MOST_POINTS], basis[16][CO_JET];
    co_stam_disc_cell(d, cell, vertex, points);
    co_bspline_bicubic(s, t, basis);
    for (int32_t p = 0; p < d->n_points; p++)
        for (int k = 0; k < CO_JET; k++) {
            double sum = k ? 0 : vertex[p];
            for (int i = 0; i < 16; i++)
                sum += basis[i][k] * points[i * d->n_points + p];
            rows[p * CO_JET + k] = ldexp(sum, d->ring * (co_jet_order_u[k] + co_jet_order_v[k]));
        }
}

static void test_valence_four_is_bicubic(void **state) {
    (void)state;
    co_stam_disc d = disc_of(4);
    for (; d.ring <= 4; co_stam_disc_advance(&d))
        for (int cell = 0; cell < CO_RING_CELLS; cell++) {
            double s = 0.3, t = 0.7, side = ldexp(1, -d.ring), rows[25 * CO_JET], basis[16][CO_JET];
            double expected[25][CO_JET] = {{0}};
            cell_rows(&d, cell, s, t, rows);
            co_bspline_bicubic(side * (co_stam_cell_place[cell][0] + s), side * (co_stam_cell_place[cell][1] + t),
                               basis);
            for (int i = 0; i < 16; i++)
                memcpy(expected[index_of_regular_point(i % 4, i / 4)], basis[i], sizeof basis[i]);
            for (int p = 0; p < 25; p++)
                for (int k = 0; k < CO_JET; k++)
                    CHECK_NEAR(rows[p * CO_JET + k], expected[p][k],
                               ldexp(1e-15, d.ring * (co_jet_order_u[k] + co_jet_order_v[k])));
        }
    co_stam_disc_free(&d);
}

/* Across x = 2^-n, where ring n ends and ring n + 1 is the inner one, everything to second order is continuous. */
static void test_rings_join_with_two_derivatives(void **state) {
    (void)state;
    for (int v = 0; v < N_VALENCES; v++) {
        co_stam_disc d = disc_of(valences[v]);
        for (int ring = 1; ring <= 5; ring++) {
            double outer[MOST_POINTS * CO_JET], inner[MOST_POINTS * CO_JET];
            cell_rows(&d, 0, 0, 0.2, outer); /* y = 0.2 / 2^ring, left end of cell (1, 0) */
            co_stam_disc_advance(&d);
            cell_rows(&d, 0, 1, 0.4, inner);
            for (int32_t p = 0; p < d.n_points; p++)
                for (int k = 0; k < 6; k++)
                    CHECK_NEAR(inner[p * CO_JET + k], outer[p * CO_JET + k],
                               ldexp(4e-15, d.ring * (co_jet_order_u[k] + co_jet_order_v[k])));
        }
        co_stam_disc_free(&d);
    }
}

static void test_rings_shrink_to_the_limit_position(void **state) {
    (void)state;
    for (int v = 0; v < N_VALENCES; v++) {
        co_stam_disc d = disc_of(valences[v]);
        double masks[3 * MOST_POINTS], rows[MOST_POINTS * CO_JET];
        co_stam_limit_masks(d.valence, masks);
        while (d.ring < 60)
            co_stam_disc_advance(&d);
        cell_rows(&d, 1, 0.5, 0.5, rows);
        for (int32_t p = 0; p < d.n_points; p++)
            CHECK_NEAR(rows[p * CO_JET], masks[p], 2 * pow(d.lambda, d.ring) + d.ring * 1e-16);
        co_stam_disc_free(&d);
    }
}

/* A flat fan has its tangents along x and y and its normal along +z. */
static void test_tangents_of_a_flat_fan(void **state) {
    (void)state;
    for (int v = 0; v < N_VALENCES; v++) {
        co_stam_disc d = disc_of(valences[v]);
        double masks[3 * MOST_POINTS], xy[2 * MOST_POINTS], tangent[2][2];
        co_stam_limit_masks(d.valence, masks);
        co_stam_characteristic_map(&d, xy);
        for (int m = 0; m < 2; m++)
            for (int c = 0; c < 2; c++)
                tangent[m][c] = dot(d.n_points, masks + (m + 1) * d.n_points, xy + c, 2);
        CHECK_TRUE(tangent[0][0] > 0.5 && tangent[1][1] > 0.5);
        CHECK_NEAR(tangent[0][1], 0, 1e-14);
        CHECK_NEAR(tangent[1][0], 0, 1e-14);
        co_stam_disc_free(&d);
    }
}

static void test_support_is_two_n_plus_eight_points_and_suffices(void **state) {
    (void)state;
    for (int v = 0; v < N_VALENCES; v++) {
        co_stam_disc d = disc_of(valences[v]);
        double rows[MOST_POINTS * CO_JET];
        int n = 0;
        for (int ring = 1; ring <= 3; ring++, co_stam_disc_advance(&d))
            for (int cell = 0; cell < CO_RING_CELLS; cell++) {
                cell_rows(&d, cell, 0.4, 0.9, rows);
                for (int32_t p = 0; p < d.n_points; p++)
                    if (!co_stam_in_support(d.valence, p))
                        for (int k = 0; k < CO_JET; k++)
                            CHECK_NEAR(rows[p * CO_JET + k], 0, 0);
            }
        for (int32_t p = 0; p < d.n_points; p++)
            n += co_stam_in_support(d.valence, p);
        CHECK_INT(n, 2 * d.valence + 8);
        co_stam_disc_free(&d);
    }
}

/* Cells of ring 30 have the control points that ring 1 has after 29 subdivisions, in parts of what is left of their
 * differences: points x go the other way round, subdivided one after the other, and the vertex is taken off them. */
static void test_differences_of_deep_rings_are_those_of_subdivided_points(void **state) {
    (void)state;
    enum { LARGEST = 200, RING = 30 };
    static const int32_t high[] = {3, 7, 64, LARGEST};
    static double x[6 * LARGEST + 1], next[6 * LARGEST + 1], deep[16 * (6 * LARGEST + 1)], cell[16 * (6 * LARGEST + 1)],
        vertex[6 * LARGEST + 1];
    for (size_t v = 0; v < sizeof high / sizeof *high; v++) {
        co_stam_disc d = disc_of(high[v]), first = disc_of(high[v]);
        const int32_t n = d.n_points;
        double expected[16] = {0}, got[16] = {0}, largest = 0;
        uint64_t seed = 5;
        for (int32_t i = 0; i < n; i++)
            x[i] = check_random(&seed);
        while (d.ring < RING)
            co_stam_disc_advance(&d);
        co_stam_disc_cell(&d, 0, vertex, deep);
        for (int k = 0; k < 16; k++)
            got[k] = dot(n, deep + k * n, x, 1);
        for (int step = 1; step < RING; step++) {
            subdivide(&first, 1, x, next);
            for (int32_t i = 0; i < n; i++)
                x[i] = next[i] - next[0]; /* differences are all that counts, and stay exact */
        }
        co_stam_disc_cell(&first, 0, vertex, cell);
        for (int k = 0; k < 16; k++) {
            expected[k] = dot(n, cell + k * n, x, 1);
            largest = fmax(largest, fabs(expected[k]));
        }
        for (int k = 0; k < 16; k++)
            CHECK_NEAR(got[k] / largest, expected[k] / largest, 1e-13);
        CHECK_TRUE(largest < pow(0.7, RING - 2));
        co_stam_disc_free(&d);
        co_stam_disc_free(&first);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_limit_masks_are_left_eigenvectors),
        cmocka_unit_test(test_differences_of_deep_rings_are_those_of_subdivided_points),
        cmocka_unit_test(test_characteristic_map_is_an_eigenvector),
        cmocka_unit_test(test_eigenvalues_of_known_valences),
        cmocka_unit_test(test_mu_is_how_fast_the_rest_decays),
        cmocka_unit_test(test_valence_four_is_bicubic),
        cmocka_unit_test(test_rings_join_with_two_derivatives),
        cmocka_unit_test(test_rings_shrink_to_the_limit_position),
        cmocka_unit_test(test_tangents_of_a_flat_fan),
        cmocka_unit_test(test_support_is_two_n_plus_eight_points_and_suffices),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
