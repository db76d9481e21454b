/* The header as other people's compilers see it: sizes and places of every field, no padding, every function there.
 * Included by one file per language. SPDX-License-Identifier: GPL-3.0-or-later */
#include "curvopt.h"
#include "curvopt_experimental.h"
/* twice: they must not mind */
#include "curvopt.h"
#include "curvopt_experimental.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define JOIN_(a, b)         a##b
#define JOIN(a, b)          JOIN_(a, b)
#define ASSERT(condition)   typedef char JOIN(assertion_, __LINE__)[(condition) ? 1 : -1]
#define AT(type, field, at) ASSERT(offsetof(type, field) == (at))
#define SIZE(type, size)    ASSERT(sizeof(type) == (size))

SIZE(curvopt_status, 4);
SIZE(curvopt_surface, 4);
SIZE(curvopt_term, 4);
SIZE(curvopt_stop, 4);
SIZE(curvopt_exception, 4);
SIZE(curvopt_step, 4);

SIZE(curvopt_error, 256);
AT(curvopt_error, code, 0);
AT(curvopt_error, element, 4);
AT(curvopt_error, message, 8);

SIZE(curvopt_mesh_info, 48);
AT(curvopt_mesh_info, n_vertices, 0);
AT(curvopt_mesh_info, n_edges, 4);
AT(curvopt_mesh_info, n_faces, 8);
AT(curvopt_mesh_info, n_corners, 12);
AT(curvopt_mesh_info, n_components, 16);
AT(curvopt_mesh_info, n_boundary_edges, 20);
AT(curvopt_mesh_info, n_extraordinary, 24);
AT(curvopt_mesh_info, max_valence, 28);
AT(curvopt_mesh_info, euler, 32);
AT(curvopt_mesh_info, all_quads, 36);
AT(curvopt_mesh_info, n_isolated, 40);
AT(curvopt_mesh_info, n_flawed_edges, 44);

SIZE(curvopt_options, 296);
AT(curvopt_options, struct_size, 0);
AT(curvopt_options, surface, 4);
AT(curvopt_options, method, 8);
AT(curvopt_options, levels, 12);
AT(curvopt_options, max_iterations, 16);
AT(curvopt_options, threads, 20);
AT(curvopt_options, joshi_sequin, 24);
AT(curvopt_options, boundary, 28);
AT(curvopt_options, weights, 32);
AT(curvopt_options, tolerance, 96);
AT(curvopt_options, gradient_tolerance, 104);
AT(curvopt_options, decrement_tolerance, 112);
AT(curvopt_options, max_step, 120);
AT(curvopt_options, constraints, 128);
AT(curvopt_options, symmetry, 136);
AT(curvopt_options, verify, 140);
AT(curvopt_options, escape, 144);
AT(curvopt_options, symmetry_planes, 148);
AT(curvopt_options, blend_width, 152);
AT(curvopt_options, spacing, 156);
AT(curvopt_options, strength, 160);
AT(curvopt_options, holes, 168);
AT(curvopt_options, n_holes, 176);
AT(curvopt_options, strict, 180);
AT(curvopt_options, slide, 184);
AT(curvopt_options, scalar_rule, 188);
AT(curvopt_options, scalar_value, 216);
AT(curvopt_options, within, 264);
AT(curvopt_options, spontaneous_curvature, 272);
AT(curvopt_options, through, 280);
AT(curvopt_options, no_crossings, 288);
AT(curvopt_options, reserved, 292);

SIZE(curvopt_chain, 40);
AT(curvopt_chain, vertices, 0);
AT(curvopt_chain, curve, 8);
AT(curvopt_chain, parameters, 16);
AT(curvopt_chain, n_vertices, 24);
AT(curvopt_chain, n_points, 28);
AT(curvopt_chain, is_closed, 32);
AT(curvopt_chain, is_curve_closed, 36);
SIZE(curvopt_through, 136);
AT(curvopt_through, struct_size, 0);
AT(curvopt_through, n, 4);
AT(curvopt_through, vertices, 8);
AT(curvopt_through, faces, 16);
AT(curvopt_through, corners, 24);
AT(curvopt_through, uv, 32);
AT(curvopt_through, freedom, 40);
AT(curvopt_through, directions, 48);
AT(curvopt_through, places, 56);
AT(curvopt_through, normals, 64);
AT(curvopt_through, tangents, 72);
AT(curvopt_through, toward, 80);
AT(curvopt_through, weights, 88);
AT(curvopt_through, chains, 96);
AT(curvopt_through, n_chains, 104);
AT(curvopt_through, reserved, 108);
AT(curvopt_through, chain_weights, 112);
AT(curvopt_through, curvatures, 120);
AT(curvopt_through, curvature_directions, 128);

