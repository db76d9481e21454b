/* Newton's method with a damped matrix: what it finds, how fast, and what it asks for. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#include "check.h"
#include "curvopt.h"

#include "optimize/damped_newton.h"
#include "optimize/step_control.h"

/* Functions of two variables, their second derivatives, and a record of what the method did. */
typedef enum shape { ROSENBROCK, SADDLE, QUARTIC, FLAT, ROUND, WRONG } shape;

typedef struct problem {
    shape shape;
    co_step_verdict verdict; /* said at step verdict_at */
    int verdict_at, cancel_at, fail_at;
    int settles, assembled, factorized;
    int mixed;      /* steps that were settled with some of G in the matrix, */
    int lengthened; /* and such that are longer than the first trial by their matrix that brought anything */
    int restless;   /* steps that were settled although another one that was evaluated was lower */
    double best;    /* least value since the matrix was assembled, or the last step settled */
    double at;      /* value there */
    double reach;   /* length of the first trial since then that brought anything; 0: none yet */
    co_damping damping;
    double start[2], last[2]; /* of the step that was settled last: where it began, where it led, */
    double slope[2], began;   /* gradient and value where it began */
    double longest;           /* step that was evaluated */
    int wrong_before;         /* calls of assemble whose `before` is not what it must be */
    int rejected;             /* the last step was */
    double seen, across;      /* part of ROUND's curvature that the matrix has, and WRONG's; across x, 0: the same */
    int misleads;             /* ROUND's is a saddle unless it is asked for closely */
    int misses;               /* `seen` is the part that it has unless it is asked for closely */
    int close;                /* times that it was */
    double H[3], G[3], M[3];  /* xx, xy, yy: the Hessian, the Gauss-Newton matrix, the damped one */
    double now[2];
    int evaluations, reports, never_positive;
    co_damping best_damping; /* by which the least value since then was found */
    co_damping tried[64];    /* [n_tried] since then */
    int n_tried, repeated;   /* all that was tried a second time, of all matrices */
} problem;

static double value_of(problem *p, const double *x, double *g) {
    double a = x[1] - x[0] * x[0], b = 1 - x[0];
    switch (p->shape) {
    case ROSENBROCK:
        g[0] = -400 * a * x[0] - 2 * b;
        g[1] = 200 * a;
        return 1 + 100 * a * a + b * b;
    case SADDLE:
        g[0] = x[0] * x[0] * x[0] - x[0];
        g[1] = x[1];
        return 1 + 0.25 * x[0] * x[0] * x[0] * x[0] - 0.5 * x[0] * x[0] + 0.5 * x[1] * x[1];
    case FLAT:
        g[0] = g[1] = 0;
        return 0;
    case ROUND:
        g[0] = x[0];
        g[1] = x[1];
        return 1 + 0.5 * (x[0] * x[0] + x[1] * x[1]);
    case WRONG: /* gradient */
        g[0] = 1;
        g[1] = 0;
        return 1;
    default:
        g[0] = 4 * x[0] * x[0] * x[0];
        g[1] = 2e6 * x[1];
        return 1 + x[0] * x[0] * x[0] * x[0] + 1e6 * x[1] * x[1];
    }
}

static double step_length(void *context, const double *d) {
    (void)context;
    return fmax(fabs(d[0]), fabs(d[1]));
}

static double reach_of(const problem *p, const double *x) {
    return step_length(NULL, (double[]){x[0] - p->now[0], x[1] - p->now[1]});
}

static void evaluate(void *context, co_iterate *at) {
    problem *p = context;
    const double *x = at->x;
    double value = at->value = value_of(p, x, at->gradient);
    p->evaluations++;
    p->longest = fmax(p->longest, reach_of(p, x));
    if (value < p->best)
        p->best_damping = p->damping;
    p->best = fmin(p->best, value);
    if (value < p->at && p->reach == 0)
        p->reach = reach_of(p, x);
}

