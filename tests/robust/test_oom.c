/* Memory that runs out at every single allocation in turn. SPDX-License-Identifier: GPL-3.0-or-later
 *
 * The linker sends the library's allocations here (--wrap). Every run with one failing must end with ERROR_MEMORY, or
 * do without; free everything; and leave handles that still work. */
#include "cages.h"
#include "check.h"

#include "base/vec3.h"
#include "constraints/given_constraints.h"
#include "constraints/given_through.h"
#include "constraints/held_curvatures.h"
#include "constraints/interpolation.h"
#include "constraints/kept_symmetry.h"
#include "constraints/pivots.h"
#include "constraints/symmetry.h"
#include "constraints/value_images.h"
#include "failing_allocator.h"
#include "hessian/blend_disc_hessian.h"
#include "hessian/surface_springs.h"
#include "mesh/subdivide.h"
#include "surface/basis_table_cache.h"
#include "surface/boundary_turning.h"
#include "surface/substitution.h"

#include <stdlib.h>
#include <string.h>

typedef int32_t (*work)(const cage *c, const curvopt_mesh *mesh, curvopt_error *error);

static curvopt_options small_options(int32_t surface, int32_t term) {
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    o.surface = surface;
    o.weights[CURVOPT_TERM_WILLMORE] = 0;
    o.weights[term] = 1;
    o.levels = 2;
    o.max_iterations = 3;
    o.threads = 1;
    o.tolerance = 0.1;
    return o;
}

static int32_t create(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_mesh *out;
    (void)mesh;
    int32_t status = curvopt_mesh_create(c->n_vertices, c->n_faces, c->sizes, c->vertices, &out, error);
    CHECK_TRUE((out != NULL) == (status == CURVOPT_OK));
    curvopt_mesh_destroy(out);
    return status;
}

static int32_t refine(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    double xyz[3 * 100];
    curvopt_mesh *out;
    int32_t status = curvopt_mesh_refine(mesh, c->xyz, &out, xyz, error);
    CHECK_TRUE((out != NULL) == (status == CURVOPT_OK));
    curvopt_mesh_destroy(out);
    return status;
}

/* Evaluates a second time after a failure: the handle must have stayed whole. */
static int32_t evaluate_with(const cage *c, const curvopt_mesh *mesh, const curvopt_options *o, curvopt_error *error) {
    curvopt_problem *problem;
    curvopt_energies e;
    double gradient[3 * 32];
    int32_t status = curvopt_problem_create(mesh, NULL, o, &problem, error);
    CHECK_TRUE((problem != NULL) == (status == CURVOPT_OK));
    if (status == CURVOPT_OK) {
        status = curvopt_problem_evaluate(problem, c->xyz, &e, sizeof e, gradient, error);
        curvopt_error again;
        if (status != CURVOPT_OK)
            CHECK_OK(curvopt_problem_evaluate(problem, c->xyz, &e, sizeof e, gradient, &again), &again);
        CHECK_TRUE(e.objective > 1);
    }
    curvopt_problem_destroy(problem);
    return status;
}

static int32_t evaluate_limit(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_options o = small_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    o.tolerance = 3e-3; /* so that rules are refined once or twice */
    return evaluate_with(c, mesh, &o, error);
}

static int32_t evaluate_plane(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_options o = small_options(CURVOPT_SURFACE_PLANE, CURVOPT_TERM_MVS);
    o.tolerance = 0.5; /* evaluate_limit refines rules */
    return evaluate_with(c, mesh, &o, error);
}

static int32_t evaluate_polynomial(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_options o = small_options(CURVOPT_SURFACE_POLYNOMIAL, CURVOPT_TERM_MVS_CROSS);
    return evaluate_with(c, mesh, &o, error);
}

static int32_t minimize(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_options o = small_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    curvopt_result *result;
    int32_t status = curvopt_minimize(mesh, c->xyz, &o, NULL, NULL, NULL, &result, error);
    CHECK_TRUE((result != NULL) == (status == CURVOPT_OK));
    curvopt_result_destroy(result);
    return status;
}

