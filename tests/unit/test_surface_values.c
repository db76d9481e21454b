/* Points, tangents and second derivatives of the surface as rows over the cage: against the sampler, which evaluates
 * patches, and through subdivision; pivots; curvatures; what is refused. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "base/vec3.h"
#include "constraints/given_constraints.h"
#include "constraints/given_through.h"
#include "constraints/held_curvatures.h"
#include "constraints/interpolation.h"
#include "constraints/pivots.h"
#include "mesh/subdivide.h"
#include "surface/vertex_mask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { N_KINDS = 6, N_AT = 5 }; /* point, two tangents and three second derivatives, of so many places */

/* All of these of each place: one vertex, then places on faces. Where a vertex has no second derivatives, points are in
 * their place. */
static co_surface_values all_of(const curvopt_mesh *m, int32_t vertex, const int32_t face[N_AT],
                                const int32_t corner[N_AT], const double uv[N_AT][2]) {
    co_surface_values out = {.n = N_KINDS * N_AT, .item = calloc(N_KINDS * N_AT, sizeof *out.item)};
    CHECK_TRUE(out.item != NULL);
    for (int32_t k = 0; k < out.n; k++) {
        const int32_t i = k / N_KINDS, kind = k % N_KINDS;
        const int order = kind < 3 ? kind > 0 : i || co_vertex_mask_has_second(m, vertex) ? 2 : 0;
        co_surface_value *f = &out.item[k];
        *f = (co_surface_value){.number = i, .vertex = i ? -1 : vertex, .order = order, .pivot = -1};
        if (order)
            f->along[order == 1 ? kind - 1 : kind - 3] = 1;
        f->corner = i ? m->face_start[face[i]] + corner[i] : m->vertex_corner[vertex];
        memcpy(f->uv, uv[i], sizeof f->uv);
    }
    return out;
}

static double *values_of(const curvopt_mesh *m, co_surface_values *values, const double *xyz) {
    curvopt_error error;
    double *out = calloc(3 * (size_t)values->n, sizeof *out);
    CHECK_TRUE(out != NULL);
    CHECK_OK(co_surface_values_make_rows(m, values, &error), &error);
    co_sparse_rows_apply(&values->rows, xyz, out);
    return out;
}

/* Inside faces they are the jets of the sampler; on the subdivided cage they are where their anchors have gone: points
 * are the same, and derivatives so much shorter. */
