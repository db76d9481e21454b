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

/* What both components of bow_tie_and_quad() have of the options. */
static void deal(const curvopt_options *o, co_component_options out[2]) {
    curvopt_mesh *mesh = bow_tie_and_quad();
    co_components parts;
    co_component_shares shares;
    curvopt_error error;
    CHECK_OK(co_components_find(mesh, &parts, &error), &error);
    CHECK_OK(co_component_shares_create(o, &parts, &shares, &error), &error);
    for (int32_t k = 0; k < 2; k++)
        CHECK_OK(co_component_options_create(o, &parts, &shares, k, &out[k], &error), &error);
    co_component_shares_free(&shares);
    co_components_free(&parts);
    curvopt_mesh_destroy(mesh);
}

static void free_both(co_component_options both[2]) {
    co_component_options_free(&both[0]);
    co_component_options_free(&both[1]);
}

/* In any order, one constraint on the isolated vertex. */
static void test_constraints_and_holes_are_dealt_out(void **state) {
    (void)state;
    static const int32_t pins[4] = {3, 9, 8, 1}, freedom[4] = {1, 0, 0, 2}, holes[2] = {2, 1};
    static const double directions[12] = {1, 2, 3, 0, 0, 0, 0, 0, 0, 4, 5, 6};
    const curvopt_constraints held = {.n = 4, .vertices = pins, .freedom = freedom, .directions = directions};
    co_component_options both[2];
    const curvopt_constraints *one = &both[0].constraints, *two = &both[1].constraints;
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    o.constraints = &held;
    o.holes = holes;
    o.n_holes = 2;
    deal(&o, both);
    CHECK_INT(one->n, 1);
    CHECK_INT(one->vertices[0], 4);
    CHECK_INT(two->n, 2);
    CHECK_INT(two->vertices[0], 1);
    CHECK_INT(two->vertices[1], 0);
    CHECK_INT(two->freedom[1], 2);
    CHECK_NEAR(two->directions[4], 5, 0);
    CHECK_TRUE(two->places == NULL && two->weights == NULL);
    CHECK_INT(both[0].options.n_holes, 1);
    CHECK_INT(both[0].options.holes[0], 1);
    CHECK_INT(both[1].options.n_holes, 1);
    CHECK_INT(both[1].options.holes[0], 0);
    free_both(both);
}

/* An entry without a tangent may have anything in `toward`. */
static void test_entries_are_dealt_out(void **state) {
    (void)state;
    static const int32_t entries[3] = {5, -1, 4}, faces[3] = {0, 2, 0}, toward[3] = {7, 1, 1 << 30};
    static const double tangents[9] = {1, 0, 0, 0, 1, 0, (double)NAN, (double)NAN, (double)NAN};
    static const double weights[3] = {0.25, 0.5, 0.75}, curvatures[6] = {1, 2, 3, 4, 5, 6};
    const curvopt_through through = {.struct_size = (int32_t)sizeof through,
                                     .n = 3,
                                     .vertices = entries,
                                     .faces = faces,
                                     .tangents = tangents,
                                     .toward = toward,
                                     .weights = weights,
                                     .curvatures = curvatures,
                                     .curvature_directions = tangents};
    co_component_options both[2];
    const curvopt_through *one = &both[0].through, *two = &both[1].through;
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    o.through = &through;
    deal(&o, both);
    CHECK_INT(one->n, 2);
    CHECK_INT(one->vertices[0], -1);
    CHECK_INT(one->faces[0], 1);
    CHECK_INT(one->toward[0], 1); /* inside a face: a direction */
    CHECK_INT(one->vertices[1], 2);
    CHECK_INT(one->toward[1], 1 << 30);
    CHECK_NEAR(one->weights[1], 0.75, 0);
    CHECK_NEAR(one->curvatures[0], 3, 0);
    CHECK_NEAR(one->curvatures[3], 6, 0);
    CHECK_NEAR(one->curvature_directions[1], 1, 0);
    CHECK_INT(two->n, 1);
    CHECK_INT(two->vertices[0], 2);
    CHECK_INT(two->toward[0], 3); /* at a vertex: a vertex */
    CHECK_NEAR(two->curvatures[1], 2, 0);
    CHECK_NEAR(two->curvature_directions[0], 1, 0);
    free_both(both);
}

static void test_chains_are_dealt_out(void **state) {
    (void)state;
    static const int32_t first[2] = {1, 3}, second[3] = {6, 8, 4};
    const curvopt_chain chains[2] = {{.vertices = second, .n_vertices = 3}, {.vertices = first, .n_vertices = 2}};
    const double weights[2] = {0.5, 1};
    const curvopt_through through = {
        .struct_size = (int32_t)sizeof through, .chains = chains, .n_chains = 2, .chain_weights = weights};
    co_component_options both[2];
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    o.through = &through;
    deal(&o, both);
    CHECK_INT(both[0].through.n_chains, 1);
    CHECK_INT(both[0].through.chains[0].vertices[1], 4);
    CHECK_NEAR(both[0].through.chain_weights[0], 0.5, 0);
    CHECK_INT(both[1].through.n_chains, 1);
    CHECK_INT(both[1].through.chains[0].vertices[1], 1);
    CHECK_NEAR(both[1].through.chain_weights[0], 1, 0);
    free_both(both);
}

/* The worst of verdicts and stops; sums; -1 and NAN where one is not known. */
static void test_summaries_add_up(void **state) {
    (void)state;
    curvopt_summary a = {.verdict = CURVOPT_VERDICT_MINIMUM,
                         .shape_decrement = 1,
                         .touch_rise = 3,
                         .is_delicate = 1,
                         .multiplier = {0, 6},
                         .symmetry_order = 4},
                    b = {.verdict = CURVOPT_VERDICT_SADDLE,
                         .shape_decrement = 2,
                         .touch_rise = 0.5,
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
    CHECK_NEAR(all.touch_rise, 4, 0);
    CHECK_INT(all.is_delicate, 0); /* no minimum */
    CHECK_INT(all.negative_directions, 6);
    CHECK_INT(all.symmetry_order, 4);
    CHECK_INT(all.n_held, 7);
    CHECK_TRUE(isnan(all.multiplier[0]) && all.multiplier[1] == 6 && all.multiplier[2] == 0);
    CHECK_NEAR(all.scalar_residual[0], -1e-9, 0);
    CHECK_INT(report.stop, CURVOPT_STOP_LIMIT);
    CHECK_NEAR(report.gradient_norm, sqrt(12 * 12 + 2 * 16 * 16) / 11, 1e-14);
    b.verdict = CURVOPT_VERDICT_MINIMUM;
    co_component_figures_summary(parts, 2, &all);
    CHECK_INT(all.is_delicate, 1);
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
        cmocka_unit_test(test_constraints_and_holes_are_dealt_out),
        cmocka_unit_test(test_entries_are_dealt_out),
        cmocka_unit_test(test_chains_are_dealt_out),
        cmocka_unit_test(test_summaries_add_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
