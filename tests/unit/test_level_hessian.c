/* The matrices of a level and what they say is left to gain: solutions against differences of the gradient, shifts
 * against their definitions, decrements of cages with one variable. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "linalg/vector.h"
#include "solve/level_hessian.h"
#include "solve/newton_decrement.h"

typedef struct matrices {
    solve_setting *s;
    co_level *l; /* whose objective and matrices they are */
    co_level_hessian *h;
    double *v; /* [4 n_variables] */
    size_t n;
} matrices;

static matrices matrices_of_motion(cage c, const curvopt_options *options, co_motion motion) {
    matrices m = {.s = solve_setting_of(c, options)};
    m.l = solve_level_of(m.s, motion);
    m.h = &m.l->hessian;
    m.n = co_level_objective_n(&m.l->objective);
    m.v = calloc(4 * m.n + 1, sizeof *m.v);
    CHECK_TRUE(m.v != NULL);
    return m;
}

static matrices matrices_of(cage c, const curvopt_options *options) {
    return matrices_of_motion(c, options, CO_MOTION_ALL);
}

static void matrices_free(matrices *m) {
    co_level_destroy(m->l);
    solve_setting_free(m->s);
    free(m->v);
}

static curvopt_options willmore(void) {
    return solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
}

static const int32_t pin_vertex[4] = {3, 7, 12, 9}, pin_freedom[4] = {0, 1, 2, 0};
static const double pin_direction[12] = {0, 0, 0, 1, 2, 3, 0, 1, -1}, pin_weight[4] = {1, 1, 1, 0.75};
static const curvopt_constraints pins = {
    .vertices = pin_vertex, .freedom = pin_freedom, .directions = pin_direction, .n = 4, .weights = pin_weight};

static const curvopt_constraints one_pin = {.vertices = pin_vertex, .n = 1};

/* ------------------------------------------------------------------------------------------- the solution -- */

