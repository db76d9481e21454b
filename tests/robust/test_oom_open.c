/* Memory that runs out at every single allocation in turn, on open and creased cages: what test_oom.c does, with the
 * allocations that only they make. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "failing_allocator.h"

#include <stdlib.h>

/* An open box with a dart from the bottom, a fading crease and a fading corner; or with the latter alone, which is less
 * work: what is held while minimizing is then the boundary. */
static int32_t make_mesh(const cage *c, int minimize, curvopt_mesh **mesh, curvopt_error *error) {
    const int32_t edge[4] = {c->vertices[0], c->vertices[1], c->vertices[1], c->vertices[2]};
    const double sharpness[2] = {10, 1.5};
    const curvopt_creases creases = {edge, sharpness, c->vertices, sharpness + 1, minimize ? 0 : 2, 1, 0, 0};
    return curvopt_mesh_create_creased(8, 5, c->sizes, c->vertices, &creases, mesh, error);
}

static int32_t run(const cage *c, int minimize, curvopt_error *error) {
    curvopt_options o;
    curvopt_mesh *mesh;
    curvopt_options_init(&o, sizeof o);
    o.levels = o.threads = 1;
    o.max_iterations = 1;
    o.tolerance = 0.5;
    o.joshi_sequin = !minimize; /* one rule is enough */
    int32_t status = make_mesh(c, minimize, &mesh, error);
    if (status == CURVOPT_OK && minimize) {
        curvopt_result *result;
        status = curvopt_minimize(mesh, c->xyz, &o, NULL, NULL, NULL, &result, error);
        curvopt_result_destroy(result);
    } else if (status == CURVOPT_OK) {
        curvopt_problem *problem;
        curvopt_energies e;
        status = curvopt_problem_create(mesh, NULL, &o, &problem, error);
        if (status == CURVOPT_OK)
            status = curvopt_problem_evaluate(problem, c->xyz, &e, sizeof e, NULL, error);
        curvopt_problem_destroy(problem);
    }
    curvopt_mesh_destroy(mesh);
    return status;
}

static int32_t run_evaluation(void *context, curvopt_error *error) {
    return run(context, 0, error);
}

static int32_t run_minimization(void *context, curvopt_error *error) {
    return run(context, 1, error);
}

/* A closed cage with a mirror plane, a face of it held softly, through a subdivision; or moved so that it has none. */
static int32_t run_softly(const cage *c, double shift, curvopt_error *error) {
    static const int32_t vertices[4] = {1, 3, 5, 7};
    static const double weights[4] = {0.5, 0.5, 0.5, 0.5};
    const curvopt_constraints pins = {.vertices = vertices, .n = 4, .weights = weights};
    curvopt_options o;
    curvopt_mesh *mesh;
    curvopt_result *result = NULL;
    double xyz[24];
    memcpy(xyz, c->xyz, sizeof xyz);
    xyz[0] += shift;
    curvopt_options_init(&o, sizeof o);
    o.threads = o.max_iterations = 1;
    o.levels = 2;
    o.tolerance = 0.5;
    o.constraints = &pins;
    o.symmetry = CURVOPT_SYMMETRY_PLANES;
    o.symmetry_planes = CURVOPT_PLANE_X + CURVOPT_PLANE_Y;
    int32_t status = curvopt_mesh_create(8, 6, c->sizes, c->vertices, &mesh, error);
    if (status == CURVOPT_OK)
        status = curvopt_minimize(mesh, xyz, &o, NULL, NULL, NULL, &result, error);
    curvopt_result_destroy(result);
    curvopt_mesh_destroy(mesh);
    return shift != 0 && status == CURVOPT_ERROR_GEOMETRY ? CURVOPT_OK : status;
}

static int32_t run_pulled(void *context, curvopt_error *error) {
    return run_softly(context, 0, error);
}

static int32_t run_asymmetric(void *context, curvopt_error *error) {
    return run_softly(context, 0.25, error);
}