static co_step_verdict settle(void *context, const co_iterate *before, co_iterate *now, int iteration) {
    problem *p = context;
    (void)iteration;
    p->mixed += p->damping.mix > 0;
    p->lengthened += reach_of(p, now->x) > p->reach;
    p->restless += now->value > p->best;
    int says = ++p->settles == p->verdict_at;
    p->rejected = says && (p->verdict == CO_STEP_REJECT || p->verdict == CO_STEP_STOP);
    if (p->rejected) {
        memcpy(now->x, before->x, 2 * sizeof(double));
        memcpy(now->gradient, before->gradient, 2 * sizeof(double));
        now->value = before->value;
    }
    memcpy(p->start, before->x, sizeof p->start);
    memcpy(p->slope, before->gradient, sizeof p->slope);
    p->began = before->value;
    p->best = p->at = now->value;
    p->reach = 0;
    memcpy(p->last, now->x, sizeof p->last);
    memcpy(p->now, now->x, sizeof p->now);
    return says ? p->verdict : CO_STEP_KEEP;
}

static int assemble(void *context, const co_iterate *now, const double *before, int closely) {
    problem *p = context;
    const double *x = now->x;
    p->close += closely;
    int wants = p->settles > 0 && !p->rejected && p->shape != SADDLE;
    if (p->shape != SADDLE)
        p->wrong_before += wants ? !before || memcmp(before, p->start, sizeof p->start) != 0 : before != NULL;
    switch (p->shape) {
    case ROSENBROCK:
        p->H[0] = 1200 * x[0] * x[0] - 400 * x[1] + 2;
        p->G[0] = 800 * x[0] * x[0] + 2;
        p->H[1] = p->G[1] = -400 * x[0];
        p->H[2] = p->G[2] = 200;
        break;
    case SADDLE:
        p->H[0] = 3 * x[0] * x[0] - 1;
        p->G[0] = 3 * x[0] * x[0];
        p->H[1] = p->G[1] = 0;
        p->H[2] = p->G[2] = 1;
        break;
    case ROUND:
    case WRONG:
        p->H[0] = p->G[0] = p->seen;
        p->H[2] = p->G[2] = p->across != 0 ? p->across : p->seen;
        p->H[1] = p->G[1] = 0;
        if (p->misses && closely)
            p->H[0] = p->G[0] = p->H[2] = p->G[2] = 1;
        if (p->misleads && !closely)
            p->H[2] = -1e-3 * p->seen;
        break;
    default:
        p->H[0] = p->G[0] = 12 * x[0] * x[0];
        p->H[1] = p->G[1] = 0;
        p->H[2] = p->G[2] = 2e6;
    }
    p->best = p->at = now->value;
    p->reach = 0;
    p->n_tried = 0;
    return ++p->assembled == p->fail_at;
}

static int factorize(void *context, const co_damping *damping, int *positive) {
    problem *p = context;
    p->factorized++;
    p->damping = *damping;
    for (int k = 0; k < p->n_tried; k++)
        p->repeated += p->tried[k].shift == damping->shift && p->tried[k].mix == damping->mix;
    p->tried[p->n_tried++ % 64] = *damping;
    for (int i = 0; i < 3; i++)
        p->M[i] = (1 - damping->mix) * p->H[i] + damping->mix * p->G[i] + (i == 1 ? 0 : damping->shift);
    *positive = !p->never_positive && p->M[0] > 0 && p->M[0] * p->M[2] > p->M[1] * p->M[1];
    return 0;
}

static int solve(void *context, const double *in, double *out) {
    const problem *p = context;
    double det = p->M[0] * p->M[2] - p->M[1] * p->M[1];
    double x = (p->M[2] * in[0] - p->M[1] * in[1]) / det, y = (p->M[0] * in[1] - p->M[1] * in[0]) / det;
    out[0] = x;
    out[1] = y;
    return 0;
}

static double least_shift(void *context, const co_iterate *now) {
    (void)context;
    (void)now;
    return 1e-9;
}

static int negative_curvature(void *context, const co_iterate *now, double *d) {
    const problem *p = context;
    (void)now;
    d[0] = 3;
    d[1] = 0;
    return p->H[0] < 0;
}

/* The step that is told of is that from where it began to the least value; what it was predicted to bring is what a
 * quadratic function with the matrix, but for its shift, says. On the way from a saddle nothing is. */
