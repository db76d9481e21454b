/* Runs over levels: what the callback is told, what cancelling returns, how levels hang together, what is refused.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "linalg/vector.h"
#include "mesh/similarity.h"
#include "solve/multilevel.h"

/* What the callback was told last, and how much of everything. */
typedef struct watcher {
    curvopt_progress last;
    double *xyz; /* [3 n_vertices] of the last report */
    int32_t calls, cancel_at;
    int32_t in_level[4], by_method[3], shifts;
    double first_shift[4], last_shift[4]; /* of each level, by L-BFGS */
} watcher;

static void note_shift(watcher *w, const curvopt_progress *p) {
    if (p->method != CURVOPT_STEP_LBFGS || isnan(p->shift))
        return;
    if (p->iteration == 1)
        w->first_shift[p->level] = p->shift;
    w->last_shift[p->level] = p->shift;
}

/* A step's numbers, and none where there is no step. */
static void check_step(const curvopt_progress *p) {
    CHECK_BETWEEN(p->method, CURVOPT_STEP_NONE, CURVOPT_STEP_NEWTON);
    CHECK_INT(p->method == CURVOPT_STEP_NONE, p->iteration == 0);
    if (p->iteration == 0) {
        CHECK_TRUE(isnan(p->predicted) && isnan(p->gain_ratio) && isnan(p->step) && isnan(p->shift));
        return;
    }
    CHECK_BETWEEN(p->step, 1e-12, 1e3);
    CHECK_TRUE(isfinite(p->predicted) && isfinite(p->gain_ratio));
    if (p->method == CURVOPT_STEP_NEWTON) /* the model of L-BFGS rises again behind twice its step */
        CHECK_TRUE(p->predicted > 0 && isfinite(p->shift));
    CHECK_TRUE(isnan(p->shift) || p->shift >= 0);
}

static int32_t watch(const curvopt_progress *p, void *user) {
    watcher *w = user;
    const curvopt_progress *last = &w->last;
    size_t size = 3 * sizeof(double) * (size_t)p->n_vertices;
    CHECK_INT(p->struct_size, sizeof *p);
    CHECK_INT(p->n_vertices, p->mesh->info.n_vertices);
    CHECK_INT(p->reserved, 0);
    CHECK_TRUE(p->samples > 0 && p->energy > 0 && isfinite(p->energy));
    CHECK_TRUE(p->start_energy > 0 && (w->calls == 0 || p->start_energy == last->start_energy));
    CHECK_TRUE(p->gradient_norm >= 0 && isfinite(p->gradient_norm));
    CHECK_TRUE(p->seconds >= (w->calls ? last->seconds : 0));
    check_step(p);
    if (w->calls && p->level == last->level) {
        CHECK_INT(p->iteration, last->iteration + 1);
        CHECK_TRUE(p->rejected >= last->rejected && p->evaluations > last->evaluations);
    } else {
        CHECK_INT(p->iteration, 0);
        CHECK_INT(p->rejected, 0);
        CHECK_INT(p->level, w->calls ? last->level + 1 : 1);
        CHECK_INT(p->evaluations, 1);
    }
    w->xyz = realloc(w->xyz, size);
    CHECK_TRUE(w->xyz != NULL);
    memcpy(w->xyz, p->xyz, size);
    w->last = *p;
    w->in_level[p->level]++;
    w->by_method[p->method]++;
    w->shifts += isfinite(p->shift) != 0;
    note_shift(w, p);
    return ++w->calls == w->cancel_at;
}

/* A run, its summary, its cage. */
typedef struct finished {
    solve_setting *s;
    curvopt_result *result;
    curvopt_summary summary;
    double *xyz;
    watcher w;
} finished;

static void finish(finished *f, curvopt_progress_fn progress, void *user) {
    solve_setting *s = f->s;
    curvopt_error error;
    CHECK_OK(co_multilevel_minimize(s->mesh, s->c.xyz, &s->options, &s->tuning, progress, user, &s->cancel, &f->result,
                                    &error),
             &error);
    curvopt_result_get_summary(f->result, &f->summary, sizeof f->summary);
    f->xyz = calloc(3 * (size_t)f->summary.n_vertices, sizeof *f->xyz);
    CHECK_TRUE(f->xyz != NULL);
    curvopt_result_get_positions(f->result, f->xyz);
}

