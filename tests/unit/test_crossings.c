/* Where limit surfaces cross themselves: pairs, neighbours, refusals. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "measure/crossing_pair.h"
#include "measure/quadric.h"

enum { ROOM = 1000 };

static curvopt_crossings find(const cage *c, int32_t n_room, int32_t *pairs) {
    curvopt_mesh *mesh = cage_mesh(c);
    curvopt_crossings out;
    curvopt_error error;
    memset(&out, 0xff, sizeof out);
    CHECK_OK(curvopt_find_crossings(mesh, c->xyz, 2, NULL, n_room, pairs, &out, sizeof out, &error), &error);
    curvopt_mesh_destroy(mesh);
    return out;
}

static void test_separate_and_overlapping_tori(void **state) {
    int32_t pairs[2 * ROOM];
    (void)state;
    for (int crosses = 0; crosses < 2; crosses++) {
        cage both = cage_both(cage_torus(12, 8, 1, 0.4), cage_torus(12, 8, 1, 0.4), crosses ? 2.2 : 3);
        curvopt_crossings c = find(&both, ROOM, pairs);
        CHECK_TRUE((c.n_pairs > 0) == crosses);
        CHECK_INT(c.n_listed, c.n_pairs);
        CHECK_INT(c.is_complete, 1);
        for (int32_t k = 0; k < c.n_listed; k++)
            CHECK_TRUE(pairs[2 * k] < 96 && pairs[2 * k + 1] >= 96); /* one face of each */
        for (int32_t k = 1; k < c.n_listed; k++)
            CHECK_TRUE(pairs[2 * k - 2] < pairs[2 * k] ||
                       (pairs[2 * k - 2] == pairs[2 * k] && pairs[2 * k - 1] < pairs[2 * k + 1]));
        curvopt_crossings some = find(&both, 0, NULL);
        CHECK_INT(some.n_pairs, c.n_pairs);
        CHECK_INT(some.n_listed, 0);
        cage_free(&both);
    }
}

static void test_surface_on_itself_is_contact(void **state) {
    cage both = cage_both(cage_torus(6, 4, 1, 0.4), cage_torus(6, 4, 1, 0.4), 0);
    (void)state;
    curvopt_crossings c = find(&both, 0, NULL);
    CHECK_INT(c.n_pairs, 0);
    CHECK_TRUE(c.n_contacts >= 24);
    cage_free(&both);
}

static void test_closed_surfaces_do_not_cross(void **state) {
    (void)state;
    cage cages[] = {cage_cube(),           cage_tetrahedron(),   cage_prism(7),
                    cage_trapezohedron(9), cage_half_star(5, 2), cage_torus(4, 3, 1, 0.5)};
    for (size_t k = 0; k < sizeof cages / sizeof *cages; k++) {
        curvopt_crossings c = find(&cages[k], 0, NULL);
        CHECK_INT(c.n_pairs + c.n_contacts + c.n_unresolved, 0);
        cage_free(&cages[k]);
    }
}

/* Two quads with a common edge, a triangle beside them:  3--2--5     faces 0 1 2 3, 1 4 5 2 and 4 6 5
 *                                                        | 0| 1|\
 *                                                        0--1--4-6                                     */
static void test_contacts(void **state) {
    static const int32_t sizes[3] = {4, 4, 3}, vertices[11] = {0, 1, 2, 3, 1, 4, 5, 2, 4, 6, 5};
    curvopt_mesh *mesh = NULL;
    curvopt_error error;
    (void)state;
    CHECK_OK(curvopt_mesh_create(7, 3, sizes, vertices, &mesh, &error), &error);
    const co_location left = {0, 0, {0, 0.5}, {0, 1}}, right = {0, 0, {0.5, 1}, {0, 0.5}};
    const co_location upper = {0, 0, {0.5, 1}, {0.5, 1}}, beside = {1, 0, {0, 0.5}, {0.5, 1}};
    const co_location low = {1, 0, {0, 0.25}, {0, 0.25}}, far = {1, 0, {0.5, 1}, {0, 0.5}};
    const co_location first = {2, 0, {0, 1}, {0, 1}}, third = {2, 2, {0, 1}, {0, 1}}, tip = {2, 1, {0.5, 1}, {0.5, 1}};
    CHECK_INT(co_location_contact(mesh, &left, &right), CO_CONTACT_EDGE);
    CHECK_INT(co_location_contact(mesh, &upper, &beside), CO_CONTACT_EDGE);
    CHECK_INT(co_location_contact(mesh, &right, &beside), CO_CONTACT_VERTEX);
    CHECK_INT(co_location_contact(mesh, &left, &beside), CO_CONTACT_NONE);
    CHECK_INT(co_location_contact(mesh, &right, &low), CO_CONTACT_EDGE);
    CHECK_INT(co_location_contact(mesh, &upper, &low), CO_CONTACT_NONE);
    CHECK_INT(co_location_contact(mesh, &far, &first), CO_CONTACT_EDGE); /* half of an edge: the quarter at vertex 4 */
    CHECK_INT(co_location_contact(mesh, &far, &third), CO_CONTACT_VERTEX); /* the middle of that edge */
    CHECK_INT(co_location_contact(mesh, &first, &third), CO_CONTACT_EDGE);
    CHECK_INT(co_location_contact(mesh, &first, &tip), CO_CONTACT_EDGE);
    curvopt_mesh_destroy(mesh);
}

