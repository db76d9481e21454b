/* Springs that keep a surface near its input: what they are worth at their ends and all together, by closed forms of
 * waves and by the energy; to which vertices they go; where they end. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "energy/adaptive_quadrature.h"
#include "hessian/penalty.h"
#include "solve/strength.h"

/* A cage whose springs have been made. */
typedef struct fixture {
    solve_setting *s;
    double radius, energy, whole; /* energy and area, the cage's, of the faces that count: area in squared radii */
    double *part;                 /* [n_faces] the faces' parts of the energy */
    double *area;                 /* [n_vertices] in squared radii */
    double *worth;                /* [n_vertices] what the springs are worth at one radius */
} fixture;

static double triangle(const double *a, const double *b, const double *c) {
    double u[3], v[3];
    for (int i = 0; i < 3; i++) {
        u[i] = b[i] - a[i];
        v[i] = c[i] - a[i];
    }
    return sqrt(pow(u[1] * v[2] - u[2] * v[1], 2) + pow(u[2] * v[0] - u[0] * v[2], 2) +
                pow(u[0] * v[1] - u[1] * v[0], 2)) /
           2;
}

/* Faces are cut into triangles from their middles; half of each goes to the two vertices. */
static void measure(fixture *f, const int32_t *left_out) {
    const cage *c = &f->s->c;
    int32_t corner = 0;
    for (int32_t face = 0; face < c->n_faces; corner += c->sizes[face++]) {
        const int32_t *v = c->vertices + corner, n = c->sizes[face];
        double middle[3] = {0};
        for (int32_t k = 0; k < 3 * n; k++)
            middle[k % 3] += c->xyz[3 * v[k / 3] + k % 3] / n;
        for (int32_t k = 0; k < n; k++) {
            const int32_t a = v[k], b = v[(k + 1) % n];
            const double area = triangle(middle, c->xyz + 3 * a, c->xyz + 3 * b) / (f->radius * f->radius);
            f->area[a] += area / 2;
            f->area[b] += area / 2;
            f->whole += left_out && left_out[face] >= 0 ? 0 : area;
        }
    }
}

/* Takes the cage over. left_out [n_faces], 0 or more where a face is left out, or NULL. */
static fixture fixture_of(cage c, const curvopt_options *options, const int32_t *left_out) {
    const co_quadrature_goal goal = {.tolerance = 1e-6, .terms = CO_TERMS_REPORT};
    fixture f = {.s = solve_setting_of(c, options)};
    co_assembly assembly;
    curvopt_energies energies;
    curvopt_error error;
    int resolved, changed;
    co_constraints *constraints = &f.s->constraints;
    if (left_out)
        CHECK_OK(co_constraints_leave_out(f.s->mesh, left_out, constraints, &error), &error);
    f.radius = f.s->run.radius;
    f.part = calloc((size_t)c.n_faces, sizeof *f.part);
    f.area = calloc((size_t)c.n_vertices, sizeof *f.area);
    f.worth = calloc((size_t)c.n_vertices, sizeof *f.worth);
    CHECK_TRUE(f.part && f.area && f.worth);
    measure(&f, left_out);
    CHECK_OK(co_assembly_create(f.s->mesh, NULL, NULL, &f.s->options, f.s->run.tables, NULL, &assembly, &error),
             &error);
    CHECK_OK(co_adaptive_quadrature_resolve(&assembly, c.xyz, &goal, &energies, &resolved, &changed, &error), &error);
    co_adaptive_quadrature_by_face(&assembly, c.n_faces, f.part);
    f.energy = energies.objective;
    CHECK_OK(co_strength_hold(&f.s->run, f.s->mesh, c.xyz, &assembly, constraints, &error), &error);
    for (int32_t v = 0; v < c.n_vertices && constraints->springs.stiffness; v++)
        f.worth[v] = co_penalty_stiffness(options->weights) / 2 * constraints->springs.stiffness[v];
    co_assembly_free(&assembly);
    return f;
}

static void fixture_free(fixture *f) {
    solve_setting_free(f->s);
    free(f->part);
    free(f->area);
    free(f->worth);
}

