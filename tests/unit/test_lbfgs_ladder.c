/* Limits, cancelling, and what happens when a step fails. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "curvopt.h"
#include "lbfgs_problem.h"
#include "optimize/step_control.h"

/* --------------------------------------------------------------------------------------- limits and cancelling -- */

static void test_first_step_is_as_long_as_the_cap(void **state) {
    (void)state;
    problem p = {.shape = QUADRATIC, .n = 5, .condition = 1};
    run r = {.options = usual_options};
    r.options.max_step = 0.5;
    r.options.max_iterations = 1;
    problem_minimize(&p, &r);
    CHECK_NEAR(problem_step_length(&p, p.first_trial), 0.5, 1e-15);
}

static co_step_verdict settle_watching_the_cap(void *context, const co_iterate *before, co_iterate *now,
                                               int iteration) {
    problem *p = context;
    CHECK_TRUE(p->longest <= 0.01 * (1 + 1e-9));
    return problem_settle(context, before, now, iteration);
}

static void test_no_trial_is_longer_than_the_cap(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK, .n = 10};
    run r = {.options = usual_options};
    r.options.max_step = 0.01;
    r.options.max_iterations = 300;
    curvopt_error error;
    co_objective f = {.context = &p,
                      .n = 10,
                      .evaluate = problem_evaluate_at,
                      .step_length = problem_step_length,
                      .review_step = settle_watching_the_cap,
                      .report = problem_report};
    for (int i = 0; i < p.n; i++)
        p.x[i] = r.x[i] = i % 2 ? 1 : -1.2;
    r.now = (co_iterate){.x = r.x, .gradient = r.g};
    r.now.value = p.value = problem_evaluate(&p, r.x, r.g);
    CHECK_OK(co_lbfgs(&f, &r.options, &r.now, &r.result, &error), &error);
    CHECK_TRUE(r.result.iterations > 100);
    CHECK_TRUE(r.now.value < 100);
}

static void test_iteration_limit_counts_accepted_steps(void **state) {
    (void)state;
    for (int limit = 0; limit <= 3; limit++) {
        problem p = {.shape = ROSENBROCK, .n = 4};
        run r = {.options = usual_options};
        r.options.max_iterations = limit;
        problem_minimize(&p, &r);
        CHECK_INT(r.result.stop, CURVOPT_STOP_LIMIT);
        CHECK_INT(r.result.iterations, limit);
        CHECK_INT(p.reports, limit);
        CHECK_TRUE((r.result.evaluations > 0) == (limit > 0));
    }
}

static void test_start_at_the_minimum_has_converged(void **state) {
    (void)state;
    problem p = {.shape = QUADRATIC, .n = 3, .condition = 1};
    run r = {.options = usual_options};
    r.options.gradient_tolerance = 100;
    problem_minimize(&p, &r);
    CHECK_INT(r.result.stop, CURVOPT_STOP_CONVERGED);
    CHECK_INT(r.result.iterations, 0);
    CHECK_INT(r.result.evaluations, 0);
}

static void test_report_cancels_and_the_iterate_stays(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK, .n = 10, .cancel_at = 7};
    run r = {.options = usual_options};
    problem_minimize(&p, &r);
    CHECK_INT(r.result.stop, CURVOPT_STOP_CANCELLED);
    CHECK_INT(r.result.iterations, 7);
    CHECK_INT(p.reports, 7);
    assert_memory_equal(r.x, p.x, sizeof(double) * 10);
}

/* ------------------------------------------------------------------------------------------------- the ladder -- */

/* The metric's directions lead nowhere: history is dropped, a scaled gradient step taken. */
static void test_failed_search_falls_back_to_the_gradient(void **state) {
    (void)state;
    problem p = {.shape = QUADRATIC, .n = 8, .condition = 50, .only_along_gradient = 1};
    run r = {.options = usual_options};
    r.options.max_iterations = 6;
    problem_minimize(&p, &r);
    CHECK_INT(r.result.stop, CURVOPT_STOP_LIMIT);
    CHECK_INT(r.result.iterations, 6);
    CHECK_INT(r.result.restarts, 5); /* all but the first, which had no history */
}

/* Settling moves x along directions that do not change the function; here so far that the pair (s, y) which is learnt
 * has a y whose square is 0, and the direction of the metric is not a number. */
static double almost_linear(void *context, const double *x, double *gradient) {
    ((problem *)context)->calls++;
    gradient[0] = -1;
    gradient[1] = 1e-170 * x[1];
    return 10 - x[0];
}

static void almost_linear_at(void *context, co_iterate *at) {
    at->value = almost_linear(context, at->x, at->gradient);
}