SIZE(curvopt_constraints, 48);
AT(curvopt_constraints, vertices, 0);
AT(curvopt_constraints, freedom, 8);
AT(curvopt_constraints, directions, 16);
AT(curvopt_constraints, n, 24);
AT(curvopt_constraints, has_places, 28);
AT(curvopt_constraints, weights, 32);
AT(curvopt_constraints, places, 40);

SIZE(curvopt_energies, 224);
AT(curvopt_energies, objective, 0);
AT(curvopt_energies, area, 8);
AT(curvopt_energies, term, 16);
AT(curvopt_energies, h2, 80);
AT(curvopt_energies, gauss, 88);
AT(curvopt_energies, gauss_bonnet_defect, 96);
AT(curvopt_energies, objective_error, 104);
AT(curvopt_energies, area_error, 112);
AT(curvopt_energies, term_error, 120);
AT(curvopt_energies, min_jacobian, 184);
AT(curvopt_energies, surface, 192);
AT(curvopt_energies, n_samples, 196);
AT(curvopt_energies, volume, 200);
AT(curvopt_energies, total_mean_curvature, 208);
AT(curvopt_energies, helfrich, 216);

SIZE(curvopt_progress, 120);
AT(curvopt_progress, struct_size, 0);
AT(curvopt_progress, level, 4);
AT(curvopt_progress, levels, 8);
AT(curvopt_progress, iteration, 12);
AT(curvopt_progress, evaluations, 16);
AT(curvopt_progress, n_vertices, 20);
AT(curvopt_progress, samples, 24);
AT(curvopt_progress, method, 28);
AT(curvopt_progress, rejected, 32);
AT(curvopt_progress, reserved, 36);
AT(curvopt_progress, xyz, 40);
AT(curvopt_progress, mesh, 48);
AT(curvopt_progress, energy, 56);
AT(curvopt_progress, start_energy, 64);
AT(curvopt_progress, gradient_norm, 72);
AT(curvopt_progress, seconds, 80);
AT(curvopt_progress, predicted, 88);
AT(curvopt_progress, shift, 96);
AT(curvopt_progress, gain_ratio, 104);
AT(curvopt_progress, step, 112);

SIZE(curvopt_level_report, 48);
AT(curvopt_level_report, energy, 0);
AT(curvopt_level_report, gradient_norm, 8);
AT(curvopt_level_report, seconds, 16);
AT(curvopt_level_report, level, 24);
AT(curvopt_level_report, n_vertices, 28);
AT(curvopt_level_report, iterations, 32);
AT(curvopt_level_report, evaluations, 36);
AT(curvopt_level_report, stop, 40);
AT(curvopt_level_report, reserved, 44);

SIZE(curvopt_deviation, 80);
AT(curvopt_deviation, max, 0);
AT(curvopt_deviation, rms, 8);
AT(curvopt_deviation, bound, 16);
AT(curvopt_deviation, size, 24);
AT(curvopt_deviation, point, 32);
AT(curvopt_deviation, other_point, 56);

SIZE(curvopt_crossings, 24);
AT(curvopt_crossings, n_pairs, 0);
AT(curvopt_crossings, n_contacts, 4);
AT(curvopt_crossings, n_unresolved, 8);
AT(curvopt_crossings, n_listed, 12);
AT(curvopt_crossings, is_complete, 16);
AT(curvopt_crossings, reserved, 20);