/* out = (Hessian + shift) v, the first by differences of fourth order, without motions that the system leaves out. */
static void multiply(matrices *m, const double *v, double shift, double *out) {
    static const double at[4] = {-2, -1, 1, 2}, weight[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
    double *z = m->v + 2 * m->n, *g = m->v + 3 * m->n, h = 1e-4 / co_dof_map_longest(&m->l->objective.reduction, v);
    for (size_t i = 0; i < m->n; i++)
        out[i] = shift * v[i];
    for (int k = 0; k < 4; k++) {
        co_iterate there = {.x = z, .gradient = g};
        for (size_t i = 0; i < m->n; i++)
            z[i] = m->l->now.x[i] + at[k] * h * v[i];
        co_level_objective_evaluate(&m->l->objective, &there);
        co_vector_add(m->n, weight[k] / h, g, out);
    }
    co_newton_system_remove_motions(&m->h->system, out);
}

/* H x = g: x from the factor, H x from differences. */
static void check_solution_of_motion(cage c, curvopt_options options, co_motion motion) {
    matrices m = matrices_of_motion(c, &options, motion);
    curvopt_error error;
    double *x = m.v, *out = m.v + m.n;
    int positive = 0;
    if (options.spacing == CURVOPT_SPACING_EVEN)
        co_level_objective_weigh_spacing(&m.l->objective, 0.5 * m.l->now.value, &m.l->now);
    co_damping damping = {.shift = co_level_hessian_least_shift(m.h, m.l->now.value)};
    CHECK_OK(co_level_hessian_assemble(m.h, &m.l->now, NULL, 1, &error), &error);
    for (; !positive; damping.shift *= positive ? 1 : 2)
        CHECK_OK(co_level_hessian_factorize(m.h, &damping, &positive, &error), &error);
    CHECK_TRUE(m.h->has_factor && m.h->shift == damping.shift);
    CHECK_OK(co_level_hessian_solve(m.h, m.l->now.gradient, x, &error), &error);
    multiply(&m, x, m.h->shift, out);
    co_vector_add(m.n, -1, m.l->now.gradient, out);
    CHECK_BETWEEN(co_vector_norm(m.n, out) / co_vector_norm(m.n, m.l->now.gradient), 0, 1e-6);
    matrices_free(&m);
}

static void check_solution(cage c, curvopt_options options) {
    check_solution_of_motion(c, options, CO_MOTION_ALL);
}

/* The matrix of a step is by coarser rules than the function: near its Hessian, and another. Where all rules are the
 * coarsest it is the Hessian, but for the limit surface, whose matrices have a coarser one. */
static void check_coarser_rules(int32_t surface, int32_t term) {
    const curvopt_options options = solve_options(surface, term);
    matrices m = matrices_of(cage_shaken(cage_trapezohedron(5), 0.2), &options);
    co_assembly *a = &m.l->objective.assembly;
    curvopt_error error;
    double *close = m.v, *of_step = m.v + m.n, norm = co_vector_norm(m.n, m.l->now.gradient);
    for (int rule = 0; rule < 3; rule++) {
        const int differs = rule > 0 || surface == CURVOPT_SURFACE_LIMIT;
        memset(a->rule, rule, (size_t)a->patches.n_patches);
        CHECK_OK(co_assembly_update_batches(a, &error), &error);
        for (int closely = 0; closely < 2; closely++) {
            CHECK_OK(co_level_hessian_assemble(m.h, &m.l->now, NULL, closely, &error), &error);
            co_sparse_hessian_multiply(&m.h->system.hessian, m.l->now.gradient, closely ? close : of_step);
        }
        const double size = co_vector_norm(m.n, close);
        co_vector_add(m.n, -1, close, of_step);
        CHECK_TRUE(norm > 0 && size > 0);
        CHECK_BETWEEN(co_vector_norm(m.n, of_step) / size, differs ? 1e-9 : 0, differs ? 0.3 : 0);
    }
    matrices_free(&m);
}

static void test_steps_have_a_matrix_by_coarser_rules(void **state) {
    (void)state;
    check_coarser_rules(CURVOPT_SURFACE_POLYNOMIAL, CURVOPT_TERM_MVS);
    check_coarser_rules(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
}

/* There the motions that are left out are far from flat. */
static void test_solutions_along_normals(void **state) {
    (void)state;
    const curvopt_options w = willmore(), mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS);
    check_solution_of_motion(cage_shaken(cage_torus(8, 4, 1, 0.4), 0.2), w, CO_MOTION_NORMALS);
    check_solution_of_motion(cage_shaken(cage_torus(7, 5, 1, 0.5), 0.2), mvs, CO_MOTION_NORMALS);
    check_solution_of_motion(cage_shaken(cage_trapezohedron(5), 0.2), w, CO_MOTION_NORMALS);
}

/* With a frame at a vertex and a point inside a face in place of vertices; half of the value is an even spacing. */
static void test_solutions_where_the_surface_is_held(void **state) {
    (void)state;
    static const int32_t vertex[2] = {15, -1}, face[2] = {0, 26}, freedom[2] = {0, 2};
    static const double uv[4] = {0, 0, 0.25, 0.5}, normal[6] = {0.2, 0.1, 1, 0, 1, 0.3},
                        direction[6] = {0, 0, 0, 1, 2, 0};
    const curvopt_through through = {.struct_size = sizeof through,
                                     .n = 2,
                                     .vertices = vertex,
                                     .faces = face,
                                     .uv = uv,
                                     .freedom = freedom,
                                     .directions = direction,
                                     .normals = normal};
    curvopt_options w = willmore(), mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS);
    w.through = mvs.through = &through;
    check_solution(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), mvs);
    w.spacing = mvs.spacing = CURVOPT_SPACING_EVEN;
    check_solution(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), w);
    check_solution(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), mvs);
}

