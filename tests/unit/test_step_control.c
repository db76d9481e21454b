/* How long steps may be, and when a method has settled. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "curvopt.h"

#include "optimize/step_control.h"

/* An objective that only reviews and reports. */
typedef struct toy {
    co_step_verdict verdict;
    int cancels, reports;
    co_step_record last;
} toy;

static co_step_verdict review(void *context, const co_iterate *before, co_iterate *now, int iteration) {
    const toy *t = context;
    (void)iteration;
    if (!co_step_stands(t->verdict))
        now->value = before->value;
    return t->verdict;
}

static int report(void *context, const co_iterate *now, const co_step_record *record) {
    toy *t = context;
    (void)now;
    t->reports++;
    t->last = *record;
    return t->cancels;
}

typedef struct fixture {
    toy toy;
    co_objective f;
    double x[2], g[2];
    co_iterate now, trial;
    co_outcome outcome;
    co_step_control control;
} fixture;

static void begin(fixture *s) {
    *s = (fixture){.toy = {.verdict = CO_STEP_KEEP}};
    s->f = (co_objective){.context = &s->toy, .n = 1, .review_step = review, .report = report};
    s->now = (co_iterate){.x = &s->x[0], .gradient = &s->g[0], .value = 10, .found = {1, 2, 3}};
    s->trial = (co_iterate){.x = &s->x[1], .gradient = &s->g[1]};
    s->control = co_step_control_begin(&co_tuning_defaults, 0.4, &s->now);
}

static int take(fixture *s, double value) {
    co_step_verdict verdict;
    s->trial.value = value;
    s->control.length = 0.3;
    s->control.predicted = 2;
    int stop = co_step_control_take(&s->control, &s->f, CO_METHOD_NEWTON, &s->now, &s->trial, &s->outcome, &verdict);
    CHECK_INT(verdict, s->toy.verdict);
    return stop;
}

static void test_step_that_stands(void **state) {
    (void)state;
    fixture s;
    begin(&s);
    s.trial.found[0] = 7;
    s.outcome.evaluations = 5;
    CHECK_INT(take(&s, 9), -1);
    CHECK_TRUE(s.now.x == &s.x[1] && s.trial.x == &s.x[0]); /* they have changed places */
    CHECK_NEAR(s.now.found[0], 7, 0);                       /* and what was found went with them */
    CHECK_NEAR(s.trial.found[2], 3, 0);
    CHECK_INT(s.outcome.iterations, 1);
    CHECK_INT(s.toy.last.method, CO_METHOD_NEWTON);
    CHECK_INT(s.toy.last.evaluations, 5);
    CHECK_NEAR(s.toy.last.gain_ratio, 0.5, 1e-15);
    CHECK_NEAR(s.toy.last.length, 0.3, 0);
}

static void test_cap_falls_and_rises(void **state) {
    (void)state;
    fixture s;
    begin(&s);
    s.toy.verdict = CO_STEP_REJECT;
    CHECK_INT(take(&s, 9), -1);
    CHECK_NEAR(s.control.cap, 0.4 * co_tuning_defaults.cap_rejected, 1e-15);
    CHECK_INT(s.outcome.iterations, 0);
    CHECK_INT(s.outcome.rejected, 1);
    CHECK_INT(s.toy.reports, 0);
    s.toy.verdict = CO_STEP_KEEP;
    for (int k = 0; k < 5; k++)
        CHECK_INT(take(&s, 9 - k), -1);
    CHECK_NEAR(s.control.cap, 0.4, 1e-15); /* never above the first one */
    CHECK_INT(s.toy.last.rejected, 1);
}

static void test_endless_rejection_is_unresolved(void **state) {
    (void)state;
    fixture s;
    begin(&s);
    s.toy.verdict = CO_STEP_REJECT;
    int stop = -1, steps = 0;
    for (; stop < 0 && steps < 100; steps++)
        stop = take(&s, 9);
    CHECK_INT(stop, CURVOPT_STOP_UNRESOLVED);
    CHECK_BETWEEN(steps, 11, 13); /* 0.25^12 is 6e-8 */
}

static void test_ends(void **state) {
    (void)state;
    fixture s;
    begin(&s);
    s.toy.verdict = CO_STEP_STOP;
    CHECK_INT(take(&s, 9), CURVOPT_STOP_UNRESOLVED);
    begin(&s);
    s.toy.cancels = 1;
    CHECK_INT(take(&s, 9), CURVOPT_STOP_CANCELLED);
    begin(&s);
    int stop = -1, steps = 0;
    for (; stop < 0 && steps < 100; steps++)
        stop = take(&s, 10);
    CHECK_INT(stop, CURVOPT_STOP_STALLED);
    CHECK_INT(steps, co_tuning_defaults.slow_steps);
}

/* Looked at once in so many steps, by what these brought; a step that was taken back is not asked about. */
static void test_settled(void **state) {
    (void)state;
    fixture s;
    begin(&s);
    const double values[] = {9, 8, 7.9999, 7.9998, 7.9997, 7.9996};
    const int settled[] = {0, 0, 0, 1, 0, 1};
    for (int k = 0; k < 6; k++) {
        take(&s, values[k]);
        CHECK_INT(co_step_control_has_settled(&s.control, &s.now, s.outcome.iterations, 2, 1e-3), settled[k]);
    }
    const double risen[] = {8, 9, 8.9995, 8.999}; /* finer rules saw more: only then two steps that bring little */
    for (int k = 0; k < 4; k++) {
        take(&s, risen[k]);
        CHECK_INT(co_step_control_has_settled(&s.control, &s.now, s.outcome.iterations, 2, 1e-3), k == 3);
    }
    s.toy.verdict = CO_STEP_REJECT;
    take(&s, 7);
    CHECK_INT(s.outcome.iterations % 2, 0);
    CHECK_INT(co_step_control_has_settled(&s.control, &s.now, s.outcome.iterations, 2, 1e-3), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_step_that_stands),
        cmocka_unit_test(test_cap_falls_and_rises),
        cmocka_unit_test(test_endless_rejection_is_unresolved),
        cmocka_unit_test(test_ends),
        cmocka_unit_test(test_settled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
