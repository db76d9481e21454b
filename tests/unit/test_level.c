/* One level: it ends where the certificate is met, or, cancelled, at the last iterate that was reported; what it
 * refuses. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "linalg/vector.h"
#include "solve/certificate.h"
#include "solve/level_figures.h"
#include "solve/newton_decrement.h"

/* What a level reported. */
typedef struct reports {
    int calls, cancel_at, iteration, rejected;
    int by_method[3]; /* co_method */
    double value;
    double *x; /* [n_variables] of the last one */
} reports;

static int record(const co_level *l, const co_step_record *step, void *user) {
    reports *r = user;
    size_t n = co_level_objective_n(&l->objective);
    CHECK_INT(step->iteration, r->calls);
    CHECK_TRUE(step->rejected >= r->rejected && step->evaluations >= r->calls);
    CHECK_INT(step->method == CO_METHOD_NONE, r->calls == 0);
    CHECK_BETWEEN(step->method, CO_METHOD_NONE, CO_METHOD_NEWTON);
    r->by_method[step->method]++;
    r->rejected = step->rejected;
    r->iteration = step->iteration;
    r->value = l->now.value;
    if (!r->x)
        r->x = calloc(n, sizeof *r->x);
    CHECK_TRUE(r->x != NULL);
    memcpy(r->x, l->now.x, n * sizeof *r->x);
    return ++r->calls == r->cancel_at;
}

/* Solves; the level is the caller's. */
static co_level *solved(solve_setting *s, co_motion motion, reports *r, co_outcome *outcome) {
    const co_level_prospect prospect = {0};
    curvopt_error error;
    co_level *l = solve_level_of(s, motion);
    l->error = &error;
    l->report = record;
    l->user = r;
    CHECK_OK(co_level_solve(l, &prospect, outcome, &error), &error);
    l->error = NULL;
    CHECK_INT(outcome->iterations, r->iteration);
    CHECK_INT(outcome->rejected, r->rejected);
    return l;
}

/* Decrements over what the level moves and of the shape are below the threshold, by rules of their own. */
static void check_certified(solve_setting *s, co_level *l) {
    double decrement, *xyz = calloc(3 * (size_t)s->c.n_vertices, sizeof *xyz);
    curvopt_energies energies;
    curvopt_error error;
    int resolved;
    CHECK_TRUE(xyz != NULL);
    CHECK_OK(co_level_finish(l, xyz, &energies, &resolved, &error), &error);
    CHECK_TRUE(resolved);
    CHECK_NEAR(energies.objective, solve_energy(s, xyz), 1e-3 * energies.objective);
    co_level_objective_evaluate(&l->objective, &l->now);
    CHECK_OK(co_newton_decrement(&l->hessian, &l->now, 0, &decrement, &error), &error);
    CHECK_BETWEEN(decrement, 0, 1e-6 * energies.objective);
    co_certificate_shape shape = solve_shape(s, &s->symmetry, xyz, l->motion == CO_MOTION_ALL ? l : NULL, 0);
    CHECK_INT(co_certificate_verdict(&s->tuning, l->now.value, decrement, &shape), CURVOPT_VERDICT_MINIMUM);
    free(xyz);
}

/* Over all coordinates, or from a cage whose shape nearly stands along its normals, which takes Newton's method alone.
 */
static void check_level(cage c, curvopt_options options, co_motion motion) {
    solve_setting *s = solve_setting_of(c, &options);
    if (motion == CO_MOTION_NORMALS) {
        solve_minimized(s);
        s->c = cage_shaken(s->c, 1e-4 * s->run.radius);
    }
    reports r = {0};
    co_outcome outcome;
    double before = solve_energy(s, s->c.xyz);
    co_level *l = solved(s, motion, &r, &outcome);
    CHECK_TRUE(outcome.stop == CURVOPT_STOP_CONVERGED || outcome.stop == CURVOPT_STOP_SETTLED);
    CHECK_BETWEEN(l->now.value, 0, (motion == CO_MOTION_ALL ? 0.99 : 1.001) * before);
    CHECK_INT(r.by_method[CO_METHOD_LBFGS] > 0, motion == CO_MOTION_ALL);
    CHECK_TRUE(r.by_method[CO_METHOD_NEWTON] > 0);
    CHECK_BETWEEN(co_level_moved(l), 1e-9, 10);
    check_certified(s, l);
    free(r.x);
    co_level_destroy(l);
    solve_setting_free(s);
}

static void test_final_level_ends_certified(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE),
                    mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS);
    w.spacing = CURVOPT_SPACING_EVEN;
    w.tolerance = 1e-6; /* along soft directions other rules have other minima */
    check_level(cage_shaken(cage_refined(cage_cube(), 1), 0.1), w, CO_MOTION_NORMALS);
    check_level(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), w, CO_MOTION_NORMALS);
    check_level(cage_shaken(cage_band(8, 4, 1, 1, 1), 0.05), w, CO_MOTION_NORMALS);
    check_level(cage_shaken(cage_torus(8, 4, 1, 0.5), 0.05), mvs, CO_MOTION_ALL);
}

