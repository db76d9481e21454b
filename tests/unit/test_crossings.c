/* Where limit surfaces cross themselves: pairs, neighbours, refusals. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "measure/location.h"

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
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_cancelled_is_not_complete),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
