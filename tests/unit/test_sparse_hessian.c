/* How face matrices become a sparse Hessian, against dense products. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "base/memory.h"
#include "constraints/given_constraints.h"
#include "energy/assembly_sums.h"
#include "hessian/sparse_hessian.h"
#include "mesh/similarity.h"

#include <string.h>

/* The Willmore energy of a cage, its variables, and its Hessian on some threads. */
typedef struct setting {
    curvopt_mesh *mesh;
    co_constraints hold;
    co_symmetry symmetry;
    co_dof_map dofs;
    co_basis_table_cache tables;
    co_assembly assembly;
    co_sparse_hessian hessian;
    double *x;
} setting;

static setting *setting_on(int32_t surface, cage c, int symmetric, const curvopt_constraints *constraints,
                           int threads) {
    setting *s = calloc(1, sizeof *s);
    CHECK_TRUE(s != NULL);
    s->x = calloc(3 * (size_t)c.n_vertices, sizeof *s->x);
    CHECK_TRUE(s->x != NULL);
    curvopt_error error;
    curvopt_options o;
    double centroid[3], radius = co_similarity_frame((size_t)c.n_vertices, c.xyz, centroid), *weight = NULL;
    curvopt_options_init(&o, sizeof o);
    o.surface = surface;
    o.threads = threads;
    s->mesh = cage_mesh(&c);
    for (int32_t i = 0; i < 3 * c.n_vertices; i++)
        s->x[i] = (c.xyz[i] - centroid[i % 3]) / radius;
    co_basis_table_cache_create(o.surface, &s->tables);
    CHECK_OK(co_given_constraints_create(s->mesh, c.xyz, constraints, &s->hold, &error), &error);
    if (symmetric)
        CHECK_OK(co_symmetry_create(s->mesh, c.xyz, &s->hold, 1, NULL, &s->symmetry, &error), &error);
    else
        CHECK_OK(co_symmetry_none(s->mesh, &s->symmetry, &error), &error);
    CHECK_OK(co_dof_map_create(s->mesh, &s->symmetry, &s->hold, s->x, &s->dofs, &error), &error);
    CHECK_OK(co_dof_map_face_weights(s->mesh, &s->symmetry, &weight, &error), &error);
    CHECK_OK(co_assembly_create(s->mesh, c.xyz, NULL, &o, &s->tables, symmetric ? weight : NULL, &s->assembly, &error),
             &error);
    CHECK_OK(co_sparse_hessian_create(&s->assembly, &s->dofs, NULL, &s->hessian, &error), &error);
    const co_second_kind kind = {.exact = 1};
    CHECK_OK(co_sparse_hessian_assemble(&s->assembly, s->x, &kind, &s->hessian, &error), &error);
    free(weight);
    cage_free(&c);
    return s;
}

static setting *setting_of(cage c, int symmetric, const curvopt_constraints *constraints, int threads) {
    return setting_on(CURVOPT_SURFACE_LIMIT, c, symmetric, constraints, threads);
}

static void setting_free(setting *s) {
    co_sparse_hessian_free(&s->hessian);
    co_assembly_free(&s->assembly);
    co_basis_table_cache_free(&s->tables);
    co_dof_map_free(&s->dofs);
    co_symmetry_free(&s->symmetry);
    co_constraints_free(&s->hold);
    curvopt_mesh_destroy(s->mesh);
    free(s->x);
    free(s);
}

/* All points over the variables, [3 n_points][n]: each variable moved by 1 and all points derived anew. */
static double *points_by_variables(const setting *s) {
    const co_patches *p = &s->assembly.patches;
    size_t n = (size_t)s->dofs.n_variables, rows = 3 * (size_t)p->n_points;
    double *z = calloc(n, sizeof *z), *origin = calloc(rows, sizeof *origin), *moved = calloc(rows, sizeof *moved),
           *out = calloc(rows * n, sizeof *out);
    CHECK_TRUE(z && origin && moved && out);
    co_dof_map_expand(&s->dofs, z, origin);
    co_patches_derive(p, origin);
    for (size_t k = 0; k < n; k++) {
        z[k] = 1;
        co_dof_map_expand(&s->dofs, z, moved);
        co_patches_derive(p, moved);
        for (size_t i = 0; i < rows; i++)
            out[i * n + k] = moved[i] - origin[i];
        z[k] = 0;
    }
    free(z);
    free(origin);
    free(moved);
    return out;
}

/* dense [n][n] += weight T^T M T, one face. */
static void add_face(const setting *s, int32_t block, int32_t k, const double *matrices, const double *T, double weight,
                     double *dense) {
    const co_element_batches *l = &s->hessian.batches;
    const co_basis_table *table = l->block[block].table;
    const int32_t lanes = l->lanes, size = 3 * table->n_points, n = s->dofs.n_variables;
    const int32_t *points = l->points + co_element_batches_point(l, block, k, 0);
    const double *matrix = matrices + co_lane_place((size_t)k, co_element_hessian_size(table->n_points), (size_t)lanes);
    double *row = calloc((size_t)n, sizeof *row); /* of M T */
    CHECK_TRUE(row != NULL);
    for (int32_t i = 0; i < size; i++) {
        const double *left = T + (3 * points[i / 3 * lanes] + i % 3) * n;
        memset(row, 0, (size_t)n * sizeof *row);
        for (int32_t j = 0; j < size; j++) {
            int32_t at = i > j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i;
            const double *right = T + (3 * points[j / 3 * lanes] + j % 3) * n;
            for (int32_t v = 0; v < n; v++)
                row[v] += weight * matrix[at * lanes] * right[v];
        }
        for (int32_t u = 0; u < n; u++)
            for (int32_t v = 0; left[u] != 0 && v < n; v++)
                dense[u * n + v] += left[u] * row[v];
    }
    free(row);
}

