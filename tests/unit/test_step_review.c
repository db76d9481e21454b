/* The review of steps, on a function that lies by its rule. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "curvopt.h"

#include "optimize/damped_newton.h"
#include "optimize/lbfgs.h"
#include "solve/step_review.h"

/* f(x) = x^2 + 1, but by rules below 2 there is a hole at x > 3: the coarser, the deeper. */
typedef struct toy {
    int rule;
    int finest;      /* rules above this are needed and not to be had: not resolved */
    int is_blind;    /* resolve() sees nothing */
    int fails;       /* resolve() is out of memory */
    int may_coarsen; /* coarsen() has something to take back */
    int resolves, coarsens, evaluations;
} toy;

static double value_of(int rule, double x) {
    double hole = rule < 2 && x > 3 ? 100.0 / (1 + rule) * (x - 3) : 0;
    return x * x + 1 - hole;
}

static void evaluate(void *context, co_iterate *at) {
    toy *t = context;
    t->evaluations++;
    at->value = value_of(t->rule, at->x[0]);
    if (at->gradient)
        at->gradient[0] = 2 * at->x[0];
}

static int32_t resolve(void *context, const double *x, int *resolved, int *changed, double *defect,
                       curvopt_error *error) {
    toy *t = context;
    int before = t->rule;
    t->resolves++;
    if (t->fails)
        return co_status_no_memory(error);
    while (t->rule < 2 && !t->is_blind && value_of(t->rule, x[0]) != value_of(2, x[0]))
        t->rule++;
    *resolved = t->rule <= t->finest;
    *changed = t->rule != before;
    *defect = 0.01 * t->rule;
    return CURVOPT_OK;
}

static int32_t coarsen(void *context, int *changed, curvopt_error *error) {
    toy *t = context;
    (void)error;
    t->coarsens++;
    *changed = t->may_coarsen;
    t->may_coarsen = 0;
    return CURVOPT_OK;
}

typedef struct fixture {
    toy toy;
    co_step_review review;
    double x, g;
    co_iterate now;
    curvopt_error error;
} fixture;

static void begin(fixture *s, double at) {
    *s = (fixture){.toy = {.finest = 2}};
    const co_reviewed f = {.context = &s->toy, .n = 1, .evaluate = evaluate, .resolve = resolve, .coarsen = coarsen};
    CHECK_OK(co_step_review_create(&co_tuning_defaults, &f, &s->review, &s->error), &s->error);
    co_step_review_begin(&s->review, &at, 0.5);
    s->now = (co_iterate){.x = &s->x, .gradient = &s->g};
}

static co_step_verdict check(fixture *s, double at, int32_t expected) {
    co_step_verdict verdict;
    s->x = at;
    evaluate(&s->toy, &s->now);
    CHECK_INT(co_step_review_check(&s->review, &s->now, &verdict, &s->error), expected);
    return verdict;
}

static void test_progress_stands(void **state) {
    (void)state;
    fixture s;
    begin(&s, 2);
    CHECK_INT(check(&s, 1, CURVOPT_OK), CO_STEP_KEEP);
    CHECK_NEAR(s.review.safe[0], 1, 0);
    CHECK_NEAR(s.review.first[0], 2, 0);
    CHECK_NEAR(s.review.defect, 0, 0);
    CHECK_INT(s.toy.coarsens, 1);
    co_step_review_free(&s.review);
}

/* What coarser rules took for progress, from 2 (f = 5) to 3.5 (13.25, or -36.75 by rule 0), is taken back. */
static void test_false_progress_is_taken_back(void **state) {
    (void)state;
    fixture s;
    begin(&s, 2);
    s.x = 3.5;
    evaluate(&s.toy, &s.now);
    CHECK_TRUE(s.now.value < 5); /* progress, it seems */
    CHECK_INT(check(&s, 3.5, CURVOPT_OK), CO_STEP_REJECT);
    CHECK_NEAR(s.now.x[0], 2, 0);
    CHECK_NEAR(s.now.value, 5, 0);
    CHECK_NEAR(s.now.gradient[0], 4, 0);
    CHECK_NEAR(s.review.safe[0], 2, 0);
    CHECK_INT(s.toy.rule, 2); /* it is not to be taken in again */
    co_step_review_free(&s.review);
}

/* From 6 (f = 37) to 4 (17) is progress by any rule: it stands, but the function has changed. */
static void test_true_progress_by_finer_rules(void **state) {
    (void)state;
    fixture s;
    begin(&s, 6);
    CHECK_INT(check(&s, 4, CURVOPT_OK), CO_STEP_CHANGED);
    CHECK_NEAR(s.now.value, 17, 0);
    CHECK_NEAR(s.review.safe[0], 4, 0);
    CHECK_INT(s.toy.coarsens, 0); /* what was just refined is not taken back at once */
    co_step_review_free(&s.review);
}

static void test_unresolved_and_failing(void **state) {
    (void)state;
    fixture s;
    begin(&s, 6);
    s.toy.finest = 1;
    CHECK_INT(check(&s, 4, CURVOPT_OK), CO_STEP_REJECT);
    CHECK_NEAR(s.now.x[0], 6, 0);
    s.toy.fails = 1;
    CHECK_INT(check(&s, 5, CURVOPT_ERROR_MEMORY), CO_STEP_STOP);
    CHECK_NEAR(s.now.x[0], 6, 0);
    co_step_review_free(&s.review);
}

