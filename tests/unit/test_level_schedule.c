/* The schedule of a level: the plan as data, and how it is run, on a script. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "check.h"
#include "curvopt.h"

#include "solve/level_schedule.h"

static const co_level_facts usual = {.has_hessian = 1,
                                     .is_linear = 1,
                                     .n_variables = 300,
                                     .max_iterations = 1000,
                                     .gradient_tolerance = 1e-9,
                                     .decrement_tolerance = 3e-7,
                                     .max_step = 0.2};

/* --------------------------------------------------------------------------------------- the plan -- */

static void test_what_follows_the_first_stage(void **state) {
    (void)state;
    for (int bits = 0; bits < 32; bits++) {
        co_level_facts f = usual;
        f.is_last = bits & 1;
        f.is_third_order = bits >> 1 & 1;
        f.is_linear = bits >> 2 & 1;
        f.expects_saddle = bits >> 3 & 1;
        f.has_hessian = bits >> 4 & 1;
        co_end_game expected = CO_END_NONE;
        if (f.has_hessian && f.is_third_order && (f.is_last || f.is_linear))
            expected = CO_END_NEWTON;
        else if (f.has_hessian && !f.is_third_order && f.is_last)
            expected = f.expects_saddle ? CO_END_FINER_RULES : CO_END_SLIDE;
        CHECK_INT(co_level_schedule_make(&f, &co_tuning_defaults).end, expected);
    }
}

static void test_tolerances(void **state) {
    (void)state;
    const co_tuning *t = &co_tuning_defaults;
    co_level_facts f = usual;
    co_level_schedule s = co_level_schedule_make(&f, t);
    CHECK_NEAR(s.first.decrement_tolerance, t->coarse_decrement, 0);
    CHECK_NEAR(s.first.settled_decrease, t->coarse_settled, 0);
    CHECK_INT(s.first.settled_steps, t->slow_steps);
    f.is_last = 1;
    s = co_level_schedule_make(&f, t);
    CHECK_NEAR(s.first.decrement_tolerance, 3e-7, 0); /* the user's */
    CHECK_NEAR(s.first.settled_decrease, t->coarse_settled, 0);
    CHECK_INT(s.first.settled_steps, t->quick_steps); /* sliding follows */
    CHECK_INT(s.goes_on_slowly, 1);
    CHECK_NEAR(s.slow.settled_decrease, 3e-7 * t->final_settled, 0);
    CHECK_INT(s.slide.memory, 0);
    CHECK_INT(s.slide.update_every, 1);
    f.expects_plateau = 1; /* near a saddle the first stage has patience */
    s = co_level_schedule_make(&f, t);
    CHECK_NEAR(s.first.settled_decrease, 3e-7 * t->final_settled, 0);
    CHECK_INT(s.first.settled_steps, t->slow_steps);
    CHECK_INT(s.goes_on_slowly, 0);
    CHECK_NEAR(s.stationary, 3e-7 * t->stationary, 0);
}

static void test_third_order_hands_over(void **state) {
    (void)state;
    const co_tuning *t = &co_tuning_defaults;
    co_level_facts f = usual;
    f.is_third_order = f.is_first = 1;
    co_level_schedule s = co_level_schedule_make(&f, t);
    CHECK_NEAR(s.first.settled_decrease, t->shape_settled, 0);
    CHECK_INT(s.first.settled_steps, t->quick_steps);
    CHECK_INT(s.rounds, 0);
    CHECK_NEAR(s.newton.settled_decrease, t->coarse_settled, 0);
    f.is_last = 1;
    f.is_first = 0;
    s = co_level_schedule_make(&f, t);
    CHECK_INT(s.first.settled_steps, 1); /* after a single step */
    CHECK_TRUE(s.first.settled_decrease == INFINITY);
    CHECK_INT(s.rounds, CO_LEVEL_SCHEDULE_ROUNDS);
    f.is_first = 1; /* but not where the first cage is all there is */
    CHECK_INT(co_level_schedule_make(&f, t).first.settled_steps, t->quick_steps);
    f.n_variables = t->many_variables + 1; /* nor where factors cost most */
    f.is_first = 0;
    CHECK_NEAR(co_level_schedule_make(&f, t).first.settled_decrease, t->coarse_settled, 0);
    f.is_linear = 0; /* `plane`: L-BFGS to its end */
    CHECK_NEAR(co_level_schedule_make(&f, t).first.settled_decrease, 3e-7 * t->final_settled, 0);
}

