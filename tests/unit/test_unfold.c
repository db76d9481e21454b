/* Folded cages: which faces are folded, where a thin plate lies, what is unfolded and what stays.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "base/constants.h"
#include "mesh/fill.h"
#include "solve/unfold.h"
#include "surface/folds.h"

enum { AROUND = 12, TUBE = 6, A = 20, B = 26 }; /* neighbours along the tube */

/* A torus of which a vertex was dragged over its neighbour. */
static cage folded_torus(void) {
    cage c = cage_torus(AROUND, TUBE, 1, 0.5);
    for (int k = 0; k < 3; k++)
        c.xyz[3 * A + k] += 2.5 * (c.xyz[3 * B + k] - c.xyz[3 * A + k]);
    return c;
}

static int32_t count_folds(const curvopt_mesh *m, const double *xyz, const uint8_t *left_out) {
    int32_t n = -1;
    curvopt_error error;
    uint8_t *folded = calloc((size_t)m->info.n_faces, 1);
    CHECK_OK(co_folds_find(m, xyz, left_out, NULL, folded, &n, &error), &error);
    for (int32_t f = 0; f < m->info.n_faces; f++)
        n -= folded[f];
    CHECK_INT(n, 0);
    for (int32_t f = 0; f < m->info.n_faces; f++)
        n += folded[f];
    free(folded);
    return n;
}

/* The two faces of which both are corners. */
static void test_faces_that_have_both(void **state) {
    (void)state;
    cage c = folded_torus();
    curvopt_mesh *m = cage_mesh(&c);
    uint8_t folded[AROUND * TUBE], left_out[AROUND * TUBE];
    int32_t n;
    curvopt_error error;
    CHECK_OK(co_folds_find(m, c.xyz, NULL, NULL, folded, &n, &error), &error);
    CHECK_INT(n, 2);
    for (int32_t f = 0; f < c.n_faces; f++) {
        int has = 0;
        for (int k = 0; k < 4; k++)
            has += c.vertices[4 * f + k] == A || c.vertices[4 * f + k] == B;
        CHECK_INT(folded[f], has == 2);
        left_out[f] = folded[f];
    }
    CHECK_INT(count_folds(m, c.xyz, left_out), 0);
    curvopt_mesh_destroy(m);
    cage_free(&c);
}

/* Surfaces that are no folds: round, of poles, of triangles, flat, open, shaken. */
static void test_what_is_not_folded(void **state) {
    (void)state;
    cage all[] = {cage_tetrahedron(),
                  cage_cube(),
                  cage_trapezohedron(9),
                  cage_prism(5),
                  cage_half_star(5, 2),
                  cage_band(8, 3, 1, 0.2, 1),
                  cage_shaken(cage_torus(8, 6, 1, 0.3), 0.05)};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        curvopt_mesh *m = cage_mesh(&all[k]);
        CHECK_INT(count_folds(m, all[k].xyz, NULL), 0);
        curvopt_mesh_destroy(m);
        cage_free(&all[k]);
    }
}

/* |x - mean of its neighbours|^2, summed over all vertices. */
static double bending(const curvopt_mesh *m, const double *xyz) {
    double sum = 0;
    for (int32_t v = 0; v < m->info.n_vertices; v++) {
        double mean[3] = {0};
        int32_t h = m->vertex_corner[v], first = h, n = 0;
        do {
            for (int k = 0; k < 3; k++)
                mean[k] += xyz[3 * co_mesh_destination(m, h) + k];
            n++;
            h = co_mesh_rotate(m, h);
        } while (h != first);
        for (int k = 0; k < 3; k++)
            sum += pow(xyz[3 * v + k] - mean[k] / n, 2);
    }
    return sum;
}