/* The mean of |edge|^4 over the square of that of |edge|^2. */
static double spread_of(const curvopt_mesh *m, const double *x) {
    double sum[2] = {0};
    for (int32_t k = 0; k < m->info.n_edges; k++) {
        int32_t h = m->edge_corner[k];
        const double *a = x + 3 * m->corner_vertex[h], *b = x + 3 * co_mesh_destination(m, h);
        double square = pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2);
        sum[0] += square;
        sum[1] += square * square;
    }
    return m->info.n_edges * sum[1] / (sum[0] * sum[0]);
}

/* An even spacing is part of what is minimized until the shape stands: edges become more alike, and the energy ends a
 * little above where vertices slide for its sake. */
static void test_even_level_spaces_its_cage(void **state) {
    (void)state;
    double spread = 0, energy[2], before = 0;
    for (int even = 0; even < 2; even++) {
        curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
        w.spacing = even ? CURVOPT_SPACING_EVEN : CURVOPT_SPACING_FREE;
        solve_setting *s = solve_setting_of(cage_shaken(cage_torus(10, 6, 1, 0.6), 0.25), &w);
        reports r = {0};
        co_outcome outcome;
        before = spread_of(s->mesh, s->c.xyz);
        co_level *l = solved(s, CO_MOTION_ALL, &r, &outcome);
        CHECK_INT(l->is_final, !even);
        CHECK_TRUE((l->now.found[CO_FOUND_SPACING] > 0) == even);
        energy[even] = co_level_objective_energy(&l->objective, &l->now);
        CHECK_NEAR(l->now.value, energy[even] + l->now.found[CO_FOUND_SPACING], 1e-12 * l->now.value);
        co_level_objective_place(&l->objective, l->now.x);
        spread = spread_of(s->mesh, l->objective.positions);
        free(r.x);
        co_level_destroy(l);
        solve_setting_free(s);
    }
    CHECK_BETWEEN(spread, 1, 0.97 * before);
    CHECK_BETWEEN(energy[1] / energy[0], 1, 1.02);
}

/* While a shape forms rules are rough where they are worth it, unless vertices slide freely; what has settled has none.
 */
static void test_level_forms_by_rough_rules(void **state) {
    (void)state;
    static const struct {
        int from, spacing, rough;
    } of[] = {{24, CURVOPT_SPACING_EVEN, 1}, {25, CURVOPT_SPACING_EVEN, 0}, {24, CURVOPT_SPACING_FREE, 0}};
    for (size_t k = 0; k < sizeof of / sizeof *of; k++) {
        curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
        w.spacing = of[k].spacing;
        solve_setting *s = solve_setting_of(cage_shaken(cage_refined(cage_cube(), 1), 0.1), &w);
        s->tuning.rough_from = of[k].from; /* each of the 24 faces has a corner of three */
        co_level *l = solve_level(s);
        const co_assembly *a = &l->objective.assembly;
        CHECK_INT(a->coarsest, of[k].rough ? CO_ROUGH_RULE : 0);
        CHECK_NEAR(l->working_tolerance / l->tolerance,
                   of[k].rough ? s->tuning.working_forming : s->tuning.working_factor, 1e-12);
        const int64_t n_samples = a->batches.n_samples;
        co_level_destroy(l);
        reports r = {0};
        co_outcome outcome;
        l = solved(s, CO_MOTION_ALL, &r, &outcome);
        a = &l->objective.assembly;
        CHECK_INT(a->coarsest, 0);
        for (int32_t p = 0; p < a->patches.n_patches; p++)
            CHECK_BETWEEN(a->rule[p], 0, CO_FINEST_RULE);
        CHECK_TRUE(!of[k].rough || a->batches.n_samples > 2 * n_samples);
        free(r.x);
        co_level_destroy(l);
        solve_setting_free(s);
    }
}

/* Cancelled at any report, the level stands where that said. */
static void test_cancelled_level_keeps_the_last_iterate(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    w.tolerance = 1e-3;
    for (int k = 1; k <= 7; k += 2) {
        solve_setting *s = solve_setting_of(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), &w);
        reports r = {.cancel_at = k};
        co_outcome outcome;
        co_level *l = solved(s, CO_MOTION_ALL, &r, &outcome);
        CHECK_INT(r.calls, k);
        CHECK_INT(outcome.stop, CURVOPT_STOP_CANCELLED);
        CHECK_INT(outcome.iterations, k - 1);
        for (size_t i = 0; i < co_level_objective_n(&l->objective); i++)
            CHECK_NEAR(l->now.x[i], r.x[i], 0);
        CHECK_NEAR(l->now.value, r.value, 1e-3 * r.value); /* by rules for the figures */
        co_level_destroy(l);
        free(r.x);
        solve_setting_free(s);
    }
}

