/* The schedule of a level: the plan as data, and how it is run, on a script. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "check.h"
#include "curvopt.h"

#include "solve/level_schedule.h"

static const co_level_facts usual = {
    .has_hessian = 1, .max_iterations = 1000, .gradient_tolerance = 1e-9, .decrement_tolerance = 3e-7, .max_step = 0.2};

/* --------------------------------------------------------------------------------------- the plan -- */

static void test_which_stages_there_are(void **state) {
    (void)state;
    for (int bits = 0; bits < 64; bits++) {
        co_level_facts f = usual;
        f.is_final = bits & 1;
        f.is_on_normals = bits >> 1 & 1;
        f.has_hessian = bits >> 2 & 1;
        f.is_last = bits >> 3 & 1;
        f.is_near = bits >> 4 & 1;
        f.stops_short = bits >> 5 & 1;
        co_level_schedule s = co_level_schedule_make(&f, &co_tuning_defaults);
        CHECK_INT(s.forms, !f.is_on_normals && !f.is_near);
        CHECK_INT(s.settles, f.is_near ? f.stops_short : (f.is_final || f.is_last) && !f.is_on_normals);
        CHECK_INT(s.ends, f.has_hessian && f.is_final && !f.stops_short);
        CHECK_INT(s.options.keeps_matrix, f.is_last && f.is_on_normals);
    }
}

static void test_tolerances(void **state) {
    (void)state;
    const co_tuning *t = &co_tuning_defaults;
    for (int bits = 0; bits < 128; bits++) {
        co_level_facts f = usual;
        f.is_final = bits & 1;
        f.is_last = bits >> 1 & 1;
        f.expects_plateau = bits >> 2 & 1;
        f.has_hessian = bits >> 3 & 1;
        f.has_repulsion = bits >> 4 & 1;
        f.is_near = bits >> 5 & 1;
        f.is_rough = bits >> 6 & 1;
        const co_level_schedule s = co_level_schedule_make(&f, t);
        for (int forming = 0; forming < 2; forming++) {
            const co_method_options *o = forming ? &s.forming : &s.options;
            CHECK_NEAR(o->decrement_tolerance,
                       forming      ? t->coarse_decrement
                       : f.is_final ? 3e-7
                                    : t->last_decrement,
                       0);
            CHECK_NEAR(o->settled_decrease, f.is_final ? 3e-7 * t->final_settled : t->coarse_settled, 0);
            CHECK_INT(o->settled_steps, forming && !f.expects_plateau ? t->quick_steps : t->slow_steps);
            CHECK_INT(o->update_every, f.is_final || f.has_repulsion ? t->lbfgs_update_often : t->lbfgs_update_every);
            CHECK_INT(o->is_scaled, forming && f.is_rough);
            CHECK_INT(o->by_hessian, !forming && !f.is_final && !f.is_near);
            CHECK_NEAR(o->gradient_tolerance, 1e-9, 0);
            CHECK_NEAR(o->max_step, 0.2, 0);
        }
        CHECK_NEAR(s.stationary, 3e-7 * t->stationary, 0);
    }
}

/* ------------------------------------------------------------------------------------ running it -- */

/* What each call of run() is to come to. */
typedef struct stage {
    int stop, iterations;
    double value;
    double left; /* decrement there */
    int verdict; /* of review_for_figures() there: co_step_verdict */
} stage;

typedef struct script {
    const stage *stage;
    int n, at;
    char log[200]; /* a letter for every call: L, N run; E begun again; C the better chosen; F refine; R review; D
                      decrement */
    int is_uneven; /* faces have folded while the shape formed */
    int limit[20]; /* max_iterations of each run */
    int place;     /* the stage that the iterate is at */
} script;

static void note(script *s, char c) {
    s->log[strlen(s->log)] = c;
}

static int32_t run(void *context, co_method method, const co_method_options *options, const co_outcome *before,
                   co_outcome *outcome, curvopt_error *error) {
    script *s = context;
    (void)error;
    (void)before;
    note(s, method == CO_METHOD_NEWTON ? 'N' : 'L');
    CHECK_TRUE(s->at < s->n);
    s->limit[s->at] = options->max_iterations;
    s->place = s->at++;
    *outcome = (co_outcome){.stop = s->stage[s->place].stop,
                            .iterations = s->stage[s->place].iterations,
                            .evaluations = 2 * s->stage[s->place].iterations};
    return CURVOPT_OK;
}

