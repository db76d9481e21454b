/* Ways down from saddles that symmetry hides, and what they must bring. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "constraints/subgroups.h"
#include "linalg/vector.h"
#include "mesh/similarity.h"
#include "solve/certificate.h"
#include "solve/saddle_escape.h"
#include "solve/symmetry_reduction.h"

/* ------------------------------------------------------------------------------------------------ the price -- */

static void test_each_halving_has_its_price(void **state) {
    (void)state;
    static const struct {
        int32_t order, left;
        double halvings;
    } rows[] = {{2, 1, 1}, {8, 4, 1}, {8, 2, 2}, {8, 1, 3}, {48, 24, 1}, {48, 1, 6}, {12, 3, 2}, {12, 4, 2}, {3, 1, 2}};
    co_tuning t = co_tuning_defaults;
    for (int k = 0; k < 2; k++) {
        for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
            CHECK_NEAR(co_symmetry_reduction_worth(&t, rows[i].order, rows[i].left), rows[i].halvings * t.loosen_half,
                       1e-15);
        CHECK_NEAR(co_symmetry_reduction_worth(&t, 8, 8), t.loosen_same, 0);
        CHECK_NEAR(co_symmetry_reduction_worth(&t, 1, 1), t.loosen_same, 0);
        CHECK_TRUE(t.loosen_same < t.loosen_half);
        t.loosen_half = 0.25;
    }
}

/* --------------------------------------------------------------------------------------------- the way down -- */

static curvopt_options symmetric(int term) {
    curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, term);
    o.symmetry = CURVOPT_SYMMETRY_KEEP;
    return o;
}

/* The minimum among symmetric cages. */
static solve_setting *minimized(cage c, int term) {
    curvopt_options o = symmetric(term);
    o.surface = term == CURVOPT_TERM_MVS ? CURVOPT_SURFACE_POLYNOMIAL : CURVOPT_SURFACE_LIMIT;
    solve_setting *s = solve_setting_of(c, &o);
    solve_minimized(s);
    return s;
}

/* Negative directions at the setting's cage among cages with this symmetry: of motion along normals, or of all. */
static int32_t count_negative(solve_setting *s, const co_symmetry *symmetry, co_motion among) {
    curvopt_error error;
    co_level *l = NULL;
    int32_t n_negative = 0;
    double decrement;
    CHECK_OK(co_level_create(&s->run, s->mesh, symmetry, &s->constraints, among, s->c.xyz, 1, &l, &error), &error);
    CHECK_OK(co_level_begin(l, &error), &error);
    CHECK_OK(co_level_hessian_count_negative(&l->hessian, &l->now, 0, &n_negative, &decrement, &error), &error);
    CHECK_INT(isnan(decrement) != 0, n_negative != 0);
    co_level_destroy(l);
    return n_negative;
}

/* No way with more symmetry is there by the inertia of the Hessian; there is one with what the way has. */
static void check_largest(solve_setting *s, const co_way_down *way, co_motion among) {
    co_subgroups groups;
    curvopt_error error;
    int n_larger = 0;
    CHECK_OK(co_subgroups_create(&s->symmetry, &groups, &error), &error);
    for (int32_t k = 0; k < groups.n; k++)
        if (groups.order[k] > way->symmetry.order) {
            co_symmetry sub = {0};
            CHECK_OK(
                co_subgroup_select(&s->symmetry, groups.member + (size_t)k * (size_t)groups.n_elements, &sub, &error),
                &error);
            CHECK_INT(count_negative(s, &sub, among), 0);
            n_larger++;
            co_symmetry_free(&sub);
        }
    CHECK_TRUE(n_larger > 0);
    CHECK_TRUE(count_negative(s, &way->symmetry, among) > 0);
    co_subgroups_free(&groups);
}