/* The Hessian as a dense matrix, from the matrices of all faces. */
static double *dense_hessian(const setting *s) {
    const co_sparse_hessian *h = &s->hessian;
    const co_assembly *a = &s->assembly;
    size_t n = (size_t)s->dofs.n_variables;
    double *T = points_by_variables(s), *dense = calloc(n * n, sizeof *dense);
    double *matrix = co_memory_aligned(h->matrix_stride * sizeof *matrix, 1);
    double *work = co_memory_aligned(h->work_stride * sizeof *work, 1);
    CHECK_TRUE(dense && matrix && work);
    for (int32_t k = 0; k < h->batches.n_blocks; k++) {
        const co_block *b = &h->batches.block[k];
        a->kernel->run_second(&(co_element_hessian){.table = b->table,
                                                    .n_used = b->n_used,
                                                    .points = h->batches.points + b->points,
                                                    .xyz = a->points,
                                                    .eps4 = co_functional_eps4(1),
                                                    .integrand = a->functional.second,
                                                    .exact = 1,
                                                    .matrix = matrix,
                                                    .work = work});
        for (int32_t lane = 0; lane < b->n_used; lane++) {
            int32_t patch = co_element_batches_patch(&h->batches, k, lane);
            add_face(s, k, lane, matrix, T, a->weight ? a->weight[patch] : 1, dense);
        }
    }
    free(T);
    free(matrix);
    free(work);
    return dense;
}

/* tolerance: of the largest entry. */
static void check_within(setting *s, double tolerance) {
    int32_t n = s->dofs.n_variables, derived = s->assembly.patches.derived.n_rows;
    const co_sparsity *p = &s->hessian.pattern;
    double *dense = dense_hessian(s), scale = 0, difference = 0;
    CHECK_TRUE(n > 1 && derived > 0);
    for (int32_t i = 0; i < n * n; i++)
        scale = fmax(scale, fabs(dense[i]));
    for (int32_t column = 0; column < n; column++)
        for (int32_t e = p->column_start[column]; e < p->column_start[column + 1]; e++) {
            difference = fmax(difference, fabs(dense[p->row[e] * n + column] - s->hessian.value[e]));
            dense[p->row[e] * n + column] = 0;
        }
    for (int32_t i = 0; i < n; i++) /* what is not stored is 0 */
        for (int32_t column = 0; column <= i; column++)
            difference = fmax(difference, fabs(dense[i * n + column]));
    CHECK_NEAR(difference, 0, tolerance * scale);
    free(dense);
    setting_free(s);
}

static void check_against_dense(setting *s) {
    check_within(s, 1e-13);
}

/* Triangles and pentagons are subdivided; their points are combinations of up to all vertices. */
static void test_faces_add_up_to_the_dense_product(void **state) {
    (void)state;
    check_against_dense(setting_of(cage_shaken(cage_tetrahedron(), 0.1), 0, NULL, 1));
    check_against_dense(setting_of(cage_shaken(cage_prism(5), 0.1), 0, NULL, 1));
    check_against_dense(setting_of(cage_shaken(cage_trapezohedron(5), 0.05), 0, NULL, 2));
}

/* Vertices of one node, and nodes with one to three variables. */
/* Vertices of high valence are discs (blend_disc.h), here of derived points. */
static void test_discs_add_up_to_the_dense_product(void **state) {
    (void)state;
    const int32_t polynomial = CURVOPT_SURFACE_POLYNOMIAL;
    enum { N = 4 };
    setting *s[N] = {setting_on(polynomial, cage_shaken(cage_prism(9), 0.1), 0, NULL, 1),
                     setting_on(polynomial, cage_shaken(cage_trapezohedron(8), 0.05), 0, NULL, 2),
                     setting_on(polynomial, cage_trapezohedron(20), 1, NULL, 2),
                     setting_of(cage_shaken(cage_prism(24), 0.02), 0, NULL, 1)};
    for (size_t i = 0; i < N; i++) {
        CHECK_INT(s[i]->assembly.patches.wide.n_discs, i == 2 ? 1 : 2); /* symmetry leaves one face */
        check_within(s[i], 1e-12); /* rows of coefficients add up to 19 in absolute value */
    }
}