/* Surfaces that repel each other. */
static int32_t minimize_apart(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_options o = small_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    curvopt_result *result;
    o.no_crossings = 1;
    o.levels = o.max_iterations = 1;
    int32_t status = curvopt_minimize(mesh, c->xyz, &o, NULL, NULL, NULL, &result, error);
    CHECK_TRUE((result != NULL) == (status == CURVOPT_OK));
    curvopt_result_destroy(result);
    return status;
}

/* A point with curvatures, whose tangents are chosen. */
static int32_t minimize_curved(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    static const double uv[2] = {0.25, 0.5}, curvatures[2] = {1, 1};
    double side[2][3], normal[3];
    const int32_t face = 0, *v = c->vertices;
    for (int k = 0; k < 3; k++) {
        side[0][k] = c->xyz[3 * v[2] + k] - c->xyz[3 * v[0] + k];
        side[1][k] = c->xyz[3 * v[3] + k] - c->xyz[3 * v[1] + k];
    }
    co_cross3(side[0], side[1], normal);
    const curvopt_through through = {.struct_size = (int32_t)sizeof through,
                                     .n = 1,
                                     .faces = &face,
                                     .uv = uv,
                                     .normals = normal,
                                     .curvatures = curvatures};
    curvopt_options o = small_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    curvopt_result *result;
    o.max_iterations = 1;
    o.levels = 1;
    o.through = &through;
    int32_t status = curvopt_minimize(mesh, c->xyz, &o, NULL, NULL, NULL, &result, error);
    CHECK_TRUE((result != NULL) == (status == CURVOPT_OK));
    curvopt_result_destroy(result);
    return status;
}

/* Pieces with constraints of their own: the first one a pin and an entry, the second one a hole. */
static int32_t minimize_pieces(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    const int32_t pins[2] = {0, 5}, entries[1] = {2}, hole = c->n_faces - 1;
    const curvopt_constraints held = {.n = 2, .vertices = pins};
    const curvopt_through through = {.struct_size = (int32_t)sizeof through, .n = 1, .vertices = entries};
    curvopt_options o = small_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    curvopt_result *result;
    o.max_iterations = 0;
    o.constraints = &held;
    o.through = &through;
    o.holes = &hole;
    o.n_holes = 1;
    int32_t status = curvopt_minimize(mesh, c->xyz, &o, NULL, NULL, NULL, &result, error);
    CHECK_TRUE((result != NULL) == (status == CURVOPT_OK));
    curvopt_result_destroy(result);
    return status;
}

/* Everything that a run can be asked for besides. */
static int32_t minimize_and_look_round(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_options o = small_options(CURVOPT_SURFACE_POLYNOMIAL, CURVOPT_TERM_MVS);
    curvopt_result *result;
    o.levels = 1;
    o.verify = o.escape = 1;
    o.scalar_rule[CURVOPT_SCALAR_VOLUME] = o.scalar_rule[CURVOPT_SCALAR_AREA] = CURVOPT_SCALAR_RULE_KEEP;
    o.tolerance = 0.5;
    int32_t status = curvopt_minimize(mesh, c->xyz, &o, NULL, NULL, NULL, &result, error);
    CHECK_TRUE((result != NULL) == (status == CURVOPT_OK));
    curvopt_result_destroy(result);
    return status;
}

/* What a solver is asked for in turn: a settled state, moved targets, a passing state, another energy, a settled state.
 */
static int32_t use_solver(curvopt_solver *solver, const curvopt_options *first, double places[6],
                          curvopt_error *error) {
    curvopt_options other = *first;
    other.weights[CURVOPT_TERM_MEAN] = 1;
    places[0] += 0.01;
    int32_t status = curvopt_solver_solve(solver, 1, NULL, NULL, NULL, error);
    if (status == CURVOPT_OK)
        status = curvopt_solver_set_places(solver, places, error);
    if (status == CURVOPT_OK)
        status = curvopt_solver_solve(solver, 0, NULL, NULL, NULL, error);
    if (status == CURVOPT_OK)
        status = curvopt_solver_set_options(solver, &other, error);
    if (status == CURVOPT_OK)
        status = curvopt_solver_set_positions(solver, NULL, error);
    return status == CURVOPT_OK ? curvopt_solver_solve(solver, 1, NULL, NULL, NULL, error) : status;
}

