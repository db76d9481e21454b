/* Ways down from saddles that symmetry hides, and what they must bring. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "solve/saddle_escape.h"
#include "solve/symmetry_reduction.h"

/* ------------------------------------------------------------------------------------------------ the price -- */

static void test_each_halving_has_its_price(void **state) {
    (void)state;
    static const struct {
        int32_t order, left;
        double halvings;
    } rows[] = {{2, 1, 1}, {8, 4, 1}, {8, 2, 2}, {8, 1, 3}, {48, 24, 1}, {48, 1, 6}, {12, 3, 2}, {12, 4, 2}, {3, 1, 2}};
    co_tuning t = co_tuning_defaults;
    for (int k = 0; k < 2; k++) {
        for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
            CHECK_NEAR(co_symmetry_reduction_worth(&t, rows[i].order, rows[i].left), rows[i].halvings * t.loosen_half,
                       1e-15);
        CHECK_NEAR(co_symmetry_reduction_worth(&t, 8, 8), t.loosen_same, 0);
        CHECK_NEAR(co_symmetry_reduction_worth(&t, 1, 1), t.loosen_same, 0);
        t.loosen_half = 0.25;
        t.loosen_same = 0.125;
    }
}

/* --------------------------------------------------------------------------------------------- the way down -- */

static curvopt_options symmetric(int term) {
    curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, term);
    o.symmetry = CURVOPT_SYMMETRY_KEEP;
    return o;
}

/* The minimum among symmetric cages. */
static solve_setting *minimized(cage c, int term) {
    curvopt_options o = symmetric(term);
    o.surface = term == CURVOPT_TERM_MVS ? CURVOPT_SURFACE_POLYNOMIAL : CURVOPT_SURFACE_LIMIT;
    solve_setting *s = solve_setting_of(c, &o);
    solve_minimized(s);
    return s;
}

/* Of the torus the shape is a minimum. */
static void test_twisting_lines_are_no_way_for_the_shape(void **state) {
    (void)state;
    solve_setting *s = minimized(cage_torus(8, 4, 1, 0.4), CURVOPT_TERM_MVS);
    curvopt_error error;
    co_way_down way;
    CHECK_OK(co_saddle_escape_find(&s->run, s->mesh, &s->symmetry, &s->constraints, s->c.xyz, 1,
                                   CO_SADDLE_ESCAPE_NORMALS, &way, &error),
             &error);
    CHECK_INT(way.found, 0);
    co_saddle_escape_free(&way);
    solve_setting_free(s);
}

/* Planes that the user chose are not given up. */
static void test_chosen_planes_stay(void **state) {
    (void)state;
    solve_setting *s = minimized(cage_torus(8, 4, 1, 0.4), CURVOPT_TERM_MVS);
    curvopt_error error;
    co_way_down way;
    s->options.symmetry = CURVOPT_SYMMETRY_PLANES;
    CHECK_OK(co_saddle_escape_find(&s->run, s->mesh, &s->symmetry, &s->constraints, s->c.xyz, 1, CO_SADDLE_ESCAPE_ALL,
                                   &way, &error),
             &error);
    CHECK_INT(way.found, 0);
    co_saddle_escape_free(&way);
    solve_setting_free(s);
}

static void test_no_way_leads_down_from_a_sphere(void **state) {
    (void)state;
    solve_setting *s = minimized(cage_refined(cage_cube(), 1), CURVOPT_TERM_WILLMORE);
    curvopt_error error;
    co_way_down way;
    CHECK_INT(s->symmetry.order, 48);
    CHECK_OK(co_saddle_escape_find(&s->run, s->mesh, &s->symmetry, &s->constraints, s->c.xyz, 1,
                                   CO_SADDLE_ESCAPE_NORMALS, &way, &error),
             &error);
    CHECK_INT(way.found, 0);
    co_saddle_escape_free(&way);
    solve_setting_free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_each_halving_has_its_price),
        cmocka_unit_test(test_twisting_lines_are_no_way_for_the_shape),
        cmocka_unit_test(test_chosen_planes_stay),
        cmocka_unit_test(test_no_way_leads_down_from_a_sphere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
