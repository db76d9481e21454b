/* A solver that stays: warm solutions are cold ones, nothing is made twice, cancelling and refusals lose nothing.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "solve/live.h"

#include <stdlib.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { N_DRAGS = 2, N_DRAGS_LONG = 3, N_DRAGS_MVS = 2, EACH = 2 }; /* each takes ten times as long */
#else
enum { N_DRAGS = 12, N_DRAGS_LONG = 32, N_DRAGS_MVS = 4, EACH = 1 };
#endif
enum { N_PINS = 4, MOST = 24 };

static const int32_t PINS[N_PINS] = {0, 7, 13, 22}, OTHER_PINS[N_PINS] = {1, 7, 15, 20};

typedef struct setting {
    cage c;
    curvopt_mesh *mesh;
    curvopt_options options;
    curvopt_constraints constraints;
    double places[3 * N_PINS];
    uint64_t state; /* of random numbers */
} setting;

static double draw(setting *s) {
    s->state = s->state * 6364136223846793005u + 1442695040888963407u;
    return (double)(s->state >> 11) / 4503599627370496.0 - 1; /* -1 .. 1 */
}

static void pin(setting *s, const int32_t *vertices) {
    s->constraints = (curvopt_constraints){.vertices = vertices, .n = N_PINS, .has_places = 1, .places = s->places};
    for (int i = 0; i < 3 * N_PINS; i++)
        s->places[i] = s->c.xyz[3 * vertices[i / 3] + i % 3];
}

/* Takes the cage over. It stays where it is: options point into it. */
static void set_up(setting *s, cage c, int32_t spacing, int term) {
    *s = (setting){.c = c, .state = 7};
    s->mesh = cage_mesh(&s->c);
    curvopt_options_init(&s->options, sizeof s->options);
    s->options.weights[CURVOPT_TERM_WILLMORE] = 0;
    s->options.weights[term] = 1;
    s->options.spacing = spacing;
    s->options.tolerance = 1e-7;
    s->options.decrement_tolerance = 1e-9;
    s->options.threads = 1;
    s->options.constraints = &s->constraints;
    pin(s, PINS);
}

/* A shaken torus, minimized without constraints: fair, and without symmetry. Of a cage that is not fair several minima
 * are in reach. */
static cage uneven_torus(void) {
    cage c = cage_shaken(cage_torus(6, 4, 1, 0.45), 0.05);
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_options o;
    curvopt_result *result;
    curvopt_error error;
    curvopt_options_init(&o, sizeof o);
    o.levels = 1;
    CHECK_OK(curvopt_minimize(mesh, c.xyz, &o, NULL, NULL, NULL, &result, &error), &error);
    curvopt_result_get_positions(result, c.xyz);
    curvopt_result_destroy(result);
    curvopt_mesh_destroy(mesh);
    cage_perturb(&c, 1e-3, 3);
    return c;
}

static void tear_down(setting *s) {
    curvopt_mesh_destroy(s->mesh);
    cage_free(&s->c);
}

static curvopt_solver *solver_of(const setting *s) {
    curvopt_solver *solver;
    curvopt_error error;
    CHECK_OK(curvopt_solver_create(s->mesh, s->c.xyz, &s->options, &solver, &error), &error);
    return solver;
}

/* One of the pins goes somewhere else, up to so far along each axis from where it was at first. */
static void drag_by(setting *s, curvopt_solver *solver, double amount) {
    curvopt_error error;
    const int k = (int)(2 * (1 + draw(s))) % N_PINS;
    pin(s, s->constraints.vertices);
    for (int c = 0; c < 3; c++)
        s->places[3 * k + c] += amount * draw(s);
    CHECK_OK(curvopt_solver_set_places(solver, s->places, &error), &error);
}

/* A twentieth of the torus' radius. */
static void drag(setting *s, curvopt_solver *solver) {
    drag_by(s, solver, 0.05);
}