static finished run_setting(solve_setting *s, int32_t cancel_at) {
    finished f = {.s = s, .w = {.cancel_at = cancel_at}};
    finish(&f, watch, &f.w);
    return f;
}

static finished run(cage c, const curvopt_options *options, int32_t cancel_at) {
    return run_setting(solve_setting_of(c, options), cancel_at);
}

static void finished_free(finished *f) {
    curvopt_result_destroy(f->result);
    solve_setting_free(f->s);
    free(f->xyz);
    free(f->w.xyz);
}

/* ------------------------------------------------------------------------------------------- progress -- */

static void test_callback_is_told_everything(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE),
                    mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS), plain = w;
    w.levels = 2;
    finished f = run(cage_shaken(cage_torus(6, 4, 1, 0.4), 0.05), &w, 0);
    CHECK_TRUE(f.w.by_method[CURVOPT_STEP_LBFGS] > 3 && f.w.shifts > 3);
    CHECK_NEAR(f.w.last.start_energy, f.result->start.objective, 0);
    finished_free(&f);
    f = run(cage_shaken(cage_torus(6, 4, 1, 0.4), 0.05), &mvs, 0);
    CHECK_TRUE(f.w.by_method[CURVOPT_STEP_LBFGS] > 0 && f.w.by_method[CURVOPT_STEP_NEWTON] > 0);
    finished_free(&f);
    plain.method = CURVOPT_METHOD_LMVM;
    plain.max_iterations = 20;
    f = run(cage_shaken(cage_torus(6, 4, 1, 0.4), 0.05), &plain, 0);
    CHECK_INT(f.w.by_method[CURVOPT_STEP_LBFGS], 20);
    CHECK_INT(f.w.shifts, 0); /* there is no Hessian */
    finished_free(&f);
}

/* The matrix of a finer level is as stiff as that by which the shape formed on the level before, softened as that of
 * each stage is. Held numbers, whose ways back are softened by that matrix, make no difference. */
static void test_the_shift_goes_over_to_the_next_level(void **state) {
    (void)state;
    curvopt_options mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS);
    mvs.levels = 3;
    mvs.spacing = CURVOPT_SPACING_EVEN;
    mvs.symmetry = CURVOPT_SYMMETRY_NONE;
    for (int holds = 0; holds < 2; holds++) {
        mvs.scalar_rule[CURVOPT_SCALAR_VOLUME] = holds ? CURVOPT_SCALAR_RULE_KEEP : CURVOPT_SCALAR_RULE_FREE;
        mvs.scalar_rule[CURVOPT_SCALAR_AREA] = mvs.scalar_rule[CURVOPT_SCALAR_VOLUME];
        finished f = run(cage_shaken(cage_torus(8, 4, 1, 0.4), 0.3), &mvs, 0);
        const double factor = f.s->tuning.soften_factor;
        for (int level = 1; level < 3; level++)
            CHECK_NEAR(f.w.first_shift[level + 1], factor * f.w.last_shift[level], 1e-12 * f.w.last_shift[level]);
        finished_free(&f);
    }
}

/* ----------------------------------------------------------------------------------------- lost levels -- */

/* Willmore on two levels, by rules of 5 %, without symmetries. */
static curvopt_options loosely(void) {
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    w.levels = 2;
    w.tolerance = 0.05;
    w.spacing = CURVOPT_SPACING_EVEN;
    w.symmetry = CURVOPT_SYMMETRY_NONE;
    return w;
}

/* Where finer rules that see a hundredth more see a fold, with so many turns by these. */
static finished run_easily_lost(cage c, int tries) {
    const curvopt_options w = loosely();
    solve_setting *s = solve_setting_of(c, &w);
    s->tuning.review_fold = 1.01;
    s->tuning.finer_tries = tries;
    return run_setting(s, 0);
}