/* `by_area` at every vertex for its area and `by_energy` for its part of the energy. */
static void check_worth(const fixture *f, double by_area, double by_energy) {
    const cage *c = &f->s->c;
    double *part = calloc((size_t)c->n_vertices, sizeof *part), all = 0, sum = 0;
    int32_t corner = 0;
    CHECK_TRUE(part != NULL);
    for (int32_t face = 0; face < c->n_faces; corner += c->sizes[face++])
        for (int32_t k = 0; k < c->sizes[face]; k++)
            part[c->vertices[corner + k]] += f->part[face] / c->sizes[face];
    for (int32_t v = 0; v < c->n_vertices; v++) {
        CHECK_NEAR(f->worth[v] / (by_area * f->area[v] + by_energy * part[v]), 1, 1e-9);
        all += f->worth[v];
        sum += f->area[v];
    }
    CHECK_NEAR(all / (by_area * sum + by_energy * f->energy), 1, 1e-6);
    free(part);
}

static cage torus(void) {
    return cage_shaken(cage_torus(7, 5, 2, 0.8), 0.1);
}

/* A wave of so many radii has 1 (1 - S) / S: at half of its height springs are worth what it is. Of Willmore's energy
 * that is k^4, of MVS area k^6. Each is worth 0.3 of the energy round it at its end, a fifth of the wave. */
static void test_strength_is_of_waves_and_of_the_energy(void **state) {
    (void)state;
    const double pi = 3.14159265358979323846;
    for (int third = 0; third < 2; third++)
        for (double strength = 0.2; strength < 0.9; strength += 0.3) {
            curvopt_options o = solve_options(third ? CURVOPT_SURFACE_POLYNOMIAL : CURVOPT_SURFACE_LIMIT,
                                              third ? CURVOPT_TERM_MVS : CURVOPT_TERM_WILLMORE);
            o.strength = strength;
            CHECK_TRUE(co_strength_stays_near(&o));
            fixture f = fixture_of(torus(), &o, NULL);
            const double wave = strength / (1 - strength), reach = 0.2 * wave, k = 2 * pi / wave;
            check_worth(&f, third ? f.whole * pow(k, 6) : pow(k, 4), 0.3 / (reach * reach));
            CHECK_NEAR(f.s->constraints.springs.reach / (reach * f.radius), 1, 1e-14);
            CHECK_NEAR(f.s->constraints.springs.weighed_by, 0, 0);
            fixture_free(&f);
        }
}

/* Faces of different sizes, each of which gives its vertices equal parts. */
static void test_parts_of_faces_of_any_size(void **state) {
    (void)state;
    curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    o.strength = 0.5;
    fixture f = fixture_of(cage_shaken(cage_prism(5), 0.1), &o, NULL);
    check_worth(&f, pow(2 * 3.14159265358979323846, 4), 0.3 / (0.2 * 0.2));
    fixture_free(&f);
}

/* What is left out has springs too, and does not count for the area that third-order energies have as a factor. */
static void test_what_is_left_out(void **state) {
    (void)state;
    int32_t left_out[35];
    curvopt_options o = solve_options(CURVOPT_SURFACE_POLYNOMIAL, CURVOPT_TERM_MVS);
    o.strength = 0.5;
    for (int32_t f = 0; f < 35; f++)
        left_out[f] = f == 3 || f == 4 ? 0 : -1;
    fixture f = fixture_of(torus(), &o, left_out), all = fixture_of(torus(), &o, NULL);
    CHECK_BETWEEN(f.whole, 0.8 * all.whole, 0.99 * all.whole);
    check_worth(&f, f.whole * pow(2 * 3.14159265358979323846, 6), 0.3 / (0.2 * 0.2));
    fixture_free(&f);
    fixture_free(&all);
}

/* All together they are worth 0.03 of the energy at their ends, by area. */
static void test_within_is_by_area(void **state) {
    (void)state;
    curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    o.within = 0.3;
    CHECK_TRUE(co_strength_stays_near(&o));
    fixture f = fixture_of(torus(), &o, NULL);
    const double reach = 0.3 / f.radius;
    check_worth(&f, 0.03 * f.energy / (f.whole * reach * reach), 0);
    CHECK_NEAR(f.s->constraints.springs.reach, 0.3, 1e-15);
    CHECK_NEAR(f.s->constraints.springs.weighed_by, f.energy, 1e-9 * f.energy);
    fixture_free(&f);
}