/* A half disc (blend_disc_half.h); all vertices beyond it are held. */
static setting *half_disc(int threads) {
    cage c = cage_half_star(3, 8);
    int32_t n = 0, *fixed = calloc((size_t)c.n_vertices, sizeof *fixed);
    CHECK_TRUE(fixed != NULL);
    for (int32_t v = 0; v < c.n_vertices; v++)
        if (hypot(c.xyz[3 * v], c.xyz[3 * v + 1]) > 4.5)
            fixed[n++] = v;
    const curvopt_constraints constraints = {.vertices = fixed, .n = n};
    setting *s = setting_on(CURVOPT_SURFACE_POLYNOMIAL, cage_shaken(c, 0.02), 0, &constraints, threads);
    CHECK_INT(s->assembly.patches.wide.n_discs, 1);
    free(fixed);
    return s;
}

static void test_half_discs_add_up_to_the_dense_product(void **state) {
    (void)state;
    check_within(half_disc(1), 1e-12);
}

/* e^T H d against differences of gradients along d. */
static void test_half_discs_against_differences_of_gradients(void **state) {
    (void)state;
    setting *s = half_disc(2);
    const size_t n = (size_t)s->dofs.n_variables, n_xyz = 3 * (size_t)s->mesh->info.n_vertices;
    const co_sparsity *p = &s->hessian.pattern;
    const double step = 1e-5;
    double *z = calloc(n, sizeof *z), *d = calloc(n, sizeof *d), *e = calloc(n, sizeof *e),
           *moved = calloc(n, sizeof *moved), *x = calloc(n_xyz, sizeof *x), *along = calloc(n_xyz, sizeof *along),
           *gradient = calloc(n_xyz, sizeof *gradient);
    double wanted = 0, found = 0;
    co_values values;
    CHECK_TRUE(z && d && e && moved && x && along && gradient);
    co_dof_map_variables(&s->dofs, s->x, z);
    for (size_t k = 0; k < n; k++) {
        d[k] = sin(1.7 * (double)(k * k));
        e[k] = cos(2.3 * (double)(k * k));
        moved[k] = z[k] + e[k];
    }
    co_dof_map_expand(&s->dofs, moved, along);
    co_dof_map_expand(&s->dofs, z, x);
    for (size_t i = 0; i < n_xyz; i++)
        along[i] -= x[i];
    for (int sign = -1; sign <= 1; sign += 2) {
        for (size_t k = 0; k < n; k++)
            moved[k] = z[k] + sign * step * d[k];
        co_dof_map_expand(&s->dofs, moved, x);
        memset(gradient, 0, n_xyz * sizeof *gradient);
        co_assembly_pieces(&s->assembly, x, 0, &(co_pieces){.second = gradient}, &values);
        for (size_t i = 0; i < n_xyz; i++)
            wanted += sign * gradient[i] * along[i] / (2 * step);
    }
    for (int32_t column = 0; column < (int32_t)n; column++)
        for (int32_t at = p->column_start[column]; at < p->column_start[column + 1]; at++) {
            const int32_t row = p->row[at];
            found += s->hessian.value[at] * (e[row] * d[column] + (row == column ? 0 : e[column] * d[row]));
        }
    CHECK_TRUE(fabs(wanted) > 1);
    CHECK_NEAR(found, wanted, 1e-6 * fabs(wanted));
    free(z);
    free(d);
    free(e);
    free(moved);
    free(x);
    free(along);
    free(gradient);
    setting_free(s);
}

static void test_symmetric_faces_add_up_to_the_dense_product(void **state) {
    (void)state;
    check_against_dense(setting_of(cage_prism(6), 1, NULL, 1));
    check_against_dense(setting_of(cage_trapezohedron(5), 1, NULL, 2));
}

static void test_vertices_that_cannot_move_have_no_columns(void **state) {
    (void)state;
    static const int32_t fixed[2] = {1, 6};
    const curvopt_constraints constraints = {.vertices = fixed, .n = 2};
    setting *s = setting_of(cage_shaken(cage_prism(5), 0.1), 0, &constraints, 1);
    CHECK_INT(s->dofs.n_variables, 3 * (10 - 2));
    check_against_dense(s);
}

static void test_threads_do_not_change_a_bit(void **state) {
    (void)state;
    setting *one = setting_of(cage_shaken(cage_refined(cage_prism(5), 1), 0.05), 0, NULL, 1);
    for (int threads = 2; threads <= 5; threads++) {
        setting *more = setting_of(cage_shaken(cage_refined(cage_prism(5), 1), 0.05), 0, NULL, threads);
        CHECK_INT(more->hessian.pattern.n_entries, one->hessian.pattern.n_entries);
        CHECK_TRUE(memcmp(more->hessian.value, one->hessian.value, one->hessian.pattern.n_entries * sizeof(double)) ==
                   0);
        setting_free(more);
    }
    setting_free(one);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_faces_add_up_to_the_dense_product),
        cmocka_unit_test(test_discs_add_up_to_the_dense_product),
        cmocka_unit_test(test_half_discs_add_up_to_the_dense_product),
        cmocka_unit_test(test_half_discs_against_differences_of_gradients),
        cmocka_unit_test(test_symmetric_faces_add_up_to_the_dense_product),
        cmocka_unit_test(test_vertices_that_cannot_move_have_no_columns),
        cmocka_unit_test(test_threads_do_not_change_a_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
