/* Verdicts: the rule for every combination of what was found, and what is found at minima and at a saddle.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "solve/certificate.h"

/* ---------------------------------------------------------------------------------------------- the rule -- */

enum {
    UNKNOWN = CURVOPT_VERDICT_UNKNOWN,
    MINIMUM = CURVOPT_VERDICT_MINIMUM,
    SADDLE = CURVOPT_VERDICT_SADDLE,
    MOVES = CURVOPT_VERDICT_NOT_STATIONARY
};

/* Decrements over all variables, of the threshold: by rows; those of the shape by columns. */
enum { N_DECREMENTS = 6 };
static const double of_threshold[N_DECREMENTS] = {0, 0.999, 1.001, 1e9, INFINITY, NAN};

/* By negative directions: unknown, none, some. */
static const int expected[3][N_DECREMENTS][N_DECREMENTS] = {{{UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN},
                                                             {UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN},
                                                             {UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN},
                                                             {UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN},
                                                             {UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN},
                                                             {UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN}},
                                                            {{MINIMUM, MINIMUM, MOVES, MOVES, MOVES, MOVES},
                                                             {MINIMUM, MINIMUM, MOVES, MOVES, MOVES, MOVES},
                                                             {MOVES, MOVES, MOVES, MOVES, MOVES, MOVES},
                                                             {MOVES, MOVES, MOVES, MOVES, MOVES, MOVES},
                                                             {MOVES, MOVES, MOVES, MOVES, MOVES, MOVES},
                                                             {UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN}},
                                                            {{SADDLE, SADDLE, SADDLE, SADDLE, SADDLE, SADDLE},
                                                             {SADDLE, SADDLE, SADDLE, SADDLE, SADDLE, SADDLE},
                                                             {MOVES, MOVES, MOVES, MOVES, MOVES, MOVES},
                                                             {MOVES, MOVES, MOVES, MOVES, MOVES, MOVES},
                                                             {MOVES, MOVES, MOVES, MOVES, MOVES, MOVES},
                                                             {UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN}}};

static void check_table(const co_tuning *tuning, double objective) {
    static const int32_t negative[4] = {-1, 0, 1, 7};
    static const int row_of[4] = {0, 1, 2, 2};
    double threshold = tuning->certificate_stationary * fabs(objective);
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < N_DECREMENTS; i++)
            for (int j = 0; j < N_DECREMENTS; j++) {
                const co_certificate_shape shape = {.decrement = threshold * of_threshold[j],
                                                    .difference_decrement = (double)NAN, /* which has no say */
                                                    .negative_directions = negative[k]};
                int32_t verdict = co_certificate_verdict(tuning, objective, threshold * of_threshold[i], &shape);
                if (verdict != expected[row_of[k]][i][j])
                    print_error("%d negative, decrement %g, of the shape %g thresholds: ", (int)negative[k],
                                of_threshold[i], of_threshold[j]);
                CHECK_INT(verdict, expected[row_of[k]][i][j]);
            }
}

static void test_verdict_of_every_combination(void **state) {
    (void)state;
    co_tuning strict = co_tuning_defaults;
    check_table(&co_tuning_defaults, 40);
    check_table(&co_tuning_defaults, -40); /* springs are not negative, but the rule does not care */
    strict.certificate_stationary = 1e-9;
    check_table(&strict, 40);
    /* exactly at the threshold it is met */
    const co_certificate_shape at = {.decrement = strict.certificate_stationary * 40};
    CHECK_INT(co_certificate_verdict(&strict, 40, strict.certificate_stationary * 40, &at), MINIMUM);
    /* an energy of nothing has nothing left */
    const co_certificate_shape none = {.decrement = 0};
    CHECK_INT(co_certificate_verdict(&co_tuning_defaults, 0, 0, &none), MINIMUM);
    CHECK_INT(co_certificate_verdict(&co_tuning_defaults, 0, 1e-300, &none), MOVES);
}

/* -------------------------------------------------------------------------------------------- what is found -- */

static curvopt_options tight(int32_t surface, int term) {
    curvopt_options o = solve_options(surface, term);
    o.tolerance = 1e-6;
    return o;
}

static co_certificate_shape shape_of(solve_setting *s, const co_level *solved) {
    return solve_shape(s, &s->symmetry, s->c.xyz, solved, 1);
}