/* With both there are the springs of both, at the nearer end; these stay what they are while the energy falls. */
static void test_both(void **state) {
    (void)state;
    for (int near = 0; near < 2; near++) {
        curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
        o.strength = 0.5; /* ends at 0.2 radii */
        o.within = near ? 0.1 : 5;
        fixture f = fixture_of(torus(), &o, NULL);
        const double reach = near ? 0.1 / f.radius : 0.2;
        check_worth(&f, pow(2 * 3.14159265358979323846, 4) + 0.03 * f.energy / (f.whole * reach * reach),
                    0.3 / (0.2 * 0.2));
        CHECK_NEAR(f.s->constraints.springs.reach / (reach * f.radius), 1, 1e-14);
        CHECK_NEAR(f.s->constraints.springs.weighed_by, 0, 0);
        fixture_free(&f);
    }
}

/* Beside the user's springs those of a distance do not get weaker. */
static void test_users_springs(void **state) {
    (void)state;
    static const int32_t vertex[1] = {4};
    static const double weight[1] = {0.5};
    const curvopt_constraints pins = {.vertices = vertex, .n = 1, .weights = weight};
    curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    o.constraints = &pins;
    o.within = 0.3;
    fixture f = fixture_of(torus(), &o, NULL);
    const double reach = 0.3 / f.radius, density = 0.03 * f.energy / (f.whole * reach * reach);
    for (int32_t v = 0; v < f.s->c.n_vertices; v++) {
        const double users = v == 4 ? co_penalty_stiffness(o.weights) / 2 : 0; /* k_v = w / (1 - w) = 1 */
        CHECK_NEAR(f.worth[v], density * f.area[v] + users, 1e-6 * f.worth[v]);
    }
    CHECK_NEAR(f.s->constraints.springs.weighed_by, 0, 0);
    fixture_free(&f);
}

/* What a level says of where it stands is true after every step, also where springs have just got weaker. */
typedef struct watched {
    int steps, changes;
    double weight;
} watched;

static int check_step(const co_level *l, const co_step_record *record, void *user) {
    watched *w = user;
    co_level_objective *o = (co_level_objective *)&l->objective;
    const size_t n = co_level_objective_n(o);
    double *gradient = calloc(n, sizeof *gradient);
    co_iterate again = {.x = l->now.x, .gradient = gradient};
    (void)record;
    CHECK_TRUE(gradient != NULL);
    co_level_objective_evaluate(o, &again);
    CHECK_NEAR(l->now.value / again.value, 1, 1e-12);
    for (size_t i = 0; i < n; i++)
        CHECK_NEAR(l->now.gradient[i], gradient[i], 1e-9 * again.value);
    CHECK_BETWEEN(co_level_objective_energy(o, &l->now) / o->held.springs.weighed_by, 0.5 * o->penalty.weight,
                  1.5 * o->penalty.weight);
    w->changes += w->steps++ && o->penalty.weight < w->weight;
    w->weight = o->penalty.weight;
    free(gradient);
    return 0;
}

/* Springs of a distance are worth a part of the energy as it falls: each time it has halved they do. */
static void test_springs_get_weaker_with_the_energy(void **state) {
    (void)state;
    const co_level_prospect prospect = {0};
    curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    co_outcome outcome;
    curvopt_error error;
    o.within = 1;
    fixture f = fixture_of(cage_shaken(cage_torus(7, 5, 2, 0.8), 0.5), &o, NULL);
    co_level *l = solve_level(f.s);
    watched w = {0};
    l->report = check_step;
    l->user = &w;
    l->error = &error;
    CHECK_OK(co_level_solve(l, &prospect, &outcome, &error), &error);
    CHECK_TRUE(w.steps > 5 && w.changes > 0);
    co_level_destroy(l);
    fixture_free(&f);
}

static void test_nothing_is_held_without(void **state) {
    (void)state;
    curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    CHECK_TRUE(!co_strength_stays_near(&o));
    fixture f = fixture_of(torus(), &o, NULL);
    CHECK_TRUE(!f.s->constraints.springs.stiffness && !f.s->constraints.freedom);
    fixture_free(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_strength_is_of_waves_and_of_the_energy),
        cmocka_unit_test(test_parts_of_faces_of_any_size),
        cmocka_unit_test(test_what_is_left_out),
        cmocka_unit_test(test_within_is_by_area),
        cmocka_unit_test(test_both),
        cmocka_unit_test(test_users_springs),
        cmocka_unit_test(test_springs_get_weaker_with_the_energy),
        cmocka_unit_test(test_nothing_is_held_without),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