/* The energy of what was found by rules of 1e-5. */
static double by_fine_rules(const finished *f) {
    curvopt_options w = f->s->options;
    curvopt_problem *problem;
    curvopt_energies fine;
    curvopt_error error;
    w.tolerance = 1e-5;
    w.weights[CURVOPT_TERM_WILLMORE] = 1;
    w.constraints = NULL;
    CHECK_OK(curvopt_problem_create(curvopt_result_mesh(f->result), f->xyz, &w, &problem, &error), &error);
    CHECK_OK(curvopt_problem_evaluate(problem, f->xyz, &fine, sizeof fine, NULL, &error), &error);
    curvopt_problem_destroy(problem);
    return fine.objective;
}

/* By rules of 5 % both tori are lost; by finer ones they end as what a torus can have, just above 8 pi^2 = 78.9568. The
 * level's report counts what was lost. */
static void test_a_level_that_is_lost_begins_again(void **state) {
    (void)state;
    for (int k = 3; k <= 4; k++) {
        finished lost = run_easily_lost(cage_shaken(cage_torus(7, 4, 1, 0.4), 0.1 * k), 0),
                 found = run_easily_lost(cage_shaken(cage_torus(7, 4, 1, 0.4), 0.1 * k), 2);
        CHECK_INT(lost.summary.stop, CURVOPT_STOP_UNRESOLVED);
        CHECK_INT(found.summary.stop, CURVOPT_STOP_CONVERGED);
        CHECK_INT(found.summary.verdict, CURVOPT_VERDICT_MINIMUM);
        CHECK_BETWEEN(by_fine_rules(&found), 78.956, 79.2);
        CHECK_TRUE(found.result->end.objective < 0.9 * lost.result->end.objective);
        CHECK_TRUE(found.result->level[1].iterations > lost.result->level[1].iterations);
        finished_free(&lost);
        finished_free(&found);
    }
}

/* Where any gradient is too much at its end, the last level begins again as often as it may, and no other does. */
static void test_the_last_level_is_lost_where_its_gradient_has_grown(void **state) {
    (void)state;
    finished f[2];
    for (int k = 0; k < 2; k++) {
        const curvopt_options w = loosely();
        solve_setting *s = solve_setting_of(cage_shaken(cage_torus(7, 4, 1, 0.4), 0.1), &w);
        s->tuning.finer_gradient = k ? 0 : 100;
        f[k] = run_setting(s, 0);
        CHECK_INT(f[k].summary.verdict, CURVOPT_VERDICT_MINIMUM);
        CHECK_BETWEEN(by_fine_rules(&f[k]), 78.956, 79.2);
    }
    CHECK_INT(f[1].result->level[0].iterations, f[0].result->level[0].iterations);
    CHECK_TRUE(f[1].result->level[1].iterations > 2 * f[0].result->level[1].iterations);
    for (int k = 0; k < 2; k++)
        finished_free(&f[k]);
}

/* From its second level on a run counts its energy a hundredfold, and takes every change of rules for a fold. */
static int32_t spoil(const curvopt_progress *p, void *user) {
    solve_setting *s = user;
    s->options.weights[CURVOPT_TERM_WILLMORE] = 100;
    if (p->level > 1)
        s->tuning.review_fold = 0;
    return 0;
}

/* A sheet, some of whose vertices are held. */
static solve_setting *setting_to_spoil(void) {
    static const int32_t held[] = {1, 4, 9, 12, 16};
    static const curvopt_constraints pins = {.vertices = held, .n = sizeof held / sizeof *held};
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    w.levels = 3;
    w.tolerance = 1e-4;
    w.boundary = CURVOPT_BOUNDARY_FREE;
    w.spacing = CURVOPT_SPACING_EVEN;
    w.constraints = &pins;
    solve_setting *s = solve_setting_of(cage_shaken(cage_half_star(2, 3), 0.1), &w);
    s->tuning.finer_tries = 0;
    return s;
}

/* A run that ends unresolved above its input has the last level that ended below it as its result, by the last level's
 * cage, whose vertices are held. */
