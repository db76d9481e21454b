/* Second derivatives: the assembled Hessian against differences of gradients, its factors and its inertia against plain
 * dense algebra. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "constraints/given_constraints.h"
#include "energy/assembly_sums.h"
#include "hessian/newton_system.h"
#include "mesh/similarity.h"

/* A cage's function, its variables and a point. */
typedef struct problem {
    curvopt_mesh *mesh;
    co_constraints hold;
    co_symmetry symmetry;
    co_dof_map reduction;
    co_basis_table_cache *tables; /* on the heap: the problem moves */
    co_assembly assembly;
    double *x, *gx, *z;
    int n;
} problem;

static problem problem_of(cage c, const curvopt_options *o, const curvopt_constraints *constraints, int symmetric) {
    problem p = {.mesh = cage_mesh(&c)};
    curvopt_error error;
    double centroid[3], radius = co_similarity_frame((size_t)c.n_vertices, c.xyz, centroid), *weight = NULL;
    p.x = calloc(3 * (size_t)c.n_vertices, sizeof(double));
    p.gx = calloc(3 * (size_t)c.n_vertices, sizeof(double));
    p.z = calloc(3 * (size_t)c.n_vertices, sizeof(double));
    p.tables = calloc(1, sizeof *p.tables);
    CHECK_TRUE(p.x && p.gx && p.z && p.tables);
    co_basis_table_cache_create(o->surface, p.tables);
    for (int32_t i = 0; i < 3 * c.n_vertices; i++)
        p.x[i] = (c.xyz[i] - centroid[i % 3]) / radius;
    CHECK_OK(co_given_constraints_create(p.mesh, c.xyz, constraints, &p.hold, &error), &error);
    if (symmetric)
        CHECK_OK(co_symmetry_create(p.mesh, c.xyz, &p.hold, 1, NULL, &p.symmetry, &error), &error);
    else
        CHECK_OK(co_symmetry_none(p.mesh, &p.symmetry, &error), &error);
    CHECK_OK(co_dof_map_create(p.mesh, &p.symmetry, &p.hold, p.x, &p.reduction, &error), &error);
    CHECK_OK(co_dof_map_face_weights(p.mesh, &p.symmetry, &weight, &error), &error);
    CHECK_OK(co_assembly_create(p.mesh, NULL, NULL, o, p.tables, symmetric ? weight : NULL, &p.assembly, &error),
             &error);
    co_dof_map_variables(&p.reduction, p.x, p.z);
    p.n = p.reduction.n_variables;
    free(weight);
    cage_free(&c);
    return p;
}

static void problem_free(problem *p) {
    co_assembly_free(&p->assembly);
    co_basis_table_cache_free(p->tables);
    free(p->tables);
    co_dof_map_free(&p->reduction);
    co_symmetry_free(&p->symmetry);
    co_constraints_free(&p->hold);
    curvopt_mesh_destroy(p->mesh);
    free(p->x);
    free(p->gx);
    free(p->z);
}

static void gradient_at(problem *p, const double *z, double *g) {
    co_values values;
    co_dof_map_expand(&p->reduction, z, p->x);
    co_assembly_evaluate(&p->assembly, p->x, &(co_request){.is_normalized = 1, .gradient = p->gx}, &values);
    co_dof_map_gradient(&p->reduction, p->gx, g);
}

/* (H + U C U^T) v, from what the model keeps, without motions. */
static void multiply(const co_newton_system *m, int n, const double *v, double *out) {
    const co_sparse_hessian *h = &m->hessian;
    memset(out, 0, sizeof *out * (size_t)n);
    for (int j = 0; j < n; j++)
        for (int32_t e = h->pattern.column_start[j]; e < h->pattern.column_start[j + 1]; e++) {
            int i = h->pattern.row[e];
            out[i] += h->value[e] * v[j];
            if (i != j)
                out[j] += h->value[e] * v[i];
        }
    for (int k = 0; k < m->n_dense - m->n_motions; k++) {
        const double *u = m->dense + (size_t)k * (size_t)n;
        double sum = 0;
        for (int i = 0; i < n; i++)
            sum += u[i] * v[i];
        for (int i = 0; i < n; i++)
            out[i] += m->weight[k] * sum * u[i];
    }
}

static double wave(int i, int k) {
    return sin(1.7 * i + 0.3 * k * k + 0.5);
}

