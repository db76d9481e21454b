/* Springs of points, normals, tangents and curvatures of the surface, beside points that are held exactly: value,
 * gradient and second derivatives by differences; couplings. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "constraints/given_through.h"
#include "constraints/pivots.h"
#include "hessian/surface_springs.h"
#include "mesh/similarity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A second derivative of a curvature that is wanted is a value, and three are one spring. */
enum { N_ENTRIES = 6, N_VALUES = 15, N_SPRINGS = 11 };

/* On an 8 x 4 torus: one held, a point on a line with its normal, a normal and a tangent with curvatures, two points of
 * a face, curvatures in another one. */
static const int32_t vertex[N_ENTRIES] = {5, 6, 10, -1, -1, -1}, face[N_ENTRIES] = {0, 0, 0, 4, 4, 20},
                     freedom[N_ENTRIES] = {0, 1, 3, 0, 2, 3}, toward[N_ENTRIES] = {0, 0, 9, 0, 0, 0};
static const double uv[2 * N_ENTRIES] = {0, 0, 0, 0, 0, 0, 0.25, 0.5, 0.3, 0.5, 0.7, 0.4},
                           direction[3 * N_ENTRIES] = {0, 0, 0, 1, 2, 3, 0, 0, 0, 0, 0, 0, 3, -1, 1},
                           weight[N_ENTRIES] = {1, 0.25, 0.75, 0.5, 0.9, 0.4};
static const double SCALE = 7;

typedef struct setting {
    cage c;
    curvopt_mesh *mesh;
    co_constraints held;
    co_interpolation map;
    co_symmetry symmetry;
    co_dof_map dofs;
    co_surface_springs springs;
    double centroid[3], radius, x[96], z[96];
} setting;

/* With curvatures, or without: then the springs are quadratic. */
static void setting_with(setting *s, int curved) {
    double normal[3 * N_ENTRIES], tangent[3 * N_ENTRIES], curvature[2 * N_ENTRIES], bends_along[3 * N_ENTRIES];
    const curvopt_through through = {.struct_size = sizeof through,
                                     .n = N_ENTRIES,
                                     .vertices = vertex,
                                     .faces = face,
                                     .uv = uv,
                                     .freedom = freedom,
                                     .directions = direction,
                                     .normals = normal,
                                     .tangents = tangent,
                                     .toward = toward,
                                     .weights = weight,
                                     .curvatures = curved ? curvature : NULL,
                                     .curvature_directions = curved ? bends_along : NULL};
    curvopt_options o;
    curvopt_error error;
    *s = (setting){.c = cage_torus(8, 4, 3, 1.2)};
    for (int i = 0; i < 3 * N_ENTRIES; i++)
        normal[i] = tangent[i] = bends_along[i] = (double)NAN;
    for (int i = 0; i < 2 * N_ENTRIES; i++)
        curvature[i] = (double)NAN;
    memcpy(normal + 3, (double[]){1, 2, 2}, 3 * sizeof *normal);
    memcpy(normal + 6, (double[]){0, 3, 4}, 3 * sizeof *normal);
    memcpy(tangent + 6, (double[]){5, 4, -3}, 3 * sizeof *tangent);
    memcpy(curvature + 4, (double[]){1.5, -0.5}, 2 * sizeof *curvature);
    memcpy(normal + 15, (double[]){1, 1, 3}, 3 * sizeof *normal);
    memcpy(curvature + 10, (double[]){-1, 0.25}, 2 * sizeof *curvature);
    memcpy(bends_along + 15, (double[]){3, 0, -1}, 3 * sizeof *bends_along);
    cage_perturb(&s->c, 0.2, 5);
    s->mesh = cage_mesh(&s->c);
    s->radius = co_similarity_frame(32, s->c.xyz, s->centroid);
    for (size_t i = 0; i < 96; i++)
        s->x[i] = (s->c.xyz[i] - s->centroid[i % 3]) / s->radius;
    curvopt_options_init(&o, sizeof o);
    o.through = &through;
    CHECK_OK(co_given_through_create(s->mesh, s->c.xyz, &o, &s->held, &error), &error);
    CHECK_INT(s->held.values.n, 1);
    CHECK_INT(s->held.drawn.n, curved ? N_VALUES : N_VALUES - 6);
    CHECK_OK(co_pivots_choose(s->mesh, NULL, &s->held, &error), &error);
    CHECK_OK(co_interpolation_create(s->mesh, &s->held, &s->map, &error), &error);
    co_interpolation_from_cage(&s->map, s->x);
    CHECK_OK(co_symmetry_none(s->mesh, &s->symmetry, &error), &error);
    CHECK_OK(co_dof_map_create(s->mesh, &s->symmetry, &s->held, s->x, &s->dofs, &error), &error);
    co_dof_map_variables(&s->dofs, s->x, s->z);
    CHECK_OK(co_surface_values_make_rows(s->mesh, &s->held.drawn, &error), &error);
    CHECK_OK(co_surface_springs_create(&s->held.drawn, &s->map, &s->dofs, s->centroid, s->radius, SCALE, &s->springs,
                                       &error),
             &error);
}