static int report(void *context, const co_iterate *now, const co_step_record *record) {
    problem *p = context;
    const double d[2] = {now->x[0] - p->start[0], now->x[1] - p->start[1]}, mix = p->best_damping.mix;
    double predicted = -d[0] * p->slope[0] - d[1] * p->slope[1];
    for (int i = 0; i < 3; i++)
        predicted -= (i == 1 ? 1 : 0.5) * d[i / 2] * d[(i + 1) / 2] * ((1 - mix) * p->H[i] + mix * p->G[i]);
    CHECK_INT(record->method, CO_METHOD_NEWTON);
    CHECK_INT(record->iteration, ++p->reports);
    CHECK_INT(record->evaluations, p->evaluations);
    CHECK_NEAR(record->length, step_length(NULL, d), 1e-12 * (1 + record->length));
    if (p->shape != SADDLE) {
        CHECK_NEAR(record->shift, p->best_damping.shift, 0);
        if (p->shape == ROUND && p->seen > 2) /* the parabola's, which is the function's own */
            predicted = p->began - now->value;
        CHECK_NEAR(record->predicted, predicted, 1e-9 * (1e-6 + predicted));
        CHECK_NEAR(record->gain_ratio * record->predicted, p->began - now->value, 1e-12 * (1 + fabs(p->began)));
    }
    return record->iteration == p->cancel_at;
}

static const co_method_options usual = {.tuning = &co_tuning_defaults,
                                        .max_iterations = 200,
                                        .decrement_tolerance = 1e-14,
                                        .saddle_decrease = 1e-14,
                                        .settled_steps = 50,
                                        .settled_decrease = 1e-16,
                                        .max_step = 10,
                                        .keeps_matrix = 1};

static co_outcome run(problem *p, co_method_options o, double x, double y, double at[2], double *value) {
    co_objective f = {.context = p,
                      .n = 2,
                      .evaluate = evaluate,
                      .step_length = step_length,
                      .review_step = settle,
                      .precondition = solve,
                      .assemble = assemble,
                      .factorize = factorize,
                      .least_shift = least_shift,
                      .negative_curvature = negative_curvature,
                      .report = report};
    double g[2];
    co_iterate now = {.x = at, .gradient = g};
    co_outcome outcome;
    curvopt_error error;
    p->now[0] = at[0] = x;
    p->now[1] = at[1] = y;
    now.value = value_of(p, at, g);
    CHECK_OK(co_damped_newton(&f, &o, &now, &outcome, &error), &error);
    CHECK_TRUE(now.x == at && now.gradient == g); /* the caller's arrays, whatever happened inside */
    *value = now.value;
    CHECK_INT(p->wrong_before, 0);
    CHECK_INT(p->repeated, 0);
    if (p->shape != SADDLE) /* the way away from a saddle is the first that will do */
        CHECK_INT(p->restless, 0);
    return outcome;
}

static void test_curved_valley(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK};
    double x[2], value;
    co_outcome end = run(&p, usual, -1.2, 1, x, &value);
    CHECK_INT(end.stop, CURVOPT_STOP_CONVERGED);
    CHECK_BETWEEN(end.iterations, 8, 40);
    CHECK_NEAR(x[0], 1, 1e-9);
    CHECK_NEAR(x[1], 1, 1e-9);
}

/* By one matrix as far as it leads: of most steps here a shorter one was good, too. A start where the Hessian is
 * indefinite, as it is on the far side of the valley's floor: some of the Gauss-Newton matrix makes it positive, and no
 * shift has to (the least eigenvalue is -137), which would make steps along the valley as short as those across it. */
static void test_damping(void **state) {
    (void)state;
    double x[2], value;
    problem far = {.shape = ROSENBROCK};
    co_method_options o = usual;
    o.max_step = 0.05;
    CHECK_INT(run(&far, o, -1.2, 1, x, &value).stop, CURVOPT_STOP_CONVERGED);
    CHECK_BETWEEN(far.lengthened, 20, far.settles);
    problem indefinite = {.shape = ROSENBROCK, .cancel_at = 1};
    run(&indefinite, usual, -0.5, 0.8, x, &value);
    CHECK_INT(indefinite.settles, 1);
    CHECK_INT(indefinite.mixed, 1);
    CHECK_BETWEEN(indefinite.damping.shift, 0, 10);
    problem convex = {.shape = QUARTIC};
    run(&convex, usual, 1, 1, x, &value);
    CHECK_INT(convex.mixed, 0);
}