static void solve(curvopt_solver *solver, int settle) {
    curvopt_error error;
    CHECK_OK(curvopt_solver_solve(solver, settle, NULL, NULL, NULL, &error), &error);
}

/* The objective at xyz, by rules that do not depend on the way there. */
static double energy_at(const setting *s, const double *xyz) {
    curvopt_problem *problem;
    curvopt_energies e;
    curvopt_error error;
    curvopt_options o = s->options;
    o.tolerance = 1e-9;
    o.constraints = NULL;
    CHECK_OK(curvopt_problem_create(s->mesh, NULL, &o, &problem, &error), &error);
    CHECK_OK(curvopt_problem_evaluate(problem, xyz, &e, sizeof e, NULL, &error), &error);
    curvopt_problem_destroy(problem);
    return e.objective;
}

static double energy_of(const setting *s, const curvopt_solver *solver) {
    double xyz[3 * MOST];
    curvopt_solver_get_positions(solver, xyz);
    return energy_at(s, xyz);
}

static void check_settled(const setting *s, const curvopt_solver *solver) {
    double xyz[3 * MOST];
    curvopt_summary summary;
    curvopt_energies end;
    curvopt_solver_get_summary(solver, &summary, sizeof summary);
    curvopt_solver_get_energies(solver, NULL, &end, sizeof end);
    curvopt_solver_get_positions(solver, xyz);
    CHECK_INT(summary.verdict, CURVOPT_VERDICT_MINIMUM);
    CHECK_INT(summary.negative_directions, 0);
    CHECK_BETWEEN(summary.newton_decrement, 0, 1e-6 * end.objective);
    CHECK_NEAR(end.objective, energy_of(s, solver), 1e-6 * end.objective);
    for (int i = 0; i < 3 * N_PINS; i++)
        CHECK_NEAR(xyz[3 * s->constraints.vertices[i / 3] + i % 3], s->places[i], 0);
}

static double cold_energy(const setting *s) {
    curvopt_solver *cold = solver_of(s);
    solve(cold, 1);
    check_settled(s, cold);
    const double energy = energy_of(s, cold);
    curvopt_solver_destroy(cold);
    return energy;
}

/* Along a chain of drags; every other one passes through a state that is not settled. */
static void check_drags(int32_t spacing, int term, int n) {
    setting s;
    set_up(&s, uneven_torus(), spacing, term);
    curvopt_solver *warm = solver_of(&s);
    solve(warm, 1);
    check_settled(&s, warm);
    const co_level *level = warm->level;
    const co_sparse_cholesky *factor = level->hessian.system.factor;
    for (int k = 0; k < n; k++) {
        drag(&s, warm);
        if (k % 2)
            solve(warm, 0);
        solve(warm, 1);
        check_settled(&s, warm);
        const double cold = cold_energy(&s);
        CHECK_BETWEEN(energy_of(&s, warm), 0, cold * (1 + 1e-6));
    }
    CHECK_TRUE(warm->level == level && level->hessian.system.factor == factor); /* no new pattern was made */
    curvopt_solver_destroy(warm);
    tear_down(&s);
}

static void test_warm_solutions_are_cold_ones(void **state) {
    (void)state;
    const int n = long_tests() ? N_DRAGS_LONG : N_DRAGS;
    check_drags(CURVOPT_SPACING_FREE, CURVOPT_TERM_WILLMORE, n);
    check_drags(CURVOPT_SPACING_EVEN, CURVOPT_TERM_WILLMORE, n);
    check_drags(CURVOPT_SPACING_EVEN, CURVOPT_TERM_MVS, N_DRAGS_MVS);
}

/* What a callback saw. */
typedef struct seen {
    double first[3 * MOST], last[3 * MOST];
    int calls, cancel_at;
} seen;

