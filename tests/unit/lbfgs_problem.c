/* Functions to minimize, with scripted callbacks. SPDX-License-Identifier: GPL-3.0-or-later */
#include "lbfgs_problem.h"

#include "check.h"

const co_method_options usual_options = {.tuning = &co_tuning_defaults,
                                         .memory = 12,
                                         .max_iterations = 1000,
                                         .gradient_tolerance = 1e-10,
                                         .max_step = 1e3,
                                         .settled_steps = 15};

static double quadratic(const problem *p, const double *x, double *gradient) {
    double value = 1;
    for (int i = 0; i < p->n; i++) {
        double q = pow(p->condition, (double)i / p->n), d = x[i] - i;
        value += q * d * d / 2;
        gradient[i] = q * d;
    }
    return value;
}

static double rosenbrock(const problem *p, const double *x, double *gradient) {
    double value = 1e-3;
    memset(gradient, 0, sizeof *gradient * (size_t)p->n);
    for (int i = 0; i + 1 < p->n; i++) {
        double a = x[i + 1] - x[i] * x[i], b = 1 - x[i];
        value += 100 * a * a + b * b;
        gradient[i] -= 400 * a * x[i] + 2 * b;
        gradient[i + 1] += 200 * a;
    }
    return value;
}

double problem_off_gradient(const problem *p, const double *d) {
    double dd = 0, gg = 0, dg = 0;
    for (int i = 0; i < p->n; i++) {
        dd += d[i] * d[i];
        gg += p->g[i] * p->g[i];
        dg += d[i] * p->g[i];
    }
    return sqrt(fmax(0, dd - dg * dg / gg) / dd);
}

double problem_evaluate(void *context, const double *x, double *gradient) {
    problem *p = context;
    double d[MOST], length = 0, value = p->shape == QUADRATIC ? quadratic(p, x, gradient) : rosenbrock(p, x, gradient);
    p->calls++;
    for (int i = 0; i < p->n; i++) {
        d[i] = x[i] - p->x[i];
        length = fmax(length, fabs(d[i]));
    }
    p->longest = fmax(p->longest, length);
    if (!p->tried++)
        memcpy(p->first_trial, d, sizeof d);
    if (p->only_along_gradient && !(problem_off_gradient(p, d) <= 1e-6))
        return (double)NAN;
    return p->undefined_after && p->reports >= p->undefined_after ? (double)NAN : value;
}

void problem_evaluate_at(void *context, co_iterate *at) {
    at->value = problem_evaluate(context, at->x, at->gradient);
}

double problem_step_length(void *context, const double *d) {
    double length = 0;
    for (int i = 0; i < ((problem *)context)->n; i++)
        length = fmax(length, fabs(d[i]));
    return length;
}

co_step_verdict problem_settle(void *context, const co_iterate *before, co_iterate *now, int iteration) {
    problem *p = context;
    (void)iteration;
    p->settles++;
    p->tried = 0;
    p->longest = 0;
    co_step_verdict verdict = p->settles >= p->verdict_from && p->settles < p->verdict_to ? p->verdict : CO_STEP_KEEP;
    if (verdict == CO_STEP_REJECT || verdict == CO_STEP_STOP) {
        memcpy(now->x, before->x, sizeof *now->x * (size_t)p->n);
        memcpy(now->gradient, before->gradient, sizeof *now->x * (size_t)p->n);
        now->value = before->value;
    }
    memcpy(p->x, now->x, sizeof *p->x * (size_t)p->n);
    memcpy(p->g, now->gradient, sizeof *p->g * (size_t)p->n);
    return verdict;
}

int problem_report(void *context, const co_iterate *now, const co_step_record *record) {
    problem *p = context;
    p->reports++;
    CHECK_INT(record->iteration, p->reports);
    p->promise = record->predicted / (p->told_value - now->value);
    p->told_value = now->value;
    CHECK_INT(record->evaluations, p->calls - 1); /* but for the one at the start */
    CHECK_TRUE(now->value <= p->value + 1e-13 * fabs(p->value));
    p->value = now->value;
    return record->iteration == p->cancel_at;
}

void problem_minimize(problem *p, run *r) {
    curvopt_error error;
    co_objective f = {.context = p,
                      .n = (size_t)p->n,
                      .evaluate = problem_evaluate_at,
                      .step_length = problem_step_length,
                      .review_step = problem_settle,
                      .report = problem_report};
    for (int i = 0; i < p->n; i++)
        r->x[i] = p->shape == QUADRATIC ? 5 : i % 2 ? 1 : -1.2;
    r->now = (co_iterate){.x = r->x, .gradient = r->g};
    int undefined_after = p->undefined_after, along = p->only_along_gradient;
    p->undefined_after = p->only_along_gradient = 0; /* the start is always good */
    r->now.value = p->value = problem_evaluate(p, r->x, r->g);
    p->undefined_after = undefined_after;
    p->only_along_gradient = along;
    memcpy(p->x, r->x, sizeof r->x);
    memcpy(p->g, r->g, sizeof r->g);
    p->tried = 0;
    p->longest = 0;
    CHECK_OK(co_lbfgs(&f, &r->options, &r->now, &r->result, &error), &error);
    CHECK_TRUE(r->now.x == r->x && r->now.gradient == r->g); /* the caller's arrays, whatever happened inside */
    CHECK_INT(r->result.evaluations, p->calls - 1);
    double g[MOST], value = p->shape == QUADRATIC ? quadratic(p, r->x, g) : rosenbrock(p, r->x, g);
    CHECK_NEAR(value, r->now.value, 1e-15 * fabs(value));
    for (int i = 0; i < p->n; i++)
        CHECK_NEAR(g[i], r->g[i], 0);
}
