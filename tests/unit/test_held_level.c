/* Numbers of the surface that are held, and spontaneous curvature, which is a function of such numbers: the way back to
 * them, the gradient and the Hessian of what is left against differences, its factors. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "linalg/vector.h"

/* A level that holds numbers, a little off those of its cage. */
typedef struct fixture {
    solve_setting *s;
    co_held_numbers held;
    co_level *level;
    size_t n;
} fixture;

/* Volume and area as they are, which needs something else that is held; or volume and mean curvature over what the
 * area says. */
static const co_held_numbers ABSOLUTE = {
    .n = 2, .orientation = 1, .held = {{CURVOPT_SCALAR_VOLUME, -1, 1, 0.7, 1}, {CURVOPT_SCALAR_AREA, -1, 1, 2, 1}}};
static const co_held_numbers RATIOS = {.n = 2,
                                       .orientation = 1,
                                       .held = {{CURVOPT_SCALAR_VOLUME, CURVOPT_SCALAR_AREA, 1, 0.1, 1},
                                                {CURVOPT_SCALAR_MEAN_CURVATURE, CURVOPT_SCALAR_AREA, 1, 3, 1}}};

/* Volume over area alone: of few vertices two numbers hardly are two. */
static const co_held_numbers RATIO = {
    .n = 1, .orientation = 1, .held = {{CURVOPT_SCALAR_VOLUME, CURVOPT_SCALAR_AREA, 1, 0.1, 1}}};

static const co_held_numbers NOTHING = {.n = 0, .orientation = 1};

/* Of Willmore's energy, in lengths that the area, the volume or the mean curvature measures, or that are what they are;
 * the last two for normals that point the other way. */
static const co_spontaneous_curvature BY_AREA = {1.3, 4, CURVOPT_SCALAR_AREA, 1.1, 1, 5},
                                      BY_VOLUME = {-0.9, 4, CURVOPT_SCALAR_VOLUME, 1.3, 1, 5},
                                      BY_MEAN = {0.7, 4, CURVOPT_SCALAR_MEAN_CURVATURE, 5, 1, 5},
                                      AS_IT_IS = {1.6, 4, -1, 0.8, -1, 5}, OTHER = {-2.2, 4, -1, 1, -1, 5};

static void fixture_of(cage c, const curvopt_options *options, const co_held_numbers *held,
                       const co_spontaneous_curvature *spontaneous, double off, fixture *f) {
    co_level_objective objective;
    curvopt_error error;
    double *z = calloc(3 * (size_t)c.n_vertices, sizeof *z);
    f->s = solve_setting_of(c, options);
    f->held = *held;
    f->s->run.held = held->n ? &f->held : NULL;
    f->s->run.wanted = f->held;
    if (spontaneous) {
        f->s->run.spontaneous = *spontaneous;
        f->s->run.size.measure = spontaneous->measure;
    }
    CHECK_TRUE(z != NULL);
    CHECK_OK(co_level_objective_create(&f->s->run, f->s->mesh, &f->s->symmetry, &f->s->constraints, CO_MOTION_ALL,
                                       f->s->c.xyz, &objective, z, &error),
             &error);
    if (held->n)
        co_held_level_take_as_targets(&objective.numbers, z);
    for (int k = 0; k < held->n; k++) {
        f->held.held[k].target = objective.numbers.numbers.held[k].target;
        f->s->run.wanted.held[k].target = (1 + off) * f->held.held[k].target;
    }
    co_level_objective_free(&objective);
    free(z);
    f->level = solve_level(f->s);
    f->n = co_level_objective_n(&f->level->objective);
}

static void fixture_free(fixture *f) {
    co_level_destroy(f->level);
    solve_setting_free(f->s);
}

static const int32_t pin_vertex[3] = {3, 7, 12}, pin_freedom[3] = {0, 1, 2};
static const double pin_direction[9] = {0, 0, 0, 1, 2, 3, 0, 1, -1};
static const curvopt_constraints pins = {
    .vertices = pin_vertex, .freedom = pin_freedom, .directions = pin_direction, .n = 3};

/* What the tests go through. */
typedef void (*check_fn)(fixture *f);

/* Far from a sphere, where volume over area has no slope. */
static cage stretched(cage c) {
    for (int32_t v = 0; v < c.n_vertices; v++)
        c.xyz[3 * v + 2] *= 2.5;
    return c;
}

