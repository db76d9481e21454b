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

/* ------------------------------------------------------------------------------- along one line, known -- */

/* 1 - x + a x^2 + k x^3, not defined from `wall` on; or value and slope as they are said at x = 1. Trials in order. */
typedef struct line {
    double a, k, wall, value, slope, trial[16];
    int calls;
} line;

static void evaluate_line(void *context, co_iterate *at) {
    line *l = context;
    const double x = at->x[0];
    if (l->calls < 16)
        l->trial[l->calls] = x;
    l->calls++;
    at->value = x >= l->wall ? (double)NAN : 1 - x + l->a * x * x + l->k * x * x * x;
    at->gradient[0] = -1 + 2 * l->a * x + 3 * l->k * x * x;
    if (l->value != 0 && x == 1) {
        at->value = l->value;
        at->gradient[0] = l->slope;
    }
}

/* From 0 with a first step of 1; what was found. */
static co_line_search search_line(line *l, const co_tuning *tuning, double max_step, int expected) {
    const co_objective f = {.context = l, .n = 1, .evaluate = evaluate_line};
    const double d = 1;
    double x = 0, g = -1, to_x, to_g;
    const co_iterate from = {.x = &x, .gradient = &g, .value = 1};
    co_iterate to = {.x = &to_x, .gradient = &to_g};
    co_line_search s = {.tuning = tuning, .step = 1, .max_step = max_step};
    CHECK_INT(co_line_search_wolfe(&f, &from, &d, &s, &to), expected);
    CHECK_INT(s.evaluations, l->calls);
    if (expected)
        CHECK_NEAR(to_x, s.step, 0);
    return s;
}

/* Both conditions hold with equality (Nocedal, Wright, eq. 3.7: "no more than"), and one trial is enough. */
static void test_equality_is_enough(void **state) {
    (void)state;
    co_tuning t = co_tuning_defaults;
    t.wolfe_curvature = 0.75;
    const line met[3] = {{.wall = INFINITY, .value = 0.5, .slope = 0.75},
                         {.wall = INFINITY, .value = 0.5, .slope = -0.75},
                         {.wall = INFINITY, .value = 1 - 1e-4, .slope = 0}};
    for (int k = 0; k < 3; k++) {
        line l = met[k];
        CHECK_NEAR(search_line(&l, &t, 10, 1).step, 1, 0);
        CHECK_INT(l.calls, 1);
    }
    for (int k = 0; k < 2; k++) {
        line l = met[k];
        l.a = 1; /* the least value is at 1/2 */
        l.slope *= 1 + 1e-9;
        search_line(&l, &t, 10, 1);
        CHECK_TRUE(l.calls > 1);
    }
}

/* After a trial that is too long the next is where the cubic through both ends is least, but no nearer to an end than a
 * tenth of the bracket; where the far end is not defined a fifth of it. */
static void test_next_trial_is_the_cubics_minimum(void **state) {
    (void)state;
    co_tuning t = co_tuning_defaults;
    line cubic = {.k = 1, .wall = INFINITY}, steep = {.k = 100, .wall = INFINITY},
         parabola = {.a = 1, .wall = INFINITY}, walled = {.a = 4, .wall = 1},
         bent = {.a = 3, .k = -1.6, .wall = INFINITY};
    search_line(&cubic, &t, 10, 1);
    CHECK_NEAR(cubic.trial[1], sqrt(1.0 / 3), 1e-12);
    search_line(&steep, &t, 10, 1);
    CHECK_NEAR(steep.trial[1], 0.1, 1e-12); /* for 0.058 */
    search_line(&parabola, &t, 10, 1);
    CHECK_NEAR(parabola.trial[1], 0.5, 1e-12);
    search_line(&walled, &t, 10, 1);
    CHECK_NEAR(walled.trial[1], 0.2, 1e-12);
    search_line(&bent, &t, 10, 1); /* -1 + 6 x - 4.8 x^2 = 0 */
    CHECK_NEAR(bent.trial[1], (6 - sqrt(36 - 19.2)) / 9.6, 1e-12);
}

/* As long as the slope is steep trials get longer by their factor, up to the longest; the bracket that is found at last
 * lies between the last two. */
static void test_trials_grow(void **state) {
    (void)state;
    co_tuning t = co_tuning_defaults;
    t.wolfe_curvature = 0.1;
    line far = {.a = 1.0 / 18, .wall = INFINITY}; /* the least value is at 9 */
    const double growth = t.search_growth;
    const co_line_search found = search_line(&far, &t, 1000, 1);
    int k = 1;
    for (double step = growth; step < 9; step *= growth, k++)
        CHECK_NEAR(far.trial[k], step, 1e-12);
    CHECK_BETWEEN(found.step, 8.1, 9.9);
    CHECK_BETWEEN(far.calls, k + 1, k + 2);
    line capped = {.a = 1.0 / 18, .wall = INFINITY};
    CHECK_NEAR(search_line(&capped, &t, 1.5, 1).step, 1.5, 0);
    CHECK_INT(capped.calls, 2);
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
        cmocka_unit_test(test_equality_is_enough),
        cmocka_unit_test(test_next_trial_is_the_cubics_minimum),
        cmocka_unit_test(test_trials_grow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