static int32_t watch(const curvopt_progress *p, void *user) {
    seen *w = user;
    if (w->calls == 0)
        memcpy(w->first, p->xyz, sizeof(double) * 3 * (size_t)p->n_vertices);
    memcpy(w->last, p->xyz, sizeof(double) * 3 * (size_t)p->n_vertices);
    return ++w->calls == w->cancel_at;
}

/* Of what is to be gained from where only the pins have moved the first answer leaves little. */
static void test_first_answer_is_near_the_last(void **state) {
    (void)state;
    setting s;
    set_up(&s, uneven_torus(), CURVOPT_SPACING_FREE, CURVOPT_TERM_WILLMORE);
    curvopt_solver *solver = solver_of(&s);
    for (int k = 0; k < 6; k++) {
        seen w = {0};
        curvopt_error error;
        double xyz[3 * MOST];
        pin(&s, PINS);
        CHECK_OK(curvopt_solver_set_places(solver, s.places, &error), &error);
        solve(solver, 1);
        drag_by(&s, solver, k % 2 ? 0.05 : 0.01);
        curvopt_solver_get_positions(solver, xyz);
        for (int i = 0; i < 3 * N_PINS; i++)
            xyz[3 * PINS[i / 3] + i % 3] = s.places[i];
        CHECK_OK(curvopt_solver_solve(solver, 1, watch, &w, NULL, &error), &error);
        const double last = energy_of(&s, solver), gain = energy_at(&s, xyz) - last;
        CHECK_BETWEEN(energy_at(&s, w.first) - last, -1e-6 * last, (k % 2 ? 0.2 : 0.05) * gain);
    }
    curvopt_solver_destroy(solver);
    tear_down(&s);
}

/* With an even spacing the end is the shape's minimum, and what is shown first after it is that, moved by what has
 * moved: not where objective and spacing together are least. */
static void test_what_is_shown_does_not_jump_back(void **state) {
    (void)state;
    setting s;
    curvopt_error error;
    double end[3 * MOST], passing[3 * MOST], jump = 0;
    set_up(&s, uneven_torus(), CURVOPT_SPACING_EVEN, CURVOPT_TERM_WILLMORE);
    curvopt_solver *solver = solver_of(&s);
    solve(solver, 0);
    curvopt_solver_get_positions(solver, passing);
    solve(solver, 1);
    curvopt_solver_get_positions(solver, end);
    for (int i = 0; i < 3 * s.c.n_vertices; i++)
        jump = fmax(jump, fabs(passing[i] - end[i]));
    CHECK_BETWEEN(jump, 1e-4, 1);
    for (int settle = 0; settle < 2; settle++) {
        seen w = {0};
        double xyz[3 * MOST];
        CHECK_OK(curvopt_solver_set_places(solver, s.places, &error), &error);
        CHECK_OK(curvopt_solver_solve(solver, settle, watch, &w, NULL, &error), &error);
        curvopt_solver_get_positions(solver, xyz);
        for (int i = 0; i < 3 * s.c.n_vertices; i++) {
            CHECK_NEAR(w.first[i], end[i], 0.02 * jump);
            CHECK_NEAR(xyz[i], end[i], 0.02 * jump);
        }
    }
    curvopt_solver_destroy(solver);
    tear_down(&s);
}

