/* How a solved level answers to places that have moved: to first order as its minimum does, in parts where the way is
 * long; what is held is where it is to be. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "constraints/given_constraints.h"
#include "linalg/vector.h"
#include "solve/level_response.h"

enum { N_VERTICES = 24, N_PINS = 4 };

static const int32_t PINS[N_PINS] = {0, 7, 13, 22};

/* The cage at its minimum, which all tests begin with: found once, by set_up. */
static double minimum[3 * N_VERTICES];

/* A level at its minimum, with its factor; where its pins are. It stays where it is. */
typedef struct fixture {
    curvopt_constraints pins;
    double places[3 * N_PINS], start[3 * N_VERTICES];
    solve_setting *s;
    co_level *level;
    size_t n;
} fixture;

/* From xyz, or from a torus where that is NULL. */
static void fixture_at(fixture *f, const double *xyz) {
    const co_level_prospect prospect = {0};
    curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    co_outcome outcome;
    curvopt_error error;
    o.tolerance = 1e-8;
    o.decrement_tolerance = 1e-13;
    cage c = cage_shaken(cage_torus(6, 4, 1, 0.45), 0.05);
    *f = (fixture){.pins = {.vertices = PINS, .n = N_PINS, .has_places = 1, .places = f->places}};
    for (int i = 0; i < 3 * N_PINS; i++)
        f->places[i] = c.xyz[3 * PINS[i / 3] + i % 3];
    if (xyz)
        memcpy(c.xyz, xyz, 3 * N_VERTICES * sizeof *xyz);
    o.constraints = &f->pins;
    f->s = solve_setting_of(c, &o);
    f->level = solve_level(f->s);
    f->level->error = &error;
    f->n = co_level_objective_n(&f->level->objective);
    CHECK_OK(co_level_solve(f->level, &prospect, &outcome, &error), &error);
    CHECK_INT(outcome.stop, CURVOPT_STOP_CONVERGED);
    f->s->tuning.shift_least = 1e-6; /* the factor is the Hessian's */
    CHECK_OK(co_level_refresh_factor(f->level, &error), &error);
    CHECK_TRUE(f->level->hessian.has_factor);
    f->level->error = NULL;
}

static void fixture_free(fixture *f) {
    co_level_destroy(f->level);
    solve_setting_free(f->s);
}

static int set_up(void **state) {
    fixture f;
    (void)state;
    fixture_at(&f, NULL);
    co_level_objective_to_user(&f.level->objective, f.level->now.x, 1, minimum);
    fixture_free(&f);
    return 0;
}

static void fixture_of(fixture *f) {
    fixture_at(f, minimum);
}

/* The first pin goes so far along x and half of that back along y from where it was at first; the level answers. */
static void answer(fixture *f, double by) {
    co_constraints moved;
    curvopt_error error;
    int fits = 0;
    double places[3 * N_PINS];
    memcpy(places, f->places, sizeof places);
    places[0] += by;
    places[1] -= by / 2;
    const curvopt_constraints pins = {.vertices = PINS, .n = N_PINS, .has_places = 1, .places = places};
    CHECK_OK(co_given_constraints_create(f->s->mesh, f->s->c.xyz, &pins, &moved, &error), &error);
    co_level_objective_to_user(&f->level->objective, f->level->now.x, 1, f->start);
    CHECK_OK(co_given_constraints_place(f->s->mesh, &moved, f->s->options.boundary, f->start, &error), &error);
    CHECK_OK(co_level_response(f->level, &f->s->symmetry, &moved, f->start, &fits, &error), &error);
    CHECK_TRUE(fits);
    co_constraints_free(&moved);
    double xyz[3 * N_VERTICES];
    co_level_objective_to_user(&f->level->objective, f->level->now.x, 1, xyz);
    for (int i = 0; i < 3 * N_PINS; i++)
        CHECK_NEAR(xyz[3 * PINS[i / 3] + i % 3], places[i], 1e-14);
}

/* What the level says of where it stands is true. */
static void check_iterate(fixture *f) {
    co_level *l = f->level;
    double *gradient = calloc(f->n, sizeof *gradient);
    co_iterate again = {.x = l->now.x, .gradient = gradient};
    CHECK_TRUE(gradient != NULL);
    co_level_objective_evaluate(&l->objective, &again);
    CHECK_NEAR(l->now.value, again.value, 0);
    assert_memory_equal(l->now.gradient, gradient, f->n * sizeof *gradient);
    assert_memory_equal(l->now.found, again.found, sizeof again.found);
    CHECK_TRUE(l->reached == l->now.x);
    free(gradient);
}

