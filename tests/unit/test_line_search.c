/* Step lengths. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "optimize/line_search.h"

enum { N = 4 };

/* f = x.Q x / 2 + sum_k sin(w_k . x + k), Q = diag(q): smooth, bounded below, not convex. */
typedef struct function {
    double q[N], w[3][N];
    double wall;   /* not defined where x0 is above this */
    double origin; /* of x0, for the longest step seen */
    double longest;
    int calls;
} function;

static double evaluate(void *context, const double *x, double *gradient) {
    function *f = context;
    double value = 0;
    f->calls++;
    f->longest = fmax(f->longest, fabs(x[0] - f->origin));
    if (x[0] > f->wall)
        return (double)NAN;
    for (int i = 0; i < N; i++) {
        value += f->q[i] * x[i] * x[i] / 2;
        gradient[i] = f->q[i] * x[i];
    }
    for (int k = 0; k < 3; k++) {
        double phase = k;
        for (int i = 0; i < N; i++)
            phase += f->w[k][i] * x[i];
        value += sin(phase);
        for (int i = 0; i < N; i++)
            gradient[i] += cos(phase) * f->w[k][i];
    }
    return value;
}

static function random_function(uint64_t *seed) {
    function f = {.wall = INFINITY};
    for (int i = 0; i < N; i++) {
        f.q[i] = pow(10, 2 * check_random(seed));
        for (int k = 0; k < 3; k++)
            f.w[k][i] = 2 * check_random(seed);
    }
    return f;
}

/* As a co_objective has it. */
#define AS_OBJECTIVE(name)                                                                                             \
    static void name##_at(void *context, co_iterate *at) {                                                             \
        at->value = name(context, at->x, at->gradient);                                                                \
    }
AS_OBJECTIVE(evaluate)

typedef struct search {
    function f;
    co_objective objective;
    double x[N], g[N], d[N], to_x[N], to_g[N], slope, slope_after;
    co_iterate from, to;
    co_line_search line;
} search;

/* From random x along a random descent direction. */
static void prepare(search *s, const function *f, uint64_t *seed) {
    *s = (search){.f = *f, .line = {.tuning = &co_tuning_defaults, .step = 1, .max_step = 1e6}};
    s->objective = (co_objective){.context = &s->f, .n = N, .evaluate = evaluate_at};
    s->from = (co_iterate){.x = s->x, .gradient = s->g};
    s->to = (co_iterate){.x = s->to_x, .gradient = s->to_g};
    for (int i = 0; i < N; i++)
        s->x[i] = 3 * check_random(seed);
    s->from.value = evaluate(&s->f, s->x, s->g);
    for (int i = 0; i < N; i++) {
        s->d[i] = -s->g[i] * pow(10, check_random(seed));
        s->slope += s->d[i] * s->g[i];
    }
    s->f.origin = s->x[0];
    s->f.calls = 0;
    s->f.longest = 0;
}

static int run(search *s) {
    int found = co_line_search_wolfe(&s->objective, &s->from, s->d, &s->line, &s->to);
    s->slope_after = 0;
    for (int i = 0; i < N; i++)
        s->slope_after += s->d[i] * s->to_g[i];
    CHECK_INT(s->line.evaluations, s->f.calls);
    return found;
}

static void check_is_evaluated_there(search *s) {
    double g[N];
    for (int i = 0; i < N; i++)
        CHECK_NEAR(s->to_x[i], s->x[i] + s->line.step * s->d[i], 1e-14 * (1 + fabs(s->to_x[i])));
    CHECK_NEAR(evaluate(&s->f, s->to_x, g), s->to.value, 0);
    for (int i = 0; i < N; i++)
        CHECK_NEAR(g[i], s->to_g[i], 0);
}

static void test_strong_wolfe_conditions_hold_on_random_functions(void **state) {
    (void)state;
    uint64_t seed = 2024;
    for (int n = 0; n < 500; n++) {
        function f = random_function(&seed);
        search s;
        prepare(&s, &f, &seed);
        s.line.step = pow(10, 3 * check_random(&seed)); /* first trials far too long and far too short */
        CHECK_TRUE(run(&s));
        CHECK_TRUE(s.to.value <= s.from.value + 1e-4 * s.line.step * s.slope);
        CHECK_TRUE(fabs(s.slope_after) <= 0.9 * fabs(s.slope));
        check_is_evaluated_there(&s);
    }
}

static void test_longest_step_is_never_exceeded(void **state) {
    (void)state;
    uint64_t seed = 31;
    int at_cap = 0;
    for (int n = 0; n < 200; n++) {
        function f = random_function(&seed);
        search s;
        prepare(&s, &f, &seed);
        s.line.max_step = 0.01;
        CHECK_TRUE(run(&s));
        CHECK_TRUE(s.line.step <= 0.01);
        CHECK_TRUE(s.f.longest <= 0.01 * fabs(s.d[0]) * (1 + 1e-12) + 1e-15);
        CHECK_TRUE(s.to.value <= s.from.value + 1e-4 * s.line.step * s.slope);
        CHECK_TRUE(s.line.step == 0.01 || fabs(s.slope_after) <= 0.9 * fabs(s.slope));
        at_cap += s.line.step == 0.01;
    }
    CHECK_BETWEEN(at_cap, 1, 199); /* both happen */
}