/* At the minimum nothing is left, by factor and by differences; beside it both say how much is, and agree. */
static void check_minimum(cage c, curvopt_options options) {
    solve_setting *s = solve_setting_of(c, &options);
    solve_minimized(s);
    double most = s->tuning.certificate_stationary * solve_energy(s, s->c.xyz);
    co_certificate_shape shape = shape_of(s, NULL);
    CHECK_INT(shape.negative_directions, 0);
    CHECK_BETWEEN(shape.decrement, 0, most);
    CHECK_BETWEEN(shape.difference_decrement, 0, most);
    cage_perturb(&s->c, 2e-3 * s->run.radius, 4);
    co_level *l = solve_level(s);
    shape = shape_of(s, NULL);
    CHECK_INT(shape.negative_directions, 0);
    CHECK_BETWEEN(shape.decrement, 10 * most, 1e5 * most);
    CHECK_NEAR(shape.difference_decrement / shape.decrement, 1, 1e-2);
    co_certificate_shape same = shape_of(s, l); /* by the same rules */
    CHECK_INT(same.negative_directions, 0);
    CHECK_NEAR(same.decrement / shape.decrement, 1, 1e-3);
    co_level_destroy(l);
    solve_setting_free(s);
}

static void test_minima_have_no_negative_directions(void **state) {
    (void)state;
    curvopt_options w = tight(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    check_minimum(cage_refined(cage_cube(), 1), w);
    check_minimum(cage_torus(8, 6, 1, 0.6), w);
    check_minimum(cage_band(8, 4, 1, 1, 0.8), w);
}

/* The shape of a coarse prism is a saddle of MVS, and a minimum among cages with its symmetry. */
static void test_saddle_is_counted(void **state) {
    (void)state;
    curvopt_options mvs = tight(CURVOPT_SURFACE_POLYNOMIAL, CURVOPT_TERM_MVS);
    mvs.tolerance = 1e-4;
    mvs.symmetry = CURVOPT_SYMMETRY_KEEP;
    solve_setting *s = solve_setting_of(cage_prism(5), &mvs);
    solve_minimized(s);
    co_certificate_shape shape = shape_of(s, NULL);
    CHECK_INT(shape.negative_directions, 0);
    CHECK_TRUE(shape.decrement <= s->tuning.certificate_stationary * solve_energy(s, s->c.xyz));
    co_symmetry none = {0};
    curvopt_error error;
    int32_t all;
    CHECK_OK(co_symmetry_none(s->mesh, &none, &error), &error);
    shape = solve_shape(s, &none, s->c.xyz, NULL, 1);
    CHECK_BETWEEN(shape.negative_directions, 1, 10);
    CHECK_TRUE(isnan(shape.decrement) && isnan(shape.difference_decrement));
    CHECK_OK(
        co_certificate_count_negative(&s->run, s->mesh, &s->constraints, CO_MOTION_NORMALS, s->c.xyz, &all, &error),
        &error);
    CHECK_INT(all, shape.negative_directions);
    CHECK_OK(co_certificate_count_negative(&s->run, s->mesh, &s->constraints, CO_MOTION_ALL, s->c.xyz, &all, &error),
             &error);
    CHECK_BETWEEN(all, shape.negative_directions, 30);
    co_symmetry_free(&none);
    solve_setting_free(s);
}

/* Nothing may move: a minimum, whatever the surface. */
static void test_nothing_to_move_is_a_minimum(void **state) {
    (void)state;
    static const int32_t all[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    const curvopt_constraints held = {.vertices = all, .n = 8};
    curvopt_options w = tight(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    w.constraints = &held;
    solve_setting *s = solve_setting_of(cage_cube(), &w);
    co_certificate_shape shape = shape_of(s, NULL);
    CHECK_INT(shape.negative_directions, 0);
    CHECK_NEAR(shape.decrement, 0, 0);
    CHECK_NEAR(shape.difference_decrement, 0, 0);
    solve_setting_free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_verdict_of_every_combination),
        cmocka_unit_test(test_minima_have_no_negative_directions),
        cmocka_unit_test(test_saddle_is_counted),
        cmocka_unit_test(test_nothing_to_move_is_a_minimum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
