/* How far a second form is from a wanted one: on surfaces whose curvatures are known, in other parameters, sizes and
 * poses; derivatives by differences. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "hessian/second_form.h"
#include "linalg/small_dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { N = CO_SECOND_FORM_VALUES };

/* Curvature k1 along x and k2 along y, for the normal z. */
static co_second_form form_of(double k1, double k2) {
    return (co_second_form){.normal = {0, 0, 1}, .tensor = {k1, 0, 0, 0, k2, 0, 0, 0, 0}};
}

/* The graph of z = -(a x^2 + 2 b x y + c y^2) / 2 at 0, whose second form along x and y is a, b, c. */
static void graph(double a, double b, double c, double y[N]) {
    const double jet[N] = {1, 0, 0, 0, 1, 0, 0, 0, -a, 0, 0, -b, 0, 0, -c};
    memcpy(y, jet, sizeof jet);
}

/* Turned by an angle in the plane of axes i and k. */
static void turn(double y[N], int i, int k, double angle) {
    for (int v = 0; v < N; v += 3) {
        const double p = y[v + i], q = y[v + k];
        y[v + i] = cos(angle) * p - sin(angle) * q;
        y[v + k] = sin(angle) * p + cos(angle) * q;
    }
}

/* By parameters s, t with u = s + .3 t + .7 s^2, v = -.4 s + 2 t + .2 s t, at 0: nothing of the surface changes. */
static void change_parameters(double y[N]) {
    double from[N];
    memcpy(from, y, sizeof from);
    for (int c = 0; c < 3; c++) {
        const double u = from[c], v = from[3 + c], uu = from[6 + c], uv = from[9 + c], vv = from[12 + c];
        y[c] = u - 0.4 * v;
        y[3 + c] = 0.3 * u + 2 * v;
        y[6 + c] = uu - 0.8 * uv + 0.16 * vv + 1.4 * u;
        y[9 + c] = 0.3 * uu + (2 - 0.12) * uv - 0.8 * vv + 0.2 * v;
        y[12 + c] = 0.09 * uu + 1.2 * uv + 4 * vv;
    }
}

static double off(const co_second_form *wanted, const double y[N]) {
    return co_second_form_off(wanted, y, NULL, NULL, 0);
}

static void test_known_curvatures(void **state) {
    (void)state;
    const co_second_form wanted = form_of(2, -1);
    double y[N];
    graph(2, 0, -1, y);
    CHECK_NEAR(off(&wanted, y), 0, 1e-15);
    graph(3, 0.5, 1, y);
    CHECK_NEAR(off(&wanted, y), (1 + 2 * 0.25 + 4) / 2, 1e-14);
    change_parameters(y);
    CHECK_NEAR(off(&wanted, y), 2.75, 1e-13);
}

/* The wanted form goes along with the tangent plane, by the least turn, past right angles to the normal's other side:
 * tilting hides no curvature. About the normal it stays. */
static void test_it_turns_with_the_plane(void **state) {
    (void)state;
    const co_second_form wanted = form_of(2, -1);
    double y[N];
    for (int axis = 0; axis < 2; axis++)
        for (int k = -3; k <= 3; k++) {
            graph(2, 0, -1, y);
            turn(y, axis, 2, 0.5 * k);
            CHECK_NEAR(off(&wanted, y), 0, 1e-14);
        }
    graph(2, 0, -1, y);
    turn(y, 0, 1, acos(0.0));
    CHECK_NEAR(off(&wanted, y), 9, 1e-13);
}

/* Curvatures are by the faces' side: the wanted normal's sign does not count. */
static void test_sign_of_the_normal(void **state) {
    (void)state;
    co_second_form wanted = form_of(2, -1);
    double y[N], there;
    graph(3, 0.5, 1, y);
    turn(y, 0, 2, 0.4);
    there = off(&wanted, y);
    wanted.normal[2] = -1;
    CHECK_NEAR(off(&wanted, y), there, 1e-14);
    graph(-3, 0, -3, y); /* and other parameters, whose normal is -z: it bends by 3 to that side */
    for (int c = 0; c < 3; c++) {
        const double u = y[c], uu = y[6 + c];
        y[c] = y[3 + c];
        y[3 + c] = u;
        y[6 + c] = y[12 + c];
        y[12 + c] = uu;
    }
    CHECK_NEAR(off(&wanted, y), (1 + 16) / 2.0, 1e-13);
}