static void test_what_a_level_has_lost_the_one_before_it_has(void **state) {
    (void)state;
    solve_setting *s = setting_to_spoil();
    finished f = {.s = s};
    finish(&f, spoil, s);
    const int term = CURVOPT_TERM_WILLMORE;
    const double start = f.result->start.term[term], end = f.result->end.term[term];
    const curvopt_constraints *pins = s->options.constraints;
    CHECK_INT(f.summary.stop, CURVOPT_STOP_UNRESOLVED);
    CHECK_INT(f.summary.verdict, CURVOPT_VERDICT_UNKNOWN);
    CHECK_INT(f.summary.n_levels, 1);
    CHECK_TRUE(f.result->level[1].energy > start);          /* it ran, and was no use */
    CHECK_NEAR(end, f.result->level[0].energy, 0.02 * end); /* blends at corners are smaller */
    CHECK_TRUE(end < 0.05 * start);
    CHECK_NEAR(by_fine_rules(&f), end, 1e-4 * end);
    CHECK_INT(f.summary.n_faces, 16 * s->mesh->info.n_faces);
    for (int32_t k = 0; k < pins->n; k++)
        for (int i = 0; i < 3; i++)
            CHECK_NEAR(f.xyz[3 * pins->vertices[k] + i], s->c.xyz[3 * pins->vertices[k] + i], 1e-12);
    finished_free(&f);
}

/* Flat but for folds between samples, by all rules, a torus would have no bending energy. */
static void test_no_torus_has_less_than_a_torus_has(void **state) {
    (void)state;
    const curvopt_options w = loosely();
    const int n[] = {5, 6, 8};
    for (size_t k = 0; k < sizeof n / sizeof *n; k++) {
        finished f = run(cage_shaken(cage_torus(n[k], 4, 1, 0.4), 0.1), &w, 0);
        CHECK_INT(f.summary.verdict, CURVOPT_VERDICT_MINIMUM);
        CHECK_BETWEEN(f.result->end.objective, 78.95, 79.05);
        finished_free(&f);
    }
}

/* --------------------------------------------------------------------------------------------- cancelling -- */

/* Where something is held, the cage that was reported last is returned as it was shown; elsewhere but for its size,
 * which finer rules than the report's give the input's area. */
static void check_cancelled(cage c, curvopt_options options, int32_t cancel_at, int32_t level) {
    finished f = run(c, &options, cancel_at);
    size_t n = 3 * (size_t)f.summary.n_vertices;
    CHECK_INT(f.w.calls, cancel_at);
    CHECK_INT(f.summary.stop, CURVOPT_STOP_CANCELLED);
    CHECK_INT(f.summary.verdict, CURVOPT_VERDICT_UNKNOWN);
    CHECK_INT(f.summary.n_levels, level);
    CHECK_INT(f.w.last.level, level);
    CHECK_INT(f.summary.n_vertices, f.w.last.n_vertices);
    CHECK_INT(f.result->level[level - 1].stop, CURVOPT_STOP_CANCELLED);
    CHECK_INT(f.result->level[level - 1].iterations, f.w.last.iteration);
    CHECK_BETWEEN(f.result->level[level - 1].seconds, 0, f.summary.seconds);
    double from[3], to[3], radius = co_similarity_frame(n / 3, f.w.xyz, from),
                           other = co_similarity_frame(n / 3, f.xyz, to);
    int held = f.s->mesh->info.n_boundary_edges > 0;
    CHECK_NEAR(other / radius, 1, held ? 1e-14 : 1e-3);
    for (size_t i = 0; i < n; i++)
        CHECK_NEAR((f.xyz[i] - to[i % 3]) / other, (f.w.xyz[i] - from[i % 3]) / radius, 1e-12);
    finished_free(&f);
}

static void test_cancelling_returns_what_was_reported_last(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    w.max_iterations = 6;
    w.levels = 2;
    for (int32_t k = 1; k <= 7; k += 2) {
        check_cancelled(cage_shaken(cage_torus(6, 4, 1, 0.4), 0.05), w, k, 1);
        check_cancelled(cage_shaken(cage_band(6, 4, 1, 1, 1), 0.05), w, k, 1);
    }
    check_cancelled(cage_shaken(cage_torus(6, 4, 1, 0.4), 0.05), w, 8, 2);
    check_cancelled(cage_shaken(cage_torus(6, 4, 1, 0.4), 0.05), w, 11, 2);
    check_cancelled(cage_shaken(cage_band(6, 4, 1, 1, 1), 0.05), w, 10, 2);
}