static void test_solutions_are_confirmed_by_differences(void **state) {
    (void)state;
    curvopt_options w = willmore(), mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS),
                    blended = solve_options(CURVOPT_SURFACE_POLYNOMIAL, CURVOPT_TERM_MVS), pinned = w, kept = w;
    check_solution(cage_shaken(cage_torus(8, 4, 1, 0.4), 0.02), w);
    check_solution(cage_shaken(cage_torus(8, 4, 1, 0.4), 0.02), mvs);
    check_solution(cage_shaken(cage_band(5, 3, 1, 1.2, 1), 0.05), w);
    pinned.constraints = &pins;
    check_solution(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), pinned);
    check_solution(cage_shaken(cage_band(5, 3, 1, 1.2, 1), 0.05), pinned);
    /* nearly umbilic: where nothing is held, the size at which umbilics are smoothed would be seen by differences */
    blended.constraints = &one_pin;
    blended.tolerance = 1e-6;
    check_solution(cage_shaken(cage_cube(), 0.1), blended);
    kept.symmetry = CURVOPT_SYMMETRY_KEEP;
    check_solution(cage_torus(8, 4, 1, 0.4), kept);
}

/* -------------------------------------------------------------------------------------------- the shift -- */

static void test_least_shift_is_a_part_of_the_energy_by_vertices(void **state) {
    (void)state;
    curvopt_options w = willmore();
    matrices m = matrices_of(cage_torus(5, 4, 1, 0.4), &w);
    CHECK_NEAR(co_level_hessian_least_shift(m.h, 30), 0.1 * 30 / 20, 1e-15);
    CHECK_NEAR(co_level_hessian_least_shift(m.h, -30), 0.1 * 30 / 20, 1e-15);
    m.s->tuning.shift_least = 0.7;
    CHECK_NEAR(co_level_hessian_least_shift(m.h, 30), 0.7 * 30 / 20, 1e-15);
    matrices_free(&m);
}

/* Whether the Hessian that is assembled is positive with this shift. */
static int is_positive(matrices *m, double shift) {
    curvopt_error error;
    int positive;
    CHECK_OK(co_newton_system_factorize(&m->h->system, shift, &positive, &error), &error);
    return positive;
}

/* A coarse torus is a saddle of MVS. The shift is the first of its sequence that makes the matrix positive. */
static void test_shift_rises_until_a_saddle_is_positive(void **state) {
    (void)state;
    curvopt_options mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS);
    matrices m = matrices_of(cage_torus(12, 4, 1, 0.15), &mvs);
    curvopt_error error;
    int32_t n_negative;
    double decrement, least = co_level_hessian_least_shift(m.h, m.l->now.value);
    CHECK_OK(co_level_hessian_count_negative(m.h, &m.l->now, 0, &n_negative, &decrement, &error), &error);
    CHECK_BETWEEN(n_negative, 1, m.n);
    CHECK_TRUE(isnan(decrement));
    for (int k = 0; k < 2; k++) {
        double raise = m.s->tuning.shift_raise = k ? 4 : 1.7;
        CHECK_OK(co_level_hessian_factorize_shifted(m.h, least, &error), &error);
        CHECK_TRUE(m.h->has_factor);
        double times = log(m.h->shift / least) / log(raise), shift = m.h->shift;
        CHECK_BETWEEN(times, 0.5, 60);
        CHECK_NEAR(times, round(times), 1e-9);
        CHECK_TRUE(is_positive(&m, shift));
        CHECK_TRUE(!is_positive(&m, shift / raise));
    }
    matrices_free(&m);
}

static void check_same(double a, double b) {
    CHECK_TRUE(a == b || (isnan(a) && isnan(b)));
}

/* What is said of a Hessian that is there already is what is said of one that is assembled for it. `more`: whether
 * motions count that steps do not know. */