/* Slope of the gradient along a few directions, by differences of fourth order, against the matrix. */
static void check_against_differences(problem p, double tolerance) {
    size_t n = (size_t)p.n;
    double *v = calloc(7 * n, sizeof *v), *z = v + n, *got = v + 2 * n, *g = v + 3 * n;
    const double h = 5e-6;
    co_newton_system model;
    curvopt_error error;
    CHECK_TRUE(v != NULL && n > 0);
    CHECK_OK(co_newton_system_create(&p.assembly, &p.reduction, NULL, &model, &error), &error);
    co_dof_map_expand(&p.reduction, p.z, p.x);
    CHECK_OK(co_newton_system_assemble(&model, p.x, &(co_second_kind){.exact = 1}, CO_GAUGE_NONE, &error), &error);
    for (int k = 0; k < 4; k++) {
        double worst = 0, scale = 0;
        static const double at[4] = {-2, -1, 1, 2}, weight[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
        for (int i = 0; i < p.n; i++)
            v[i] = wave(i, k);
        for (int s = 0; s < 4; s++) {
            for (size_t i = 0; i < n; i++)
                z[i] = p.z[i] + at[s] * h * v[i];
            gradient_at(&p, z, g + (size_t)s * n);
        }
        multiply(&model, p.n, v, got);
        for (size_t i = 0; i < n; i++) {
            double wanted = 0;
            for (size_t s = 0; s < 4; s++)
                wanted += weight[s] * g[s * n + i] / h;
            worst = fmax(worst, fabs(got[i] - wanted));
            scale = fmax(scale, fabs(wanted));
        }
        CHECK_BETWEEN(worst / scale, 0, tolerance);
    }
    co_newton_system_free(&model);
    free(v);
    problem_free(&p);
}

static curvopt_options options_of(int32_t surface, double willmore, double mvs, double cross) {
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    o.surface = surface;
    o.weights[CURVOPT_TERM_WILLMORE] = willmore;
    o.weights[CURVOPT_TERM_MVS] = mvs;
    o.weights[CURVOPT_TERM_MVS_CROSS] = cross;
    o.threads = 2;
    return o;
}

static void test_regular_cages(void **state) {
    (void)state;
    curvopt_options w = options_of(CURVOPT_SURFACE_LIMIT, 1, 0, 0), mvs = options_of(CURVOPT_SURFACE_LIMIT, 0, 1, 0),
                    mix = options_of(CURVOPT_SURFACE_LIMIT, 1, 0.02, 0.01);
    check_against_differences(problem_of(cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &w, NULL, 0), 1e-6);
    check_against_differences(problem_of(cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &mvs, NULL, 0), 1e-6);
    check_against_differences(problem_of(cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &mix, NULL, 0), 1e-6);
}

/* One isolated extraordinary vertex a face; and faces that are split, whose points are rows over the cage. */
static void test_irregular_cages(void **state) {
    (void)state;
    curvopt_options w = options_of(CURVOPT_SURFACE_LIMIT, 1, 0, 0),
                    mvs = options_of(CURVOPT_SURFACE_POLYNOMIAL, 0, 1, 0);
    check_against_differences(problem_of(cage_shaken(cage_cube(), 0.1), &w, NULL, 0), 1e-6);
    check_against_differences(problem_of(cage_shaken(cage_cube(), 0.1), &mvs, NULL, 0), 5e-6);
    check_against_differences(problem_of(cage_shaken(cage_prism(5), 0.1), &w, NULL, 0), 1e-6);
    check_against_differences(problem_of(cage_shaken(cage_trapezohedron(6), 0.05), &mvs, NULL, 0), 5e-6);
}

/* Wide blends, over all vertices and over half of a symmetric cage's. */
static void test_wide_blends(void **state) {
    (void)state;
    curvopt_options mvs = options_of(CURVOPT_SURFACE_POLYNOMIAL, 0, 1, 0);
    check_against_differences(problem_of(cage_shaken(cage_refined(cage_cube(), 3), 0.01), &mvs, NULL, 0), 5e-6);
    check_against_differences(problem_of(cage_refined(cage_trapezohedron(5), 3), &mvs, NULL, 1), 5e-5);
}

static void test_reduced_cages(void **state) {
    (void)state;
    curvopt_options w = options_of(CURVOPT_SURFACE_LIMIT, 1, 0, 0),
                    mvs = options_of(CURVOPT_SURFACE_POLYNOMIAL, 0, 1, 0);
    int32_t vertices[] = {3, 7, 12}, freedom[] = {0, 1, 2};
    double directions[] = {0, 0, 0, 1, 2, 3, 0, 1, -1};
    curvopt_constraints pins = {.vertices = vertices, .freedom = freedom, .directions = directions, .n = 3};
    check_against_differences(problem_of(cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &mvs, &pins, 0), 1e-6);
    check_against_differences(problem_of(cage_torus(8, 4, 1, 0.4), &w, NULL, 1), 1e-6);
    check_against_differences(problem_of(cage_torus(8, 4, 1, 0.4), &mvs, NULL, 1), 1e-6);
    /* two smooth motions, in which what stiff ones have cancels */
    check_against_differences(problem_of(cage_prism(5), &mvs, NULL, 1), 5e-5);
    check_against_differences(problem_of(cage_trapezohedron(6), &w, NULL, 1), 1e-6);
}

/* ------------------------------------------------------------------------------- digits, and the lifted matrix -- */

static double largest_diagonal(const co_newton_system *m, int n) {
    double largest = 0;
    for (int j = 0; j < n; j++)
        largest = fmax(largest, fabs(m->hessian.value[m->hessian.pattern.column_start[j]]));
    return largest;
}

/* The direction of least curvature, by inverse iteration from a vector without symmetries. */
static void softest(co_newton_system *m, int n, double *v) {
    int positive = 0;
    curvopt_error error;
    double shift = 1;
    for (; !positive; shift *= 4)
        CHECK_OK(co_newton_system_factorize(m, shift, &positive, &error), &error);
    for (int i = 0; i < n; i++)
        v[i] = wave(i, 2);
    for (int step = 0; step < 60; step++) {
        double norm = 0;
        for (int i = 0; i < n; i++)
            norm += v[i] * v[i];
        for (int i = 0; i < n; i++)
            v[i] /= sqrt(norm);
        CHECK_OK(co_newton_system_solve(m, v, v, &error), &error);
    }
    double norm = 0;
    for (int i = 0; i < n; i++)
        norm += v[i] * v[i];
    for (int i = 0; i < n; i++)
        v[i] /= sqrt(norm);
}

/* v becomes the rotation of x about an axis. */
static void rotate(int32_t n_vertices, const double *x, double *v) {
    for (int32_t i = 0; i < n_vertices; i++) {
        v[3 * i] = 0;
        v[3 * i + 1] = -x[3 * i + 2];
        v[3 * i + 2] = x[3 * i + 1];
    }
}

/* The energy does not see rotations: the Hessian makes of one the rotation of the gradient. Eigenvalues go over ten
 * orders and more, and the least ones, which the optimizer lives by, must not be noise of the largest. */
static void test_digits(void **state) {
    (void)state;
    curvopt_options mvs = options_of(CURVOPT_SURFACE_LIMIT, 0, 1, 0);
    problem p = problem_of(cage_shaken(cage_refined(cage_torus(8, 4, 1, 0.4), 2), 0.002), &mvs, NULL, 0);
    size_t n = (size_t)p.n, n_full = 3 * (size_t)p.reduction.n_vertices;
    double *v = calloc(4 * n_full, sizeof *v), *got = v + n_full, *wanted = v + 2 * n_full, *full = v + 3 * n_full;
    co_newton_system model;
    curvopt_error error;
    CHECK_TRUE(v != NULL);
    CHECK_OK(co_newton_system_create(&p.assembly, &p.reduction, NULL, &model, &error), &error);
    gradient_at(&p, p.z, wanted);
    CHECK_OK(co_newton_system_assemble(&model, p.x, &(co_second_kind){.exact = 1}, CO_GAUGE_NONE, &error), &error);
    rotate(p.reduction.n_vertices, p.gx, full);
    co_dof_map_gradient(&p.reduction, full, wanted);
    rotate(p.reduction.n_vertices, p.x, full);
    co_dof_map_variables(&p.reduction, full, v);
    multiply(&model, p.n, v, got);
    double worst = 0;
    for (size_t i = 0; i < n; i++)
        worst = fmax(worst, fabs(got[i] - wanted[i]));
    CHECK_BETWEEN(worst / largest_diagonal(&model, p.n), 0, 1e-11);
    co_newton_system_free(&model);
    problem_free(&p);
    free(v);
}

/* A step along the slide v, of this length: how far M(x; before) v is from M(x) v. */
static void compare_lifted(problem *p, co_newton_system *model, const double *v, double length, double *lifted) {
    size_t n = (size_t)p->n, n_full = 3 * (size_t)p->reduction.n_vertices;
    double *x = calloc(2 * n_full + 3 * n, sizeof *x), *before = x + n_full, *z = x + 2 * n_full, *there = z + n,
           *other = z + 2 * n;
    curvopt_error error;
    CHECK_TRUE(x != NULL);
    for (size_t i = 0; i < n; i++)
        z[i] = p->z[i] + length * v[i];
    co_dof_map_expand(&p->reduction, p->z, before);
    co_dof_map_expand(&p->reduction, z, x);
    CHECK_OK(co_newton_system_assemble(model, x, &(co_second_kind){.exact = 1}, CO_GAUGE_NONE, &error), &error);
    multiply(model, p->n, v, there);
    CHECK_OK(
        co_newton_system_assemble(model, x, &(co_second_kind){.exact = 1, .before = before}, CO_GAUGE_NONE, &error),
        &error);
    multiply(model, p->n, v, other);
    *lifted = 0;
    for (size_t i = 0; i < n; i++)
        *lifted += v[i] * (other[i] - there[i]);
    free(x);
}

/* Without a step it is the Hessian; after one it differs from that by the second order of the step. (That it leads
 * further is seen in tests/numeric, by the steps that a level takes.) */
static void test_lifted_matrix(void **state) {
    (void)state;
    curvopt_options mvs = options_of(CURVOPT_SURFACE_LIMIT, 0, 1, 0);
    problem p = problem_of(cage_refined(cage_torus(8, 4, 1, 0.4), 2), &mvs, NULL, 1);
    double *v = calloc((size_t)p.n, sizeof *v), lifted[3];
    co_newton_system model;
    curvopt_error error;
    CHECK_TRUE(v != NULL);
    CHECK_OK(co_newton_system_create(&p.assembly, &p.reduction, NULL, &model, &error), &error);
    CHECK_OK(co_newton_system_assemble(&model, p.x, &(co_second_kind){.exact = 1}, CO_GAUGE_SIMILARITY, &error),
             &error);
    softest(&model, p.n, v);
    compare_lifted(&p, &model, v, 0, &lifted[0]);
    CHECK_NEAR(lifted[0], 0, 1e-13 * largest_diagonal(&model, p.n));
    for (int k = 1; k < 3; k++)
        compare_lifted(&p, &model, v, 0.02 / k, &lifted[k]);
    CHECK_BETWEEN(log2(lifted[1] / lifted[2]), 1.8, 2.2);
    co_newton_system_free(&model);
    problem_free(&p);
    free(v);
}

/* The matrix between the Hessian and the Gauss-Newton matrix, with some of each, and back. The dense columns stay. */
static void test_mixture(void **state) {
    (void)state;
    curvopt_options mvs = options_of(CURVOPT_SURFACE_LIMIT, 0, 1, 0);
    problem p = problem_of(cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &mvs, NULL, 0);
    size_t n = (size_t)p.n;
    double *v = calloc(4 * n, sizeof *v), *exact = v + n, *guide = v + 2 * n, *got = v + 3 * n, scale = 0;
    static const double mixes[] = {0.25, 1, 0, 0.75};
    co_newton_system model;
    curvopt_error error;
    CHECK_TRUE(v != NULL);
    for (int i = 0; i < p.n; i++)
        v[i] = wave(i, 4);
    CHECK_OK(co_newton_system_create(&p.assembly, &p.reduction, NULL, &model, &error), &error);
    CHECK_OK(co_newton_system_assemble(&model, p.x, &(co_second_kind){.exact = 1}, CO_GAUGE_SIMILARITY, &error),
             &error);
    multiply(&model, p.n, v, exact);
    CHECK_OK(co_newton_system_begin_gauss_newton(&model, p.x, &error), &error);
    multiply(&model, p.n, v, guide);
    co_newton_system_end_gauss_newton(&model);
    for (size_t i = 0; i < n; i++)
        scale = fmax(scale, fabs(exact[i]));
    for (size_t k = 0; k < sizeof mixes / sizeof *mixes; k++) {
        double worst = 0, apart = 0;
        co_newton_system_mix(&model, mixes[k]);
        multiply(&model, p.n, v, got);
        for (size_t i = 0; i < n; i++) {
            worst = fmax(worst, fabs(got[i] - (1 - mixes[k]) * exact[i] - mixes[k] * guide[i]));
            apart = fmax(apart, fabs(exact[i] - guide[i]));
        }
        CHECK_BETWEEN(worst / scale, 0, 1e-14);
        CHECK_BETWEEN(apart / scale, 0.01, 10);
    }
    CHECK_OK(co_newton_system_assemble(&model, p.x, &(co_second_kind){.exact = 0}, CO_GAUGE_SIMILARITY, &error),
             &error);
    CHECK_NEAR(model.mix, 0, 0);
    for (size_t e = 0; e < model.hessian.pattern.n_entries; e++)
        CHECK_NEAR(model.hessian.value[e], model.gauss_newton[e], 0);
    co_newton_system_free(&model);
    problem_free(&p);
    free(v);
}

/* Gaussian elimination with the whole matrix: solutions and signs of pivots, by symmetric pivoting on the diagonal. */
static int eliminate(int n, double *a, double *b) {
    int negative = 0;
    for (int k = 0; k < n; k++) {
        negative += a[k * n + k] < 0;
        for (int i = k + 1; i < n; i++) {
            double f = a[i * n + k] / a[k * n + k];
            for (int j = k; j < n; j++)
                a[i * n + j] -= f * a[k * n + j];
            b[i] -= f * b[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++)
            b[k] -= a[k * n + j] * b[j];
        b[k] /= a[k * n + k];
    }
    return negative;
}

static void test_solutions_and_inertia(void **state) {
    (void)state;
    curvopt_options mvs = options_of(CURVOPT_SURFACE_LIMIT, 0, 1, 0);
    problem p = problem_of(cage_shaken(cage_torus(7, 5, 1, 0.4), 0.05), &mvs, NULL, 0);
    size_t n = (size_t)p.n;
    double *a = calloc(n * n, sizeof *a), *e = calloc(4 * n, sizeof *e), *b = e + n, *x = e + 2 * n;
    co_newton_system model;
    curvopt_error error;
    int positive;
    int32_t negative;
    CHECK_TRUE(a && e);
    CHECK_OK(co_newton_system_create(&p.assembly, &p.reduction, NULL, &model, &error), &error);
    model.leaves_motions_out = 1;
    for (int round = 0; round < 2; round++) {
        CHECK_OK(co_newton_system_assemble(&model, p.x, &(co_second_kind){.exact = 1},
                                           round ? CO_GAUGE_MOEBIUS : CO_GAUGE_SIMILARITY, &error),
                 &error);
        CHECK_INT(model.n_dense, round ? 12 : 9);
        const double mean = co_newton_system_mean_diagonal(&model), shift = round ? 0.5 * mean : 0.01 * mean;
        for (size_t j = 0; j < n; j++) { /* P (M + shift) P, and motions as they are */
            memset(e, 0, n * sizeof *e);
            e[j] = 1;
            co_newton_system_remove_motions(&model, e);
            multiply(&model, p.n, e, a + j * n);
            for (size_t i = 0; i < n; i++)
                a[j * n + i] += shift * e[i];
            co_newton_system_remove_motions(&model, a + j * n);
            for (size_t i = 0; i < n; i++)
                a[j * n + i] += (i == j) - e[i];
        }
        for (size_t i = 0; i < n; i++)
            b[i] = x[i] = wave((int)i, 3);
        co_newton_system_remove_motions(&model, b);
        CHECK_OK(co_newton_system_count_negative(&model, shift, x, e, &negative, &error), &error);
        CHECK_OK(co_newton_system_factorize(&model, shift, &positive, &error), &error);
        int wanted = eliminate(p.n, a, b);
        CHECK_INT(negative, wanted);
        for (size_t i = 0; i < n; i++) /* indefinite or not */
            CHECK_NEAR(e[i], b[i], 1e-7 * (1 + fabs(b[i])));
        CHECK_INT(positive, wanted == 0);
        if (positive)
            CHECK_OK(co_newton_system_solve(&model, x, x, &error), &error);
        for (size_t i = 0; positive && i < n; i++)
            CHECK_NEAR(x[i], b[i], 1e-8 * (1 + fabs(b[i])));
    }
    co_newton_system_free(&model);
    problem_free(&p);
    free(a);
    free(e);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_regular_cages), cmocka_unit_test(test_irregular_cages),
        cmocka_unit_test(test_wide_blends),   cmocka_unit_test(test_reduced_cages),
        cmocka_unit_test(test_digits),        cmocka_unit_test(test_lifted_matrix),
        cmocka_unit_test(test_mixture),       cmocka_unit_test(test_solutions_and_inertia),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
