/* Connected components: faces that share a vertex, numbers within them, options by components.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "mesh/components.h"
#include "solve/component_figures.h"
#include "solve/component_options.h"

#include <math.h>

/* Two triangles of a bow tie, a quad whose vertices lie between theirs, and a vertex that no face uses. */
static curvopt_mesh *bow_tie_and_quad(void) {
    static const int32_t sizes[3] = {3, 4, 3}, vertices[10] = {0, 2, 4, 1, 3, 5, 7, 4, 6, 8};
    curvopt_mesh *mesh = NULL;
    curvopt_error error;
    CHECK_OK(curvopt_mesh_create(10, 3, sizes, vertices, &mesh, &error), &error);
    return mesh;
}

static void test_faces_that_share_a_vertex_are_together(void **state) {
    (void)state;
    static const int32_t of_vertex[10] = {0, 1, 0, 1, 0, 1, 0, 1, 0, -1}, vertex[9] = {0, 0, 1, 1, 2, 2, 3, 3, 4};
    static const int32_t of_face[3] = {0, 1, 0}, face[3] = {0, 0, 1};
    curvopt_mesh *mesh = bow_tie_and_quad();
    co_components parts;
    curvopt_error error;
    CHECK_OK(co_components_find(mesh, &parts, &error), &error);
    CHECK_INT(parts.n, 2);
    for (int v = 0; v < 10; v++)
        CHECK_INT(parts.of_vertex[v], of_vertex[v]);
    for (int v = 0; v < 9; v++)
        CHECK_INT(parts.vertex[v], vertex[v]);
    for (int f = 0; f < 3; f++) {
        CHECK_INT(parts.of_face[f], of_face[f]);
        CHECK_INT(parts.face[f], face[f]);
    }
    co_components_free(&parts);
    curvopt_mesh_destroy(mesh);
}

/* Constraints, entries, chains and holes in any order, some of them on the isolated vertex. An entry without a tangent
 * may have anything in `toward`. */
static void test_options_are_dealt_out(void **state) {
    (void)state;
    static const int32_t pins[4] = {3, 9, 8, 1}, freedom[4] = {1, 0, 0, 2}, holes[2] = {2, 1};
    static const double directions[12] = {1, 2, 3, 0, 0, 0, 0, 0, 0, 4, 5, 6};
    static const int32_t entries[3] = {5, -1, 4}, faces[3] = {0, 2, 0}, toward[3] = {7, 1, 1 << 30};
    static const double tangents[9] = {1, 0, 0, 0, 1, 0, (double)NAN, (double)NAN, (double)NAN};
    static const double weights[3] = {0.25, 0.5, 0.75};
    static const int32_t first[2] = {1, 3}, second[3] = {6, 8, 4};
    const curvopt_chain chains[2] = {{.vertices = second, .n_vertices = 3}, {.vertices = first, .n_vertices = 2}};
    const double chain_weights[2] = {0.5, 1};
    const curvopt_constraints held = {.n = 4, .vertices = pins, .freedom = freedom, .directions = directions};
    const curvopt_through through = {.struct_size = (int32_t)sizeof through,
                                     .n = 3,
                                     .vertices = entries,
                                     .faces = faces,
                                     .tangents = tangents,
                                     .toward = toward,
                                     .weights = weights,
                                     .chains = chains,
                                     .n_chains = 2,
                                     .chain_weights = chain_weights};
    curvopt_mesh *mesh = bow_tie_and_quad();
    co_components parts;
    co_component_shares shares;
    co_component_options one, two;
    curvopt_options o;
    curvopt_error error;
    curvopt_options_init(&o, sizeof o);
    o.constraints = &held;
    o.through = &through;
    o.holes = holes;
    o.n_holes = 2;
    CHECK_OK(co_components_find(mesh, &parts, &error), &error);
    CHECK_OK(co_component_shares_create(&o, &parts, &shares, &error), &error);
    CHECK_OK(co_component_options_create(&o, &parts, &shares, 0, &one, &error), &error);
    CHECK_OK(co_component_options_create(&o, &parts, &shares, 1, &two, &error), &error);
    CHECK_INT(one.constraints.n, 1);
    CHECK_INT(one.constraints.vertices[0], 4);
    CHECK_INT(two.constraints.n, 2);
    CHECK_INT(two.constraints.vertices[0], 1);
    CHECK_INT(two.constraints.vertices[1], 0);
    CHECK_INT(two.constraints.freedom[1], 2);
    CHECK_NEAR(two.constraints.directions[4], 5, 0);
    CHECK_TRUE(two.constraints.places == NULL && two.constraints.weights == NULL);
    CHECK_INT(one.through.n, 2);
    CHECK_INT(one.through.vertices[0], -1);
    CHECK_INT(one.through.faces[0], 1);
    CHECK_INT(one.through.toward[0], 1); /* inside a face: a direction */
    CHECK_INT(one.through.vertices[1], 2);
    CHECK_INT(one.through.toward[1], 1 << 30); /* at a vertex: a vertex */
    CHECK_NEAR(one.through.weights[1], 0.75, 0);
    CHECK_INT(one.through.n_chains, 1);
    CHECK_INT(one.through.chains[0].vertices[1], 4);
    CHECK_NEAR(one.through.chain_weights[0], 0.5, 0);
    CHECK_INT(two.through.n, 1);
    CHECK_INT(two.through.vertices[0], 2);
    CHECK_INT(two.through.toward[0], 3);
    CHECK_INT(two.through.chains[0].vertices[1], 1);
    CHECK_NEAR(two.through.chain_weights[0], 1, 0);
    CHECK_INT(one.options.n_holes, 1);
    CHECK_INT(one.options.holes[0], 1);
    CHECK_INT(two.options.n_holes, 1);
    CHECK_INT(two.options.holes[0], 0);
    co_component_options_free(&one);
    co_component_options_free(&two);
    co_component_shares_free(&shares);
    co_components_free(&parts);
    curvopt_mesh_destroy(mesh);
}

