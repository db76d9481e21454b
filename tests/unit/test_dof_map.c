/* Variables of a minimization: orthonormal, complete, and what symmetry and constraints leave.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "constraints/dof_map.h"
#include "constraints/given_constraints.h"
#include "energy/assembly_sums.h"
#include "linalg/vector.h"
#include "mesh/similarity.h"

typedef struct setting {
    cage c;
    curvopt_mesh *mesh;
    co_constraints constraints;
    co_symmetry symmetry;
    co_dof_map dofs;
    double *x, *gx; /* [3 n_vertices] */
    double *z, *gz; /* [n_variables] */
    size_t n, n_full;
} setting;

static double *zeros(size_t n) {
    double *p = calloc(n + 1, sizeof *p);
    CHECK_TRUE(p != NULL);
    return p;
}

/* Takes the cage, as it is. */
static setting setting_of(cage c, const curvopt_constraints *user, int symmetric) {
    setting s = {.c = c, .mesh = cage_mesh(&c)};
    curvopt_error error;
    CHECK_OK(co_given_constraints_create(s.mesh, c.xyz, user, &s.constraints, &error), &error);
    if (symmetric)
        CHECK_OK(co_symmetry_create(s.mesh, c.xyz, &s.constraints, 1, NULL, &s.symmetry, &error), &error);
    else
        CHECK_OK(co_symmetry_none(s.mesh, &s.symmetry, &error), &error);
    CHECK_OK(co_dof_map_create(s.mesh, &s.symmetry, &s.constraints, c.xyz, &s.dofs, &error), &error);
    s.n = (size_t)s.dofs.n_variables;
    s.n_full = 3 * (size_t)c.n_vertices;
    s.x = zeros(s.n_full);
    s.gx = zeros(s.n_full);
    s.z = zeros(s.n);
    s.gz = zeros(s.n);
    return s;
}

static void setting_free(setting *s) {
    co_dof_map_free(&s->dofs);
    co_symmetry_free(&s->symmetry);
    co_constraints_free(&s->constraints);
    curvopt_mesh_destroy(s->mesh);
    cage_free(&s->c);
    free(s->x);
    free(s->gx);
    free(s->z);
    free(s->gz);
}

/* Unit vectors of variables become orthonormal displacements; variables of what they reach are they themselves; the
 * gradient is the transpose. */
static void check_map(setting *s) {
    double *origin = zeros(s->n_full), *columns = zeros(s->n * s->n_full);
    co_dof_map_expand(&s->dofs, s->z, origin);
    for (size_t k = 0; k < s->n; k++) {
        s->z[k] = 1;
        co_dof_map_expand(&s->dofs, s->z, s->x);
        co_dof_map_variables(&s->dofs, s->x, s->gz);
        for (size_t j = 0; j < s->n; j++)
            CHECK_NEAR(s->gz[j], j == k, 1e-14);
        for (size_t i = 0; i < s->n_full; i++)
            columns[k * s->n_full + i] = s->x[i] - origin[i];
        s->z[k] = 0;
    }
    uint64_t random = 3;
    for (size_t i = 0; i < s->n_full; i++)
        s->gx[i] = check_random(&random);
    co_dof_map_gradient(&s->dofs, s->gx, s->gz);
    for (size_t k = 0; k < s->n; k++) {
        for (size_t j = 0; j <= k; j++)
            CHECK_NEAR(co_vector_dot(s->n_full, columns + j * s->n_full, columns + k * s->n_full), j == k, 1e-14);
        CHECK_NEAR(s->gz[k], co_vector_dot(s->n_full, columns + k * s->n_full, s->gx), 1e-14);
    }
    co_dof_map_variables(&s->dofs, s->c.xyz, s->z);
    co_dof_map_expand(&s->dofs, s->z, s->x);
    for (size_t i = 0; i < s->n_full; i++) /* the cage itself is in reach */
        CHECK_NEAR(s->x[i], s->c.xyz[i], 1e-14);
    free(origin);
    free(columns);
}