static void setting_free(setting *s) {
    co_surface_springs_free(&s->springs);
    co_dof_map_free(&s->dofs);
    co_symmetry_free(&s->symmetry);
    co_interpolation_free(&s->map);
    co_constraints_free(&s->held);
    curvopt_mesh_destroy(s->mesh);
    cage_free(&s->c);
}

static void setting_of(setting *s) {
    setting_with(s, 1);
}

static void move(setting *s, uint64_t seed) {
    for (int32_t i = 0; i < s->dofs.n_variables; i++)
        s->z[i] += 0.3 * check_random(&seed);
}

/* What the second form off value k on is off by, in parts of 1 / radius: its values are not normalized here. */
static double form_is_off(const setting *s, int k, const double *value) {
    const co_surface_value *f = &s->held.drawn.item[k];
    co_second_form wanted;
    memcpy(wanted.normal, f->direction, sizeof wanted.normal);
    memcpy(wanted.tensor, f->curvature, sizeof wanted.tensor);
    return s->radius * s->radius * co_second_form_off(&wanted, value + 3 * (k - 2), NULL, NULL, 0);
}

/* SCALE / 2 sum k |Q (value - wanted)|^2 of the cage that the variables make, points in parts of the radius; of second
 * forms likewise. */
static double definition(setting *s) {
    double xyz[96], value[3 * N_VALUES], sum = 0;
    co_dof_map_expand(&s->dofs, s->z, xyz);
    co_interpolation_to_cage(&s->map, xyz);
    for (size_t i = 0; i < 96; i++)
        xyz[i] = s->radius * xyz[i] + s->centroid[i % 3];
    co_sparse_rows_apply(&s->held.drawn.rows, xyz, value);
    for (int k = 0; k < N_VALUES; k++) {
        const co_surface_value *f = &s->held.drawn.item[k];
        const double w = weight[f->number];
        double square = 0, along = 0;
        if (f->order == 2) {
            sum += SCALE * w / (1 - w) * form_is_off(s, k, value);
            k += 2;
            continue;
        }
        for (int c = 0; c < 3; c++) {
            const double off = (value[3 * k + c] - f->anchor[c]) / (f->order ? 1 : s->radius);
            square += off * off;
            along += off * f->direction[c];
        }
        sum += SCALE / 2 * w / (1 - w) *
               (f->freedom == CO_FREEDOM_LINE    ? square - along * along
                : f->freedom == CO_FREEDOM_PLANE ? along * along
                                                 : square);
    }
    return sum;
}

static void test_value_is_its_definition(void **state) {
    (void)state;
    setting s;
    setting_of(&s);
    for (uint64_t seed = 1; seed < 4; seed++) {
        CHECK_NEAR(co_surface_springs_value(&s.springs, s.z, 1, NULL), definition(&s), 1e-11);
        move(&s, seed);
    }
    setting_free(&s);
}

/* Tangents that springs draw have length 1 on the first cage, and two of an entry stand at right angles; so they do on
 * its subdivision. */