/* Where no move is so small that one Newton step follows it. */
enum { NEVER_STRAIGHT = 0 };

/* The gradient after an answer to a move by `by` of a level at its minimum. */
static double gradient_after_straight(double by, double straight, double reach, int parts) {
    fixture f;
    fixture_of(&f);
    const double before = co_vector_norm(f.n, f.level->now.gradient);
    f.s->tuning.near_straight = straight;
    f.s->tuning.near_reach = reach;
    f.s->tuning.near_parts = parts;
    answer(&f, by);
    check_iterate(&f);
    const double after = co_vector_norm(f.n, f.level->now.gradient);
    CHECK_BETWEEN(before, 0, 0.05 * after);
    fixture_free(&f);
    return after;
}

static double gradient_after(double by, double reach, int parts) {
    return gradient_after_straight(by, NEVER_STRAIGHT, reach, parts);
}

/* What is left is of second order, at once and by parts. */
static void test_answer_is_of_first_order(void **state) {
    (void)state;
    CHECK_BETWEEN(check_order(gradient_after(0.02, 100, 1), gradient_after(0.01, 100, 1)), 1.7, 2.3);
    CHECK_BETWEEN(check_order(gradient_after(-0.02, 100, 1), gradient_after(-0.01, 100, 1)), 1.7, 2.3);
}

/* The same of one Newton step from where only what is held has moved. */
static void test_newton_step_is_of_first_order(void **state) {
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2)
        CHECK_BETWEEN(check_order(gradient_after_straight(0.02 * sign, 1, 100, 1),
                                  gradient_after_straight(0.01 * sign, 1, 100, 1)),
                      1.7, 2.3);
    CHECK_TRUE(gradient_after_straight(0.01, 1, 100, 1) != gradient_after(0.01, 100, 1));
}

/* The matrix is that of where the way began, and what it misses grows with the distance from there: a part of the way
 * leaves that times its own length. What the parts before have left the steps back take; else it would add up to as
 * much as the whole way leaves. */
static void test_parts_of_a_long_way(void **state) {
    (void)state;
    const double once = gradient_after(0.1, 100, 32), four = gradient_after(0.1, 0.05, 4),
                 eight = gradient_after(0.1, 0.01, 8);
    CHECK_BETWEEN(once / four, 1.4, 4);
    CHECK_BETWEEN(four / eight, 1.7, 4);
}

/* The number of parts is that of the longest displacement over the reach, in mean edges. */
static void test_how_many_parts(void **state) {
    (void)state;
    fixture f;
    fixture_of(&f);
    const double edge = f.level->objective.edge * f.s->run.radius, by = 0.1, length = by * sqrt(1.25) / edge;
    fixture_free(&f);
    static const double reach[4] = {1.05, 0.53, 0.35, 0.27};
    for (int parts = 1; parts <= 4; parts++)
        CHECK_NEAR(gradient_after(by, reach[parts - 1] * length, 32), gradient_after(by, 0.001, parts), 0);
    CHECK_TRUE(gradient_after(by, 0.9 * length, 32) != gradient_after(by, 0.001, 1));
}

/* Without a factor, and without a move, nothing moves but what is held. */
static void test_nothing_else_moves(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++) {
        fixture f;
        double x[3 * N_VERTICES];
        fixture_of(&f);
        memcpy(x, f.level->now.x, f.n * sizeof *x);
        f.level->hessian.has_factor = k;
        answer(&f, k ? 0 : 0.02);
        check_iterate(&f);
        for (size_t i = 0; i < f.n; i++)
            CHECK_NEAR(f.level->now.x[i], x[i], 1e-14);
        fixture_free(&f);
    }
}

/* A step that does not lower what is below it is not made: here the answer's sign is wrong, by a negative matrix. */
static void test_no_answer_is_worse_than_none(void **state) {
    (void)state;
    double values[2];
    for (int k = 0; k < 2; k++) {
        fixture f;
        fixture_of(&f);
        f.level->hessian.has_factor = k;
        f.s->tuning.near_reach = 100;
        answer(&f, 1.5);
        values[k] = f.level->now.value;
        fixture_free(&f);
    }
    CHECK_TRUE(isfinite(values[0]) && values[1] <= values[0]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_answer_is_of_first_order), cmocka_unit_test(test_newton_step_is_of_first_order),
        cmocka_unit_test(test_parts_of_a_long_way),      cmocka_unit_test(test_how_many_parts),
        cmocka_unit_test(test_nothing_else_moves),       cmocka_unit_test(test_no_answer_is_worse_than_none),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