static co_step_verdict settle_far_away(void *context, const co_iterate *before, co_iterate *now, int iteration) {
    (void)context;
    (void)before;
    if (iteration == 1) {
        now->x[1] += 1;
        now->gradient[1] = 1e-170 * now->x[1];
    }
    return CO_STEP_KEEP;
}

static int report_nothing(void *context, const co_iterate *now, const co_step_record *record) {
    (void)context;
    (void)now;
    (void)record;
    return 0;
}

static void test_direction_that_does_not_descend_is_replaced_by_the_gradient(void **state) {
    (void)state;
    problem p = {.n = 2};
    double x[2] = {0, 0}, g[2];
    co_iterate now = {.x = x, .gradient = g, .value = almost_linear(&p, x, g)};
    co_method_options options = usual_options;
    co_outcome result;
    curvopt_error error;
    co_objective f = {.context = &p,
                      .n = 2,
                      .evaluate = almost_linear_at,
                      .step_length = problem_step_length,
                      .review_step = settle_far_away,
                      .report = report_nothing};
    options.max_iterations = 2;
    options.max_step = 1;
    CHECK_OK(co_lbfgs(&f, &options, &now, &result, &error), &error);
    CHECK_INT(result.stop, CURVOPT_STOP_LIMIT);
    CHECK_INT(result.iterations, 2);
    CHECK_INT(result.restarts, 1);
    CHECK_TRUE(x[0] > 1 && x[0] <= 2); /* one gradient step to the cap each time */
}

/* When the preconditioner was asked for, by steps that stood; it is the inverse of the quadratic's matrix, a little
 * off. */
typedef struct preconditioned {
    problem p; /* first, so that it is the callbacks' context */
    int n_updates, at[32], applied, wants_hessian;
    double unit;     /* it is this multiple of the unit matrix instead; 0: it is not */
    double softness; /* above 1: it is so many times too soft */
} preconditioned;

static int precondition(void *context, const double *in, double *out) {
    preconditioned *c = context;
    c->applied++;
    for (int i = 0; i < c->p.n; i++) {
        const double exact = 1 / pow(c->p.condition, (double)i / c->p.n);
        out[i] = in[i] * (c->unit > 0 ? c->unit : fmax(1, c->softness) * (i % 2 ? 0.8 : 1.2) * exact);
    }
    return 0;
}

static void update(void *context, const co_iterate *now, double step_excess, int by_hessian) {
    preconditioned *c = context;
    CHECK_NEAR(now->x[0], c->p.x[0], 0);
    CHECK_BETWEEN(step_excess, 0, 1);
    CHECK_INT(by_hessian, c->wants_hessian);
    c->at[c->n_updates++] = c->p.reports;
}

/* From 5 in all coordinates, with r->options, into r. */
static void minimize_preconditioned(preconditioned *c, run *r) {
    curvopt_error error;
    co_objective f = {.context = c,
                      .n = (size_t)c->p.n,
                      .evaluate = problem_evaluate_at,
                      .step_length = problem_step_length,
                      .review_step = problem_settle,
                      .precondition = precondition,
                      .update_preconditioner = update,
                      .report = problem_report};
    for (int i = 0; i < c->p.n; i++)
        c->p.x[i] = r->x[i] = 5;
    r->now = (co_iterate){.x = r->x, .gradient = r->g};
    r->now.value = c->p.value = problem_evaluate(&c->p, r->x, r->g);
    c->p.told_value = r->now.value;
    CHECK_OK(co_lbfgs(&f, &r->options, &r->now, &r->result, &error), &error);
}

/* Every so many steps, the first time before the first one; each direction is by it. */
static void test_preconditioner_is_updated_at_regular_steps(void **state) {
    (void)state;
    for (int every = 1; every <= 4; every++) {
        preconditioned c = {.p = {.shape = QUADRATIC, .n = 12, .condition = 1e4}};
        run r = {.options = usual_options};
        r.options.update_every = every;
        r.options.by_hessian = c.wants_hessian = every % 2;
        r.options.max_iterations = 7;
        r.options.gradient_tolerance = 0;
        minimize_preconditioned(&c, &r);
        CHECK_INT(r.result.iterations, 7);
        CHECK_INT(c.applied, 7);
        CHECK_INT(c.n_updates, (7 + every - 1) / every);
        for (int k = 0; k < c.n_updates; k++)
            CHECK_INT(c.at[k], k * every);
        CHECK_BETWEEN(r.now.value - 1, 0, 1e-6); /* without it 7 steps leave .1 and more */
    }
}