static void for_all(check_fn check) {
    curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE),
                    mvs = solve_options(CURVOPT_SURFACE_POLYNOMIAL, CURVOPT_TERM_MVS), pinned = w, symmetric = w,
                    mixed = mvs;
    pinned.constraints = &pins;
    symmetric.symmetry = CURVOPT_SYMMETRY_KEEP;
    mixed.weights[CURVOPT_TERM_WILLMORE] = 1;
    const struct {
        cage c;
        const curvopt_options *options;
        const co_held_numbers *held;
        const co_spontaneous_curvature *spontaneous;
    } of[] = {{cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &w, &RATIOS, NULL},
              {cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &mvs, &RATIOS, NULL},
              {stretched(cage_shaken(cage_prism(5), 0.1)), &w, &RATIO, NULL},
              {cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &pinned, &ABSOLUTE, NULL},
              {cage_torus(8, 6, 1, 0.35), &symmetric, &RATIOS, NULL},
              {cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &w, &NOTHING, &BY_AREA},
              {cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &w, &RATIOS, &BY_VOLUME},
              {stretched(cage_shaken(cage_prism(5), 0.1)), &w, &NOTHING, &BY_VOLUME},
              {cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &mixed, &RATIO, &BY_MEAN},
              {cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &pinned, &ABSOLUTE, &AS_IT_IS},
              {cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &pinned, &NOTHING, &OTHER},
              {cage_torus(8, 6, 1, 0.35), &symmetric, &RATIOS, &BY_AREA}};
    for (size_t k = 0; k < sizeof of / sizeof *of; k++) {
        fixture f;
        fixture_of(of[k].c, of[k].options, of[k].held, of[k].spontaneous, -1e-5, &f);
        check(&f);
        fixture_free(&f);
    }
}

static double wave(size_t i, int k) {
    return sin(1.7 * (double)i + 0.3 * k * k + 0.5);
}

/* A cage begins where the numbers are what is wanted; a point near it goes back to that, and is not another function's
 * for it. */
static void check_way_back(fixture *f) {
    co_level_objective *o = &f->level->objective;
    double residual[CURVOPT_N_SCALARS], *z = calloc(f->n, sizeof *z);
    CHECK_TRUE(z != NULL);
    if (!f->held.n) {
        free(z);
        return;
    }
    co_held_level_residuals(&o->numbers, f->level->now.x, residual);
    for (int k = 0; k < f->held.n; k++) {
        CHECK_NEAR(o->numbers.numbers.held[k].target, f->s->run.wanted.held[k].target, 0);
        CHECK_NEAR(residual[k], 0, 1e-11);
    }
    for (size_t i = 0; i < f->n; i++)
        z[i] = f->level->now.x[i] + 0.01 * wave(i, 1);
    CHECK_TRUE(co_held_level_go_back(&o->numbers, z, 1));
    memcpy(o->numbers.work, o->numbers.back, f->n * sizeof *z);
    const double value = co_level_objective_value(o, z);
    co_held_level_residuals(&o->numbers, o->numbers.work, residual);
    for (int k = 0; k < f->held.n; k++)
        CHECK_NEAR(residual[k], 0, 1e-11);
    CHECK_NEAR(co_level_objective_value(o, o->numbers.work), value, 1e-9 * fabs(value));
    free(z);
}

static void test_way_back(void **state) {
    (void)state;
    for_all(check_way_back);
}

/* Of a point from which nothing leads back nothing is known, and no optimizer stays there. */
static void check_no_way_back(fixture *f) {
    co_level_objective *o = &f->level->objective;
    double *gradient = calloc(f->n, sizeof *gradient);
    co_iterate at = {.x = f->level->now.x, .gradient = gradient};
    CHECK_TRUE(gradient != NULL);
    for (size_t i = 0; i < f->n; i++)
        gradient[i] = 1;
    for (int k = 0; k < f->held.n; k++)
        o->numbers.numbers.held[k].target *= 1000;
    co_level_objective_evaluate(o, &at);
    CHECK_INT(at.value == (double)INFINITY, f->held.n > 0);
    for (int k = 0; k < CO_N_FINDINGS; k++)
        CHECK_INT(isnan(at.found[k]) != 0, f->held.n > 0);
    CHECK_INT(co_vector_norm(f->n, gradient) == 0, f->held.n > 0);
    at.gradient = NULL;
    co_level_objective_evaluate(o, &at);
    CHECK_INT(isfinite(at.value) != 0, f->held.n == 0);
    free(gradient);
}