static void check_count_of_what_is_there(cage c, const curvopt_options *options, co_motion motion, int more) {
    matrices m = matrices_of_motion(c, options, motion);
    curvopt_error error;
    int32_t n_negative[2];
    int positive, n_motions;
    double decrement[2], left[2];
    CHECK_OK(co_level_hessian_count_negative(m.h, &m.l->now, 0, &n_negative[0], &decrement[0], &error), &error);
    n_motions = m.h->system.n_motions;
    CHECK_OK(co_newton_decrement_factorize(m.h, &m.l->now, 1, &positive, &error), &error);
    CHECK_INT(n_motions > m.h->system.n_motions, more);
    CHECK_OK(co_level_hessian_count_negative(m.h, &m.l->now, 1, &n_negative[1], &decrement[1], &error), &error);
    CHECK_INT(m.h->system.n_motions, n_motions);
    CHECK_INT(n_negative[1], n_negative[0]);
    check_same(decrement[1], decrement[0]);
    for (int k = 0; k < 2; k++)
        CHECK_OK(co_newton_decrement(m.h, &m.l->now, k && !positive, &left[k], &error), &error);
    check_same(left[1], left[0]);
    matrices_free(&m);
}

static void test_count_of_a_hessian_that_is_there(void **state) {
    (void)state;
    const curvopt_options w = willmore(), mvs = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_MVS);
    curvopt_options pinned = willmore();
    pinned.constraints = &pins;
    for (int k = 0; k < 2; k++) {
        const co_motion motion = k ? CO_MOTION_NORMALS : CO_MOTION_ALL;
        check_count_of_what_is_there(cage_torus(12, 4, 1, 0.15), &mvs, motion, 0);
        check_count_of_what_is_there(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), &w, motion, 1);
        check_count_of_what_is_there(cage_torus(8, 8, 1, 0.7), &w, motion, 1);
        check_count_of_what_is_there(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), &pinned, motion, 0);
    }
}

/* Of the Gauss-Newton matrix, which is positive with the least shift: nothing but the excess changes the shift. */
static void test_long_steps_stiffen_and_short_ones_soften(void **state) {
    (void)state;
    static const struct {
        double excess, change;
    } defaults[] = {{0, 1.0 / 3}, {0.69, 1.0 / 3}, {0.71, 1}, {1.49, 1}, {1.51, 2}, {1e300, 2}};
    curvopt_options w = willmore();
    matrices m = matrices_of(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), &w);
    curvopt_error error;
    double least = co_level_hessian_least_shift(m.h, m.l->now.value);
    CHECK_OK(co_level_hessian_update(m.h, &m.l->now, 0, 0, &error), &error);
    CHECK_TRUE(m.h->has_factor);
    CHECK_NEAR(m.h->shift, least, 0);
    for (size_t k = 0; k < sizeof defaults / sizeof *defaults; k++) {
        m.h->shift = 4 * least;
        CHECK_OK(co_level_hessian_update(m.h, &m.l->now, defaults[k].excess, 0, &error), &error);
        CHECK_TRUE(m.h->has_factor);
        CHECK_NEAR(m.h->shift, 4 * least * defaults[k].change, 1e-13 * least);
    }
    m.h->shift = 2 * least; /* never below the least one */
    CHECK_OK(co_level_hessian_update(m.h, &m.l->now, 0, 0, &error), &error);
    CHECK_NEAR(m.h->shift, least, 0);
    m.s->tuning.stiffen_from = 2; /* the numbers are the table's */
    m.s->tuning.stiffen_factor = 3;
    CHECK_OK(co_level_hessian_update(m.h, &m.l->now, 1.9, 0, &error), &error);
    CHECK_NEAR(m.h->shift, least, 1e-13 * least);
    CHECK_OK(co_level_hessian_update(m.h, &m.l->now, 2.1, 0, &error), &error);
    CHECK_NEAR(m.h->shift, 3 * least, 1e-13 * least);
    m.s->tuning.soften_below = 1.2;
    m.s->tuning.soften_factor = 0.5;
    CHECK_OK(co_level_hessian_update(m.h, &m.l->now, 1.1, 0, &error), &error);
    CHECK_NEAR(m.h->shift, 1.5 * least, 1e-13 * least);
    matrices_free(&m);
}