/* At the least sum its slope is 0, and a move of any free vertex raises it by half to three times the move's square. */
static void test_a_plate_bends_least(void **state) {
    (void)state;
    cage c = cage_refined(cage_cube(), 2);
    curvopt_mesh *m = cage_mesh(&c);
    const size_t n = 3 * (size_t)c.n_vertices;
    uint8_t *is_free = calloc((size_t)c.n_vertices, 1);
    double *before = malloc(n * sizeof *before);
    curvopt_error error;
    for (int32_t v = 0; v < 17; v++)
        is_free[v] = 1;
    cage_perturb(&c, 0.3, 4);
    memcpy(before, c.xyz, n * sizeof *before);
    CHECK_OK(co_mesh_fill(m, is_free, NULL, NULL, c.xyz, &error), &error);
    const double least = bending(m, c.xyz);
    CHECK_TRUE(least < bending(m, before));
    for (size_t i = 0; i < n; i++) {
        const double x = c.xyz[i], step = 1e-3;
        if (!is_free[i / 3]) {
            CHECK_TRUE(x == before[i]);
            continue;
        }
        c.xyz[i] = x + step;
        const double up = bending(m, c.xyz);
        c.xyz[i] = x - step;
        const double down = bending(m, c.xyz);
        c.xyz[i] = x;
        CHECK_NEAR((up - down) / step, 0, 1e-8);
        CHECK_BETWEEN(up - least, 0.5 * step * step, 3 * step * step);
    }
    curvopt_mesh_destroy(m);
    cage_free(&c);
    free(is_free);
    free(before);
}

static void unfold(const curvopt_mesh *m, const co_constraints *constraints, double *xyz, co_unfolding *found) {
    curvopt_error error;
    CHECK_OK(co_unfold(m, constraints, CURVOPT_BOUNDARY_POSITION, NULL, xyz, found, &error), &error);
}

/* The two alone are moved; where one is held, others round them are; where all are, nothing is. */
static void test_what_moves(void **state) {
    (void)state;
    for (int held = 0; held < 3; held++) {
        cage c = folded_torus(), start = folded_torus(), true_one = cage_torus(AROUND, TUBE, 1, 0.5);
        curvopt_mesh *m = cage_mesh(&c);
        co_constraints constraints = {0};
        co_unfolding found;
        curvopt_error error;
        int32_t n_moved = 0;
        if (held)
            CHECK_OK(co_constraints_allocate(c.n_vertices, &constraints, &error), &error);
        for (int32_t v = 0; held && v < c.n_vertices; v++) {
            constraints.freedom[v] = held == 2 || v == A ? 0 : 3;
            memcpy(constraints.anchor + 3 * v, c.xyz + 3 * v, 3 * sizeof *c.xyz);
        }
        unfold(m, held ? &constraints : &(co_constraints){0}, c.xyz, &found);
        CHECK_INT(found.n_folded, 2);
        for (int32_t v = 0; v < c.n_vertices; v++) {
            const int moved = memcmp(c.xyz + 3 * v, start.xyz + 3 * v, 3 * sizeof *c.xyz) != 0;
            n_moved += moved;
            CHECK_TRUE(!(moved && held && constraints.freedom[v] == 0));
        }
        CHECK_INT(n_moved, found.n_moved);
        if (held == 2) {
            CHECK_INT(found.n_moved, 0);
        } else {
            CHECK_INT(count_folds(m, c.xyz, NULL), 0);
        }
        if (held == 0) {
            CHECK_INT(found.n_moved, 2);
            for (int k = 0; k < 3; k++) { /* less than a third of an edge from where they were */
                CHECK_NEAR(c.xyz[3 * A + k], true_one.xyz[3 * A + k], 0.15);
                CHECK_NEAR(c.xyz[3 * B + k], true_one.xyz[3 * B + k], 0.15);
            }
        }
        co_constraints_free(&constraints);
        curvopt_mesh_destroy(m);
        cage_free(&c);
        cage_free(&start);
        cage_free(&true_one);
    }
}