/* By a matrix that is much too soft a small part of each direction stands: a search begins there, once a step has told
 * what to expect. */
static void test_searches_begin_where_the_last_decrease_says(void **state) {
    (void)state;
    int evaluations[2];
    for (int from_all = 0; from_all < 2; from_all++) {
        preconditioned c = {.p = {.shape = QUADRATIC, .n = 12, .condition = 100}, .unit = 0.2};
        run r = {.options = usual_options};
        co_tuning tuning = co_tuning_defaults;
        if (from_all)
            tuning.lbfgs_least_part = 1;
        r.options.tuning = &tuning;
        r.options.memory = 0; /* or it would learn */
        r.options.update_every = 100;
        r.options.max_iterations = 10;
        minimize_preconditioned(&c, &r);
        evaluations[from_all] = r.result.evaluations;
    }
    CHECK_BETWEEN(evaluations[0], 10, 16);
    CHECK_BETWEEN(evaluations[1], 20, 100);
}

/* A matrix that is too soft is scaled by what the newest pair has found: directions are as long as by the matrix that
 * it ought to be, and searches need not cut them. */
static void test_a_pair_says_by_how_much_a_matrix_is_too_soft(void **state) {
    (void)state;
    int evaluations[2] = {0, 0};
    for (int is_scaled = 0; is_scaled < 2; is_scaled++) {
        for (double softness = 1; softness <= 16; softness *= 2) {
            preconditioned c = {.p = {.shape = QUADRATIC, .n = 12, .condition = 1e4}, .softness = softness};
            run r = {.options = usual_options};
            r.options.is_scaled = is_scaled;
            r.options.memory = 3;
            r.options.update_every = 100;
            r.options.max_iterations = 9;
            r.options.max_step = 1e3;
            minimize_preconditioned(&c, &r);
            CHECK_BETWEEN(r.now.value - 1, 0, 1e-9);
            evaluations[is_scaled] += r.result.evaluations;
            CHECK_INT(c.applied, (1 + is_scaled) * r.result.iterations - is_scaled); /* the first step has no pair */
        }
    }
    CHECK_BETWEEN(evaluations[0], 35, 60);
    CHECK_BETWEEN(evaluations[1], 20, 28);
}

static void linear_at(void *context, co_iterate *at) {
    ((problem *)context)->calls++;
    at->value = 10 - at->x[0];
    at->gradient[0] = -1;
}

/* Where the gradient does not change there is no pair to learn from, and no history that would have to be dropped. */
static void test_a_linear_function_teaches_nothing(void **state) {
    (void)state;
    problem p = {.n = 1};
    double x = 0, g = -1;
    co_iterate now = {.x = &x, .gradient = &g, .value = 10};
    co_method_options options = usual_options;
    co_outcome result;
    curvopt_error error;
    co_objective f = {.context = &p,
                      .n = 1,
                      .evaluate = linear_at,
                      .step_length = problem_step_length,
                      .review_step = problem_settle,
                      .report = report_nothing};
    options.max_iterations = 4;
    options.max_step = 0.5;
    CHECK_OK(co_lbfgs(&f, &options, &now, &result, &error), &error);
    CHECK_INT(result.iterations, 4);
    CHECK_INT(result.restarts, 0);
    CHECK_NEAR(x, 2, 1e-12);
}

static void test_nothing_works_at_the_start_is_a_stall(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK, .n = 4, .only_along_gradient = 1};
    run r = {.options = usual_options};
    p.undefined_after = -1; /* reports >= -1 from the start on */
    problem_minimize(&p, &r);
    CHECK_INT(r.result.stop, CURVOPT_STOP_STALLED);
    CHECK_INT(r.result.iterations, 0);
    CHECK_INT(r.result.restarts, 0);
    assert_memory_equal(r.x, p.x, sizeof(double) * 4);
}

static void test_nothing_works_later_is_a_stall_at_the_last_iterate(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK, .n = 4, .undefined_after = 5};
    run r = {.options = usual_options};
    problem_minimize(&p, &r);
    CHECK_INT(r.result.stop, CURVOPT_STOP_STALLED);
    CHECK_INT(r.result.iterations, 5);
    CHECK_INT(r.result.restarts, 1); /* first the history goes, then the search for a gradient step fails as well */
    assert_memory_equal(r.x, p.x, sizeof(double) * 4);
}

/* ------------------------------------------------------------------------------------------------ settlements -- */