static void test_size_and_pose(void **state) {
    (void)state;
    co_second_form wanted = form_of(2, -1), larger = form_of(2 / 3.0, -1 / 3.0);
    double y[N];
    graph(1, 0.3, 1, y);
    turn(y, 1, 2, 0.3);
    const double there = off(&wanted, y);
    for (int i = 0; i < N; i++)
        y[i] *= 3;
    CHECK_NEAR(9 * off(&larger, y), there, 1e-13);
}

static void test_a_plane_that_is_none(void **state) {
    (void)state;
    const co_second_form wanted = form_of(2, -1);
    double y[N];
    graph(1, 0, 1, y);
    memcpy(y + 3, y, 3 * sizeof *y);
    CHECK_TRUE(!isfinite(off(&wanted, y)));
}

/* Far from what is wanted, at angles up to some 60 degrees. */
static void test_derivatives_are_differences(void **state) {
    (void)state;
    const co_second_form wanted = {.normal = {0, 0.6, 0.8},
                                   .tensor = {3, 0.4, -0.3, 0.4, 1.28, -0.96, -0.3, -0.96, 0.72}};
    for (uint64_t seed = 1; seed < 6; seed++) {
        double y[N], gradient[N], hessian[N * N], gauss[N * N], size[N], vector[N * N], same[N];
        uint64_t random = seed;
        graph(1, 0.3, -1, y);
        for (int i = 0; i < N; i++)
            y[i] += 0.4 * check_random(&random);
        co_second_form_off(&wanted, y, gradient, hessian, 1);
        for (int i = 0; i < N; i++) {
            double up[N], down[N], value[2];
            const double at = y[i], h = 1e-5;
            y[i] = at + h;
            value[0] = co_second_form_off(&wanted, y, up, NULL, 0);
            y[i] = at - h;
            value[1] = co_second_form_off(&wanted, y, down, NULL, 0);
            y[i] = at;
            CHECK_NEAR(gradient[i], (value[0] - value[1]) / (2 * h), 1e-7);
            for (int j = 0; j < N; j++)
                CHECK_NEAR(hessian[N * j + i], (up[j] - down[j]) / (2 * h), 1e-6);
        }
        co_second_form_off(&wanted, y, same, gauss, 0);
        CHECK_TRUE(memcmp(same, gradient, sizeof same) == 0);
        co_small_dense_eigen(N, N, gauss, size, vector);
        for (int i = 0; i < N; i++)
            CHECK_TRUE(size[i] > -1e-12);
    }
}

/* Where the wanted form is met Gauss and Newton's matrix is the Hessian. */
static void test_gauss_and_newton_at_the_wanted_form(void **state) {
    (void)state;
    const co_second_form wanted = form_of(2, -1);
    double y[N], gradient[N], hessian[N * N], gauss[N * N];
    graph(2, 0, -1, y);
    change_parameters(y);
    co_second_form_off(&wanted, y, gradient, hessian, 1);
    co_second_form_off(&wanted, y, gradient, gauss, 0);
    for (int i = 0; i < N * N; i++)
        CHECK_NEAR(hessian[i], gauss[i], 1e-12);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_known_curvatures),
        cmocka_unit_test(test_it_turns_with_the_plane),
        cmocka_unit_test(test_sign_of_the_normal),
        cmocka_unit_test(test_size_and_pose),
        cmocka_unit_test(test_a_plane_that_is_none),
        cmocka_unit_test(test_derivatives_are_differences),
        cmocka_unit_test(test_gauss_and_newton_at_the_wanted_form),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