/* The gradient does not point along the way down: it has to be looked for. */
static void test_saddle_is_left(void **state) {
    (void)state;
    problem p = {.shape = SADDLE};
    double x[2], value;
    co_outcome end = run(&p, usual, 0, 1, x, &value);
    CHECK_INT(end.stop, CURVOPT_STOP_CONVERGED);
    CHECK_NEAR(fabs(x[0]), 1, 1e-6);
    CHECK_NEAR(value, 0.75, 1e-12);
}

/* Where the minimum is below the saddle by less than what a step has to bring, it is not left. */
static void test_shallow_saddle(void **state) {
    (void)state;
    for (int any = 0; any < 2; any++) {
        problem p = {.shape = SADDLE};
        double x[2], value;
        co_method_options o = usual;
        o.decrement_tolerance = 0.3; /* it is .25 below */
        o.saddle_decrease = any ? CO_KNOWN_DECREASE : 0.3;
        CHECK_INT(run(&p, o, 0, 1e-3, x, &value).stop, CURVOPT_STOP_CONVERGED);
        CHECK_NEAR(value, any ? 0.75 : 1, 0.05);
    }
}

/* Indefinite at first, and a hundred thousand times softer one way than the other. */
static void test_stiff_and_soft(void **state) {
    (void)state;
    problem p = {.shape = QUARTIC};
    double x[2], value;
    co_outcome end = run(&p, usual, 1, 1, x, &value);
    CHECK_INT(end.stop, CURVOPT_STOP_CONVERGED);
    CHECK_BETWEEN(end.iterations, 10,
                  60); /* a third is gone with each step of Newton's, and 1e-14 of the value is left */
    CHECK_NEAR(value, 1, 1e-12);
}

static void test_steps_keep_to_the_cap(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK};
    double x[2], value;
    co_method_options o = usual;
    o.max_step = 0.05;
    co_outcome end = run(&p, o, -1.2, 1, x, &value);
    CHECK_INT(end.stop, CURVOPT_STOP_CONVERGED);
    CHECK_BETWEEN(p.longest, 0.03, 0.05);
    CHECK_BETWEEN(end.iterations, 40, 200);
}

/* After a step that was taken back the matrix knows of none. (`before` is looked at in assemble.) */
static void test_rejected_step(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK, .verdict = CO_STEP_REJECT, .verdict_at = 3};
    double x[2], value;
    co_outcome end = run(&p, usual, -1.2, 1, x, &value);
    CHECK_INT(end.stop, CURVOPT_STOP_CONVERGED);
    CHECK_INT(end.iterations, p.settles - 1);
    CHECK_NEAR(x[0], 1, 1e-9);
}

/* A step that is taken back says nothing of whether the function still falls: whichever it is, also the very first, the
 * method goes on with shorter ones. */
static void test_rejected_step_is_no_settled_one(void **state) {
    (void)state;
    for (int at = 1; at <= 12; at++) {
        problem p = {.shape = ROSENBROCK, .verdict = CO_STEP_REJECT, .verdict_at = at};
        double x[2], value;
        co_method_options o = usual;
        o.settled_steps = 5;
        co_outcome end = run(&p, o, -1.2, 1, x, &value);
        CHECK_INT(end.stop, CURVOPT_STOP_CONVERGED);
        CHECK_INT(end.rejected, 1);
        CHECK_INT(end.iterations, p.settles - 1);
        CHECK_NEAR(x[0], 1, 1e-6);
    }
}

/* Nobody has said of an iterate that the method was thrown back to that it is a minimum. */
static void test_rejected_step_has_not_converged(void **state) {
    (void)state;
    problem p = {.shape = ROSENBROCK, .verdict = CO_STEP_REJECT, .verdict_at = 1};
    double x[2], value;
    co_method_options o = usual;
    o.decrement_tolerance = 1e-10;
    co_outcome end = run(&p, o, 1 + 1e-6, 1 + 2e-6, x, &value);
    CHECK_INT(end.stop, CURVOPT_STOP_CONVERGED);
    CHECK_INT(end.rejected, 1);
    CHECK_INT(end.iterations, 1);
}