static void test_undefined_region_is_backed_out_of(void **state) {
    (void)state;
    uint64_t seed = 5;
    int walls = 0;
    for (int n = 0; n < 200; n++) {
        function f = random_function(&seed);
        search s;
        prepare(&s, &f, &seed);
        s.f.wall = s.x[0] + 1e-3;
        s.line.step = 10;
        walls += s.d[0] > 0;
        CHECK_TRUE(run(&s));
        CHECK_TRUE(s.to_x[0] <= s.f.wall);
        CHECK_TRUE(isfinite(s.to.value) && s.to.value < s.from.value);
    }
    CHECK_TRUE(walls > 20);
}

static void test_ascent_direction_finds_nothing_and_tries_nothing(void **state) {
    (void)state;
    uint64_t seed = 8;
    function f = random_function(&seed);
    search s;
    prepare(&s, &f, &seed);
    for (int i = 0; i < N; i++)
        s.d[i] = s.g[i];
    CHECK_TRUE(!run(&s));
    CHECK_INT(s.f.calls, 0);
}

/* -t (1 - t)^2 + t^2 / 500: at t = 1 it is flat, and a little higher than at 0. */
static double flat_but_higher(void *context, const double *x, double *gradient) {
    double t = x[0];
    ((function *)context)->calls++;
    memset(gradient, 0, sizeof *gradient * N);
    gradient[0] = -(1 - t) * (1 - 3 * t) + t / 250;
    return -t * (1 - t) * (1 - t) + t * t / 500;
}
AS_OBJECTIVE(flat_but_higher)

static void test_flat_step_without_decrease_is_not_taken(void **state) {
    (void)state;
    search s = {.line = {.tuning = &co_tuning_defaults, .step = 1, .max_step = 1}, .d = {1}, .slope = -1};
    s.objective = (co_objective){.context = &s.f, .n = N, .evaluate = flat_but_higher_at};
    s.from = (co_iterate){.x = s.x, .gradient = s.g};
    s.to = (co_iterate){.x = s.to_x, .gradient = s.to_g};
    s.from.value = flat_but_higher(&s.f, s.x, s.g);
    s.f.calls = 0;
    CHECK_TRUE(run(&s));
    CHECK_BETWEEN(s.line.step, 0.05, 0.7);
    CHECK_TRUE(s.to.value < -0.05);
}

/* A gradient of the wrong sign promises a decrease that never comes; `step_up` puts everything but the start higher. */
static double step_up;

static double lying(void *context, const double *x, double *gradient) {
    double value = evaluate(context, x, gradient);
    for (int i = 0; i < N; i++)
        gradient[i] = -gradient[i];
    return value + step_up;
}
AS_OBJECTIVE(lying)

static int search_in_vain(search *s) {
    uint64_t seed = 9;
    function f = {.q = {1, 1, 1, 1}, .wall = INFINITY};
    prepare(s, &f, &seed);
    s->objective.evaluate = lying_at;
    for (int i = 0; i < N; i++) {
        s->d[i] = s->g[i];
        s->g[i] = -s->g[i];
    }
    return run(s);
}

static void test_search_without_any_decrease_gives_up(void **state) {
    (void)state;
    search s;
    step_up = 1e-3;
    CHECK_TRUE(!search_in_vain(&s));
    CHECK_BETWEEN(s.f.calls, 1, 40);
    step_up = 0; /* here a step too short to change the value may pass for one */
    CHECK_TRUE(!search_in_vain(&s) || s.to.value <= s.from.value + 1e-14 * fabs(s.from.value));
    CHECK_BETWEEN(s.f.calls, 1, 40);
}

/* So near the minimum of f + 1e6 that values agree to rounding, the slopes still tell. */
static double lifted(void *context, const double *x, double *gradient) {
    return 1e6 + evaluate(context, x, gradient);
}
AS_OBJECTIVE(lifted)

static void test_search_near_a_minimum_succeeds_by_slopes(void **state) {
    (void)state;
    uint64_t seed = 10;
    function f = {.q = {1, 1, 1, 1}, .wall = INFINITY};
    search s;
    prepare(&s, &f, &seed);
    s.objective.evaluate = lifted_at;
    for (int i = 0; i < N; i++)
        s.x[i] = 1e-7 * (i + 1);
    s.from.value = lifted(&s.f, s.x, s.g);
    double slope = 0;
    for (int i = 0; i < N; i++) {
        s.d[i] = -s.g[i];
        slope += s.d[i] * s.g[i];
    }
    s.line.step = 0.3;
    s.f.calls = 0;
    CHECK_TRUE(run(&s));
    CHECK_TRUE(fabs(s.slope_after) <= -0.9 * slope);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_strong_wolfe_conditions_hold_on_random_functions),
        cmocka_unit_test(test_longest_step_is_never_exceeded),
        cmocka_unit_test(test_undefined_region_is_backed_out_of),
        cmocka_unit_test(test_ascent_direction_finds_nothing_and_tries_nothing),
        cmocka_unit_test(test_flat_step_without_decrease_is_not_taken),
        cmocka_unit_test(test_search_without_any_decrease_gives_up),
        cmocka_unit_test(test_search_near_a_minimum_succeeds_by_slopes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