static void test_tangents_are_unit_vectors(void **state) {
    (void)state;
    setting s;
    setting_of(&s);
    const co_surface_values *drawn = &s.held.drawn;
    curvopt_mesh *fine;
    curvopt_error error;
    double *xyz = calloc(3 * 128, sizeof *xyz), t[3 * N_VALUES];
    CHECK_TRUE(xyz != NULL);
    CHECK_OK(curvopt_mesh_refine(s.mesh, s.c.xyz, &fine, xyz, &error), &error);
    for (int level = 0; level < 2; level++) {
        int n = 0;
        if (level) {
            co_surface_values_subdivide(s.mesh, &s.held.drawn);
            CHECK_OK(co_surface_values_make_rows(fine, &s.held.drawn, &error), &error);
        }
        co_sparse_rows_apply(&drawn->rows, level ? xyz : s.c.xyz, t);
        for (int k = 0; k < N_VALUES; k++) {
            const double *a = t + 3 * k;
            if (drawn->item[k].order != 1)
                continue;
            CHECK_NEAR(a[0] * a[0] + a[1] * a[1] + a[2] * a[2], 1, 1e-13);
            if (++n % 2 == 0)
                CHECK_NEAR(a[0] * a[-3] + a[1] * a[-2] + a[2] * a[-1], 0, 1e-13);
        }
        CHECK_INT(n, 6);
    }
    curvopt_mesh_destroy(fine);
    free(xyz);
    setting_free(&s);
}

/* The Hessian's pattern is that of no energy but of the couplings: the assembly has coarse patches that know nothing of
 * the point that is held. Of a quadratic function central differences are exact but for rounding. */
static void check_differences(int curved) {
    setting s;
    setting_with(&s, curved);
    const int n = s.dofs.n_variables;
    double g[96] = {0}, matrix[96][96] = {{0}}, largest = 0;
    curvopt_options o;
    curvopt_error error;
    co_basis_table_cache tables;
    co_assembly assembly;
    co_couplings couplings = {0};
    co_sparse_hessian hessian;
    curvopt_options_init(&o, sizeof o);
    o.surface = CURVOPT_SURFACE_LIMIT;
    co_basis_table_cache_create(o.surface, &tables);
    CHECK_OK(co_assembly_create(s.mesh, NULL, NULL, &o, &tables, NULL, &assembly, &error), &error);
    for (int twice = 0; twice < 2; twice++) /* couplings are added to others */
        CHECK_OK(co_surface_springs_couple(&s.springs, &couplings, &error), &error);
    CHECK_INT(couplings.n, 2 * (curved ? N_SPRINGS : N_SPRINGS - 2));
    CHECK_OK(co_sparse_hessian_create(&assembly, &s.dofs, &couplings, &hessian, &error), &error);
    move(&s, 9);
    co_surface_springs_add_hessian(&s.springs, s.z, 1, 0.5, &hessian);
    for (int j = 0; j < n; j++)
        for (int32_t e = hessian.pattern.column_start[j]; e < hessian.pattern.column_start[j + 1]; e++)
            matrix[hessian.pattern.row[e]][j] = matrix[j][hessian.pattern.row[e]] = hessian.value[e];
    for (int i = 0; i < n; i++)
        largest = fmax(largest, matrix[i][i]);
    co_surface_springs_value(&s.springs, s.z, 0.5, g);
    for (int i = 0; i < n; i++) {
        double up[96] = {0}, down[96] = {0}, value[2];
        const double at = s.z[i], h = curved ? 1e-5 : 0.5, most = curved ? 1e-6 * largest : 1e-10;
        s.z[i] = at + h;
        value[0] = co_surface_springs_value(&s.springs, s.z, 0.5, up);
        s.z[i] = at - h;
        value[1] = co_surface_springs_value(&s.springs, s.z, 0.5, down);
        s.z[i] = at;
        CHECK_NEAR(g[i], 0.5 * (value[0] - value[1]) / (2 * h), most);
        for (int j = 0; j < n; j++)
            CHECK_NEAR(matrix[j][i], (up[j] - down[j]) / (2 * h), most);
    }
    co_couplings_free(&couplings);
    co_sparse_hessian_free(&hessian);
    co_assembly_free(&assembly);
    co_basis_table_cache_free(&tables);
    setting_free(&s);
}

static void test_gradient_and_hessian_are_its_differences(void **state) {
    (void)state;
    check_differences(1);
    check_differences(0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_value_is_its_definition),
        cmocka_unit_test(test_tangents_are_unit_vectors),
        cmocka_unit_test(test_gradient_and_hessian_are_its_differences),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