/* ------------------------------------------------------------------------------------ running it -- */

/* What each call of run() is to come to. */
typedef struct stage {
    int stop, iterations;
    double value;
    double left;     /* decrement there */
    double jacobian; /* least there; 0: 1 */
    int verdict;     /* of review_for_figures() there: co_step_verdict */
} stage;

typedef struct script {
    const stage *stage;
    int n, at;
    char log[200]; /* a letter for every call: L, N run; R review; D decrement; H, h Hessian on, off; s, b remember; S,
                      B go */
    int limit[20]; /* max_iterations of each run */
    double settled[20];
    int start, best; /* stages that were remembered */
    int place;       /* the stage that the iterate is at */
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
    s->settled[s->at] = options->settled_decrease;
    s->place = s->at++;
    *outcome = (co_outcome){.stop = s->stage[s->place].stop,
                            .iterations = s->stage[s->place].iterations,
                            .evaluations = 2 * s->stage[s->place].iterations};
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

static void use_hessian(void *context, int on) {
    note(context, on ? 'H' : 'h');
}

static double value(void *context) {
    const script *s = context;
    return s->stage[s->place].value;
}

static double min_jacobian(void *context) {
    const script *s = context;
    double jacobian = s->stage[s->place].jacobian;
    return jacobian > 0 ? jacobian : 1;
}

static void remember(void *context, co_milestone milestone) {
    script *s = context;
    note(s, milestone == CO_MILESTONE_START ? 's' : 'b');
    *(milestone == CO_MILESTONE_START ? &s->start : &s->best) = s->place;
}

static int32_t go_to(void *context, co_milestone milestone, curvopt_error *error) {
    script *s = context;
    (void)error;
    note(s, milestone == CO_MILESTONE_START ? 'S' : 'B');
    s->place = milestone == CO_MILESTONE_START ? s->start : s->best;
    return CURVOPT_OK;
}

static co_outcome play(const co_level_facts *facts, script *s) {
    const co_level_schedule schedule = co_level_schedule_make(facts, &co_tuning_defaults);
    const co_scheduled on = {.context = s,
                             .run = run,
                             .review_for_figures = review,
                             .decrement = decrement,
                             .use_hessian = use_hessian,
                             .value = value,
                             .min_jacobian = min_jacobian,
                             .remember = remember,
                             .go_to = go_to};
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

static void test_a_first_stage_that_fails_is_the_last(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_last = 1;
    PLAY(&f, end, s, {ENDS(LIMIT, 1000, 50)});
    assert_string_equal(s.log, "L");
    CHECK_INT(end.stop, LIMIT);
}

static void test_finer_rules(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_last = f.expects_saddle = 1;
    PLAY(&f, end, s, {ENDS(SETTLED, 10, 50), .verdict = CO_STEP_CHANGED}, {ENDS(CONVERGED, 3, 49)});
    assert_string_equal(s.log, "LRL");
    CHECK_INT(end.stop, CONVERGED);
    CHECK_INT(s.limit[1], 990);
    PLAY(&f, other, t, {ENDS(SETTLED, 10, 50), .verdict = CO_STEP_KEEP});
    assert_string_equal(t.log, "LR");
    CHECK_INT(other.stop, SETTLED);
}

/* Sliding goes on for a few steps while the decrement is not met. */
static void test_sliding(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_last = 1;
    PLAY(&f, end, s, {ENDS(SETTLED, 10, 50)}, {ENDS(SETTLED, 20, 49.99), .left = 1e-4},
         {ENDS(SETTLED, 5, 49.98), .left = 1e-6});
    assert_string_equal(s.log, "LsHLRDbLRDbhB");
    CHECK_INT(end.stop, CONVERGED);
    CHECK_INT(s.limit[1], co_tuning_defaults.sliding_steps);
    CHECK_INT(s.limit[2], co_tuning_defaults.sliding_more_steps);
    CHECK_NEAR(s.settled[1], 3e-7 * co_tuning_defaults.sliding_settled, 0);
    CHECK_TRUE(s.settled[2] == INFINITY);
    CHECK_INT(s.place, 2);
}

/* A cage that is too distorted does not count; then it goes on slowly from the start. */
static void test_sliding_that_distorts_is_undone(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_last = 1;
    PLAY(&f, end, s, {ENDS(SETTLED, 10, 50)}, {ENDS(SETTLED, 20, 49.9), .left = 1e-7, .jacobian = 0.4},
         {ENDS(LIMIT, 30, 49.8)}, {ENDS(SETTLED, 7, 49.95), .left = 3e-4});
    assert_string_equal(s.log, "LsHLRDLhSLD");
    CHECK_INT(end.stop, SETTLED);
    CHECK_NEAR(s.settled[3], 3e-7 * co_tuning_defaults.final_settled, 0);
    CHECK_INT(s.place, 3);
}

/* Where sliding has come nearer than going on slowly does, that is taken. */
static void test_sliding_that_came_nearer(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_last = 1;
    PLAY(&f, end, s, {ENDS(SETTLED, 10, 50)}, {ENDS(SETTLED, 20, 49.9), .left = 6e-5}, {ENDS(LIMIT, 30, 49.8)},
         {ENDS(SETTLED, 7, 49.95), .left = 3e-4});
    assert_string_equal(s.log, "LsHLRDbLhSLDB");
    CHECK_INT(end.stop, SETTLED);
    CHECK_INT(s.place, 1);
}

static void test_newton_on_a_coarse_level(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_third_order = f.is_first = 1;
    PLAY(&f, end, s, {ENDS(SETTLED, 5, 50)}, {ENDS(SETTLED, 5, 40)});
    assert_string_equal(s.log, "LN");
    CHECK_INT(end.stop, SETTLED);
}

/* A plateau is no end: while the certificate is not met both methods go on. */
static void test_newton_goes_on_while_not_stationary(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_third_order = f.is_last = 1;
    PLAY(&f, end, s, {ENDS(SETTLED, 1, 50)}, {ENDS(SETTLED, 15, 40), .left = 1e-3}, {ENDS(SETTLED, 9, 39)},
         {ENDS(SETTLED, 4, 30), .left = 1e-8});
    assert_string_equal(s.log, "LNRDLNRD");
    CHECK_INT(end.stop, SETTLED);
    CHECK_NEAR(s.settled[1], 3e-7 * co_tuning_defaults.final_settled, 0);
    CHECK_NEAR(s.settled[3], 3e-7 * co_tuning_defaults.final_settled, 0);
}

static void test_newton_by_finer_rules(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_third_order = f.is_last = 1;
    PLAY(&f, end, s, {ENDS(SETTLED, 1, 50)}, {ENDS(CONVERGED, 15, 40), .verdict = CO_STEP_CHANGED},
         {ENDS(CONVERGED, 4, 39)});
    assert_string_equal(s.log, "LNRNR");
    CHECK_INT(end.stop, CONVERGED);
}

/* It ends after so many rounds, whatever is left. */
static void test_rounds_are_limited(void **state) {
    (void)state;
    co_level_facts f = usual;
    f.is_third_order = f.is_last = 1;
    stage stages[20] = {{ENDS(SETTLED, 1, 50)}};
    int n = 1;
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
        cmocka_unit_test(test_what_follows_the_first_stage),
        cmocka_unit_test(test_tolerances),
        cmocka_unit_test(test_third_order_hands_over),
        cmocka_unit_test(test_coarse_level_is_one_stage),
        cmocka_unit_test(test_a_first_stage_that_fails_is_the_last),
        cmocka_unit_test(test_finer_rules),
        cmocka_unit_test(test_sliding),
        cmocka_unit_test(test_sliding_that_distorts_is_undone),
        cmocka_unit_test(test_sliding_that_came_nearer),
        cmocka_unit_test(test_newton_on_a_coarse_level),
        cmocka_unit_test(test_newton_goes_on_while_not_stationary),
        cmocka_unit_test(test_newton_by_finer_rules),
        cmocka_unit_test(test_rounds_are_limited),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