/* All of it a second time after a failure: the handle must have stayed whole. */
static int32_t stay(const cage *c, const curvopt_mesh *mesh, int32_t spacing, curvopt_error *error) {
    const int32_t vertices[2] = {0, 7};
    double places[6];
    const curvopt_constraints held = {.vertices = vertices, .n = 2, .has_places = 1, .places = places};
    curvopt_options o = small_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    curvopt_solver *solver;
    curvopt_error again;
    for (int i = 0; i < 6; i++)
        places[i] = c->xyz[3 * vertices[i / 3] + i % 3];
    o.constraints = &held;
    o.spacing = spacing;
    int32_t status = curvopt_solver_create(mesh, c->xyz, &o, &solver, error);
    CHECK_TRUE((solver != NULL) == (status == CURVOPT_OK));
    if (status == CURVOPT_OK) {
        status = use_solver(solver, &o, places, error);
        if (status != CURVOPT_OK)
            CHECK_OK(use_solver(solver, &o, places, &again), &again);
    }
    curvopt_solver_destroy(solver);
    return status;
}

static int32_t stay_even(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    return stay(c, mesh, CURVOPT_SPACING_EVEN, error);
}

static int32_t stay_free(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    return stay(c, mesh, CURVOPT_SPACING_FREE, error);
}

/* What held limit points add: their map, of vertices that touch, and patches of its rows. */
static int32_t limit_parts(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    const int32_t vertices[2] = {0, 1}, freedom[2] = {CURVOPT_FREEDOM_OF_LIMIT_POINT, CURVOPT_FREEDOM_OF_LIMIT_POINT};
    const curvopt_constraints wanted = {.vertices = vertices, .freedom = freedom, .n = 2};
    co_constraints held = {0};
    co_interpolation map = {0};
    co_patches patches = {0};
    int32_t status = co_given_constraints_create(mesh, c->xyz, &wanted, &held, error);
    if (status == CURVOPT_OK)
        status = co_interpolation_create(mesh, &held, &map, error);
    if (status == CURVOPT_OK)
        status = co_patches_create(mesh, c->xyz, NULL, CURVOPT_SURFACE_LIMIT, 1, NULL, &patches, error);
    if (status == CURVOPT_OK)
        status = co_patches_substitute(&patches, &(co_substitution){map.vertex, &map.cage}, error);
    double xyz[3 * 12];
    memcpy(xyz, c->xyz, 3 * (size_t)c->n_vertices * sizeof *xyz);
    if (status == CURVOPT_OK)
        status = co_given_constraints_place(mesh, &held, CURVOPT_BOUNDARY_POSITION, xyz, error);
    co_patches_free(&patches);
    co_interpolation_free(&map);
    co_constraints_free(&held);
    return status;
}

/* What points, normals and places inside faces add: values, pivots, and the cage that is put there. */
static int32_t through_parts(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    const int32_t vertices[2] = {0, -1}, faces[2] = {0, 2};
    const double uv[4] = {0, 0, 0.25, 0.5}, places[6] = {2, 0, 0.5, (double)NAN, (double)NAN, (double)NAN};
    const curvopt_through wanted = {
        .struct_size = sizeof wanted, .n = 2, .vertices = vertices, .faces = faces, .uv = uv, .places = places};
    curvopt_options o;
    co_constraints held = {0};
    double xyz[3 * 12];
    curvopt_options_init(&o, sizeof o);
    o.through = &wanted;
    memcpy(xyz, c->xyz, 3 * (size_t)c->n_vertices * sizeof *xyz);
    int32_t status = co_given_through_create(mesh, c->xyz, &o, &held, error);
    if (status == CURVOPT_OK)
        status = co_given_constraints_place(mesh, &held, CURVOPT_BOUNDARY_POSITION, xyz, error);
    if (status == CURVOPT_OK)
        status = co_held_curvatures_fix(mesh, xyz, &held.values, error);
    co_constraints_free(&held);
    return status;
}