/* The worst of verdicts and stops; sums; -1 and NAN where one is not known. */
static void test_summaries_add_up(void **state) {
    (void)state;
    curvopt_summary a = {.verdict = CURVOPT_VERDICT_MINIMUM,
                         .shape_decrement = 1,
                         .multiplier = {0, 6},
                         .symmetry_order = 4},
                    b = {.verdict = CURVOPT_VERDICT_SADDLE,
                         .shape_decrement = 2,
                         .negative_directions = 3,
                         .multiplier = {5},
                         .scalar_residual = {-1e-9},
                         .symmetry_order = 2};
    curvopt_level_report first = {.energy = 3, .gradient_norm = 4, .stop = CURVOPT_STOP_SETTLED},
                         other = {.energy = 4, .gradient_norm = 4, .stop = CURVOPT_STOP_LIMIT};
    const co_component_part parts[2] = {{.times = 1, .report = &first, .summary = &a},
                                        {.times = 2, .report = &other, .summary = &b}};
    curvopt_summary all = {.newton_decrement = (double)NAN, .n_held = 7};
    curvopt_level_report report = {0};
    co_component_figures_summary(parts, 2, &all);
    co_component_figures_report(parts, 2, &report);
    CHECK_INT(all.verdict, CURVOPT_VERDICT_SADDLE);
    CHECK_NEAR(all.shape_decrement, 5, 0);
    CHECK_INT(all.negative_directions, 6);
    CHECK_INT(all.symmetry_order, 4);
    CHECK_INT(all.n_held, 7);
    CHECK_TRUE(isnan(all.multiplier[0]) && all.multiplier[1] == 6 && all.multiplier[2] == 0);
    CHECK_NEAR(all.scalar_residual[0], -1e-9, 0);
    CHECK_INT(report.stop, CURVOPT_STOP_LIMIT);
    CHECK_NEAR(report.gradient_norm, sqrt(12 * 12 + 2 * 16 * 16) / 11, 1e-14);
    b.verdict = CURVOPT_VERDICT_UNKNOWN;
    b.negative_directions = -1;
    b.shape_decrement = (double)NAN;
    co_component_figures_summary(parts, 2, &all);
    CHECK_INT(all.verdict, CURVOPT_VERDICT_UNKNOWN);
    CHECK_INT(all.negative_directions, -1);
    CHECK_TRUE(isnan(all.shape_decrement));
    a.verdict = CURVOPT_VERDICT_NOT_STATIONARY;
    co_component_figures_summary(parts, 2, &all);
    CHECK_INT(all.verdict, CURVOPT_VERDICT_NOT_STATIONARY);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_faces_that_share_a_vertex_are_together),
        cmocka_unit_test(test_options_are_dealt_out),
        cmocka_unit_test(test_summaries_add_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