/* By a matrix that has a half or a third of the function's curvature: of a step that is small enough to be the last, as
 * much as leads to the end. Otherwise it would lead as far beyond, or nowhere. */
static void test_small_steps_are_shortened(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++) {
        problem p = {.shape = ROUND, .seen = k ? 0.33 : 0.52};
        double x[2], value;
        co_method_options o = usual;
        o.decrement_tolerance = 1e-2;
        co_outcome end = run(&p, o, 0.05, -0.02, x, &value);
        CHECK_INT(end.stop, CURVOPT_STOP_CONVERGED);
        CHECK_INT(end.iterations, 1);
        CHECK_INT(end.evaluations, 2);
        CHECK_INT(p.factorized, 1);
        CHECK_NEAR(x[0], 0, 1e-8);
        CHECK_NEAR(x[1], 0, 1e-8);
    }
}

/* The matrix has a thousandth of the curvature along x, where the gradient is, and a little negative curvature across,
 * of which nothing comes. Only a shift makes steps right, and it makes their promise small: to stay where the first one
 * begins would leave .5 .05^2 / .001 = 1.25 by the matrix, and .00125 in truth. */
static void test_steps_small_by_their_shift(void **state) {
    (void)state;
    for (int closely = 0; closely < 2; closely++) {
        problem p = {.shape = ROUND, .seen = 1e-3, .across = -1e-3};
        double x[2], value;
        co_method_options o = usual;
        o.decrement_tolerance = 1e-2;
        o.closely = closely;
        co_outcome end = run(&p, o, 0.05, 0, x, &value);
        CHECK_INT(end.stop, closely ? CURVOPT_STOP_SETTLED : CURVOPT_STOP_CONVERGED);
        CHECK_BETWEEN(end.iterations, closely, closely ? 20 : 0);
        CHECK_INT(0.5 * x[0] * x[0] / p.seen < 1e-2 * value, closely);
    }
}

/* Along negative curvature the matrix promises more the longer the step: that none brings anything is no minimum. */
static void test_negative_curvature_without_decrease(void **state) {
    (void)state;
    for (int closely = 0; closely < 2; closely++) {
        problem p = {.shape = ROUND, .seen = -0.5, .across = 1};
        double x[2], value;
        co_method_options o = usual;
        o.decrement_tolerance = 1e-4;
        o.closely = closely;
        CHECK_INT(run(&p, o, 1e-3, 0, x, &value).stop, closely ? CURVOPT_STOP_SETTLED : CURVOPT_STOP_CONVERGED);
    }
}

/* Where no step brings anything, the shift rises until next to nothing is promised. What counts closely is what was
 * promised without: much, or so little that rounding may hide it. */
static void test_nothing_found(void **state) {
    (void)state;
    for (int much = 0; much < 2; much++) {
        problem p = {.shape = WRONG, .seen = 1};
        double x[2], value;
        co_method_options o = usual;
        o.decrement_tolerance = much ? 0.1 : 1;
        o.closely = 1;
        co_outcome end = run(&p, o, 0, 0, x, &value);
        CHECK_INT(end.stop, much ? CURVOPT_STOP_STALLED : CURVOPT_STOP_CONVERGED);
        CHECK_INT(end.iterations, 0);
        p = (problem){.shape = WRONG, .seen = 1};
        o.closely = 0;
        CHECK_INT(run(&p, o, 0, 0, x, &value).stop, CURVOPT_STOP_CONVERGED);
    }
}