/* A cube with one face three times, two corners in one place and a loose vertex: mesh, its subdivision, its exceptions;
 * then a cube with a hole and a loose vertex, evaluated. */
static int32_t run_flawed(void *context, curvopt_error *error) {
    const cage *c = context;
    const int32_t hole = 0;
    int32_t sizes[8], vertices[32], vertex[9], face[8];
    double plain[27] = {0}, xyz[27], fine_xyz[3 * 64];
    curvopt_options o;
    curvopt_mesh *mesh, *fine = NULL;
    curvopt_problem *problem = NULL;
    curvopt_energies e;
    memcpy(plain, c->xyz, 24 * sizeof *plain);
    memcpy(xyz, plain, sizeof xyz);
    memcpy(xyz, plain + 3, 3 * sizeof *xyz);
    memcpy(vertices, c->vertices, 24 * sizeof *vertices);
    for (int f = 0; f < 8; f++)
        sizes[f] = 4;
    for (int k = 0; k < 4; k++)
        vertices[24 + k] = vertices[31 - k] = c->vertices[k];
    curvopt_options_init(&o, sizeof o);
    o.threads = o.joshi_sequin = 1;
    o.holes = &hole;
    o.n_holes = 1;
    int32_t status = curvopt_mesh_create(9, 8, sizes, vertices, &mesh, error);
    if (status == CURVOPT_OK)
        status = curvopt_mesh_refine(mesh, xyz, &fine, fine_xyz, error);
    if (status == CURVOPT_OK)
        status = curvopt_mesh_find_exceptions(mesh, xyz, &o, vertex, face, error);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
    if (status != CURVOPT_OK || (status = curvopt_mesh_create(9, 6, sizes, vertices, &mesh, error)) != CURVOPT_OK)
        return status;
    status = curvopt_problem_create(mesh, plain, &o, &problem, error);
    if (status == CURVOPT_OK)
        status = curvopt_problem_evaluate(problem, plain, &e, sizeof e, NULL, error);
    curvopt_problem_destroy(problem);
    curvopt_mesh_destroy(mesh);
    return status;
}

/* One quad, held by its boundary. */
static int32_t run_moving_level(void *context, curvopt_error *error) {
    const cage *c = context;
    const int32_t size = 4;
    int32_t level = 0;
    curvopt_options o;
    curvopt_mesh *mesh;
    curvopt_options_init(&o, sizeof o);
    int32_t status = curvopt_mesh_create(8, 1, &size, c->vertices, &mesh, error);
    if (status != CURVOPT_OK)
        return status;
    status = curvopt_find_moving_level(mesh, c->xyz, &o, &level, error);
    if (status == CURVOPT_OK)
        CHECK_INT(level, 2);
    curvopt_mesh_destroy(mesh);
    return status;
}

static void fail_in_turn(failing_run *run_it) {
    cage c = cage_cube();
    fail_every_allocation(run_it, &c, 50);
    cage_free(&c);
}

static void test_evaluation_survives_every_failure(void **state) {
    (void)state;
    fail_in_turn(run_evaluation);
}

static void test_minimization_survives_every_failure(void **state) {
    (void)state;
    fail_in_turn(run_minimization);
}

static void test_soft_pins_and_planes_survive_every_failure(void **state) {
    (void)state;
    fail_in_turn(run_pulled);
    cage c = cage_cube();
    fail_every_allocation(run_asymmetric, &c, 5);
    cage_free(&c);
}

static void test_flawed_cages_survive_every_failure(void **state) {
    (void)state;
    fail_in_turn(run_flawed);
}

static void test_moving_level_survives_every_failure(void **state) {
    (void)state;
    cage c = cage_cube();
    fail_every_allocation(run_moving_level, &c, 20);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_evaluation_survives_every_failure),
        cmocka_unit_test(test_minimization_survives_every_failure),
        cmocka_unit_test(test_soft_pins_and_planes_survive_every_failure),
        cmocka_unit_test(test_flawed_cages_survive_every_failure),
        cmocka_unit_test(test_moving_level_survives_every_failure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