/* A flag that is raised while a step is made: that step is not reported, and nothing is worse than what was. */
static int raise_flag(const co_level *l, const co_step_record *step, void *user) {
    reports *r = user;
    if (step->iteration == 3)
        curvopt_cancel_request((curvopt_cancel *)l->objective.run->cancel);
    r->value = l->now.value;
    r->calls++;
    return 0;
}

/* A level whose flag is raised at its third step. */
static co_level *level_with_flag(solve_setting **s, reports *r, curvopt_error *error) {
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    w.tolerance = 1e-6; /* what a level shows on its way is by coarser rules */
    *s = solve_setting_of(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), &w);
    co_level *l = solve_level(*s);
    l->error = error;
    l->report = raise_flag;
    l->user = r;
    return l;
}

static void test_flag_stops_a_level(void **state) {
    (void)state;
    const co_level_prospect prospect = {0};
    solve_setting *s;
    reports r = {0};
    co_outcome outcome;
    curvopt_error error;
    co_level *l = level_with_flag(&s, &r, &error);
    CHECK_OK(co_level_solve(l, &prospect, &outcome, &error), &error);
    CHECK_INT(outcome.stop, CURVOPT_STOP_CANCELLED);
    CHECK_INT(r.calls, 4);
    CHECK_BETWEEN(l->now.value, 0, r.value * (1 + 1e-3));
    co_level_destroy(l);
    solve_setting_free(s);
}

/* What takes long is cut off at the late_from-th look at the clock after the third step: whichever value is lost, the
 * level stands at the best of what it has, never at its first iterate. */
static int n_looks, late_from; /* 0: never */

double __wrap_co_clock_seconds(void);
double __real_co_clock_seconds(void);

double __wrap_co_clock_seconds(void) {
    n_looks++;
    return __real_co_clock_seconds() + (late_from > 0 && n_looks >= late_from ? 1e3 : 0);
}

static int is_cut_off(int k) {
    const co_level_prospect prospect = {0};
    solve_setting *s;
    reports r = {0};
    co_outcome outcome;
    curvopt_error error;
    co_level *l = level_with_flag(&s, &r, &error);
    const double before = l->now.value;
    co_cancel cancel = {.flag = l->objective.run->cancel};
    l->objective.assembly.cancel = &cancel;
    n_looks = 0;
    late_from = k;
    const int32_t status = co_level_solve(l, &prospect, &outcome, &error);
    const int was_cut = n_looks >= k;
    CHECK_TRUE(status == CURVOPT_OK || (was_cut && status == CO_CANCELLED));
    CHECK_INT(r.calls, 4);
    late_from = 0;
    l->objective.assembly.cancel = NULL;
    CHECK_BETWEEN(co_level_objective_value(&l->objective, l->reached), 0, 0.9 * before);
    co_level_destroy(l);
    solve_setting_free(s);
    return was_cut;
}

static void test_level_that_is_cut_off_keeps_what_stands(void **state) {
    (void)state;
    int k = 1;
    while (is_cut_off(k))
        k += 53;
    CHECK_TRUE(k > 530); /* it was cut off often */
}

/* The limit of steps counts all stages together. */
static void test_limit_of_steps(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    for (w.max_iterations = 0; w.max_iterations < 5; w.max_iterations += 2) {
        solve_setting *s = solve_setting_of(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), &w);
        reports r = {0};
        co_outcome outcome;
        co_level *l = solved(s, CO_MOTION_ALL, &r, &outcome);
        CHECK_INT(outcome.stop, CURVOPT_STOP_LIMIT);
        CHECK_INT(outcome.iterations, w.max_iterations);
        co_level_destroy(l);
        free(r.x);
        solve_setting_free(s);
    }
}

/* From a saddle some way down; from a minimum nowhere. 96 variables, no symmetry. */
static void test_saddle_is_left(void **state) {
    (void)state;
    for (int saddle = 0; saddle < 2; saddle++) {
        curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, saddle ? CURVOPT_TERM_MVS : CURVOPT_TERM_WILLMORE);
        o.symmetry = CURVOPT_SYMMETRY_KEEP;
        solve_setting *s = solve_setting_of(saddle ? cage_torus(8, 4, 1, 0.4) : cage_refined(cage_cube(), 1), &o);
        curvopt_error error;
        co_constraints lines = {0}, none = {0};
        int left;
        solve_minimized(s);
        co_symmetry_free(&s->symmetry);
        CHECK_OK(co_symmetry_none(s->mesh, &s->symmetry, &error), &error);
        if (!saddle) { /* sliding along the sphere would bring something */
            CHECK_OK(co_constraints_to_normals(s->mesh, &none, s->c.xyz, &lines, &error), &error);
            co_constraints_free(&s->constraints);
            s->constraints = lines;
        }
        co_level *l = solve_level(s);
        double before = l->now.value;
        if (!saddle)
            l->objective.gauge = co_gauge_of(o.weights, &none, 0);
        CHECK_OK(co_level_leave_saddle(l, &left, &error), &error);
        CHECK_INT(left, saddle);
        if (saddle)
            CHECK_BETWEEN(l->now.value, 0, before * (1 - s->options.decrement_tolerance));
        else
            CHECK_NEAR(l->now.value, before, 0);
        co_level_destroy(l);
        solve_setting_free(s);
    }
}