SIZE(curvopt_summary, 248);
AT(curvopt_summary, seconds, 0);
AT(curvopt_summary, newton_decrement, 8);
AT(curvopt_summary, shape_decrement, 16);
AT(curvopt_summary, n_levels, 24);
AT(curvopt_summary, stop, 28);
AT(curvopt_summary, n_vertices, 32);
AT(curvopt_summary, n_faces, 36);
AT(curvopt_summary, method, 40);
AT(curvopt_summary, verdict, 44);
AT(curvopt_summary, negative_directions, 48);
AT(curvopt_summary, symmetry_order, 52);
AT(curvopt_summary, difference_decrement, 56);
AT(curvopt_summary, all_negative_directions, 64);
AT(curvopt_summary, free_negative_directions, 68);
AT(curvopt_summary, n_held, 72);
AT(curvopt_summary, n_left_out, 76);
AT(curvopt_summary, curve_deviation, 80);
AT(curvopt_summary, n_sliding, 88);
AT(curvopt_summary, n_folded, 92);
AT(curvopt_summary, multiplier, 96);
AT(curvopt_summary, scalar_residual, 144);
AT(curvopt_summary, discretization_error, 192);
AT(curvopt_summary, clearance, 200);
AT(curvopt_summary, n_touching, 208);
AT(curvopt_summary, n_crossing_before, 212);
AT(curvopt_summary, n_refused, 216);
AT(curvopt_summary, n_unfolded, 220);
AT(curvopt_summary, spring_energy, 224);
AT(curvopt_summary, touch_rise, 232);
AT(curvopt_summary, is_delicate, 240);
AT(curvopt_summary, reserved, 244);

SIZE(curvopt_creases, 48);
AT(curvopt_creases, crease_vertices, 0);
AT(curvopt_creases, crease_sharpness, 8);
AT(curvopt_creases, corner_vertices, 16);
AT(curvopt_creases, corner_sharpness, 24);
AT(curvopt_creases, n_creases, 32);
AT(curvopt_creases, n_corners, 36);
AT(curvopt_creases, boundary_rule, 40);
AT(curvopt_creases, reserved, 44);

SIZE(curvopt_sums, 120);
AT(curvopt_sums, area, 0);
AT(curvopt_sums, second, 8);
AT(curvopt_sums, third, 16);
AT(curvopt_sums, gauss, 24);
AT(curvopt_sums, turning, 32);
AT(curvopt_sums, term, 40);
AT(curvopt_sums, samples, 104);
AT(curvopt_sums, min_jacobian, 112);

SIZE(curvopt_matrix, 32);
AT(curvopt_matrix, column_start, 0);
AT(curvopt_matrix, row, 8);
AT(curvopt_matrix, value, 16);
AT(curvopt_matrix, n, 24);
AT(curvopt_matrix, reserved, 28);

static int32_t on_progress(const curvopt_progress *progress, void *user) {
    ++*(int *)user;
    return progress->iteration >= 2;
}

/* A tetrahedron, as a stranger would use the shared library; 0 if all went well. */
static int use_library(void) {
    static const int32_t sizes[] = {3, 3, 3, 3}, vertices[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    static const double xyz[] = {2, 1, 1, -1, 1.5, -1, 1, -1, -1, -1, -1, 1};
    curvopt_mesh *mesh = NULL;
    curvopt_result *result = NULL;
    curvopt_options options;
    curvopt_summary summary;
    curvopt_error error;
    char version[32];
    int calls = 0;
    sprintf(version, "%d.%d.%d", CURVOPT_VERSION_MAJOR, CURVOPT_VERSION_MINOR, CURVOPT_VERSION_PATCH);
    if (strcmp(curvopt_version(), version) != 0)
        return 1;
    curvopt_options_init(&options, sizeof options);
    options.levels = 1;
    options.method = CURVOPT_METHOD_LMVM; /* the other one is done too soon to be cancelled */
    if (options.struct_size != (int32_t)sizeof options)
        return 2;
    if (curvopt_mesh_create(4, 4, sizes, vertices, &mesh, &error) != CURVOPT_OK)
        return 3;
    if (curvopt_minimize(mesh, xyz, &options, on_progress, &calls, NULL, &result, &error) != CURVOPT_OK)
        return 4;
    curvopt_result_get_summary(result, &summary, sizeof summary);
    curvopt_result_destroy(result);
    curvopt_mesh_destroy(mesh);
    return calls == 3 && summary.stop == CURVOPT_STOP_CANCELLED && summary.n_vertices == 4 ? 0 : 5;
}