/* All vertices in random places of a ball: too little stays. */
static void test_what_cannot_be_unfolded(void **state) {
    (void)state;
    cage c = cage_torus(AROUND, TUBE, 1, 0.5);
    memset(c.xyz, 0, 3 * sizeof *c.xyz * (size_t)c.n_vertices);
    cage_perturb(&c, 1, 3);
    curvopt_mesh *m = cage_mesh(&c);
    double *before = malloc(3 * sizeof *before * (size_t)c.n_vertices);
    co_unfolding found;
    memcpy(before, c.xyz, 3 * sizeof *before * (size_t)c.n_vertices);
    unfold(m, &(co_constraints){0}, c.xyz, &found);
    CHECK_TRUE(found.n_folded > 20 && found.n_moved == 0);
    CHECK_TRUE(memcmp(before, c.xyz, 3 * sizeof *before * (size_t)c.n_vertices) == 0);
    free(before);
    curvopt_mesh_destroy(m);
    cage_free(&c);
}

/* A cage that is shaken all over: no part of it is in its place, and all of it is smoothed until nothing is folded. */
static void test_a_cage_that_is_folded_all_over(void **state) {
    (void)state;
    cage c = cage_torus(8, 4, 1, 0.3);
    cage_perturb(&c, 0.5, 4);
    curvopt_mesh *m = cage_mesh(&c);
    co_constraints held = {0};
    co_unfolding found;
    curvopt_error error;
    double *xyz = malloc(3 * sizeof *xyz * (size_t)c.n_vertices);
    memcpy(xyz, c.xyz, 3 * sizeof *xyz * (size_t)c.n_vertices);
    unfold(m, &(co_constraints){0}, xyz, &found);
    CHECK_TRUE(found.n_folded > 0);
    CHECK_INT(found.n_moved, c.n_vertices);
    CHECK_INT(count_folds(m, xyz, NULL), 0);
    CHECK_OK(co_constraints_allocate(c.n_vertices, &held, &error), &error);
    for (int32_t v = 0; v < c.n_vertices; v++) {
        held.freedom[v] = v == 5 ? 0 : 3;
        memcpy(held.anchor + 3 * v, c.xyz + 3 * v, 3 * sizeof *xyz);
    }
    memcpy(xyz, c.xyz, 3 * sizeof *xyz * (size_t)c.n_vertices);
    unfold(m, &held, xyz, &found);
    CHECK_INT(found.n_moved, c.n_vertices - 1);
    CHECK_INT(count_folds(m, xyz, NULL), 0);
    CHECK_INT(memcmp(xyz + 15, c.xyz + 15, 3 * sizeof *xyz), 0);
    co_constraints_free(&held);
    free(xyz);
    curvopt_mesh_destroy(m);
    cage_free(&c);
}

static int32_t keep_first(const curvopt_progress *p, void *user) {
    double *first = user;
    if (p->iteration == 0)
        memcpy(first, p->xyz, 3 * sizeof *first * (size_t)p->n_vertices);
    return 0;
}

/* A run, its summary and its energies. */
typedef struct run {
    curvopt_result *result;
    curvopt_summary summary;
    curvopt_energies start, end;
} run;

static run run_of(const curvopt_mesh *m, const double *xyz, const curvopt_options *o, double *first) {
    run r;
    curvopt_error error;
    CHECK_OK(curvopt_minimize(m, xyz, o, first ? keep_first : NULL, first, NULL, &r.result, &error), &error);
    curvopt_result_get_summary(r.result, &r.summary, sizeof r.summary);
    curvopt_result_get_energies(r.result, &r.start, &r.end, sizeof r.start);
    return r;
}