static void test_cancelling_loses_nothing(void **state) {
    (void)state;
    setting s;
    double xyz[3 * MOST];
    curvopt_summary summary;
    curvopt_error error;
    curvopt_cancel *cancel;
    set_up(&s, uneven_torus(), CURVOPT_SPACING_EVEN, CURVOPT_TERM_WILLMORE);
    curvopt_solver *solver = solver_of(&s);
    CHECK_OK(curvopt_cancel_create(&cancel, &error), &error);
    curvopt_cancel_request(cancel);
    CHECK_OK(curvopt_solver_solve(solver, 1, NULL, NULL, cancel, &error), &error); /* before there is anything */
    for (int at = 1; at < 8; at += EACH) {
        seen w = {.cancel_at = at};
        drag(&s, solver);
        CHECK_OK(curvopt_solver_solve(solver, 1, watch, &w, NULL, &error), &error);
        curvopt_solver_get_summary(solver, &summary, sizeof summary);
        curvopt_solver_get_positions(solver, xyz);
        if (w.calls == at) {
            CHECK_INT(summary.stop, CURVOPT_STOP_CANCELLED);
            CHECK_INT(summary.verdict, CURVOPT_VERDICT_UNKNOWN);
            for (int i = 0; i < 3 * s.c.n_vertices; i++)
                CHECK_NEAR(xyz[i], w.last[i], 1e-12);
        }
        CHECK_OK(curvopt_solver_solve(solver, 1, NULL, NULL, cancel, &error), &error);
        solve(solver, 1);
        check_settled(&s, solver);
        CHECK_BETWEEN(energy_of(&s, solver), 0, cold_energy(&s) * (1 + 1e-6));
    }
    curvopt_cancel_destroy(cancel);
    curvopt_solver_destroy(solver);
    tear_down(&s);
}