/* Bicubic pieces of random control points round a bent sheet. */
static void make_sheet(double bend, double height, double shaken, double part, uint64_t *seed, double out[CO_BEZIER]) {
    for (int i = 0; i < 16; i++) {
        const double x = part * (i % 4 - 1.5), y = part * (i / 4 - 1.5);
        out[3 * i] = x + shaken * (check_random(seed) - 0.5);
        out[3 * i + 1] = y + 0.2 * x + shaken * (check_random(seed) - 0.5);
        out[3 * i + 2] = height + bend * (x * x - x * y + 2 * y * y) + shaken * (check_random(seed) - 0.5);
    }
}

/* Cones of several pieces hold the derivatives of each, and are as wide as the control nets ask for. */
static void test_cones_of_several_pieces(void **state) {
    enum { N = 3 };
    double net[N * CO_BEZIER];
    uint64_t seed = 11;
    (void)state;
    for (int n = 0; n < 50; n++) {
        double least[2] = {1, 1}, least_of_net[2] = {1, 1};
        co_cone cone[2];
        for (int k = 0; k < N; k++)
            make_sheet(0.1 * k, 0, 0.1, 1.0 / (1 + k), &seed, net + (size_t)k * CO_BEZIER);
        co_bezier_cones(net, N, &cone[0], &cone[1]);
        for (int k = 0; k < N; k++)
            for (int i = 0; i < 49; i++) {
                co_bezier_jet j;
                co_bezier_at(net + (size_t)k * CO_BEZIER, i / 7 / 6.0, i % 7 / 6.0, &j);
                least[0] = fmin(least[0], co_dot3(j.u, cone[0].axis) / co_length3(j.u));
                least[1] = fmin(least[1], co_dot3(j.v, cone[1].axis) / co_length3(j.v));
            }
        for (int k = 0; k < 16 * N; k++) {
            const double *p = net + 3 * (size_t)k;
            for (int way = 0; way < 2; way++) {
                if (way ? k % 16 >= 12 : k % 4 == 3)
                    continue;
                const double *q = p + (way ? 12 : 3), d[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
                least_of_net[way] = fmin(least_of_net[way], co_dot3(d, cone[way].axis) / co_length3(d));
            }
        }
        for (int way = 0; way < 2; way++) {
            CHECK_BETWEEN(cos(cone[way].angle), -1, least[way] + 1e-12);
            CHECK_NEAR(cos(cone[way].angle), least_of_net[way], 1e-12);
        }
    }
}

/* Normals of a bent piece are within the cone of their control net, also where directions along u and along v overlap,
 * as in the sectors of a fan; of a flat one that is one normal. */
static void test_cones_of_normals(void **state) {
    double net[CO_BEZIER];
    uint64_t seed = 5;
    int n_narrower = 0;
    (void)state;
    for (int n = 0; n < 60; n++) {
        const double bend = n % 3 * 0.05;
        make_sheet(bend, 0, n % 3 ? 0.05 : 0, 1, &seed, net);
        for (size_t i = 0; i < 16; i++) { /* a sector of 30 degrees, but for its tip */
            const double x = net[3 * i], y = net[3 * i + 1];
            net[3 * i] = (x + 2.2) * cos(0.17 * y);
            net[3 * i + 1] = (x + 2.2) * sin(0.17 * y) - 0.5 * x;
        }
        const co_cone cone = co_bezier_normals(net);
        const co_directions directions = co_directions_of(net, 1);
        CHECK_TRUE(cone.angle < 1.5 && directions.normal.angle <= fmax(cone.angle, 0.3));
        n_narrower += directions.normal.angle == cone.angle;
        if (bend == 0)
            CHECK_NEAR(cone.angle, 0, 1e-7);
        for (int i = 0; i < 49; i++) {
            co_bezier_jet j;
            double normal[3];
            co_bezier_at(net, i / 7 / 6.0, i % 7 / 6.0, &j);
            co_cross3(j.u, j.v, normal);
            CHECK_TRUE(co_dot3(normal, cone.axis) >= (cos(cone.angle) - 1e-12) * co_length3(normal));
        }
    }
    CHECK_TRUE(n_narrower > 0);
}

static double height_over(const co_quadric *q, const double at[3]) {
    const double d[3] = {at[0] - q->origin[0], at[1] - q->origin[1], at[2] - q->origin[2]};
    const double x = co_dot3(d, q->axis[0]), y = co_dot3(d, q->axis[1]);
    return co_dot3(d, q->axis[2]) - (q->c[0] * x * x + q->c[1] * x * y + q->c[2] * y * y);
}

/* All heights are within range, which is not much more than they take; where the paraboloid osculates they are of third
 * order: on a part of half the side an eighth. */
static void test_heights_over_a_paraboloid(void **state) {
    uint64_t seed = 8;
    (void)state;
    for (int k = 0; k < 20; k++) {
        double range[2], most[2] = {0, 0}, wall[CO_BEZIER], piece[CO_BEZIER];
        co_quadric q;
        make_sheet(0.3, 0, 0.3, 0.4, &seed, wall);
        CHECK_TRUE(co_quadric_at_middle(wall, &q));
        for (int other = 0; other < 2; other++) {
            double low = INFINITY, high = -INFINITY;
            make_sheet(0.3, 0.1, 0.3, 0.4, &seed, piece);
            co_quadric_heights(&q, other ? piece : wall, range);
            for (int i = 0; i <= 20; i++)
                for (int j = 0; j <= 20; j++) {
                    double at[3];
                    co_bezier_point(other ? piece : wall, i / 20.0, j / 20.0, at);
                    const double h = height_over(&q, at);
                    CHECK_BETWEEN(h, range[0] - 1e-14, range[1] + 1e-14);
                    low = fmin(low, h);
                    high = fmax(high, h);
                }
            CHECK_TRUE(range[1] - range[0] < 2 * (high - low));
        }
        for (int level = 0; level < 2; level++) {
            const double side[2] = {0.5 - ldexp(0.1, -level), 0.5 + ldexp(0.1, -level)};
            co_bezier_part(wall, side, side, piece);
            co_quadric_heights(&q, piece, range);
            most[level] = fmax(-range[0], range[1]);
        }
        CHECK_BETWEEN(most[0] / most[1], 5, 12);
    }
    const double flat[CO_BEZIER] = {0};
    co_quadric none;
    CHECK_TRUE(!co_quadric_at_middle(flat, &none));
}

/* Tori one round the other, a hundredth of a face apart: their hulls overlap until parts are small. */
static void test_sheets_along_each_other_are_told_apart(void **state) {
    cage both = cage_both(cage_torus(12, 8, 1, 0.4), cage_torus(12, 8, 1, 0.4025), 0);
    (void)state;
    curvopt_crossings c = find(&both, 0, NULL);
    CHECK_INT(c.n_pairs, 0);
    CHECK_INT(c.n_contacts, 0);
    CHECK_INT(c.n_unresolved, 0);
    cage_free(&both);
}

static void test_refusals(void **state) {
    cage a = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&a);
    curvopt_crossings c;
    curvopt_error error;
    (void)state;
    CHECK_REFUSED(curvopt_find_crossings(mesh, a.xyz, 1, NULL, 1, NULL, &c, sizeof c, &error), &error,
                  CURVOPT_ERROR_ARGUMENT, -1, "pairs");
    CHECK_REFUSED(curvopt_find_crossings(mesh, a.xyz, 1, NULL, -1, NULL, &c, sizeof c, &error), &error,
                  CURVOPT_ERROR_ARGUMENT, -1, "n_room");
    CHECK_REFUSED(curvopt_find_crossings(mesh, NULL, 1, NULL, 0, NULL, &c, sizeof c, &error), &error,
                  CURVOPT_ERROR_ARGUMENT, -1, "xyz");
    curvopt_mesh_destroy(mesh);
    cage_free(&a);
}

static void test_cancelled_is_not_complete(void **state) {
    cage a = cage_torus(6, 4, 1, 0.4);
    curvopt_mesh *mesh = cage_mesh(&a);
    curvopt_cancel *cancel = NULL;
    curvopt_crossings c;
    curvopt_error error;
    (void)state;
    CHECK_OK(curvopt_cancel_create(&cancel, &error), &error);
    curvopt_cancel_request(cancel);
    CHECK_OK(curvopt_find_crossings(mesh, a.xyz, 1, cancel, 0, NULL, &c, sizeof c, &error), &error);
    CHECK_INT(c.is_complete, 0);
    curvopt_cancel_destroy(cancel);
    curvopt_mesh_destroy(mesh);
    cage_free(&a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_separate_and_overlapping_tori),
        cmocka_unit_test(test_surface_on_itself_is_contact),
        cmocka_unit_test(test_closed_surfaces_do_not_cross),
        cmocka_unit_test(test_contacts),
        cmocka_unit_test(test_cones_of_several_pieces),
        cmocka_unit_test(test_cones_of_normals),
        cmocka_unit_test(test_heights_over_a_paraboloid),
        cmocka_unit_test(test_sheets_along_each_other_are_told_apart),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_cancelled_is_not_complete),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