/* A run begins with the unfolded cage, and ends where the torus does; one that stays near its input does not. */
static void test_a_run(void **state) {
    (void)state;
    cage c = folded_torus();
    curvopt_mesh *m = cage_mesh(&c);
    double *first = malloc(3 * sizeof *first * (size_t)c.n_vertices);
    for (int near = 0; near < 2; near++) {
        curvopt_options o;
        curvopt_options_init(&o, sizeof o);
        o.levels = 1;
        o.max_iterations = near ? 3 : o.max_iterations;
        o.within = near ? 0.01 : 0;
        const run r = run_of(m, c.xyz, &o, first);
        CHECK_INT(r.summary.n_folded, near ? 0 : 2);
        CHECK_INT(r.summary.n_unfolded, near ? 0 : 2);
        CHECK_TRUE(r.start.objective_error > 0.01 * r.start.objective);
        if (!near) {
            CHECK_INT(r.summary.verdict, CURVOPT_VERDICT_MINIMUM);
            CHECK_NEAR(r.end.objective, 8 * CO_PI * CO_PI, 0.1);
            CHECK_INT(count_folds(m, first, NULL), 0);
        }
        curvopt_result_destroy(r.result);
    }
    free(first);
    curvopt_mesh_destroy(m);
    cage_free(&c);
}

/* A run that cannot be resolved does not end above its input: that is the result then, subdivided as often. */
static void test_what_is_lost_is_taken_back(void **state) {
    (void)state;
    const int32_t vertex = 0;
    const double nothing = 0, nowhere[3] = {(double)NAN, (double)NAN, (double)NAN};
    const curvopt_constraints none = {
        .vertices = &vertex, .weights = &nothing, .places = nowhere, .has_places = 1, .n = 1};
    int n_taken = 0;
    for (uint64_t seed = 3; seed <= 6; seed++) { /* unfolded, and not; the same with a constraint that moves nothing */
        cage c = cage_torus(8, 4, 1, 0.3);
        const int more = (int)(seed + 1) % 2;
        cage_perturb(&c, more ? 0.8 : 0.5, 3 + (uint64_t)more);
        curvopt_mesh *m = cage_mesh(&c), *fine;
        curvopt_options o;
        curvopt_error error;
        curvopt_options_init(&o, sizeof o);
        o.levels = 2;
        o.constraints = seed > 4 ? &none : NULL;
        const run r = run_of(m, c.xyz, &o, NULL);
        CHECK_TRUE(r.end.objective <= r.start.objective);
        const size_t n = 3 * (size_t)r.summary.n_vertices;
        double *expected = malloc(n * sizeof *expected), *got = malloc(n * sizeof *got);
        if (r.summary.stop == CURVOPT_STOP_UNRESOLVED && r.end.objective == r.start.objective) {
            n_taken++;
            CHECK_INT(r.summary.verdict, CURVOPT_VERDICT_UNKNOWN);
            CHECK_INT(r.summary.n_levels, 2);
            CHECK_OK(curvopt_mesh_refine(m, c.xyz, &fine, expected, &error), &error);
            curvopt_result_get_positions(r.result, got);
            CHECK_INT(memcmp(got, expected, n * sizeof *got), 0);
            curvopt_mesh_destroy(fine);
        }
        free(expected);
        free(got);
        curvopt_result_destroy(r.result);
        curvopt_mesh_destroy(m);
        cage_free(&c);
    }
    CHECK_INT(n_taken, 2);
}