/* out += shift times the metric of strains times the change from z to z + v, by its definition. */
static void add_strains(matrices *m, const double *v, double shift, double *out) {
    const co_level_objective *o = &m->l->objective;
    const curvopt_mesh *mesh = m->s->mesh;
    const size_t n_x = 3 * (size_t)mesh->info.n_vertices;
    double *x = calloc(3 * n_x + m->n, sizeof *x), *to = x + n_x, *force = x + 2 * n_x, *z = x + 3 * n_x;
    CHECK_TRUE(x != NULL);
    memcpy(z, m->l->now.x, m->n * sizeof *z);
    co_dof_map_expand(&o->reduction, z, x);
    co_vector_add(m->n, 1, v, z);
    co_dof_map_expand(&o->reduction, z, to);
    for (int32_t k = 0; k < mesh->info.n_edges; k++) {
        const int32_t a = mesh->corner_vertex[mesh->edge_corner[k]],
                      b = co_mesh_destination(mesh, mesh->edge_corner[k]);
        double square = 0;
        for (int c = 0; c < 3; c++)
            square += pow(x[3 * a + c] - x[3 * b + c], 2);
        for (int c = 0; c < 3; c++) {
            const double change = to[3 * a + c] - x[3 * a + c] - (to[3 * b + c] - x[3 * b + c]);
            force[3 * a + c] += shift * o->edge * o->edge / 4 * change / square;
            force[3 * b + c] -= shift * o->edge * o->edge / 4 * change / square;
        }
    }
    co_dof_map_gradient(&o->reduction, force, z);
    co_vector_add(m->n, 1, z, out);
    free(x);
}

/* L-BFGS' matrix has the shift times the metric of strains, and the least shift; a matrix of Newton's method after it
 * has the shift alone again. */
static void test_the_shift_of_lbfgs_is_one_of_strains(void **state) {
    (void)state;
    const curvopt_options w = willmore();
    matrices m = matrices_of(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), &w);
    const co_newton_system *system = &m.h->system;
    const double least = co_level_hessian_least_shift(m.h, m.l->now.value),
                 norm = co_vector_norm(m.n, m.l->now.gradient);
    curvopt_error error;
    double *x = m.v, *out = m.v + m.n;
    int positive;
    for (int newton = 0; newton < 2; newton++) {
        m.h->shift = 500;
        if (newton) {
            const co_damping damping = {.shift = 500};
            CHECK_OK(co_level_hessian_assemble(m.h, &m.l->now, NULL, 1, &error), &error);
            CHECK_OK(co_level_hessian_factorize(m.h, &damping, &positive, &error), &error);
        } else {
            CHECK_OK(co_level_hessian_update(m.h, &m.l->now, 1, 0, &error), &error);
        }
        CHECK_TRUE(m.h->has_factor && m.h->shift == 500);
        CHECK_OK(co_level_hessian_solve(m.h, m.l->now.gradient, x, &error), &error);
        co_sparse_hessian_multiply(&system->hessian, x, out);
        co_vector_add(m.n, newton ? 500 : least, x, out);
        if (!newton)
            add_strains(&m, x, 500, out);
        for (int k = 0; k < system->n_motions; k++) {
            const double *motion = system->motion + (size_t)k * m.n;
            co_vector_add(m.n, system->stiffness * co_vector_dot(m.n, motion, x), motion, out);
        }
        co_vector_add(m.n, -1, m.l->now.gradient, out);
        CHECK_BETWEEN(co_vector_norm(m.n, out), 0, 1e-10 * norm);
    }
    matrices_free(&m);
}

static void test_cancelled_runs_make_no_matrix(void **state) {
    (void)state;
    curvopt_options w = willmore();
    matrices m = matrices_of(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), &w);
    curvopt_error error;
    CHECK_OK(co_level_hessian_update(m.h, &m.l->now, 0, 0, &error), &error);
    CHECK_TRUE(m.h->has_factor);
    curvopt_cancel_request(&m.s->cancel);
    CHECK_OK(co_level_hessian_update(m.h, &m.l->now, 0, 0, &error), &error);
    CHECK_TRUE(!m.h->has_factor);
    matrices_free(&m);
}