static void test_variables_are_orthonormal(void **state) {
    (void)state;
    const int32_t vertices[4] = {0, 3, 5, 6}, freedom[4] = {0, 1, 2, 2};
    const double directions[12] = {0, 0, 0, 1, 2, 3, 0, 1, 1, 1, 0, 0};
    curvopt_constraints user = {.n = 4, .vertices = vertices, .freedom = freedom, .directions = directions};
    setting s = setting_of(cage_torus(4, 4, 2, 1), NULL, 0);
    CHECK_INT(s.n, 48);
    CHECK_TRUE(s.dofs.plain);
    check_map(&s);
    setting_free(&s);
    s = setting_of(cage_torus(4, 4, 2, 1), &user, 0);
    CHECK_INT(s.n, 48 - 3 - 2 - 1 - 1);
    CHECK_TRUE(!s.dofs.plain && s.dofs.offset);
    check_map(&s);
    setting_free(&s);
    s = setting_of(cage_prism(6), NULL, 1); /* one orbit of 12 vertices, each on a mirror plane: radius and height */
    CHECK_INT(s.symmetry.order, 24);
    CHECK_INT(s.n, 2);
    check_map(&s);
    setting_free(&s);
    cage c = cage_torus(4, 4, 2, 1);
    for (int32_t i = 0; i < 3 * c.n_vertices; i++) /* mirror planes and lines askew */
        c.xyz[i] = c.xyz[i] + 0.3 * c.xyz[(i / 3) * 3 + (i + 1) % 3];
    s = setting_of(c, NULL, 1);
    CHECK_TRUE(s.symmetry.order > 1);
    check_map(&s);
    setting_free(&s);
}

static void test_lists_of_vertices_do_as_all(void **state) {
    (void)state;
    for (int symmetric = 0; symmetric < 2; symmetric++) {
        setting s = setting_of(cage_prism(4), NULL, symmetric);
        const int32_t some[2] = {1, 6};
        double *other = zeros(s.n_full);
        uint64_t random = 11;
        for (size_t k = 0; k < s.n; k++)
            s.z[k] = check_random(&random);
        co_dof_map_expand(&s.dofs, s.z, s.x);
        co_dof_map_expand_some(&s.dofs, some, 2, s.z, other);
        for (size_t i = 0; i < s.n_full; i++)
            CHECK_NEAR(other[i], i / 3 == 1 || i / 3 == 6 ? s.x[i] : 0, 0);
        co_dof_map_expand_some(&s.dofs, NULL, 0, s.z, other);
        for (size_t i = 0; i < s.n_full; i++)
            CHECK_NEAR(other[i], s.x[i], 0);
        memset(s.gx, 0, s.n_full * sizeof *s.gx);
        s.gx[4] = 1;
        s.gx[20] = -2;
        co_dof_map_gradient(&s.dofs, s.gx, s.gz);
        co_dof_map_gradient_of(&s.dofs, some, 2, s.gx, s.z);
        for (size_t k = 0; k < s.n; k++)
            CHECK_NEAR(s.z[k], s.gz[k], 0);
        free(other);
        setting_free(&s);
    }
}

static void test_the_longest_displacement_is_a_vertex_own(void **state) {
    (void)state;
    for (int symmetric = 0; symmetric < 2; symmetric++) {
        setting s = setting_of(cage_prism(5), NULL, symmetric);
        double *origin = zeros(s.n_full), longest = 0;
        uint64_t random = 7;
        co_dof_map_expand(&s.dofs, s.z, origin);
        for (size_t k = 0; k < s.n; k++)
            s.z[k] = check_random(&random);
        co_dof_map_expand(&s.dofs, s.z, s.x);
        for (size_t v = 0; v < s.n_full / 3; v++) {
            double square = 0;
            for (size_t k = 3 * v; k < 3 * v + 3; k++)
                square += (s.x[k] - origin[k]) * (s.x[k] - origin[k]);
            longest = fmax(longest, sqrt(square));
        }
        CHECK_NEAR(co_dof_map_longest(&s.dofs, s.z), longest, 1e-14);
        free(origin);
        setting_free(&s);
    }
}

/* Normalized by variables and by positions: the same cage, the same radius; and the two formulas by which gradients are
 * taken back agree, with and without symmetry. */