static int32_t refine(void *context, curvopt_error *error) {
    script *s = context;
    (void)error;
    note(s, 'F');
    return CURVOPT_OK;
}

static int32_t review(void *context, co_step_verdict *verdict, curvopt_error *error) {
    script *s = context;
    (void)error;
    note(s, 'R');
    *verdict = (co_step_verdict)s->stage[s->place].verdict;
    return CURVOPT_OK;
}

static int32_t decrement(void *context, double *left, curvopt_error *error) {
    script *s = context;
    (void)error;
    note(s, 'D');
    *left = s->stage[s->place].left;
    return CURVOPT_OK;
}

static double value(void *context) {
    const script *s = context;
    return s->stage[s->place].value;
}

static int32_t begin_even(void *context, int *begun, curvopt_error *error) {
    script *s = context;
    (void)error;
    *begun = s->is_uneven;
    s->is_uneven = 0;
    if (*begun)
        note(s, 'E');
    return CURVOPT_OK;
}

static void end_even(void *context) {
    note(context, 'C');
}

static co_outcome play(const co_level_facts *facts, script *s) {
    const co_level_schedule schedule = co_level_schedule_make(facts, &co_tuning_defaults);
    const co_scheduled on = {.context = s,
                             .run = run,
                             .refine = refine,
                             .review_for_figures = review,
                             .decrement = decrement,
                             .value = value,
                             .begin_even = begin_even,
                             .end_even = end_even};
    co_outcome outcome;
    curvopt_error error;
    CHECK_OK(co_level_schedule_run(&schedule, &on, &outcome, &error), &error);
    CHECK_INT(s->at, s->n); /* the whole script was played */
    int iterations = 0;
    for (int k = 0; k < s->n; k++) {
        CHECK_TRUE(s->limit[k] + iterations <= facts->max_iterations);
        iterations += s->stage[k].iterations;
    }
    CHECK_INT(outcome.iterations, iterations);
    CHECK_INT(outcome.evaluations, 2 * iterations);
    return outcome;
}