static void test_no_way_back(void **state) {
    (void)state;
    for_all(check_no_way_back);
}

/* v -= its part along translations, which a function of surfaces that nothing holds in their place does not see. */
static void remove_translations(const fixture *f, double *v) {
    const double *translation = f->level->objective.reduction.translation;
    if (translation)
        co_vector_remove(f->n, 3, translation, v);
}

static const double AT[4] = {-2, -1, 1, 2}, WEIGHT[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};

static void check_gradient(fixture *f) {
    co_level_objective *o = &f->level->objective;
    double *z = calloc(2 * f->n, sizeof *z), *v = z + f->n;
    const double h = 2e-4;
    CHECK_TRUE(z != NULL);
    co_level_objective_evaluate(o, &f->level->now);
    for (int k = 0; k < 5; k++) {
        double wanted = 0, scale = 0;
        for (size_t i = 0; i < f->n; i++)
            v[i] = wave(i, k);
        for (int s = 0; s < 4; s++) {
            for (size_t i = 0; i < f->n; i++)
                z[i] = f->level->now.x[i] + AT[s] * h * v[i];
            wanted += WEIGHT[s] * co_level_objective_value(o, z) / h;
        }
        scale = co_vector_norm(f->n, f->level->now.gradient) * co_vector_norm(f->n, v);
        CHECK_NEAR(co_vector_dot(f->n, f->level->now.gradient, v), wanted, 1e-6 * scale);
    }
    memcpy(v, f->level->now.gradient, f->n * sizeof *v); /* it does not see translations */
    remove_translations(f, v);
    co_vector_add(f->n, -1, f->level->now.gradient, v);
    CHECK_NEAR(co_vector_norm(f->n, v), 0, 1e-12 * co_vector_norm(f->n, f->level->now.gradient));
    for (int k = 0; k < f->held.n; k++) /* it does not see the ways */
        CHECK_NEAR(co_vector_dot(f->n, f->level->now.gradient, o->numbers.newton.way + (size_t)k * f->n), 0,
                   1e-9 * co_vector_norm(f->n, f->level->now.gradient));
    free(z);
}

static void test_gradient(void **state) {
    (void)state;
    for_all(check_gradient);
}

/* out = (M + shift) v, without motions. */
static void multiply(const co_newton_system *m, size_t n, double shift, const double *v, double *out) {
    co_sparse_hessian_multiply(&m->hessian, v, out);
    co_vector_add(n, shift, v, out);
    for (int k = 0; k < m->n_dense - m->n_motions; k++) {
        const double *u = m->dense + (size_t)k * n;
        co_vector_add(n, m->weight[k] * co_vector_dot(n, u, v), u, out);
    }
}

/* The matrix is that of positions as they are, and solved without translations. */
static void check_hessian(fixture *f) {
    co_level *l = f->level;
    co_level_objective *o = &l->objective;
    curvopt_error error;
    double *z = calloc(7 * f->n, sizeof *z), *v = z + f->n, *got = z + 2 * f->n, *g = z + 3 * f->n;
    const double h = 5e-6;
    CHECK_TRUE(z != NULL);
    CHECK_OK(co_level_hessian_assemble_exact(&l->hessian, &l->now, CO_GAUGE_NONE, &error), &error);
    for (int k = 0; k < 4; k++) {
        double worst = 0, scale = 0;
        for (size_t i = 0; i < f->n; i++)
            v[i] = wave(i, k);
        remove_translations(f, v);
        for (size_t s = 0; s < 4; s++) {
            for (size_t i = 0; i < f->n; i++)
                z[i] = l->now.x[i] + AT[s] * h * v[i];
            co_iterate at = {.x = z, .gradient = g + s * f->n};
            co_level_objective_evaluate(o, &at);
        }
        multiply(&l->hessian.system, f->n, 0, v, got);
        remove_translations(f, got);
        for (size_t i = 0; i < f->n; i++) {
            double wanted = 0;
            for (size_t s = 0; s < 4; s++)
                wanted += WEIGHT[s] * g[s * f->n + i] / h;
            worst = fmax(worst, fabs(got[i] - wanted));
            scale = fmax(scale, fabs(wanted));
        }
        CHECK_BETWEEN(worst / scale, 0, 1e-6);
    }
    free(z);
}