/* ------------------------------------------------------------------------------------------------ levels -- */

static void check_mesh(const curvopt_mesh *got, const curvopt_mesh *coarse) {
    curvopt_mesh *fine = NULL;
    curvopt_error error;
    CHECK_OK(curvopt_mesh_refine(coarse, NULL, &fine, NULL, &error), &error);
    CHECK_INT(got->info.n_vertices, fine->info.n_vertices);
    CHECK_INT(got->info.n_corners, fine->info.n_corners);
    assert_memory_equal(got->corner_vertex, fine->corner_vertex, sizeof(int32_t) * (size_t)fine->info.n_corners);
    curvopt_mesh_destroy(fine);
}

static void test_levels_add_up(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    w.levels = 2;
    finished f = run(cage_shaken(cage_prism(5), 0.05), &w, 0);
    const curvopt_level_report *level = f.result->level;
    CHECK_INT(f.summary.n_levels, 2);
    check_mesh(f.result->mesh, f.s->mesh);
    CHECK_INT(level[0].n_vertices, f.s->c.n_vertices);
    CHECK_INT(level[1].n_vertices, f.summary.n_vertices);
    CHECK_INT(f.summary.n_faces, f.result->mesh->info.n_faces);
    for (int k = 0; k < 2; k++) {
        CHECK_INT(level[k].level, k + 1);
        CHECK_INT(level[k].iterations, f.w.in_level[k + 1] - 1); /* and one at its start */
        CHECK_TRUE(level[k].evaluations > level[k].iterations);
        CHECK_INT(level[k].reserved, 0);
    }
    CHECK_TRUE(level[1].evaluations >= f.w.last.evaluations);
    CHECK_TRUE(level[0].energy < f.result->start.objective && level[1].energy < level[0].energy);
    CHECK_NEAR(level[1].energy, f.result->end.objective, 0);
    CHECK_NEAR(f.result->end.area, f.result->start.area, 1e-12);
    CHECK_BETWEEN(level[0].seconds + level[1].seconds, 0, f.summary.seconds);
    CHECK_INT(f.summary.verdict, CURVOPT_VERDICT_MINIMUM);
    CHECK_INT(f.summary.method, CURVOPT_METHOD_GAUSS_NEWTON);
    CHECK_BETWEEN(f.summary.newton_decrement, 0, 1e-6 * f.result->end.objective);
    CHECK_BETWEEN(f.summary.shape_decrement, 0, 1e-6 * f.result->end.objective);
    CHECK_INT(f.summary.negative_directions, 0);
    CHECK_TRUE(isnan(f.summary.difference_decrement)); /* was not asked for */
    CHECK_INT(f.summary.free_negative_directions, -1);
    CHECK_INT(f.summary.all_negative_directions, -1);
    finished_free(&f);
}

static void test_asked_for_verification_is_reported(void **state) {
    (void)state;
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    w.verify = 1;
    w.symmetry = CURVOPT_SYMMETRY_KEEP;
    finished f = run(cage_refined(cage_cube(), 1), &w, 0);
    CHECK_INT(f.summary.symmetry_order, 48);
    CHECK_BETWEEN(f.summary.difference_decrement, 0, 1e-6 * f.result->end.objective);
    CHECK_INT(f.summary.free_negative_directions, 0);
    CHECK_BETWEEN(f.summary.all_negative_directions, 0, 78);
    finished_free(&f);
}

/* Held vertices are where they were, on both levels. */
static void test_held_vertices_stay_through_levels(void **state) {
    (void)state;
    static const int32_t vertex[2] = {3, 9};
    const curvopt_constraints pins = {.vertices = vertex, .n = 2};
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    w.levels = 2;
    w.max_iterations = 5;
    w.constraints = &pins;
    finished f = run(cage_shaken(cage_torus(6, 4, 1, 0.4), 0.05), &w, 0);
    for (int k = 0; k < 2; k++)
        assert_memory_equal(f.xyz + 3 * vertex[k], f.s->c.xyz + 3 * vertex[k], 3 * sizeof(double));
    finished_free(&f);
}

