/* Pivots in orbits: positions of symmetric cages are symmetric; whatever the variables, entries are held; which part of
 * a group can be kept. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "constraints/dof_map.h"
#include "constraints/given_through.h"
#include "constraints/interpolation.h"
#include "constraints/kept_symmetry.h"
#include "constraints/pivots.h"
#include "constraints/value_images.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { RINGS = 12, SIDES = 6, N = 3 * RINGS * SIDES };
static const double pi = 3.14159265358979323846;

typedef struct setting {
    cage c;
    curvopt_mesh *mesh;
    co_constraints given, held; /* held: with pivots by the symmetry */
    co_symmetry symmetry;
    co_interpolation map;
    co_dof_map dofs;
} setting;

/* A torus of so many rings with these entries, whose places are where they are; `order`: of the symmetries that the
 * entries have. */
static setting begin(int32_t rings, curvopt_through *through, int32_t order, int32_t kept) {
    setting s = {.c = cage_torus(rings, SIDES, 1, 0.4)};
    curvopt_error error;
    curvopt_options o;
    double positions[N];
    s.mesh = cage_mesh(&s.c);
    curvopt_options_init(&o, sizeof o);
    through->struct_size = sizeof *through;
    o.through = through;
    CHECK_OK(co_given_through_create(s.mesh, s.c.xyz, &o, &s.given, &error), &error);
    CHECK_OK(co_symmetry_create(s.mesh, s.c.xyz, &s.given, 1, NULL, &s.symmetry, &error), &error);
    CHECK_INT(s.symmetry.order, order);
    CHECK_OK(co_value_images_adapt(s.mesh, &s.symmetry, &s.given.values, &error), &error);
    CHECK_OK(co_kept_symmetry_restrict(s.mesh, &s.given, o.boundary, &s.symmetry, &error), &error);
    CHECK_INT(s.symmetry.order, kept);
    CHECK_OK(co_constraints_copy(s.mesh, &s.given, &s.held, &error), &error);
    CHECK_OK(co_pivots_choose(s.mesh, &s.symmetry, &s.held, &error), &error);
    CHECK_OK(co_interpolation_create(s.mesh, &s.held, &s.map, &error), &error);
    memcpy(positions, s.c.xyz, 3 * sizeof *positions * (size_t)s.c.n_vertices);
    co_interpolation_from_cage(&s.map, positions);
    CHECK_OK(co_dof_map_create(s.mesh, &s.symmetry, &s.held, positions, &s.dofs, &error), &error);
    return s;
}

static void end(setting *s) {
    co_dof_map_free(&s->dofs);
    co_interpolation_free(&s->map);
    co_symmetry_free(&s->symmetry);
    co_constraints_free(&s->held);
    co_constraints_free(&s->given);
    curvopt_mesh_destroy(s->mesh);
    cage_free(&s->c);
}

/* Distance of x from being symmetric. */
static double asymmetry(const setting *s, const double *x) {
    double most = 0;
    for (int32_t g = 0; g < s->symmetry.order; g++)
        for (int32_t v = 0; v < s->c.n_vertices; v++) {
            const double *q = s->symmetry.matrix + 9 * g, *from = x + 3 * v,
                         *to = x + 3 * co_symmetry_vertex(&s->symmetry, s->mesh, g, v);
            for (int k = 0; k < 3; k++)
                most = fmax(most, fabs(q[3 * k] * from[0] + q[3 * k + 1] * from[1] + q[3 * k + 2] * from[2] - to[k]));
        }
    return most;
}

static void check_positions(const setting *s) {
    double x[N] = {0};
    uint64_t seed = 7;
    for (int32_t v = 0; v < s->c.n_vertices; v++) {
        const double d[3] = {check_random(&seed), check_random(&seed), check_random(&seed)};
        for (int32_t g = 0; g < s->symmetry.order; g++)
            for (int k = 0; k < 9; k++)
                x[3 * co_symmetry_vertex(&s->symmetry, s->mesh, g, v) + k / 3] +=
                    s->symmetry.matrix[9 * g + k] * d[k % 3];
    }
    CHECK_NEAR(asymmetry(s, x), 0, 1e-12);
    co_interpolation_from_cage(&s->map, x);
    CHECK_NEAR(asymmetry(s, x), 0, 1e-11);
}

/* Entries hold so many numbers of symmetric cages. */
static void check_count(const setting *s, int32_t n_held) {
    const co_constraints none = {0};
    curvopt_error error;
    co_dof_map all;
    CHECK_OK(co_dof_map_create(s->mesh, &s->symmetry, &none, s->c.xyz, &all, &error), &error);
    CHECK_INT(s->dofs.n_variables, all.n_variables - n_held);
    co_dof_map_free(&all);
}