/* Two vertices of a face in one place, a whole row in another: there is no surface. */
static void test_degenerate_cage_is_refused(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    solve_setting *s = solve_setting_of(cage_torus(8, 6, 1, 0.4), &w);
    curvopt_error error;
    co_level *l = NULL;
    for (int32_t v = 0; v < 5 * 6; v++)
        for (int k = 0; k < 3; k++)
            s->c.xyz[3 * v + k] = k;
    CHECK_OK(co_level_create(&s->run, s->mesh, &s->symmetry, &s->constraints, CO_MOTION_ALL, s->c.xyz, 1, &l, &error),
             &error);
    int32_t status = co_level_begin(l, &error);
    CHECK_INT(status, CURVOPT_ERROR_GEOMETRY);
    CHECK_INT(error.code, CURVOPT_ERROR_GEOMETRY);
    CHECK_BETWEEN(error.element, 0, 47);
    CHECK_TEXT(error.message, "degenerate at face");
    co_level_destroy(l);
    co_level_destroy(NULL);
    solve_setting_free(s);
}

/* Along normals, away from where the level began: of a step by the matrix the derivative of the gradient, by a
 * difference, is what the matrix has. The shift makes the matrix positive. */
static void test_steps_along_normals_solve_the_derivative(void **state) {
    (void)state;
    const int term[2] = {CURVOPT_TERM_WILLMORE, CURVOPT_TERM_MVS};
    for (int k = 0; k < 2; k++) {
        curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, term[k]);
        solve_setting *s = solve_setting_of(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), &o);
        co_level *l = solve_level_of(s, CO_MOTION_NORMALS);
        co_level_objective *f = &l->objective;
        const size_t n = co_level_objective_n(f);
        curvopt_error error;
        double *d = calloc(3 * n, sizeof *d), *slope[2] = {d + n, d + 2 * n};
        uint64_t seed = 7;
        CHECK_TRUE(d != NULL && f->n_sliding > 0);
        for (size_t i = 0; i < n; i++)
            l->now.x[i] += 0.1 * f->edge * check_random(&seed);
        co_level_objective_normalize(f, &l->now);
        co_level_objective_evaluate(f, &l->now);
        CHECK_OK(co_level_hessian_assemble(&l->hessian, &l->now, NULL, 1, &error), &error);
        CHECK_OK(co_level_hessian_factorize_shifted(&l->hessian,
                                                    1e-3 * co_newton_system_mean_diagonal(&l->hessian.system), &error),
                 &error);
        CHECK_TRUE(l->hessian.has_factor);
        const double shift = l->hessian.shift;
        CHECK_OK(co_level_hessian_solve(&l->hessian, l->now.gradient, d, &error), &error);
        co_level_objective_restrict(f, d);
        const double step = 1e-4 * f->edge / co_level_objective_length(f, d);
        for (int side = 0; side < 2; side++) {
            co_iterate at = {.x = s->c.xyz, .gradient = slope[side]}; /* which has room */
            memcpy(at.x, l->now.x, n * sizeof *at.x);
            co_vector_add(n, side ? -step : step, d, at.x);
            co_level_objective_evaluate(f, &at);
        }
        for (size_t i = 0; i < n; i++)
            CHECK_NEAR((slope[0][i] - slope[1][i]) / (2 * step) + shift * d[i], l->now.gradient[i],
                       1e-4 * co_vector_norm(n, l->now.gradient));
        free(d);
        co_level_destroy(l);
        solve_setting_free(s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_final_level_ends_certified),
        cmocka_unit_test(test_steps_along_normals_solve_the_derivative),
        cmocka_unit_test(test_even_level_spaces_its_cage),
        cmocka_unit_test(test_level_forms_by_rough_rules),
        cmocka_unit_test(test_cancelled_level_keeps_the_last_iterate),
        cmocka_unit_test(test_flag_stops_a_level),
        cmocka_unit_test(test_level_that_is_cut_off_keeps_what_stands),
        cmocka_unit_test(test_limit_of_steps),
        cmocka_unit_test(test_saddle_is_left),
        cmocka_unit_test(test_degenerate_cage_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