static void test_normalization_is_that_of_positions(void **state) {
    (void)state;
    for (int symmetric = 0; symmetric < 2; symmetric++) {
        cage c = cage_refined(cage_prism(3), 1);
        for (int32_t i = 0; i < 3 * c.n_vertices; i++)
            c.xyz[i] = 2.5 * c.xyz[i] + (symmetric ? 0 : i % 3 - 0.7);
        setting s = setting_of(c, NULL, symmetric);
        double centroid[3], radius = co_similarity_frame((size_t)c.n_vertices, c.xyz, centroid);
        double *normalized = zeros(s.n), *g = zeros(s.n_full);
        co_dof_map_variables(&s.dofs, c.xyz, s.z);
        CHECK_NEAR(co_dof_map_normalize(&s.dofs, s.z, normalized), radius, 1e-14 * radius);
        co_dof_map_expand(&s.dofs, normalized, s.x);
        for (size_t i = 0; i < s.n_full; i++)
            CHECK_NEAR(s.x[i], (c.xyz[i] - centroid[i % 3]) / radius, 1e-14);
        curvopt_options o;
        curvopt_error error;
        co_assembly assembly;
        co_values raw, values;
        curvopt_options_init(&o, sizeof o);
        o.surface = CURVOPT_SURFACE_POLYNOMIAL;
        o.threads = 1;
        CHECK_OK(co_assembly_create(s.mesh, NULL, NULL, &o, NULL, NULL, &assembly, &error), &error);
        co_assembly_evaluate(&assembly, c.xyz, &(co_request){.gradient = g}, &raw);
        co_assembly_evaluate(&assembly, s.x, &(co_request){.is_normalized = 1, .gradient = s.gx}, &values);
        CHECK_NEAR(values.objective / raw.objective, 1, 1e-13);
        CHECK_NEAR(raw.radius, radius, 0);
        CHECK_NEAR(values.radius, 1, 0);
        co_dof_map_gradient(&s.dofs, s.gx, s.gz);
        co_dof_map_normalized_gradient(&s.dofs, normalized, radius, s.gz);
        co_dof_map_gradient(&s.dofs, g, s.z);
        double size = co_vector_norm(s.n, s.gz);
        CHECK_TRUE(size > 0.01);
        for (size_t k = 0; k < s.n; k++)
            CHECK_NEAR(s.gz[k], s.z[k], 1e-11 * size);
        co_assembly_free(&assembly);
        free(normalized);
        free(g);
        setting_free(&s);
    }
}

/* Each orbit of faces is represented once. */
static void test_face_weights_count_orbits(void **state) {
    (void)state;
    cage c = cage_torus(6, 4, 2, 1);
    setting s = setting_of(c, NULL, 1);
    double *weight, sum = 0;
    int n_used = 0;
    curvopt_error error;
    CHECK_OK(co_dof_map_face_weights(s.mesh, &s.symmetry, &weight, &error), &error);
    for (int32_t f = 0; f < c.n_faces; f++) {
        sum += weight[f];
        n_used += weight[f] > 0;
    }
    CHECK_NEAR(sum, c.n_faces, 0);
    CHECK_INT(n_used, 2); /* outer and inner faces */
    free(weight);
    setting_free(&s);
}

static void test_the_identity_is_plain(void **state) {
    (void)state;
    co_dof_map dofs;
    curvopt_error error;
    double x[9], z[9] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    CHECK_OK(co_dof_map_identity(3, &dofs, &error), &error);
    CHECK_INT(dofs.n_variables, 9);
    CHECK_INT(co_dof_map_dimension(&dofs, 2), 3);
    co_dof_map_expand(&dofs, z, x);
    co_dof_map_variables(&dofs, x, z);
    for (int k = 0; k < 9; k++)
        CHECK_TRUE(x[k] == k + 1 && z[k] == k + 1);
    co_dof_map_free(&dofs);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_variables_are_orthonormal),
        cmocka_unit_test(test_lists_of_vertices_do_as_all),
        cmocka_unit_test(test_the_longest_displacement_is_a_vertex_own),
        cmocka_unit_test(test_normalization_is_that_of_positions),
        cmocka_unit_test(test_face_weights_count_orbits),
        cmocka_unit_test(test_the_identity_is_plain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