/* What symmetries that are kept with such add. */
static int32_t symmetric_parts(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    const int32_t vertex = 0;
    const double normal[3] = {1, 0, 0};
    const curvopt_through wanted = {.struct_size = sizeof wanted, .n = 1, .vertices = &vertex, .normals = normal};
    curvopt_options o;
    co_constraints held = {0};
    co_symmetry symmetry = {0};
    curvopt_options_init(&o, sizeof o);
    o.through = &wanted;
    int32_t status = co_given_through_create(mesh, c->xyz, &o, &held, error);
    if (status == CURVOPT_OK)
        status = co_symmetry_create(mesh, c->xyz, &held, 1, NULL, &symmetry, error);
    CHECK_TRUE(status != CURVOPT_OK || symmetry.order == 4);
    if (status == CURVOPT_OK)
        status = co_value_images_adapt(mesh, &symmetry, &held.values, error);
    if (status == CURVOPT_OK)
        status = co_kept_symmetry_restrict(mesh, &held, o.boundary, &symmetry, error);
    if (status == CURVOPT_OK)
        status = co_pivots_choose(mesh, &symmetry, &held, error);
    co_symmetry_free(&symmetry);
    co_constraints_free(&held);
    return status;
}

/* What an open and a closed chain of edges add, and one that springs draw, a level on, too. */
static int32_t chain_parts(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    static const double curve[12] = {1.5, 0, 0, 0, 1.5, 0, -1.5, 0, 0, 0, -1.5, 0};
    static const double parameters[4] = {0, 1, 2, 3};
    const int32_t ring[4] = {0, 3, 6, 9}, open[2] = {1, 4};
    const double weights[3] = {1, 1, 0.5};
    const curvopt_chain chains[3] = {
        {.vertices = ring, .curve = curve, .n_vertices = 4, .n_points = 4, .is_closed = 1, .is_curve_closed = 1},
        {.vertices = open, .curve = curve, .parameters = parameters, .n_vertices = 2, .n_points = 4},
        {.vertices = open, .curve = curve, .n_vertices = 2, .n_points = 4}};
    const curvopt_through wanted = {
        .struct_size = sizeof wanted, .chains = chains, .n_chains = 3, .chain_weights = weights};
    curvopt_options o;
    co_constraints held = {0};
    curvopt_mesh *fine = NULL;
    co_sparse_rows rows = {0};
    double xyz[3 * 12], finer[3 * 48];
    curvopt_options_init(&o, sizeof o);
    o.through = &wanted;
    memcpy(xyz, c->xyz, sizeof xyz);
    int32_t status = co_given_through_create(mesh, c->xyz, &o, &held, error);
    if (status == CURVOPT_OK)
        status = co_given_constraints_place(mesh, &held, CURVOPT_BOUNDARY_POSITION, xyz, error);
    if (status == CURVOPT_OK)
        status = co_subdivide(mesh, &fine, &rows, error);
    if (status == CURVOPT_OK) {
        co_sparse_rows_apply(&rows, xyz, finer);
        status = co_constraints_subdivide(mesh, fine, &rows, finer, &held, error);
    }
    co_sparse_rows_free(&rows);
    co_mesh_destroy(fine);
    co_constraints_free(&held);
    return status;
}

/* What springs of points, normals and curvatures add: rows, springs, couplings. */
static int32_t spring_parts(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    const int32_t vertices[2] = {0, -1}, faces[2] = {0, 2};
    const double uv[4] = {0, 0, 0.25, 0.5}, normals[6] = {1, 0, 0, 0, 0, 1}, weights[2] = {0.5, 0.25},
                 curvatures[4] = {(double)NAN, (double)NAN, 1, 1};
    const curvopt_through wanted = {.struct_size = sizeof wanted,
                                    .n = 2,
                                    .vertices = vertices,
                                    .faces = faces,
                                    .uv = uv,
                                    .normals = normals,
                                    .weights = weights,
                                    .curvatures = curvatures};
    const double centroid[3] = {0, 0, 0};
    const co_interpolation none = {0};
    curvopt_options o;
    co_constraints held = {0}, copy = {0};
    co_dof_map dofs = {0};
    co_surface_springs springs = {0};
    co_couplings couplings = {0};
    curvopt_options_init(&o, sizeof o);
    o.through = &wanted;
    int32_t status = co_given_through_create(mesh, c->xyz, &o, &held, error);
    if (status == CURVOPT_OK)
        status = co_constraints_copy(mesh, &held, &copy, error);
    if (status == CURVOPT_OK)
        status = co_surface_values_make_rows(mesh, &copy.drawn, error);
    if (status == CURVOPT_OK)
        status = co_dof_map_identity(c->n_vertices, &dofs, error);
    if (status == CURVOPT_OK)
        status = co_surface_springs_create(&copy.drawn, &none, &dofs, centroid, 1, 1, &springs, error);
    for (int twice = 0; status == CURVOPT_OK && twice < 2; twice++)
        status = co_surface_springs_couple(&springs, &couplings, error);
    co_couplings_free(&couplings);
    co_surface_springs_free(&springs);
    co_dof_map_free(&dofs);
    co_constraints_free(&copy);
    co_constraints_free(&held);
    return status;
}

