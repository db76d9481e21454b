/* A normalized cage and its variables. SPDX-License-Identifier: GPL-3.0-or-later */
#include "variables_setting.h"
#include "check.h"

#include "constraints/given_constraints.h"
#include "mesh/similarity.h"

variables_setting variables_setting_of(cage c, const curvopt_constraints *pins, int symmetric) {
    variables_setting s = {.c = c, .mesh = cage_mesh(&c)};
    size_t n = 3 * (size_t)c.n_vertices;
    curvopt_error error;
    s.radius = co_similarity_frame((size_t)c.n_vertices, c.xyz, s.centroid);
    s.x = calloc(n, sizeof *s.x);
    s.z = calloc(n, sizeof *s.z);
    CHECK_TRUE(s.x && s.z);
    for (size_t i = 0; i < n; i++)
        s.x[i] = (c.xyz[i] - s.centroid[i % 3]) / s.radius;
    CHECK_OK(co_given_constraints_create(s.mesh, c.xyz, pins, &s.held, &error), &error);
    if (symmetric)
        CHECK_OK(co_symmetry_create(s.mesh, c.xyz, &s.held, 1, NULL, &s.symmetry, &error), &error);
    else
        CHECK_OK(co_symmetry_none(s.mesh, &s.symmetry, &error), &error);
    CHECK_OK(co_dof_map_create(s.mesh, &s.symmetry, &s.held, s.x, &s.dofs, &error), &error);
    co_dof_map_variables(&s.dofs, s.x, s.z);
    return s;
}

void variables_setting_free(variables_setting *s) {
    co_dof_map_free(&s->dofs);
    co_symmetry_free(&s->symmetry);
    co_constraints_free(&s->held);
    curvopt_mesh_destroy(s->mesh);
    cage_free(&s->c);
    free(s->x);
    free(s->z);
}

co_sparse_hessian variables_hessian(const variables_setting *s) {
    curvopt_options o;
    curvopt_error error;
    co_basis_table_cache tables;
    co_assembly assembly;
    co_sparse_hessian hessian;
    curvopt_options_init(&o, sizeof o);
    o.surface = CURVOPT_SURFACE_LIMIT;
    co_basis_table_cache_create(o.surface, &tables);
    CHECK_OK(co_assembly_create(s->mesh, NULL, NULL, &o, &tables, NULL, &assembly, &error), &error);
    CHECK_OK(co_sparse_hessian_create(&assembly, &s->dofs, NULL, &hessian, &error), &error);
    co_assembly_free(&assembly);
    co_basis_table_cache_free(&tables);
    return hessian;
}

void variables_hessian_column(const co_sparse_hessian *hessian, int column, double *out) {
    const int n = hessian->dofs->n_variables;
    memset(out, 0, (size_t)n * sizeof *out);
    for (int j = 0; j < n; j++) /* the lower triangle has the column from its diagonal on, and rows before */
        for (int32_t e = hessian->pattern.column_start[j]; e < hessian->pattern.column_start[j + 1]; e++)
            if (j == column || hessian->pattern.row[e] == column)
                out[j == column ? hessian->pattern.row[e] : j] = hessian->value[e];
}