/* Springs are in the Hessian, in the Gauss-Newton matrix, and in what is mixed of them: three times their stiffness in
 * each trace. */
static void test_springs_are_in_every_mixture(void **state) {
    (void)state;
    static const double mixes[] = {0, 1, 0.25, 0};
    const double without[4] = {1, 1, 1, 0};
    curvopt_constraints less = pins;
    less.weights = without;
    curvopt_options w = willmore(), o = w;
    w.constraints = &pins;
    o.constraints = &less;
    matrices m[2] = {matrices_of(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), &w),
                     matrices_of(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), &o)};
    double trace[2], k = 3 * 24 * 3.14159265358979323846; /* Willmore's stiffness times 0.75 / 0.25 */
    curvopt_error error;
    int positive;
    for (int j = 0; j < 2; j++)
        CHECK_OK(co_level_hessian_assemble(m[j].h, &m[j].l->now, NULL, 1, &error), &error);
    for (size_t i = 0; i < sizeof mixes / sizeof *mixes; i++) {
        for (int j = 0; j < 2; j++) {
            const co_damping damping = {.shift = 1e4, .mix = mixes[i]};
            CHECK_OK(co_level_hessian_factorize(m[j].h, &damping, &positive, &error), &error);
            CHECK_TRUE(positive && m[j].h->has_factor && m[j].h->shift == 1e4);
            trace[j] = co_sparse_hessian_mean_diagonal(&m[j].h->system.hessian) * (double)m[j].n;
        }
        CHECK_NEAR(trace[0] - trace[1], 3 * k, 1e-9 * trace[0]);
    }
    matrices_free(&m[0]);
    matrices_free(&m[1]);
}

/* --------------------------------------------------------------------------------------------- decrements -- */

/* Everything is held but vertex 6, which moves on a line: the function has one variable. */
static const int32_t every_vertex[20] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19};

static matrices one_variable(const double direction[3], double at) {
    static int32_t freedom[20];
    static double directions[60];
    static curvopt_constraints all;
    all = (curvopt_constraints){.vertices = every_vertex, .freedom = freedom, .directions = directions, .n = 20};
    freedom[6] = CO_FREEDOM_LINE;
    memcpy(directions + 18, direction, 3 * sizeof *direction);
    curvopt_options w = willmore();
    w.constraints = &all;
    matrices m = matrices_of(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), &w);
    CHECK_INT(m.n, 1);
    m.l->now.x[0] += at;
    co_level_objective_evaluate(&m.l->objective, &m.l->now);
    return m;
}

/* Second derivative in the one variable. */
static double second_derivative(matrices *m) {
    const double one = 1;
    double out;
    multiply(m, &one, 0, &out);
    return out;
}

static void test_decrement_of_one_variable(void **state) {
    (void)state;
    static const double outwards[3] = {1, 2, 3};
    matrices m = one_variable(outwards, 0.01);
    curvopt_error error;
    double decrement, H = second_derivative(&m), g = m.l->now.gradient[0];
    CHECK_BETWEEN(H, 1e-3, 1e6);
    CHECK_OK(co_newton_decrement(m.h, &m.l->now, 0, &decrement, &error), &error);
    CHECK_TRUE(!m.h->has_factor);
    double exact = 0.5 * g * g / (H + 0.1 * m.l->now.value / 20);
    CHECK_NEAR(decrement, exact, 1e-7 * exact);
    matrices_free(&m);
}