/* Each element of the group takes the cage to itself. */
static void check_symmetric(const curvopt_mesh *mesh, const co_symmetry *g, const double *xyz) {
    double centre[3], radius = co_similarity_frame((size_t)mesh->info.n_vertices, xyz, centre);
    for (int32_t e = 0; e < g->order; e++)
        for (int32_t v = 0; v < mesh->info.n_vertices; v++) {
            const double *to = xyz + 3 * (size_t)co_symmetry_vertex(g, mesh, e, v), *q = g->matrix + 9 * (size_t)e;
            for (int i = 0; i < 3; i++) {
                double image = centre[i];
                for (int j = 0; j < 3; j++)
                    image += q[3 * i + j] * (xyz[3 * v + j] - centre[j]);
                CHECK_NEAR(image, to[i], 1e-9 * radius);
            }
        }
}

static void check_way(cage c, int32_t order, co_motion among) {
    solve_setting *s = minimized(c, CURVOPT_TERM_MVS);
    curvopt_error error;
    co_way_down way;
    CHECK_INT(s->symmetry.order, order);
    CHECK_OK(co_saddle_escape_find(&s->run, s->mesh, &s->symmetry, &s->constraints, s->c.xyz, 1, among, &way, &error),
             &error);
    CHECK_INT(way.found, 1);
    CHECK_BETWEEN(way.symmetry.order, 1, order / 2);
    check_largest(s, &way, among);
    check_symmetric(s->mesh, &way.symmetry, way.xyz);
    double before = solve_energy(s, s->c.xyz);
    CHECK_BETWEEN(solve_energy(s, way.xyz), 0, before * (1 - s->options.decrement_tolerance / 2));
    co_saddle_escape_free(&way);
    CHECK_TRUE(!way.xyz && !way.found);
    solve_setting_free(s);
}

/* MVS of a coarse torus: its lines want to twist. */
static void test_a_way_with_the_most_symmetry_is_found(void **state) {
    (void)state;
    check_way(cage_torus(8, 4, 1, 0.4), 32, CO_MOTION_ALL);
}

/* Frees s. */
static void check_no_way(solve_setting *s, co_motion among) {
    curvopt_error error;
    co_way_down way;
    CHECK_OK(co_saddle_escape_find(&s->run, s->mesh, &s->symmetry, &s->constraints, s->c.xyz, 1, among, &way, &error),
             &error);
    CHECK_INT(way.found, 0);
    co_saddle_escape_free(&way);
    solve_setting_free(s);
}

/* Of the torus the shape is a minimum. */
static void test_twisting_lines_are_no_way_for_the_shape(void **state) {
    (void)state;
    solve_setting *s = minimized(cage_torus(8, 4, 1, 0.4), CURVOPT_TERM_MVS);
    check_no_way(s, CO_MOTION_NORMALS);
}

/* Planes that the user chose are not given up. */
static void test_chosen_planes_stay(void **state) {
    (void)state;
    solve_setting *s = minimized(cage_torus(8, 4, 1, 0.4), CURVOPT_TERM_MVS);
    s->options.symmetry = CURVOPT_SYMMETRY_PLANES;
    check_no_way(s, CO_MOTION_ALL);
}

static void test_no_way_leads_down_from_a_sphere(void **state) {
    (void)state;
    solve_setting *s = minimized(cage_refined(cage_cube(), 1), CURVOPT_TERM_WILLMORE);
    CHECK_INT(s->symmetry.order, 48);
    check_no_way(s, CO_MOTION_NORMALS);
}

/* ------------------------------------------------------------------------------------------- the reduction -- */

typedef struct reduced {
    double energy;
    int32_t order, stop, iterations;
} reduced;

static reduced reduce(solve_setting *s, curvopt_progress_fn progress, void *user) {
    co_level *level = NULL;
    curvopt_error error;
    co_run *r = solve_run(s, progress, user);
    CHECK_OK(co_symmetry_reduction_solve(r, 1, &level, &error), &error);
    CHECK_TRUE(level != NULL && level->objective.mesh == r->result->mesh);
    check_symmetric(s->mesh, &r->at.symmetry, r->at.xyz);
    const reduced out = {.energy = r->at.report.energy,
                         .order = r->at.symmetry.order,
                         .stop = r->at.report.stop,
                         .iterations = r->at.report.iterations};
    CHECK_NEAR(solve_energy(s, r->at.xyz), out.energy, 1e-3 * out.energy);
    CHECK_NEAR(r->at.energies.objective, out.energy, 0);
    co_level_destroy(level);
    solve_run_free(r);
    return out;
}