/* Other vertices, another energy, a strength, springs, no constraints at all: as a new solver has it. */
static void test_other_options(void **state) {
    (void)state;
    setting s;
    curvopt_error error;
    const double springs[N_PINS] = {1, 0.5, 1, 0.9};
    set_up(&s, uneven_torus(), CURVOPT_SPACING_FREE, CURVOPT_TERM_WILLMORE);
    curvopt_solver *solver = solver_of(&s);
    solve(solver, 1);
    pin(&s, OTHER_PINS);
    CHECK_OK(curvopt_solver_set_options(solver, &s.options, &error), &error);
    drag(&s, solver);
    solve(solver, 1);
    check_settled(&s, solver);
    CHECK_BETWEEN(energy_of(&s, solver), 0, cold_energy(&s) * (1 + 1e-6));
    s.options.weights[CURVOPT_TERM_WILLMORE] = 0;
    s.options.weights[CURVOPT_TERM_MEAN] = 1;
    CHECK_OK(curvopt_solver_set_options(solver, &s.options, &error), &error);
    solve(solver, 1);
    check_settled(&s, solver);
    CHECK_BETWEEN(energy_of(&s, solver), 0, cold_energy(&s) * (1 + 1e-6));
    s.options.strength = 0.2;
    CHECK_OK(curvopt_solver_set_options(solver, &s.options, &error), &error);
    drag(&s, solver);
    solve(solver, 1);
    check_settled(&s, solver);
    CHECK_NEAR(energy_of(&s, solver) / cold_energy(&s), 1, 1e-5); /* springs are not in it */
    s.options.strength = 1;
    s.constraints.weights = springs;
    CHECK_OK(curvopt_solver_set_options(solver, &s.options, &error), &error);
    for (int k = 0; k < 2; k++) {
        curvopt_solver *cold;
        drag(&s, solver);
        solve(solver, 1);
        cold = solver_of(&s);
        solve(cold, 1);
        CHECK_NEAR(energy_of(&s, solver) / energy_of(&s, cold), 1, 1e-5);
        curvopt_solver_destroy(cold);
    }
    s.options.constraints = NULL;
    CHECK_OK(curvopt_solver_set_options(solver, &s.options, &error), &error);
    solve(solver, 1);
    CHECK_REFUSED(curvopt_solver_set_places(solver, s.places, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "no constraints");
    curvopt_solver_destroy(solver);
    tear_down(&s);
}

static void test_same_bits_for_any_threads(void **state) {
    (void)state;
    double xyz[2][3 * MOST];
    for (int threads = 1; threads <= 2; threads++) {
        setting s;
        set_up(&s, uneven_torus(), CURVOPT_SPACING_EVEN, CURVOPT_TERM_MVS);
        s.options.tolerance = 1e-4;
        s.options.threads = threads;
        curvopt_solver *solver = solver_of(&s);
        solve(solver, 1);
        for (int k = 0; k < 4; k++) {
            drag(&s, solver);
            solve(solver, k % 2);
        }
        curvopt_solver_get_positions(solver, xyz[threads - 1]);
        curvopt_solver_destroy(solver);
        tear_down(&s);
    }
    CHECK_TRUE(memcmp(xyz[0], xyz[1], sizeof xyz[0]) == 0);
}

/* Symmetries that places break are given up, and come back with the cage. */
static void test_symmetries(void **state) {
    (void)state;
    setting s;
    curvopt_summary summary;
    curvopt_error error;
    set_up(&s, cage_torus(6, 4, 1, 0.45), CURVOPT_SPACING_EVEN, CURVOPT_TERM_WILLMORE);
    s.constraints.n = 1;
    s.options.tolerance = 1e-4;
    s.options.max_iterations = 10; /* the symmetry is that of the start */
    curvopt_solver *solver = solver_of(&s);
    solve(solver, 1);
    curvopt_solver_get_summary(solver, &summary, sizeof summary);
    CHECK_TRUE(summary.symmetry_order > 1);
    s.places[0] += 0.04;
    s.places[1] += 0.05;
    s.places[2] += 0.06;
    CHECK_OK(curvopt_solver_set_places(solver, s.places, &error), &error);
    solve(solver, 1);
    curvopt_solver_get_summary(solver, &summary, sizeof summary);
    CHECK_INT(summary.symmetry_order, 1);
    pin(&s, PINS);
    CHECK_OK(curvopt_solver_set_places(solver, s.places, &error), &error);
    CHECK_OK(curvopt_solver_set_positions(solver, NULL, &error), &error);
    solve(solver, 0);
    curvopt_solver_get_summary(solver, &summary, sizeof summary);
    CHECK_TRUE(summary.symmetry_order > 1);
    curvopt_solver_destroy(solver);
    tear_down(&s);
}

static void test_what_is_refused(void **state) {
    (void)state;
    setting s;
    curvopt_solver *none;
    curvopt_error error;
    double before[3 * MOST], after[3 * MOST];
    set_up(&s, uneven_torus(), CURVOPT_SPACING_EVEN, CURVOPT_TERM_WILLMORE);
    curvopt_solver *solver = solver_of(&s);
    solve(solver, 1);
    curvopt_solver_get_positions(solver, before);
    CHECK_REFUSED(curvopt_solver_solve(solver, 2, NULL, NULL, NULL, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "settle");
    s.places[1] = (double)INFINITY;
    CHECK_INT(curvopt_solver_set_places(solver, s.places, &error), CURVOPT_ERROR_ARGUMENT);
    pin(&s, PINS);
    s.options.slide = 1;
    CHECK_REFUSED(curvopt_solver_set_options(solver, &s.options, &error), &error, CURVOPT_ERROR_UNSUPPORTED, -1,
                  "slide");
    CHECK_REFUSED(curvopt_solver_create(s.mesh, s.c.xyz, &s.options, &none, &error), &error, CURVOPT_ERROR_UNSUPPORTED,
                  -1, "slide");
    CHECK_TRUE(none == NULL);
    s.options.slide = 0;
    s.options.no_crossings = 1;
    CHECK_REFUSED(curvopt_solver_set_options(solver, &s.options, &error), &error, CURVOPT_ERROR_UNSUPPORTED, -1,
                  "no_crossings");
    s.options.no_crossings = 0;
    after[0] = (double)NAN;
    for (int i = 1; i < 3 * s.c.n_vertices; i++)
        after[i] = before[i];
    CHECK_INT(curvopt_solver_set_positions(solver, after, &error), CURVOPT_ERROR_GEOMETRY);
    curvopt_solver_get_positions(solver, after);
    for (int i = 0; i < 3 * s.c.n_vertices; i++)
        CHECK_NEAR(after[i], before[i], 0);
    drag(&s, solver);
    solve(solver, 1);
    check_settled(&s, solver);
    curvopt_solver_destroy(solver);
    tear_down(&s);
}

/* Handles that coincide, that go through each other and far away: whatever comes of it, the way back is open. */
static void test_wild_drags(void **state) {
    (void)state;
    setting s;
    curvopt_error error;
    double xyz[3 * MOST];
    set_up(&s, uneven_torus(), CURVOPT_SPACING_EVEN, CURVOPT_TERM_WILLMORE);
    s.options.tolerance = 1e-3;
    s.options.max_iterations = 60;
    curvopt_solver *solver = solver_of(&s);
    solve(solver, 1);
    for (int k = 0; k < 4; k++) {
        pin(&s, PINS);
        for (int c = 0; c < 3; c++)
            s.places[c] = k < 2 ? s.places[3 * (k + 1) + c] : k == 2 ? 100.0 * (c + 1) : -s.places[c];
        CHECK_OK(curvopt_solver_set_places(solver, s.places, &error), &error);
        const int32_t status = curvopt_solver_solve(solver, 0, NULL, NULL, NULL, &error);
        CHECK_TRUE(status == CURVOPT_OK || status == CURVOPT_ERROR_GEOMETRY || status == CURVOPT_ERROR_RESOLUTION);
        curvopt_solver_get_positions(solver, xyz);
        for (int i = 0; i < 3 * s.c.n_vertices; i++)
            CHECK_TRUE(isfinite(xyz[i]));
    }
    pin(&s, PINS);
    CHECK_OK(curvopt_solver_set_places(solver, s.places, &error), &error);
    CHECK_OK(curvopt_solver_set_positions(solver, NULL, &error), &error);
    s.options.max_iterations = 3000;
    s.options.tolerance = 1e-7;
    CHECK_OK(curvopt_solver_set_options(solver, &s.options, &error), &error);
    solve(solver, 1);
    check_settled(&s, solver);
    curvopt_solver_destroy(solver);
    tear_down(&s);
}

/* Newton's method by matrices of far too coarse rules ends when these promise nothing more. A certificate that asks for
 * more than they can see sends it on by the rules of the function, where it converges. */
static void test_matrices_that_are_off_are_not_the_end(void **state) {
    (void)state;
    setting s;
    curvopt_error error;
    curvopt_summary summary;
    curvopt_solver *solver;
    co_tuning tuning = co_tuning_defaults;
    tuning.newton_coarser = 7;
    tuning.certificate_stationary = 1e-11;
    set_up(&s, uneven_torus(), CURVOPT_SPACING_EVEN, CURVOPT_TERM_WILLMORE);
    s.options.tolerance = 1e-4;
    s.options.decrement_tolerance = 2e-7;
    CHECK_OK(co_live_create(s.mesh, s.c.xyz, &s.options, &tuning, &solver, &error), &error);
    for (int k = 0; k < 3; k++) {
        drag(&s, solver);
        solve(solver, 1);
        curvopt_solver_get_summary(solver, &summary, sizeof summary);
        CHECK_INT(summary.verdict, CURVOPT_VERDICT_MINIMUM);
    }
    curvopt_solver_destroy(solver);
    tear_down(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_warm_solutions_are_cold_ones),
                                       cmocka_unit_test(test_first_answer_is_near_the_last),
                                       cmocka_unit_test(test_what_is_shown_does_not_jump_back),
                                       cmocka_unit_test(test_cancelling_loses_nothing),
                                       cmocka_unit_test(test_other_options),
                                       cmocka_unit_test(test_same_bits_for_any_threads),
                                       cmocka_unit_test(test_symmetries),
                                       cmocka_unit_test(test_what_is_refused),
                                       cmocka_unit_test(test_wild_drags),
                                       cmocka_unit_test(test_matrices_that_are_off_are_not_the_end)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