/* Somewhere along the line the function is concave: then the Gauss-Newton matrix decides, which is positive. */
static void test_decrement_where_the_hessian_is_negative(void **state) {
    (void)state;
    static const double along[3] = {0, 0, 1};
    curvopt_error error;
    int seen = 0;
    for (int k = -20; k <= 20 && !seen; k++) {
        matrices m = one_variable(along, 0.05 * k);
        double decrement, least = co_level_hessian_least_shift(m.h, m.l->now.value), g = m.l->now.gradient[0];
        if (isfinite(m.l->now.value) && second_derivative(&m) < -2 * least) {
            int positive;
            CHECK_OK(co_newton_decrement(m.h, &m.l->now, 0, &decrement, &error), &error);
            CHECK_OK(co_level_hessian_factorize_at(m.h, &m.l->now, 0, &positive, &error), &error);
            CHECK_TRUE(positive && m.h->system.hessian.value[0] >= 0);
            double exact = 0.5 * g * g / (m.h->system.hessian.value[0] + least);
            CHECK_NEAR(decrement, exact, 1e-12 * exact);
            CHECK_OK(co_newton_decrement_factorize(m.h, &m.l->now, 1, &positive, &error), &error);
            CHECK_TRUE(!positive);
            seen = 1;
        }
        matrices_free(&m);
    }
    CHECK_TRUE(seen);
}

/* Nothing may move: nothing is left. */
static void test_decrement_of_no_variables(void **state) {
    (void)state;
    const curvopt_constraints all = {.vertices = every_vertex, .n = 20};
    curvopt_options w = willmore();
    w.constraints = &all;
    solve_setting *s = solve_setting_of(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), &w);
    co_level *l = solve_level(s);
    curvopt_error error;
    double decrement = 1;
    int32_t n_negative = -1;
    CHECK_INT(co_level_objective_n(&l->objective), 0);
    CHECK_TRUE(!l->hessian.exists);
    CHECK_OK(co_newton_decrement(&l->hessian, &l->now, 0, &decrement, &error), &error);
    CHECK_NEAR(decrement, 0, 0);
    CHECK_OK(co_level_hessian_count_negative(&l->hessian, &l->now, 0, &n_negative, &decrement, &error), &error);
    CHECK_INT(n_negative, 0);
    CHECK_NEAR(decrement, 0, 0);
    co_level_destroy(l);
    solve_setting_free(s);
}

/* A flat ring has no energy: the least shift is nothing, its vertices slide for free, and rounding alone would decide
 * what the matrix is. */
static void test_decrement_where_the_energy_is_nothing(void **state) {
    (void)state;
    curvopt_options w = willmore();
    matrices m = matrices_of(cage_band(6, 3, 1, 2, 0), &w);
    curvopt_error error;
    double decrement;
    CHECK_BETWEEN(m.l->now.value, 0, 1e-20);
    CHECK_OK(co_newton_decrement(m.h, &m.l->now, 0, &decrement, &error), &error);
    CHECK_BETWEEN(decrement, 0, 1e-18);
    matrices_free(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_solutions_are_confirmed_by_differences),
        cmocka_unit_test(test_solutions_where_the_surface_is_held),
        cmocka_unit_test(test_steps_have_a_matrix_by_coarser_rules),
        cmocka_unit_test(test_solutions_along_normals),
        cmocka_unit_test(test_least_shift_is_a_part_of_the_energy_by_vertices),
        cmocka_unit_test(test_shift_rises_until_a_saddle_is_positive),
        cmocka_unit_test(test_count_of_a_hessian_that_is_there),
        cmocka_unit_test(test_long_steps_stiffen_and_short_ones_soften),
        cmocka_unit_test(test_the_shift_of_lbfgs_is_one_of_strains),
        cmocka_unit_test(test_cancelled_runs_make_no_matrix),
        cmocka_unit_test(test_springs_are_in_every_mixture),
        cmocka_unit_test(test_decrement_of_one_variable),
        cmocka_unit_test(test_decrement_where_the_hessian_is_negative),
        cmocka_unit_test(test_decrement_of_no_variables),
        cmocka_unit_test(test_decrement_where_the_energy_is_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