/* A solver that stays stands at the unfolded cage, also when it goes back to where it was created. */
static void test_a_solver(void **state) {
    (void)state;
    cage c = folded_torus();
    curvopt_mesh *m = cage_mesh(&c);
    double *xyz = malloc(3 * sizeof *xyz * (size_t)c.n_vertices);
    curvopt_options o;
    curvopt_solver *solver;
    curvopt_summary s;
    curvopt_energies end;
    curvopt_error error;
    curvopt_options_init(&o, sizeof o);
    CHECK_OK(curvopt_solver_create(m, c.xyz, &o, &solver, &error), &error);
    for (int k = 0; k < 2; k++) {
        curvopt_solver_get_positions(solver, xyz);
        CHECK_INT(count_folds(m, xyz, NULL), 0);
        for (int32_t v = 0; v < c.n_vertices; v++)
            CHECK_INT(memcmp(xyz + 3 * v, c.xyz + 3 * v, 3 * sizeof *xyz) != 0, v == A || v == B);
        CHECK_OK(curvopt_solver_solve(solver, 1, NULL, NULL, NULL, &error), &error);
        curvopt_solver_get_summary(solver, &s, sizeof s);
        curvopt_solver_get_energies(solver, NULL, &end, sizeof end);
        CHECK_INT(s.verdict, CURVOPT_VERDICT_MINIMUM);
        CHECK_NEAR(end.objective, 8 * CO_PI * CO_PI, 0.1);
        CHECK_OK(curvopt_solver_set_positions(solver, NULL, &error), &error);
    }
    curvopt_solver_destroy(solver);
    free(xyz);
    curvopt_mesh_destroy(m);
    cage_free(&c);
}

/* What the exported function says, and refuses. */
static void test_find_folds(void **state) {
    (void)state;
    cage c = folded_torus();
    curvopt_mesh *m = cage_mesh(&c);
    curvopt_options o;
    curvopt_error error;
    curvopt_cancel *cancel;
    int32_t folded[AROUND * TUBE], holes[2], n = -1, n_found = 0;
    curvopt_options_init(&o, sizeof o);
    CHECK_OK(curvopt_find_folds(m, c.xyz, &o, NULL, folded, &n, &error), &error);
    CHECK_INT(n, 2);
    for (int32_t f = 0; f < c.n_faces; f++)
        if (folded[f])
            holes[n_found++] = f;
    CHECK_INT(n_found, 2);
    o.holes = holes;
    o.n_holes = 1;
    CHECK_OK(curvopt_find_folds(m, c.xyz, &o, NULL, NULL, &n, &error), &error);
    CHECK_INT(n, 1);
    CHECK_OK(curvopt_find_folds(m, c.xyz, &o, NULL, folded, NULL, &error), &error);
    CHECK_OK(curvopt_cancel_create(&cancel, &error), &error);
    curvopt_cancel_request(cancel);
    CHECK_OK(curvopt_find_folds(m, c.xyz, &o, cancel, folded, &n, &error), &error);
    CHECK_INT(n, 0);
    CHECK_INT(curvopt_find_folds(NULL, c.xyz, &o, NULL, folded, &n, &error), CURVOPT_ERROR_ARGUMENT);
    CHECK_INT(curvopt_find_folds(m, NULL, &o, NULL, folded, &n, &error), CURVOPT_ERROR_ARGUMENT);
    CHECK_INT(curvopt_find_folds(m, c.xyz, NULL, NULL, folded, &n, &error), CURVOPT_ERROR_ARGUMENT);
    c.xyz[5] = (double)NAN;
    CHECK_INT(curvopt_find_folds(m, c.xyz, &o, NULL, folded, &n, &error), CURVOPT_ERROR_GEOMETRY);
    holes[0] = 1000;
    c.xyz[5] = 0;
    CHECK_INT(curvopt_find_folds(m, c.xyz, &o, NULL, folded, &n, &error), CURVOPT_ERROR_ARGUMENT);
    curvopt_cancel_destroy(cancel);
    curvopt_mesh_destroy(m);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_faces_that_have_both),
        cmocka_unit_test(test_what_is_not_folded),
        cmocka_unit_test(test_a_plate_bends_least),
        cmocka_unit_test(test_what_moves),
        cmocka_unit_test(test_what_cannot_be_unfolded),
        cmocka_unit_test(test_a_cage_that_is_folded_all_over),
        cmocka_unit_test(test_a_run),
        cmocka_unit_test(test_what_is_lost_is_taken_back),
        cmocka_unit_test(test_a_solver),
        cmocka_unit_test(test_find_folds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