/* Far from the cage that variables were made of. */
static void check_variables(setting *s) {
    double z[N], x[N], *found;
    uint64_t seed = 5;
    curvopt_error error;
    co_surface_values *values = &s->given.values;
    co_dof_map_variables(&s->dofs, s->c.xyz, z);
    for (int32_t k = 0; k < s->dofs.n_variables; k++)
        z[k] += 0.3 * check_random(&seed);
    co_dof_map_expand(&s->dofs, z, x);
    CHECK_NEAR(asymmetry(s, x), 0, 1e-12);
    co_interpolation_to_cage(&s->map, x);
    CHECK_NEAR(asymmetry(s, x), 0, 1e-11);
    found = calloc(3 * (size_t)values->n, sizeof *found);
    CHECK_TRUE(found != NULL);
    CHECK_OK(co_surface_values_make_rows(s->mesh, values, &error), &error);
    co_sparse_rows_apply(&values->rows, x, found);
    for (int32_t i = 0; i < values->n; i++) {
        const co_surface_value *f = &values->item[i];
        double off[3], projector[9];
        co_freedom_projector(f->freedom, f->direction, projector);
        for (int k = 0; k < 3; k++)
            off[k] = found[3 * i + k] - f->anchor[k];
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(off[k],
                       projector[3 * k] * off[0] + projector[3 * k + 1] * off[1] + projector[3 * k + 2] * off[2],
                       1e-11);
    }
    free(found);
}

/* At four vertices of the outer ring, each of which is on two mirror planes: of tangents and points nothing is left but
 * how far out. */
static void test_frames_on_mirror_planes(void **state) {
    (void)state;
    int32_t vertices[4];
    double normals[12] = {0};
    for (int k = 0; k < 4; k++) {
        vertices[k] = 3 * k * SIDES;
        normals[3 * k] = cos(pi / 2 * k);
        normals[3 * k + 1] = sin(pi / 2 * k);
    }
    setting s = begin(RINGS, &(curvopt_through){.n = 4, .vertices = vertices, .normals = normals}, 16, 16);
    CHECK_INT(s.given.values.n, 12);
    CHECK_INT(s.held.values.n, 4); /* points by their own vertices */
    for (int k = 0; k < 4; k++)
        CHECK_INT(s.held.values.item[k].pivot, s.held.values.item[k].vertex);
    check_count(&s, 1);
    check_positions(&s);
    check_variables(&s);
    end(&s);
}

/* Of the turns round the axis alone frames have nothing; all of them need pivots. */
static void test_tilted_frames(void **state) {
    (void)state;
    int32_t vertices[4];
    double normals[12] = {0};
    for (int k = 0; k < 4; k++) {
        const double out[3] = {cos(pi / 2 * k), sin(pi / 2 * k), 0}, along[3] = {-out[1], out[0], 0};
        vertices[k] = 3 * k * SIDES + 1;
        for (int c = 0; c < 3; c++)
            normals[3 * k + c] = out[c] + 0.2 * along[c] + (c == 2);
    }
    setting s = begin(RINGS, &(curvopt_through){.n = 4, .vertices = vertices, .normals = normals}, 4, 4);
    CHECK_INT(s.held.values.n, 12);
    check_count(&s, 5);
    check_positions(&s);
    end(&s);
}

/* A point on a mirror plane, inside a face, is the mean of two vertices beside it. */
static void test_means_of_vertices(void **state) {
    (void)state;
    enum { ODD = 9 };
    int32_t faces[ODD], vertices[ODD];
    double uv[2 * ODD];
    for (int k = 0; k < ODD; k++) {
        faces[k] = 3 * k * SIDES + 1;
        vertices[k] = -1;
        uv[2 * k] = uv[2 * k + 1] = 0.5;
    }
    curvopt_through through = {.n = 4, .vertices = vertices, .faces = faces, .uv = uv};
    setting s = begin(RINGS, &through, 8, 8);
    CHECK_INT(s.held.values.n, 8); /* each by two vertices */
    check_count(&s, 2);            /* where on the mirror plane */
    check_positions(&s);
    check_variables(&s);
    end(&s);
    /* in all faces round the axis; vertices are on mirror planes of their own, and turns are what is left */
    for (int k = 0; k < ODD; k++)
        faces[k] = k * SIDES + 1;
    through.n = ODD;
    s = begin(ODD, &through, 18, 9);
    CHECK_INT(s.held.values.n, ODD);
    check_count(&s, 3);
    check_positions(&s);
    check_variables(&s);
    end(&s);
}

/* Along a line and in a plane, which are on mirror planes or across them. */
static void test_lines_and_planes(void **state) {
    (void)state;
    int32_t vertices[RINGS], freedom[RINGS];
    double directions[3 * RINGS] = {0};
    for (int k = 0; k < RINGS; k++) {
        const double out[2] = {cos(2 * pi * k / RINGS), sin(2 * pi * k / RINGS)};
        vertices[k] = k * SIDES;
        freedom[k] = k % 2 ? CO_FREEDOM_LINE : CO_FREEDOM_PLANE;
        directions[3 * k] = k % 2 ? -out[1] : out[0];
        directions[3 * k + 1] = k % 2 ? out[0] : out[1];
    }
    setting s =
        begin(RINGS, &(curvopt_through){.n = RINGS, .vertices = vertices, .freedom = freedom, .directions = directions},
              24, 24);
    check_count(&s, 2); /* how far out both kinds are */
    check_positions(&s);
    check_variables(&s);
    end(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_frames_on_mirror_planes),
        cmocka_unit_test(test_tilted_frames),
        cmocka_unit_test(test_means_of_vertices),
        cmocka_unit_test(test_lines_and_planes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