static void check_values(cage c, int32_t vertex, const int32_t face[N_AT], const int32_t corner[N_AT]) {
    static const double uv[N_AT][2] = {{0, 0}, {0.3, 0.4}, {0.7, 0.1}, {0.9, 0.625}, {0.125, 0.75}};
    curvopt_mesh *mesh = cage_mesh(&c), *fine;
    co_sparse_rows rows;
    curvopt_error error;
    curvopt_options o;
    curvopt_sampler *sampler;
    double jets[30 * (N_AT - 1)];
    co_surface_values values = all_of(mesh, vertex, face, corner, uv);
    double *found = values_of(mesh, &values, c.xyz);
    curvopt_options_init(&o, sizeof o);
    CHECK_OK(curvopt_sampler_create(mesh, c.xyz, &o, &sampler, &error), &error);
    CHECK_OK(curvopt_sampler_jets(sampler, N_AT - 1, face + 1, corner + 1, uv[1], jets, &error), &error);
    for (int i = 1; i < N_AT; i++)
        for (int k = 0; k < 3 * N_KINDS; k++)
            CHECK_NEAR(found[3 * N_KINDS * i + k], jets[30 * (i - 1) + k], 1e-13);
    CHECK_OK(co_subdivide(mesh, &fine, &rows, &error), &error);
    double *xyz = calloc(3 * (size_t)rows.n_rows, sizeof *xyz);
    CHECK_TRUE(xyz != NULL);
    co_sparse_rows_apply(&rows, c.xyz, xyz);
    for (int k = 0; k < values.n; k++)
        memcpy(values.item[k].anchor, found + 3 * k, sizeof values.item[k].anchor);
    co_surface_values_subdivide(mesh, &values);
    double *finer = values_of(fine, &values, xyz);
    for (int k = 0; k < values.n; k++)
        for (int j = 0; j < 3; j++)
            CHECK_NEAR(finer[3 * k + j], values.item[k].anchor[j], 1e-12);
    free(found);
    free(finer);
    free(xyz);
    co_surface_values_free(&values);
    co_sparse_rows_free(&rows);
    curvopt_sampler_destroy(sampler);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_values_are_those_of_the_surface(void **state) {
    (void)state;
    const int32_t faces[N_AT] = {0, 0, 3, 5, 2}, quads[N_AT] = {0}, corners[N_AT] = {0, 2, 1, 0, 0};
    const int32_t ends[N_AT] = {0, 0, 1, 3, 2};
    check_values(cage_shaken(cage_torus(6, 4, 1, 0.4), 0.05), 7, faces, quads);
    check_values(cage_shaken(cage_cube(), 0.2), 3, faces, quads);    /* valence 3 on every corner */
    check_values(cage_shaken(cage_prism(7), 0.1), 4, ends, corners); /* faces of many corners */
    check_values(cage_refined(cage_shaken(cage_cube(), 0.1), 2), 1, faces, quads);
}

/* At a vertex of four triangles they are those of the quarter at a corner, whose parameters run half as far. */
static void test_second_derivatives_at_vertices_with_faces_of_any_size(void **state) {
    (void)state;
    static const int32_t sizes[8] = {3, 3, 3, 3, 3, 3, 3, 3};
    static const int32_t corners[24] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    static const double xyz[18] = {1, 0.1, 0, -1, 0, 0.2, 0, 1.1, 0, 0.1, -1, 0, 0, 0.2, 1.3, 0.1, 0, -0.9};
    cage c = cage_of(6, 8, sizes, corners, xyz);
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_error error;
    curvopt_options o;
    curvopt_sampler *sampler;
    curvopt_options_init(&o, sizeof o);
    CHECK_OK(curvopt_sampler_create(mesh, c.xyz, &o, &sampler, &error), &error);
    for (int32_t face = 0; face < 8; face++)
        for (int32_t corner = 0; corner < 3; corner++) {
            static const double uv[2] = {0, 0}, half[N_KINDS] = {1, 2, 2, 4, 4, 4};
            const int32_t at[N_AT] = {face}, none[N_AT] = {0};
            static const double inside[N_AT][2] = {{0, 0}, {0.5, 0.5}, {0.5, 0.5}, {0.5, 0.5}, {0.5, 0.5}};
            double jet[30];
            CHECK_TRUE(co_vertex_mask_has_second(mesh, corners[3 * face + corner]));
            co_surface_values values = all_of(mesh, corners[3 * face + corner], at, none, inside);
            for (int k = 0; k < N_KINDS; k++)
                values.item[k].corner = 3 * face + corner;
            double *found = values_of(mesh, &values, c.xyz);
            CHECK_OK(curvopt_sampler_jets(sampler, 1, &face, &corner, uv, jet, &error), &error);
            for (int k = 0; k < 3 * N_KINDS; k++)
                CHECK_NEAR(found[k], half[k / 3] * jet[k], 1e-13);
            free(found);
            co_surface_values_free(&values);
        }
    curvopt_sampler_destroy(sampler);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Values of a place have the same rows wherever they are in the list. */
static void test_a_place_may_come_again(void **state) {
    (void)state;
    cage c = cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05);
    curvopt_mesh *mesh = cage_mesh(&c);
    co_surface_value item[5] = {{.vertex = -1, .corner = 40, .uv = {0.25, 0.5}, .order = 1, .along = {1}},
                                {.vertex = -1, .corner = 40, .uv = {0.25, 0.5}, .order = 2, .along = {1}},
                                {.vertex = 3, .corner = mesh->vertex_corner[3], .order = 1, .along = {1}},
                                {.vertex = -1, .corner = 40, .uv = {0.25, 0.5}, .order = 1, .along = {1}},
                                {.vertex = -1, .corner = 40, .uv = {0.5, 0.5}, .order = 1, .along = {1}}};
    co_surface_values values = {.n = 5, .item = item};
    double *found = values_of(mesh, &values, c.xyz);
    for (int k = 0; k < 3; k++) {
        CHECK_NEAR(found[9 + k], found[k], 0);
        CHECK_TRUE(found[k] != found[3 + k] && found[k] != found[6 + k] && found[k] != found[12 + k]);
    }
    free(found);
    co_sparse_rows_free(&values.rows);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* ---------------------------------------------------------------------------------------------- curvatures -- */

/* The second form of a cage moved by its two placements, by the sampler, is the tensor's. */
static void test_curvatures_are_held_by_fixed_tangents(void **state) {
    (void)state;
    cage c = cage_shaken(cage_torus(8, 6, 1, 0.4), 0.02);
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_error error;
    const double k[2] = {0.75, 2.5}, uv[2] = {0.25, 0.5};
    const int32_t face = 7, corner = 0;
    double jet[30], normal[3], direction[3], xyz[3 * 48];
    curvopt_options o;
    curvopt_sampler *sampler;
    curvopt_options_init(&o, sizeof o);
    CHECK_OK(curvopt_sampler_create(mesh, c.xyz, &o, &sampler, &error), &error);
    CHECK_OK(curvopt_sampler_jets(sampler, 1, &face, &corner, uv, jet, &error), &error);
    curvopt_sampler_destroy(sampler);
    co_cross3(jet + 3, jet + 6, normal);
    normal[0] += 0.1 * co_length3(normal);
    co_cross3(normal, jet + 3, direction);
    const curvopt_through through = {.struct_size = sizeof through,
                                     .n = 1,
                                     .faces = &face,
                                     .uv = uv,
                                     .normals = normal,
                                     .curvatures = k,
                                     .curvature_directions = direction};
    o.through = &through;
    co_constraints given = {0};
    memcpy(xyz, c.xyz, sizeof xyz);
    CHECK_OK(co_given_through_create(mesh, c.xyz, &o, &given, &error), &error);
    CHECK_INT(given.values.n, N_KINDS);
    CHECK_TRUE(co_held_curvatures_exist(&given.values));
    CHECK_OK(co_given_constraints_place(mesh, &given, CURVOPT_BOUNDARY_POSITION, xyz, &error), &error);
    CHECK_OK(co_held_curvatures_fix(mesh, xyz, &given.values, &error), &error);
    CHECK_OK(co_given_constraints_place(mesh, &given, CURVOPT_BOUNDARY_POSITION, xyz, &error), &error);
    for (int i = 0; i < N_KINDS; i++)
        CHECK_INT(given.values.item[i].is_fixed, i > 0);
    curvopt_options_init(&o, sizeof o);
    CHECK_OK(curvopt_sampler_create(mesh, xyz, &o, &sampler, &error), &error);
    CHECK_OK(curvopt_sampler_jets(sampler, 1, &face, &corner, uv, jet, &error), &error);
    const double n_length = co_length3(normal), d_length = co_length3(direction);
    for (int a = 0; a < 2; a++) {
        CHECK_NEAR(co_dot3(jet + 3 + 3 * a, normal), 0, 1e-12);
        for (int b = a; b < 2; b++) {
            const double *s = jet + 3 + 3 * a, *t = jet + 3 + 3 * b;
            const double p = co_dot3(s, direction) / d_length, q = co_dot3(t, direction) / d_length;
            const double form = k[1] * co_dot3(s, t) + (k[0] - k[1]) * p * q;
            CHECK_NEAR(-co_dot3(jet + 9 + 3 * (a + b), normal) / n_length, form, 1e-12);
        }
    }
    co_constraints_free(&given);
    curvopt_sampler_destroy(sampler);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* ------------------------------------------------------------------------------------------------ pivots -- */

/* A frame at a vertex, one inside a face, and a limit point and a vertex that are held near: the map there and back, no
 * pivot twice, and none that is held. */
static void test_pivots_make_a_map_that_can_be_inverted(void **state) {
    (void)state;
    cage c = cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05);
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_error error;
    const double nan = (double)NAN, normals[6] = {0, 0.3, 1, 1, 0, 0.2}, uv[4] = {nan, nan, 0.25, 0.5};
    const int32_t vertices[2] = {8, -1}, faces[2] = {0, 20}, pinned[2] = {9, 7};
    const int32_t freedom[2] = {CURVOPT_FREEDOM_OF_LIMIT_POINT, 0};
    const curvopt_constraints pins = {.vertices = pinned, .freedom = freedom, .n = 2};
    const curvopt_through through = {
        .struct_size = sizeof through, .n = 2, .vertices = vertices, .faces = faces, .uv = uv, .normals = normals};
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    o.through = &through;
    co_constraints given = {0};
    co_interpolation map;
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, &pins, &given, &error), &error);
    CHECK_OK(co_given_through_create(mesh, c.xyz, &o, &given, &error), &error);
    CHECK_INT(given.values.n, 6);
    CHECK_OK(co_pivots_choose(mesh, NULL, &given, &error), &error);
    for (int i = 0; i < 6; i++) {
        const co_surface_value *f = &given.values.item[i];
        CHECK_TRUE(f->pivot >= 0 && f->pivot != 9 && f->pivot != 7);
        CHECK_INT(given.of_limit[f->pivot], f->order ? CO_OF_TANGENT : CO_OF_POINT);
        for (int j = 0; j < i; j++)
            CHECK_TRUE(given.values.item[j].pivot != f->pivot);
    }
    CHECK_OK(co_interpolation_create(mesh, &given, &map, &error), &error);
    CHECK_INT(map.limit.n_rows, 7);
    double xyz[3 * 48], gradient[3 * 48], sum = 0, sum_y = 0, step[3 * 48], moved[3 * 48];
    uint64_t seed = 3;
    memcpy(xyz, c.xyz, sizeof xyz);
    co_interpolation_from_cage(&map, xyz);
    co_interpolation_to_cage(&map, xyz);
    for (int i = 0; i < 3 * 48; i++) {
        CHECK_NEAR(xyz[i], c.xyz[i], 1e-13);
        gradient[i] = check_random(&seed);
        step[i] = moved[i] = check_random(&seed);
    }
    co_interpolation_to_cage(&map, moved); /* g . S d = S^T g . d */
    for (int i = 0; i < 3 * 48; i++)
        sum += gradient[i] * moved[i];
    co_interpolation_gradient(&map, gradient);
    for (int i = 0; i < 3 * 48; i++)
        sum_y += gradient[i] * step[i];
    CHECK_NEAR(sum, sum_y, 1e-12);
    co_interpolation_free(&map);
    co_constraints_free(&given);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_structs_of_other_versions_are_refused(void **state) {
    (void)state;
    cage c = cage_torus(8, 6, 1, 0.4);
    curvopt_mesh *mesh = cage_mesh(&c);
    const int32_t vertex = 3,
                  sizes[4] = {0, 8, (int32_t)sizeof(curvopt_through) + 8, (int32_t)sizeof(curvopt_through) - 4};
    curvopt_error error;
    curvopt_options o;
    curvopt_result *result = NULL;
    curvopt_options_init(&o, sizeof o);
    o.levels = 1;
    for (int k = 0; k < 4; k++) {
        const curvopt_through through = {.struct_size = sizes[k], .n = 1, .vertices = &vertex};
        o.through = &through;
        CHECK_INT(curvopt_minimize(mesh, c.xyz, &o, NULL, NULL, NULL, &result, &error), CURVOPT_ERROR_ARGUMENT);
        CHECK_TRUE(!result && strstr(error.message, "struct_size"));
    }
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values_are_those_of_the_surface),
        cmocka_unit_test(test_second_derivatives_at_vertices_with_faces_of_any_size),
        cmocka_unit_test(test_a_place_may_come_again),
        cmocka_unit_test(test_curvatures_are_held_by_fixed_tangents),
        cmocka_unit_test(test_pivots_make_a_map_that_can_be_inverted),
        cmocka_unit_test(test_structs_of_other_versions_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