#define PLAY(facts, outcome, script_, ...)                                                                             \
    const stage stages_##script_[] = {__VA_ARGS__};                                                                    \
    script script_ = {.stage = stages_##script_, .n = sizeof stages_##script_ / sizeof(stage)};                        \
    co_outcome outcome = play(facts, &script_)

#define ENDS(stop_, iterations_, value_) .stop = stop_, .iterations = iterations_, .value = value_

enum { SETTLED = CURVOPT_STOP_SETTLED, CONVERGED = CURVOPT_STOP_CONVERGED, LIMIT = CURVOPT_STOP_LIMIT };

static void test_coarse_level_is_one_stage(void **state) {
    (void)state;
    PLAY(&usual, end, s, {ENDS(SETTLED, 12, 50)});
    assert_string_equal(s.log, "L");
    CHECK_INT(end.stop, SETTLED);
    CHECK_INT(s.limit[0], 1000);
}

static void test_last_level_settles(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_last = 1;
    PLAY(&f, end, s, {ENDS(SETTLED, 12, 50)}, {ENDS(CONVERGED, 7, 49)});
    assert_string_equal(s.log, "LFL");
    CHECK_INT(end.stop, CONVERGED);
    CHECK_INT(s.limit[1], 988);
}

/* Where faces have folded the shape forms once more, if the first stage ended well; however the second one ends, the
 * better shape is chosen. */
static void test_a_shape_that_folds_forms_again(void **state) {
    (void)state;
    const stage ends_twice[] = {{ENDS(SETTLED, 12, 50)}, {ENDS(SETTLED, 9, 50)}, {ENDS(CONVERGED, 7, 49)}},
                ends_once[] = {{ENDS(SETTLED, 12, 50)}, {ENDS(LIMIT, 9, 50)}}, never[] = {{ENDS(LIMIT, 12, 50)}};
    script plays[] = {{.stage = ends_twice, .n = 3}, {.stage = ends_once, .n = 2}, {.stage = never, .n = 1}};
    const char *logs[] = {"LELCFL", "LELC", "L"};
    co_level_facts f = usual;
    f.is_last = 1;
    for (int k = 0; k < 3; k++) {
        plays[k].is_uneven = 1;
        CHECK_INT(play(&f, &plays[k]).stop, k == 0 ? CONVERGED : LIMIT);
        assert_string_equal(plays[k].log, logs[k]);
    }
}

static void test_a_first_stage_that_fails_is_the_last(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_last = 1;
    PLAY(&f, end, s, {ENDS(LIMIT, 1000, 50)});
    assert_string_equal(s.log, "L");
    CHECK_INT(end.stop, LIMIT);
}

/* Along normals Newton's method has the first word. */
static void test_normals(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_last = f.is_final = f.is_on_normals = 1;
    PLAY(&f, end, s, {ENDS(CONVERGED, 4, 40), .verdict = CO_STEP_KEEP});
    assert_string_equal(s.log, "NR");
    CHECK_INT(end.stop, CONVERGED);
    CHECK_INT(s.limit[0], 1000);
}

/* A plateau is no end: while the certificate is not met both methods go on. */
static void test_newton_goes_on_while_not_stationary(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_last = f.is_final = 1;
    PLAY(&f, end, s, {ENDS(SETTLED, 6, 60)}, {ENDS(SETTLED, 1, 50)}, {ENDS(SETTLED, 15, 40), .left = 1e-3},
         {ENDS(SETTLED, 9, 39)}, {ENDS(SETTLED, 4, 30), .left = 1e-8});
    assert_string_equal(s.log, "LFLNRDLNRD");
    CHECK_INT(end.stop, SETTLED);
}

static void test_newton_by_finer_rules(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_last = f.is_final = 1;
    PLAY(&f, end, s, {ENDS(SETTLED, 6, 60)}, {ENDS(SETTLED, 1, 50)},
         {ENDS(CONVERGED, 15, 40), .verdict = CO_STEP_CHANGED}, {ENDS(CONVERGED, 4, 39)});
    assert_string_equal(s.log, "LFLNRNR");
    CHECK_INT(end.stop, CONVERGED);
}

/* A fold that is found at the end is no result. */
static void test_a_fold_at_the_end(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_last = f.is_final = f.is_on_normals = 1;
    PLAY(&f, end, s, {ENDS(CONVERGED, 4, 40), .verdict = CO_STEP_STOP});
    assert_string_equal(s.log, "NR");
    CHECK_INT(end.stop, CURVOPT_STOP_UNRESOLVED);
}

/* It ends after so many rounds, whatever is left. */
static void test_rounds_are_limited(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_last = f.is_final = 1;
    stage stages[20] = {{ENDS(SETTLED, 6, 60)}, {ENDS(SETTLED, 1, 50)}};
    int n = 2;
    for (int round = 0; round <= CO_LEVEL_SCHEDULE_ROUNDS; round++) {
        stages[n++] = (stage){ENDS(SETTLED, 3, 40), .left = 1};
        if (round < CO_LEVEL_SCHEDULE_ROUNDS)
            stages[n++] = (stage){ENDS(SETTLED, 3, 40)};
    }
    script s = {.stage = stages, .n = n};
    CHECK_INT(play(&f, &s).stop, SETTLED);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_which_stages_there_are),
        cmocka_unit_test(test_tolerances),
        cmocka_unit_test(test_coarse_level_is_one_stage),
        cmocka_unit_test(test_last_level_settles),
        cmocka_unit_test(test_a_shape_that_folds_forms_again),
        cmocka_unit_test(test_a_first_stage_that_fails_is_the_last),
        cmocka_unit_test(test_normals),
        cmocka_unit_test(test_newton_goes_on_while_not_stationary),
        cmocka_unit_test(test_newton_by_finer_rules),
        cmocka_unit_test(test_a_fold_at_the_end),
        cmocka_unit_test(test_rounds_are_limited),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