/* What discs add to all that: points, room for second derivatives, what boundaries need, tables of both kinds of faces,
 * of which the one that takes longest comes last. xyz: NULL or positions, which allow half discs. */
static int32_t disc_parts(const curvopt_mesh *mesh, const double *xyz, int n_discs, const int32_t kind[2],
                          curvopt_error *error) {
    co_patches patches;
    co_blend_disc_hessian matrix = {0};
    co_dof_map reduction = {0};
    co_boundary_turning turning = {0};
    co_basis_table *table[2] = {NULL, NULL};
    int32_t status =
        co_patches_create(mesh, xyz, NULL, CURVOPT_SURFACE_POLYNOMIAL, CO_BLEND_DISC_LARGEST, NULL, &patches, error);
    if (status != CURVOPT_OK)
        return status;
    CHECK_INT(patches.wide.n_discs, n_discs);
    status = co_dof_map_identity(patches.n_cage, &reduction, error);
    if (status == CURVOPT_OK)
        status = co_blend_disc_hessian_create(&patches, &reduction, &matrix, error);
    if (status == CURVOPT_OK)
        status = co_boundary_turning_create(mesh, &patches, CURVOPT_SURFACE_POLYNOMIAL, &turning, error);
    for (int i = 0; status == CURVOPT_OK && i < 2; i++)
        status = co_basis_table_create(CURVOPT_SURFACE_POLYNOMIAL, kind[i], 0, &table[i], error);
    co_boundary_turning_free(&turning);
    co_blend_disc_hessian_free(&matrix);
    co_dof_map_free(&reduction);
    for (int i = 0; i < 2; i++)
        co_basis_table_destroy(table[i]);
    co_patches_free(&patches);
    return status;
}

static int32_t wide_parts(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    const int32_t kind[2] = {co_fan_make_wide(3, 2, 1, 1), co_fan_make_wide(3, 2, 0, 0)};
    (void)c;
    return disc_parts(mesh, NULL, 8, kind, error);
}

static int32_t half_parts(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    const int32_t kind[2] = {co_fan_make_half(3, 1, 2, 1, 1, 1), co_fan_make_half(3, 1, 2, 1, 0, 0)};
    return disc_parts(mesh, c->xyz, 1, kind, error);
}

static int32_t sample(const cage *c, const curvopt_mesh *mesh, int32_t surface, int32_t n, const double *uv,
                      curvopt_error *error) {
    static const int32_t face[2] = {0, 1}, corner[2] = {0, 0};
    double out[60];
    curvopt_options o;
    curvopt_sampler *sampler;
    curvopt_options_init(&o, sizeof o);
    o.surface = surface;
    int32_t status = curvopt_sampler_create(mesh, c->xyz, &o, &sampler, error);
    if (status == CURVOPT_OK)
        status = curvopt_sampler_jets(sampler, n, face, corner, uv, out, error);
    curvopt_sampler_destroy(sampler);
    return status;
}

static int32_t wide_jets(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    const double uv[4] = {0.3, 0.2, 0.4, 0.7}; /* of the four quarters of a face at a vertex, two */
    return sample(c, mesh, CURVOPT_SURFACE_POLYNOMIAL, 2, uv, error);
}

static int32_t jets(const cage *c, const curvopt_mesh *mesh, curvopt_error *error) {
    const double uv[2] = {0.3, 0.2};
    return sample(c, mesh, CURVOPT_SURFACE_PLANE, 1, uv, error);
}

/* A cage and what is done with it. */
typedef struct task {
    cage c;
    curvopt_mesh *mesh;
    work run;
} task;

static int32_t run_task(void *context, curvopt_error *error) {
    task *t = context;
    return t->run(&t->c, t->mesh, error);
}