static void test_rejected_step_is_taken_back_and_the_next_one_is_shorter(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK, .n = 4, .verdict = CO_STEP_REJECT, .verdict_from = 4, .verdict_to = 5};
    run r = {.options = usual_options};
    r.options.max_step = 0.04;
    r.options.max_iterations = 3;
    problem_minimize(&p, &r);
    double before[MOST];
    memcpy(before, r.x, sizeof before);
    p = (problem){.shape = ROSENBROCK, .n = 4, .verdict = CO_STEP_REJECT, .verdict_from = 4, .verdict_to = 5};
    r.options.max_iterations = 4;
    problem_minimize(&p, &r);
    CHECK_INT(p.settles, 5);
    CHECK_INT(r.result.iterations, 4);
    double longest = 0;
    for (int i = 0; i < 4; i++)
        longest = fmax(longest, fabs(r.x[i] - before[i]));
    CHECK_BETWEEN(longest, 1e-6, 0.01 * (1 + 1e-12));
    CHECK_NEAR(problem_step_length(&p, p.first_trial), 0.01, 1e-15); /* no history: a quarter of the cap */
}

static void test_endless_rejection_ends_unresolved_at_the_start(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK, .n = 4, .verdict = CO_STEP_REJECT, .verdict_from = 1, .verdict_to = 1000};
    run r = {.options = usual_options};
    problem_minimize(&p, &r);
    CHECK_INT(r.result.stop, CURVOPT_STOP_UNRESOLVED);
    CHECK_INT(r.result.iterations, 0);
    CHECK_BETWEEN(p.settles, 10, 15); /* 4^-12 < 1e-7 */
    CHECK_INT(p.reports, 0);
    for (int i = 0; i < 4; i++)
        CHECK_NEAR(r.x[i], i % 2 ? 1 : -1.2, 0);
}

static void test_stop_ends_unresolved_at_the_iterate_before(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK, .n = 4, .verdict = CO_STEP_STOP, .verdict_from = 3, .verdict_to = 4};
    run r = {.options = usual_options};
    problem_minimize(&p, &r);
    CHECK_INT(r.result.stop, CURVOPT_STOP_UNRESOLVED);
    CHECK_INT(r.result.iterations, 2);
    CHECK_INT(p.settles, 3);
    assert_memory_equal(r.x, p.x, sizeof(double) * 4);
}

static void test_changed_function_makes_history_void(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK, .n = 4, .verdict = CO_STEP_CHANGED, .verdict_from = 5, .verdict_to = 6};
    run r = {.options = usual_options};
    double d[MOST], g[MOST];
    r.options.max_iterations = 5;
    problem_minimize(&p, &r);
    memcpy(g, p.g, sizeof g);
    p = (problem){.shape = ROSENBROCK, .n = 4, .verdict = CO_STEP_CHANGED, .verdict_from = 5, .verdict_to = 6};
    r.options.max_iterations = 6;
    problem_minimize(&p, &r);
    memcpy(d, p.first_trial, sizeof d);
    memcpy(p.g, g, sizeof g);
    CHECK_NEAR(problem_off_gradient(&p, d), 0, 1e-7);
    p = (problem){.shape = ROSENBROCK, .n = 4};
    problem_minimize(&p, &r);
    memcpy(p.g, g, sizeof g);
    CHECK_TRUE(problem_off_gradient(&p, p.first_trial) > 1e-3); /* without the change the metric bends it */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_first_step_is_as_long_as_the_cap),
        cmocka_unit_test(test_no_trial_is_longer_than_the_cap),
        cmocka_unit_test(test_iteration_limit_counts_accepted_steps),
        cmocka_unit_test(test_start_at_the_minimum_has_converged),
        cmocka_unit_test(test_report_cancels_and_the_iterate_stays),
        cmocka_unit_test(test_failed_search_falls_back_to_the_gradient),
        cmocka_unit_test(test_direction_that_does_not_descend_is_replaced_by_the_gradient),
        cmocka_unit_test(test_preconditioner_is_updated_at_regular_steps),
        cmocka_unit_test(test_searches_begin_where_the_last_decrease_says),
        cmocka_unit_test(test_a_pair_says_by_how_much_a_matrix_is_too_soft),
        cmocka_unit_test(test_a_linear_function_teaches_nothing),
        cmocka_unit_test(test_nothing_works_at_the_start_is_a_stall),
        cmocka_unit_test(test_nothing_works_later_is_a_stall_at_the_last_iterate),
        cmocka_unit_test(test_rejected_step_is_taken_back_and_the_next_one_is_shorter),
        cmocka_unit_test(test_endless_rejection_ends_unresolved_at_the_start),
        cmocka_unit_test(test_stop_ends_unresolved_at_the_iterate_before),
        cmocka_unit_test(test_changed_function_makes_history_void),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