/* ------------------------------------------------------------------------------------------------ refusals -- */

enum { SOME_FACE = -2 }; /* one of several that are alike but for rounding */

static void check_refused_run(cage c, const curvopt_options *options, int32_t code, int32_t element,
                              const char *message) {
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_result *result = NULL;
    curvopt_error error;
    watcher w = {0};
    int32_t status =
        co_multilevel_minimize(mesh, c.xyz, options, &co_tuning_defaults, watch, &w, NULL, &result, &error);
    if (element == SOME_FACE) {
        CHECK_BETWEEN(error.element, 0, c.n_faces - 1);
        element = error.element;
    }
    CHECK_REFUSED(status, &error, code, element, message);
    CHECK_TRUE(result == NULL);
    CHECK_INT(w.calls, 0);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static cage flattened(cage c, int directions) {
    for (int32_t i = 0; i < 3 * c.n_vertices; i++)
        if (i % 3 < directions)
            c.xyz[i] = 0;
    return c;
}

static void test_what_has_no_minimum_is_refused(void **state) {
    (void)state;
    static const int32_t all[24] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11,
                                    12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23},
                         third[1] = {3}, outside[1] = {24}, line[1] = {1};
    static const double direction[3] = {0, 0, 0};
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE), o = w,
                    mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS);
    curvopt_constraints pins = {.vertices = all, .n = 24};
    check_refused_run(flattened(cage_torus(6, 4, 1, 0.4), 2), &w, CURVOPT_ERROR_SURFACE, 0, "edges of length 0");
    check_refused_run(flattened(cage_shaken(cage_torus(6, 4, 1, 0.4), 0.1), 2), &w, CURVOPT_ERROR_GEOMETRY, -1,
                      "the cage has zero area");
    check_refused_run(flattened(cage_refined(cage_cube(), 1), 1), &w, CURVOPT_ERROR_RESOLUTION, SOME_FACE,
                      "folded flat");
    check_refused_run(cage_prism(5), &mvs, CURVOPT_ERROR_SURFACE, 0, "vertex 0 is one");
    o.constraints = &pins;
    check_refused_run(cage_torus(6, 4, 1, 0.4), &o, CURVOPT_ERROR_ARGUMENT, -1, "nothing may move");
    pins = (curvopt_constraints){.vertices = outside, .n = 1};
    check_refused_run(cage_torus(6, 4, 1, 0.4), &o, CURVOPT_ERROR_ARGUMENT, 0, "vertex 24");
    pins = (curvopt_constraints){.vertices = third, .freedom = line, .directions = direction, .n = 1};
    check_refused_run(cage_torus(6, 4, 1, 0.4), &o, CURVOPT_ERROR_ARGUMENT, 0, "the direction 0 0 0");
    o = w;
    o.symmetry = CURVOPT_SYMMETRY_PLANES;
    o.symmetry_planes = CURVOPT_PLANE_X;
    check_refused_run(cage_shaken(cage_torus(6, 4, 1, 0.4), 0.05), &o, CURVOPT_ERROR_GEOMETRY, 0, "plane x = ");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_callback_is_told_everything),
        cmocka_unit_test(test_the_shift_goes_over_to_the_next_level),
        cmocka_unit_test(test_a_level_that_is_lost_begins_again),
        cmocka_unit_test(test_the_last_level_is_lost_where_its_gradient_has_grown),
        cmocka_unit_test(test_what_a_level_has_lost_the_one_before_it_has),
        cmocka_unit_test(test_no_torus_has_less_than_a_torus_has),
        cmocka_unit_test(test_cancelling_returns_what_was_reported_last),
        cmocka_unit_test(test_levels_add_up),
        cmocka_unit_test(test_asked_for_verification_is_reported),
        cmocka_unit_test(test_held_vertices_stay_through_levels),
        cmocka_unit_test(test_what_has_no_minimum_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