static void test_hessian(void **state) {
    (void)state;
    for_all(check_hessian);
}

/* What is said of a Hessian that is there already, with its ways, is what is said of one that is assembled for it. */
static void check_count(fixture *f) {
    co_level *l = f->level;
    curvopt_error error;
    int32_t n_negative[2];
    double decrement[2];
    for (int k = 0; k < 2; k++) {
        if (k)
            CHECK_OK(co_level_hessian_assemble_exact(&l->hessian, &l->now, CO_GAUGE_NONE, &error), &error);
        CHECK_OK(co_level_hessian_count_negative(&l->hessian, &l->now, k, &n_negative[k], &decrement[k], &error),
                 &error);
    }
    CHECK_INT(n_negative[1], n_negative[0]);
    CHECK_TRUE(decrement[1] == decrement[0] || (isnan(decrement[1]) && isnan(decrement[0])));
}

static void test_count(void **state) {
    (void)state;
    for_all(check_count);
}

/* A shift at which the matrix is positive definite, from both sides of where its sparse part is: what solves then
 * solves that matrix. */
static void check_factor(fixture *f) {
    co_level *l = f->level;
    curvopt_error error;
    double *b = calloc(3 * f->n, sizeof *b), *x = b + f->n, *back = b + 2 * f->n;
    int positive = 0, found = 0;
    CHECK_TRUE(b != NULL);
    l->hessian.system.leaves_motions_out = 1;
    CHECK_OK(co_level_hessian_assemble_exact(&l->hessian, &l->now, CO_GAUGE_SIMILARITY, &error), &error);
    double shift = 100 * co_newton_system_mean_diagonal(&l->hessian.system);
    for (size_t i = 0; i < f->n; i++)
        b[i] = wave(i, 3);
    co_newton_system_remove_motions(&l->hessian.system, b);
    for (int k = 0; k < 60; k++, shift *= 0.7) {
        CHECK_OK(co_newton_system_factorize(&l->hessian.system, shift, &positive, &error), &error);
        if (!positive)
            break;
        found++;
        CHECK_OK(co_newton_system_solve(&l->hessian.system, b, x, &error), &error);
        multiply(&l->hessian.system, f->n, shift, x, back);
        co_newton_system_remove_motions(&l->hessian.system, back);
        for (size_t i = 0; i < f->n; i++)
            CHECK_NEAR(back[i], b[i], 1e-6);
    }
    CHECK_TRUE(found > 5);
    free(b);
}

static void test_factor(void **state) {
    (void)state;
    for_all(check_factor);
}

/* A target that vertices cannot go to at once is approached, and one out of reach is left alone. */
static void test_targets(void **state) {
    (void)state;
    const curvopt_options w = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    static const double off[3] = {-0.01, -0.6, 3};
    for (int k = 0; k < 3; k++) {
        fixture f;
        int changed;
        fixture_of(cage_torus(7, 5, 1, 0.4), &w, &RATIO, NULL, off[k], &f);
        const double wanted = f.s->run.wanted.held[0].target, now = f.held.held[0].target;
        CHECK_TRUE((now == wanted) == (k == 0));
        CHECK_TRUE(fabs(now - wanted) < fabs(wanted / (1 + off[k]) - wanted));
        if (k == 2) { /* seven times a sphere's volume */
            for (int step = 0; step < 30; step++)
                co_level_objective_aim(&f.level->objective, 0.5, &f.level->now, &changed);
            CHECK_TRUE(f.held.held[0].target < 0.0941); /* 1 / (6 sqrt pi), the sphere's */
            CHECK_TRUE(isfinite(f.level->now.value));
        }
        fixture_free(&f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_way_back), cmocka_unit_test(test_no_way_back), cmocka_unit_test(test_gradient),
        cmocka_unit_test(test_hessian),  cmocka_unit_test(test_factor),      cmocka_unit_test(test_count),
        cmocka_unit_test(test_targets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