/* Where a matrix that is off by a little is indefinite, a close one decides, and all after it are close. */
static void test_indefinite_matrices_are_looked_at_closely(void **state) {
    (void)state;
    problem p = {.shape = ROUND, .seen = 1, .misleads = 1};
    double x[2], value;
    co_method_options o = usual;
    o.decrement_tolerance = 1e-2;
    co_outcome end = run(&p, o, 0.05, -0.02, x, &value);
    CHECK_INT(end.stop, CURVOPT_STOP_CONVERGED);
    CHECK_INT(end.iterations, 1);
    CHECK_INT(p.assembled, 2);
    CHECK_INT(p.close, 1);
    CHECK_NEAR(x[0], 0, 1e-8);
    CHECK_NEAR(x[1], 0, 1e-8);
    problem far = {.shape = QUARTIC}; /* no saddle */
    run(&far, usual, 1, 1, x, &value);
    CHECK_INT(far.close, 0);
    problem saddle = {.shape = SADDLE};
    CHECK_INT(run(&saddle, usual, 1e-3, 0.5, x, &value).stop, CURVOPT_STOP_CONVERGED);
    CHECK_BETWEEN(saddle.assembled, 3, 100);
    CHECK_INT(saddle.close, saddle.assembled - 1);
}

/* Where the matrix is four times as stiff as the function a step goes on to where the parabola is least, but not
 * farther than the cap; where it is less than twice as stiff it does not. */
static void test_steps_are_extended_where_the_matrix_is_stiff(void **state) {
    (void)state;
    static const double seen[3] = {4, 1.9, 4}, cap[3] = {10, 10, 0.3}, steps[3] = {2, 20, 4};
    for (int k = 0; k < 3; k++) {
        problem p = {.shape = ROUND, .seen = seen[k]};
        co_method_options o = usual;
        double x[2], value;
        o.max_step = cap[k];
        const co_outcome end = run(&p, o, 0.5, -0.2, x, &value);
        CHECK_INT(end.stop, CURVOPT_STOP_CONVERGED);
        CHECK_NEAR(value, 1, 1e-13);
        if (k == 1)
            CHECK_BETWEEN(end.iterations, 6, 30);
        else
            CHECK_BETWEEN(end.iterations, 1, steps[k]);
        CHECK_BETWEEN(p.longest, 0, cap[k]);
    }
}

/* A step that brings little of what was promised may be the matrix' fault: all after it are close. */
static void test_matrices_that_miss_curvature_are_looked_at_closely(void **state) {
    (void)state;
    for (int misses = 0; misses < 2; misses++) {
        problem p = {.shape = ROUND, .seen = 0.55, .misses = misses};
        double x[2], value;
        CHECK_INT(run(&p, usual, 0.5, -0.2, x, &value).stop, CURVOPT_STOP_CONVERGED);
        CHECK_NEAR(value, 1, 1e-13);
        if (misses) { /* one by the first matrix; one by a close one, which is right; one that says so */
            CHECK_INT(p.assembled, 3);
            CHECK_INT(p.close, 2);
        } else {
            CHECK_BETWEEN(p.assembled, 6, 100);
        }
    }
}

/* A step that came true leaves a factor that is good for the next gradient, too. One of .9 of the curvature does for
 * all steps, of which each leaves a ninth, unless one is taken back. By one of .6 nothing comes true, and each step has
 * its own; so where matrices are not kept. */
static void test_steps_by_the_same_matrix(void **state) {
    (void)state;
    double x[2], value;
    co_method_options o = usual;
    o.decrement_tolerance = 1e-12;
    problem near = {.shape = ROSENBROCK};
    CHECK_INT(run(&near, o, 1.001, 1.0021, x, &value).stop, CURVOPT_STOP_CONVERGED);
    CHECK_INT(near.assembled, 1);
    CHECK_NEAR(value, 1, 1e-12);
    static const co_step_verdict verdict[3] = {CO_STEP_KEEP, CO_STEP_CHANGED, CO_STEP_REJECT};
    for (int k = 0; k < 3; k++) {
        problem p = {.shape = ROUND, .seen = 0.9, .verdict = verdict[k], .verdict_at = 1};
        const co_outcome end = run(&p, o, 1, 1, x, &value);
        CHECK_INT(end.stop, CURVOPT_STOP_CONVERGED);
        CHECK_BETWEEN(end.iterations, 6, 8);
        CHECK_INT(p.assembled, verdict[k] == CO_STEP_REJECT ? 2 : 1);
        CHECK_NEAR(value, 1, 1e-11);
    }
    for (int k = 0; k < 2; k++) { /* the second one is right, and not kept */
        problem p = {.shape = k ? ROSENBROCK : ROUND, .seen = 0.6};
        o.keeps_matrix = !k;
        const co_outcome end = run(&p, o, 1.001, 1.0021, x, &value);
        CHECK_INT(end.stop, CURVOPT_STOP_CONVERGED);
        CHECK_TRUE(end.iterations > 1);
        CHECK_TRUE(p.assembled >= end.iterations);
    }
}