static void fail_each(cage c, work run, long least) {
    task t = {c, cage_mesh(&c), run};
    fail_every_allocation(run_task, &t, least);
    curvopt_mesh_destroy(t.mesh);
    cage_free(&t.c);
}

static void test_mesh_creation_survives_every_failure(void **state) {
    (void)state;
    fail_each(cage_prism(5), create, 8);
}

static void test_refinement_survives_every_failure(void **state) {
    (void)state;
    fail_each(cage_prism(5), refine, 12);
}

static void test_evaluation_survives_every_failure(void **state) {
    (void)state;
    fail_each(cage_torus(4, 3, 1, 0.45), evaluate_limit, 30);
    fail_each(cage_prism(3), evaluate_limit, 100);
}

static void test_evaluation_of_blended_surfaces_survives_every_failure(void **state) {
    (void)state;
    fail_each(cage_cube(), evaluate_plane, 80);
    fail_each(cage_cube(), evaluate_polynomial, 80);
}

static void test_wide_blends_survive_every_failure(void **state) {
    (void)state;
    fail_each(cage_refined(cage_cube(), 3), wide_parts, 100);
    fail_each(cage_refined(cage_cube(), 3), wide_jets, 60);
    fail_each(cage_half_star(3, 8), half_parts, 100);
}

static void test_held_limit_points_survive_every_failure(void **state) {
    (void)state;
    fail_each(cage_torus(4, 3, 1, 0.45), limit_parts, 20);
    fail_each(cage_torus(4, 3, 1, 0.45), through_parts, 30);
    fail_each(cage_torus(4, 3, 1, 0.45), spring_parts, 30);
    fail_each(cage_torus(4, 3, 1, 0.45), chain_parts, 50);
    fail_each(cage_torus(4, 4, 1, 0.45), symmetric_parts, 40);
    fail_each(cage_tetrahedron(), limit_parts, 30);
}

static void test_minimization_survives_every_failure(void **state) {
    (void)state;
    fail_each(cage_torus(4, 3, 1, 0.45), minimize, 150);
    fail_each(cage_torus(5, 4, 1, 0.45), minimize_curved, 200);
    fail_each(cage_both(cage_torus(4, 3, 1, 0.45), cage_torus(4, 3, 1, 0.45), 1.5), minimize_apart, 150);
    fail_each(cage_both(cage_tetrahedron(), cage_tetrahedron(), 3), minimize, 300); /* one copies the other */
    fail_each(cage_both(cage_torus(4, 3, 1, 0.45), cage_cube(), 3), minimize_pieces, 300);
}

static void test_minimization_with_all_options_survives_every_failure(void **state) {
    (void)state;
    fail_each(cage_torus(4, 3, 1, 0.45), minimize_and_look_round, 500);
}

static void test_solver_survives_every_failure(void **state) {
    (void)state;
    fail_each(cage_torus(4, 3, 1, 0.45), stay_even, 300);
    fail_each(cage_torus(4, 3, 1, 0.45), stay_free, 300);
}

static void test_sampling_survives_every_failure(void **state) {
    (void)state;
    fail_each(cage_tetrahedron(), jets, 30);
}

static void test_cancel_flag_survives_failure(void **state) {
    (void)state;
    curvopt_cancel *cancel;
    curvopt_error error;
    atomic_store(&allocations, 0);
    fail_at = 0;
    int32_t status = curvopt_cancel_create(&cancel, &error);
    fail_at = -1;
    CHECK_REFUSED(status, &error, CURVOPT_ERROR_MEMORY, -1, "memory");
    CHECK_TRUE(cancel == NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mesh_creation_survives_every_failure),
        cmocka_unit_test(test_refinement_survives_every_failure),
        cmocka_unit_test(test_evaluation_survives_every_failure),
        cmocka_unit_test(test_evaluation_of_blended_surfaces_survives_every_failure),
        cmocka_unit_test(test_wide_blends_survive_every_failure),
        cmocka_unit_test(test_held_limit_points_survive_every_failure),
        cmocka_unit_test(test_minimization_survives_every_failure),
        cmocka_unit_test(test_minimization_with_all_options_survives_every_failure),
        cmocka_unit_test(test_solver_survives_every_failure),
        cmocka_unit_test(test_sampling_survives_every_failure),
        cmocka_unit_test(test_cancel_flag_survives_failure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
