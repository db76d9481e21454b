/* Turning of boundaries and creases against the Gauss-Bonnet theorem: in the plane K = 0, and what the boundary turns
 * by must be 2 pi chi alone, whatever the fans there. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "base/constants.h"
#include "mesh/crease.h"
#include "mesh/fan.h"
#include "surface/boundary_turning.h"

enum { SIDE = 5, MOST_SECTORS = 8, MOST = 1 + (MOST_SECTORS + 1) * SIDE * (SIDE + 1) };

/* A flat cage: `sectors` grids of SIDE x SIDE quads round vertex 0, all round it if it is closed, else over half a
 * turn. Sector s owns its points with x > 0, of which there are SIDE (SIDE + 1). */
typedef struct flat {
    int32_t sectors, n_vertices;
    int closed;
    double xyz[3 * MOST];
    curvopt_mesh *mesh;
} flat;

static int32_t index_of(const flat *f, int32_t s, int x, int y) {
    if (x == 0 && y == 0)
        return 0;
    if (x == 0)
        return index_of(f, s + 1, y, 0);
    return 1 + (f->closed ? s % f->sectors : s) * SIDE * (SIDE + 1) + y * SIDE + x - 1;
}

/* Bent within the plane, so that boundaries are no straight lines. */
static void place(const flat *f, int32_t s, int x, int y, double *out) {
    double turn = (f->closed ? 2 : 1) * CO_PI / f->sectors, a = s * turn, b = (s + 1) * turn;
    double u = x * cos(a) + y * cos(b), v = x * sin(a) + y * sin(b);
    out[0] = u + 0.05 * v * v;
    out[1] = v + 0.04 * u * u;
    out[2] = 0;
}

static void flat_create(flat *f, int32_t sectors, int closed, const curvopt_creases *creases) {
    static int32_t sizes[MOST_SECTORS * SIDE * SIDE], vertices[4 * MOST_SECTORS * SIDE * SIDE];
    int32_t n = 0;
    curvopt_error error;
    *f = (flat){
        .sectors = sectors, .closed = closed, .n_vertices = 1 + sectors * SIDE * (SIDE + 1) + (closed ? 0 : SIDE)};
    for (int32_t s = 0; s < sectors; s++)
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++, n++) {
                sizes[n] = 4;
                vertices[4 * n] = index_of(f, s, x, y);
                vertices[4 * n + 1] = index_of(f, s, x + 1, y);
                vertices[4 * n + 2] = index_of(f, s, x + 1, y + 1);
                vertices[4 * n + 3] = index_of(f, s, x, y + 1);
            }
    for (int32_t s = 0; s < sectors; s++)
        for (int y = 0; y <= SIDE; y++)
            for (int x = 0; x <= SIDE; x++)
                place(f, s, x, y, f->xyz + 3 * (size_t)index_of(f, s, x, y));
    CHECK_OK(curvopt_mesh_create_creased(f->n_vertices, n, sizes, vertices, creases, &f->mesh, &error), &error);
}

/* Checks the theorem; whether any patch is of this type of fan. */
static int check_turning(flat *f, double target, co_fan_type type) {
    co_patches patches;
    co_boundary_turning turning;
    curvopt_error error;
    int found = 0;
    CHECK_OK(co_patches_create(f->mesh, NULL, NULL, CURVOPT_SURFACE_LIMIT, 1, NULL, &patches, &error), &error);
    CHECK_OK(co_boundary_turning_create(f->mesh, &patches, CURVOPT_SURFACE_LIMIT, &turning, &error), &error);
    double *points = calloc(3 * (size_t)patches.n_points, sizeof *points);
    double *weight = calloc((size_t)patches.n_patches, sizeof *weight);
    CHECK_TRUE(points && weight);
    memcpy(points, f->xyz, 3 * (size_t)f->n_vertices * sizeof *points);
    co_patches_derive(&patches, points);
    CHECK_NEAR(turning.target, target, 1e-14);
    CHECK_NEAR(co_boundary_turning_total(&turning, &patches, NULL, points), target, 1e-9);
    CHECK_NEAR(co_boundary_turning_total(&turning, &patches, weight, points), 0, 0);
    for (int32_t p = 0; p < patches.n_patches; p++) {
        weight[p] = 2;
        found |= patches.kind[p] != CO_FAN_REGULAR && co_fan_type_of(patches.kind[p]) == type;
    }
    CHECK_NEAR(co_boundary_turning_total(&turning, &patches, weight, points), 2 * target, 2e-9);
    free(points);
    free(weight);
    co_boundary_turning_free(&turning);
    co_patches_free(&patches);
    co_mesh_destroy(f->mesh);
    return found;
}

static void test_boundaries(void **state) {
    static flat f;
    const curvopt_creases corners = {.boundary_rule = CURVOPT_BOUNDARY_RULE_CORNERS};
    (void)state;
    for (int32_t sectors = 2; sectors <= 3; sectors++) {
        flat_create(&f, sectors, 0, &corners);
        CHECK_INT(check_turning(&f, 2 * CO_PI, CO_FAN_CREASE), sectors != 2);
    }
    flat_create(&f, 5, 1, &corners);
    CHECK_TRUE(check_turning(&f, 2 * CO_PI, CO_FAN_CLOSED));
}

/* A crease from the boundary to vertex 0, where it ends: a dart, round which the cut turns by 2 pi. */
static void test_dart(void **state) {
    static flat f;
    int32_t edges[2 * SIDE];
    double sharpness[SIDE];
    curvopt_creases creases = {.crease_vertices = edges,
                               .crease_sharpness = sharpness,
                               .n_creases = SIDE,
                               .boundary_rule = CURVOPT_BOUNDARY_RULE_CORNERS};
    (void)state;
    f = (flat){.sectors = 5, .closed = 1};
    for (int x = 0; x < SIDE; x++) {
        edges[2 * x] = index_of(&f, 0, x, 0);
        edges[2 * x + 1] = index_of(&f, 0, x + 1, 0);
        sharpness[x] = CURVOPT_SHARPNESS_INFINITE;
    }
    flat_create(&f, 5, 1, &creases);
    CHECK_TRUE(check_turning(&f, 3 * CO_PI, CO_FAN_DART));
}

/* A crease right through an extraordinary vertex: two surfaces of one boundary each. */
static void test_crease_through(void **state) {
    static flat f;
    int32_t edges[4 * SIDE];
    double sharpness[2 * SIDE];
    curvopt_creases creases = {.crease_vertices = edges,
                               .crease_sharpness = sharpness,
                               .n_creases = 2 * SIDE,
                               .boundary_rule = CURVOPT_BOUNDARY_RULE_CORNERS};
    (void)state;
    f = (flat){.sectors = 6, .closed = 1};
    for (int i = 0; i < 2 * SIDE; i++) {
        edges[2 * i] = index_of(&f, i < SIDE ? 0 : 3, i % SIDE, 0);
        edges[2 * i + 1] = index_of(&f, i < SIDE ? 0 : 3, i % SIDE + 1, 0);
        sharpness[i] = CURVOPT_SHARPNESS_INFINITE;
    }
    flat_create(&f, 6, 1, &creases);
    CHECK_TRUE(check_turning(&f, 4 * CO_PI, CO_FAN_CREASE));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_boundaries),
        cmocka_unit_test(test_dart),
        cmocka_unit_test(test_crease_through),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