static void test_ends(void **state) {
    (void)state;
    double x[2], value;
    problem stopped = {.shape = ROSENBROCK, .verdict = CO_STEP_STOP, .verdict_at = 4};
    CHECK_INT(run(&stopped, usual, -1.2, 1, x, &value).stop, CURVOPT_STOP_UNRESOLVED);
    CHECK_NEAR(x[0], stopped.last[0], 0);
    problem cancelled = {.shape = ROSENBROCK, .cancel_at = 3};
    co_outcome end = run(&cancelled, usual, -1.2, 1, x, &value);
    CHECK_INT(end.stop, CURVOPT_STOP_CANCELLED);
    CHECK_INT(end.iterations, 3);
    CHECK_NEAR(x[0], cancelled.last[0], 0);
    problem failing = {.shape = ROSENBROCK, .fail_at = 2};
    CHECK_INT(run(&failing, usual, -1.2, 1, x, &value).stop, CURVOPT_STOP_STALLED);
    CHECK_INT(failing.settles, 2); /* both by the first matrix */
    problem limited = {.shape = ROSENBROCK};
    co_method_options o = usual;
    o.max_iterations = 5;
    end = run(&limited, o, -1.2, 1, x, &value);
    CHECK_INT(end.stop, CURVOPT_STOP_LIMIT);
    CHECK_INT(end.iterations, 5);
    problem settling = {.shape = ROSENBROCK};
    o = usual;
    o.settled_steps = 2;
    o.settled_decrease = 10;
    end = run(&settling, o, -1.2, 1, x, &value);
    CHECK_INT(end.stop, CURVOPT_STOP_SETTLED);
    CHECK_INT(end.iterations, 2);
    problem hopeless = {.shape = ROSENBROCK, .never_positive = 1}; /* as many matrices as there are trials, no step */
    CHECK_INT(run(&hopeless, usual, -1.2, 1, x, &value).stop, CURVOPT_STOP_STALLED);
    CHECK_INT(hopeless.factorized, co_tuning_defaults.trials);
    CHECK_INT(hopeless.evaluations, 0);
    problem flat = {.shape = FLAT}; /* there is nothing to be gained, and no matrix is asked for */
    CHECK_INT(run(&flat, o, 3, 4, x, &value).stop, CURVOPT_STOP_CONVERGED);
    CHECK_INT(flat.assembled, 0);
    problem there = {.shape = ROSENBROCK};
    o = usual;
    o.gradient_tolerance = 1e-8;
    CHECK_INT(run(&there, o, 1, 1, x, &value).iterations, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_curved_valley),
        cmocka_unit_test(test_saddle_is_left),
        cmocka_unit_test(test_shallow_saddle),
        cmocka_unit_test(test_stiff_and_soft),
        cmocka_unit_test(test_steps_keep_to_the_cap),
        cmocka_unit_test(test_rejected_step),
        cmocka_unit_test(test_rejected_step_is_no_settled_one),
        cmocka_unit_test(test_rejected_step_has_not_converged),
        cmocka_unit_test(test_damping),
        cmocka_unit_test(test_small_steps_are_shortened),
        cmocka_unit_test(test_indefinite_matrices_are_looked_at_closely),
        cmocka_unit_test(test_steps_are_extended_where_the_matrix_is_stiff),
        cmocka_unit_test(test_matrices_that_miss_curvature_are_looked_at_closely),
        cmocka_unit_test(test_steps_small_by_their_shift),
        cmocka_unit_test(test_negative_curvature_without_decrease),
        cmocka_unit_test(test_nothing_found),
        cmocka_unit_test(test_steps_by_the_same_matrix),
        cmocka_unit_test(test_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