/* At 3.1 f is 10.61, and .61 by rule 0, which a blind review takes for safe. Whatever is seen next, be it lower, higher
 * or not resolved, shows that it was not. */
static void test_fold_that_was_not_seen_in_time(void **state) {
    (void)state;
    const struct {
        double at;
        int finest;
    } cases[] = {{3.105, 2}, {3.095, 2}, {3.095, 1}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        fixture s;
        begin(&s, 2);
        s.toy.is_blind = 1;
        CHECK_INT(check(&s, 3.1, CURVOPT_OK), CO_STEP_KEEP);
        CHECK_NEAR(s.review.value, 0.61, 1e-12);
        s.toy.is_blind = 0;
        s.toy.finest = cases[k].finest;
        CHECK_INT(check(&s, cases[k].at, CURVOPT_OK), CO_STEP_STOP);
        co_step_review_free(&s.review);
    }
}

static void test_coarser_rules_change_the_function(void **state) {
    (void)state;
    fixture s;
    begin(&s, 2);
    s.toy.may_coarsen = 1;
    CHECK_INT(check(&s, 1, CURVOPT_OK), CO_STEP_CHANGED);
    CHECK_INT(check(&s, 0.5, CURVOPT_OK), CO_STEP_KEEP);
    co_step_review_free(&s.review);
}

static void test_when_a_review_is_due(void **state) {
    (void)state;
    const co_tuning *t = &co_tuning_defaults;
    fixture s;
    begin(&s, 2); /* defect 0.5 */
    const double small = t->review_step / 2, great = t->review_step * 2, alarm = t->defect_growth * 0.5 + 0.01;
    const struct {
        co_step_facts facts;
        int due;
    } cases[] = {
        {{1, 1, small, 0.5}, 0},
        {{1, 1, great, 0.5}, 1},               /* a long step */
        {{1, 0, great, 0.5}, 0},               /* without a Hessian all steps are short of where they aim */
        {{t->review_every, 1, small, 0.5}, 1}, /* in turn */
        {{t->review_every, 0, small, 0.5}, 1},
        {{1, 1, small, alarm}, 1}, /* Gauss and Bonnet object */
        {{1, 0, small, alarm}, 1},
        {{1, 1, small, (double)NAN}, 1},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        CHECK_INT(co_step_review_is_due(&s.review, &cases[k].facts), cases[k].due);
    co_step_review_free(&s.review);
}

/* ----- an optimizer under review ----- */

static double length_of(void *context, const double *d) {
    (void)context;
    return fabs(d[0]);
}

static co_step_verdict review_step(void *context, const co_iterate *before, co_iterate *now, int iteration) {
    fixture *s = context;
    co_step_verdict verdict;
    (void)before;
    (void)iteration;
    CHECK_OK(co_step_review_check(&s->review, now, &verdict, &s->error), &s->error);
    return verdict;
}

static int report(void *context, const co_iterate *now, const co_step_record *record) {
    (void)context;
    (void)now;
    (void)record;
    return 0;
}

static void evaluate_toy(void *context, co_iterate *at) {
    fixture *s = context;
    double x = at->x[0];
    evaluate(&s->toy, at);
    if (s->toy.rule < 2 && x > 3)
        at->gradient[0] -= 100.0 / (1 + s->toy.rule);
}

/* By its coarse rule the function falls without bound beyond 3; under review the method ends at the minimum all the
 * same, from either side. */
static void test_optimizer_does_not_fall_into_the_hole(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++) {
        fixture s;
        begin(&s, k ? 2.9 : 3.2);
        co_objective f = {.context = &s,
                          .n = 1,
                          .evaluate = evaluate_toy,
                          .step_length = length_of,
                          .review_step = review_step,
                          .report = report};
        const co_method_options options = {.tuning = &co_tuning_defaults,
                                           .max_iterations = 100,
                                           .gradient_tolerance = 1e-9,
                                           .settled_steps = 15,
                                           .max_step = 2,
                                           .memory = 5};
        co_outcome outcome;
        s.x = k ? 2.9 : 3.2;
        evaluate_toy(&s, &s.now);
        CHECK_OK(co_lbfgs(&f, &options, &s.now, &outcome, &s.error), &s.error);
        CHECK_INT(outcome.stop, CURVOPT_STOP_CONVERGED);
        CHECK_NEAR(s.x, 0, 1e-8);
        CHECK_TRUE(k == 1 || outcome.rejected > 0);
        co_step_review_free(&s.review);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_progress_stands),
        cmocka_unit_test(test_false_progress_is_taken_back),
        cmocka_unit_test(test_true_progress_by_finer_rules),
        cmocka_unit_test(test_unresolved_and_failing),
        cmocka_unit_test(test_fold_that_was_not_seen_in_time),
        cmocka_unit_test(test_coarser_rules_change_the_function),
        cmocka_unit_test(test_when_a_review_is_due),
        cmocka_unit_test(test_optimizer_does_not_fall_into_the_hole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