/* Symmetries go where that is worth it, and stay where it is not: then everything is as if nobody had looked. */
static void test_symmetries_go_as_far_as_that_is_worth_it(void **state) {
    (void)state;
    curvopt_options o = symmetric(CURVOPT_TERM_MVS);
    solve_setting *s = solve_setting_of(cage_torus(8, 4, 1, 0.4), &o);
    s->tuning.loosen_least_vertices = 33; /* one more than it has */
    reduced kept = reduce(s, NULL, NULL);
    CHECK_INT(kept.order, 32);
    s->options.symmetry = CURVOPT_SYMMETRY_AUTO;
    reduced small = reduce(s, NULL, NULL); /* a cage this small is let be */
    CHECK_INT(small.order, 32);
    CHECK_NEAR(small.energy, kept.energy, 0);
    s->tuning.loosen_least_vertices = 10;
    reduced gone = reduce(s, NULL, NULL);
    CHECK_BETWEEN(gone.order, 1, 16);
    CHECK_BETWEEN(gone.energy, 0, (1 - co_symmetry_reduction_worth(&s->tuning, 32, gone.order)) * kept.energy);
    CHECK_TRUE(gone.iterations > kept.iterations); /* what led to the saddle counts */
    s->tuning.loosen_half = s->tuning.loosen_same = 1;
    reduced dear = reduce(s, NULL, NULL);
    CHECK_INT(dear.order, 32);
    CHECK_INT(dear.stop, kept.stop);
    CHECK_NEAR(dear.energy, kept.energy, 0);
    solve_setting_free(s);
}

typedef struct watcher {
    double least;
    int32_t calls, cancel_at;
} watcher;

static int32_t watch(const curvopt_progress *p, void *user) {
    watcher *w = user;
    w->least = w->calls ? fmin(w->least, p->energy) : p->energy;
    return ++w->calls == w->cancel_at;
}

/* A run that is cancelled on the way down says so, and keeps the better of where it was and where it is. */
static void test_cancelled_on_the_way_down(void **state) {
    (void)state;
    curvopt_options o = symmetric(CURVOPT_TERM_MVS);
    o.tolerance = 1e-6; /* what a level shows on its way is by coarser rules */
    solve_setting *s = solve_setting_of(cage_torus(8, 4, 1, 0.4), &o);
    reduced kept = reduce(s, NULL, NULL);
    s->options.symmetry = CURVOPT_SYMMETRY_AUTO;
    s->tuning.loosen_least_vertices = 10;
    for (int later = 2; later <= 8; later += 3) {
        watcher w = {.cancel_at =
                         kept.iterations + 1 + later}; /* reports of the symmetric level, and some of the next */
        reduced cut = reduce(s, watch, &w);
        CHECK_INT(w.calls, w.cancel_at);
        CHECK_INT(cut.stop, CURVOPT_STOP_CANCELLED);
        CHECK_BETWEEN(cut.energy, 0, kept.energy);
        CHECK_NEAR(cut.energy, w.least, 1e-3 * w.least);
    }
    solve_setting_free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_each_halving_has_its_price),
        cmocka_unit_test(test_a_way_with_the_most_symmetry_is_found),
        cmocka_unit_test(test_twisting_lines_are_no_way_for_the_shape),
        cmocka_unit_test(test_chosen_planes_stay),
        cmocka_unit_test(test_no_way_leads_down_from_a_sphere),
        cmocka_unit_test(test_symmetries_go_as_far_as_that_is_worth_it),
        cmocka_unit_test(test_cancelled_on_the_way_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
