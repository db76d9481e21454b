/* What an even spacing is worth, against its definition and its differences. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "check.h"
#include "variables_setting.h"

#include "hessian/spacing.h"

static const double WEIGHT = 3;

/* The spacing of the variables s->z, and with g [n_variables] its gradient with respect to them. */
static double value(variables_setting *s, double *g) {
    const co_spacing spacing = {.edges = {.mesh = s->mesh, .dofs = &s->dofs}, .weight = WEIGHT};
    co_dof_map_expand(&s->dofs, s->z, s->x);
    if (!g)
        return co_spacing_value(&spacing, s->x, NULL);
    double *gradient = calloc(3 * (size_t)s->c.n_vertices, sizeof *gradient);
    CHECK_TRUE(gradient);
    double v = co_spacing_value(&spacing, s->x, gradient);
    co_dof_map_gradient(&s->dofs, gradient, g);
    free(gradient);
    return v;
}

/* Over pairs of corners that follow each other in a face, each of which is seen from both sides of the edge. */
static void test_value_is_the_sum_over_edges_that_move(void **state) {
    (void)state;
    static const int32_t face[4] = {0, 1, 5, 4}; /* its four edges do not move */
    const curvopt_constraints pins = {.vertices = face, .n = 4};
    for (int held = 0; held < 2; held++) {
        variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), held ? &pins : NULL, 0);
        double twice = 0;
        for (int32_t f = 0, h = 0; f < s.c.n_faces; h += s.c.sizes[f++])
            for (int32_t k = 0; k < s.c.sizes[f]; k++) {
                int32_t v = s.c.vertices[h + k], w = s.c.vertices[h + (k + 1) % s.c.sizes[f]];
                int v_held = v == 0 || v == 1 || v == 5 || v == 4, w_held = w == 0 || w == 1 || w == 5 || w == 4;
                const double *a = s.x + 3 * v, *b = s.x + 3 * w;
                double square = pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2);
                twice += held && v_held && w_held ? 0 : square * square;
            }
        CHECK_NEAR(value(&s, NULL), WEIGHT * twice / 2, 1e-12 * twice);
        variables_setting_free(&s);
    }
}

static void check_differences(variables_setting *s) {
    int n = s->dofs.n_variables;
    const double step = 1e-3;
    double *g = calloc(4 * (size_t)n, sizeof *g), *up = g + n, *down = g + 2 * n, *column = g + 3 * n;
    co_sparse_hessian hessian = variables_hessian(s);
    CHECK_TRUE(g);
    double whole = value(s, g);
    const co_spacing spacing = {.edges = {.mesh = s->mesh, .dofs = &s->dofs}, .weight = WEIGHT};
    CHECK_INT(co_spacing_add_hessian(&spacing, s->x, &hessian, NULL), CURVOPT_OK);
    for (int i = 0; i < n; i++) {
        double at = s->z[i];
        s->z[i] = at + step;
        double above = value(s, up);
        s->z[i] = at - step;
        double below = value(s, down);
        s->z[i] = at;
        CHECK_NEAR(g[i], (above - below) / (2 * step), 1e-4 * whole);
        variables_hessian_column(&hessian, i, column);
        for (int j = 0; j < n; j++)
            CHECK_NEAR(column[j], (up[j] - down[j]) / (2 * step), 1e-4 * whole);
    }
    co_sparse_hessian_free(&hessian);
    free(g);
}

static void test_gradient_and_hessian_are_its_differences(void **state) {
    (void)state;
    static const int32_t some[3] = {0, 9, 14}, freedom[3] = {0, 1, 2};
    static const double direction[9] = {0, 0, 0, 1, 2, 3, 0, 1, -1};
    const curvopt_constraints pins = {.vertices = some, .n = 3, .freedom = freedom, .directions = direction};
    variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), NULL, 0);
    check_differences(&s);
    variables_setting_free(&s);
    s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), &pins, 0);
    check_differences(&s);
    variables_setting_free(&s);
    s = variables_setting_of(cage_torus(8, 4, 3, 1.2), NULL, 1); /* edges within one orbit, too */
    CHECK_TRUE(s.symmetry.order > 8);
    check_differences(&s);
    variables_setting_free(&s);
}

/* Edges that are too short: their costs, slopes and curvatures along themselves by differences in their lengths. */
static double cost_of(double length, double shortest, double wall) {
    const double t = pow(shortest / length, 2) - 1;
    return t > 0 ? wall * t * t * t : 0;
}

static void check_short_edges(variables_setting *s) {
    const int n = s->dofs.n_variables;
    const double h = 1e-5;
    co_spacing bare = {.edges = {.mesh = s->mesh, .dofs = &s->dofs}, .weight = WEIGHT}, walled = bare;
    co_dof_map_expand(&s->dofs, s->z, s->x);
    walled.shortest = 0.8 * co_mesh_mean_edge(s->mesh, NULL, s->x);
    walled.wall = 2;
    double *work = calloc(9 * (size_t)s->c.n_vertices + 4 * (size_t)n, sizeof *work), *moved = work,
           *g0 = work + 3 * s->c.n_vertices, *g1 = g0 + 3 * s->c.n_vertices, *v = g1 + 3 * s->c.n_vertices,
           *column = v + n, *slope = column + n;
    CHECK_TRUE(work);
    for (int i = 0; i < n; i++)
        v[i] = sin(3 * i + 1);
    co_sparse_hessian hessian[2] = {variables_hessian(s), variables_hessian(s)};
    double value = co_spacing_value(&walled, s->x, g1) - co_spacing_value(&bare, s->x, g0), form = 0, work_done = 0;
    CHECK_INT(co_spacing_add_hessian(&bare, s->x, &hessian[0], NULL), CURVOPT_OK);
    CHECK_INT(co_spacing_add_hessian(&walled, s->x, &hessian[1], NULL), CURVOPT_OK);
    for (size_t i = 0; i < 3 * (size_t)s->c.n_vertices; i++)
        g1[i] -= g0[i];
    co_dof_map_gradient(&s->dofs, g1, slope);
    for (int j = 0; j < n; j++) {
        work_done += slope[j] * v[j];
        for (int k = 0; k < 2; k++) {
            variables_hessian_column(&hessian[k], j, column);
            for (int i = 0; i < n; i++)
                form += (k ? 1 : -1) * v[i] * column[i] * v[j];
        }
        s->z[j] += v[j];
    }
    co_dof_map_expand(&s->dofs, s->z, moved);
    int n_short = 0;
    for (int32_t k = 0; k < s->mesh->info.n_edges; k++) {
        const int32_t c = s->mesh->edge_corner[k], a = s->mesh->corner_vertex[c], b = co_mesh_destination(s->mesh, c);
        if (s->dofs.node[a] < 0 && s->dofs.node[b] < 0)
            continue;
        double square = 0, change = 0;
        for (int i = 0; i < 3; i++) {
            const double d = s->x[3 * a + i] - s->x[3 * b + i];
            square += d * d;
            change += d * (moved[3 * a + i] - moved[3 * b + i] - d);
        }
        const double length = sqrt(square), at = cost_of(length, walled.shortest, 2),
                     above = cost_of(length + h, walled.shortest, 2), below = cost_of(length - h, walled.shortest, 2);
        n_short += at > 0;
        value -= at;
        work_done -= (above - below) / (2 * h) * change / length;
        form -= (above + below - 2 * at) / (h * h) * pow(change / length, 2);
    }
    CHECK_TRUE(n_short > 3 && n_short < s->mesh->info.n_edges);
    CHECK_BETWEEN(value, -1e-9, 1e-9);
    CHECK_BETWEEN(work_done, -1e-4, 1e-4);
    CHECK_BETWEEN(form, -1e-2, 1e-2);
    co_sparse_hessian_free(&hessian[0]);
    co_sparse_hessian_free(&hessian[1]);
    free(work);
}

/* Plain; held, `some` in their places, on a line, on a plane; with nodes of several vertices, which only an even cage
 * has. */
static void in_three_settings(double shaken, const int32_t some[3], void (*check)(variables_setting *)) {
    static const int32_t freedom[3] = {0, 1, 2};
    static const double direction[9] = {0, 0, 0, 1, 2, 3, 0, 1, -1};
    const curvopt_constraints pins = {.vertices = some, .n = 3, .freedom = freedom, .directions = direction};
    for (int k = 0; k < 3; k++) {
        variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), k == 2 ? 0 : shaken),
                                                   k == 1 ? &pins : NULL, k == 2);
        check(&s);
        variables_setting_free(&s);
    }
}

static void test_short_edges_cost_more(void **state) {
    (void)state;
    in_three_settings(0.1, (const int32_t[3]){0, 9, 14}, check_short_edges);
}

/* Weights say what edges are worth; short ones that are there already do not drown the rest, nor do those of length 0.
 */
static void test_weights(void **state) {
    (void)state;
    variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), NULL, 0);
    co_spacing spacing = {.edges = {.mesh = s.mesh, .dofs = &s.dofs}};
    const double mean = co_mesh_mean_edge(s.mesh, NULL, s.x), shortest[3] = {0, 0.8 * mean, 0.8 * mean};
    for (int k = 0; k < 3; k++) {
        if (k == 2) /* its first edge has no length */
            for (int c = 0; c < 3; c++)
                s.x[3 * s.c.vertices[1] + c] = s.x[3 * s.c.vertices[0] + c];
        co_spacing_weigh(&spacing, s.x, 7, shortest[k]);
        const double value = co_spacing_value(&spacing, s.x, NULL);
        CHECK_BETWEEN(value, k == 1 ? 7.001 : 7 - 1e-12, k == 1 ? 707 : 7 + 1e-12);
        if (k == 1)
            CHECK_NEAR(spacing.wall, 0.7 / s.mesh->info.n_edges, 1e-15);
    }
    co_spacing_weigh(&spacing, s.x, 7, 0);
    CHECK_NEAR(co_spacing_value(&spacing, s.x, NULL), 7, 1e-12);
    variables_setting_free(&s);
}

/* Of s = sum w x over the vertices of a face, which hang together, H_ij = s_i . block s_j with s_i its change by
 * variable i. */
static void check_sum(variables_setting *s) {
    enum { MOST = 4 };
    static const double block[9] = {3, 1, .5, 1, 4, -1, .5, -1, 5}, weights[MOST] = {1, -.3, .7, -2};
    const int n = s->dofs.n_variables;
    co_sparse_hessian hessian = variables_hessian(s);
    co_weighted_vertex sum[MOST];
    size_t n_terms = 0;
    double *change = calloc(4 * (size_t)n, sizeof *change), *column = change + 3 * n;
    CHECK_TRUE(change);
    for (int32_t node = 0; node < s->dofs.n_nodes; node++) /* nodes ascend */
        for (int k = 0; k < MOST; k++)
            if (s->dofs.node[s->c.vertices[k]] == node)
                sum[n_terms++] = (co_weighted_vertex){{node, s->c.vertices[k]}, weights[k]};
    CHECK_TRUE(n_terms > 0);
    for (int sign = -1; sign <= 1; sign += 2)
        for (int i = 0; i < n; i++) {
            s->z[i] += sign;
            co_dof_map_expand(&s->dofs, s->z, s->x);
            s->z[i] -= sign;
            for (size_t t = 0; t < n_terms; t++)
                for (int c = 0; c < 3; c++)
                    change[3 * i + c] += sign * sum[t].weight * s->x[3 * sum[t].at.vertex + c] / 2;
        }
    co_sparse_hessian_add_sum(&hessian, n_terms, sum, block);
    for (int j = 0; j < n; j++) {
        variables_hessian_column(&hessian, j, column);
        for (int i = 0; i < n; i++) {
            double expected = 0;
            for (int a = 0; a < 9; a++)
                expected += change[3 * i + a / 3] * block[a] * change[3 * j + a % 3];
            CHECK_NEAR(column[i], expected, 1e-12);
        }
    }
    co_sparse_hessian_free(&hessian);
    free(change);
}

static void test_sums_of_vertices(void **state) {
    (void)state;
    in_three_settings(0, (const int32_t[3]){0, 1, 9}, check_sum);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_value_is_the_sum_over_edges_that_move),
        cmocka_unit_test(test_gradient_and_hessian_are_its_differences),
        cmocka_unit_test(test_short_edges_cost_more),
        cmocka_unit_test(test_weights),
        cmocka_unit_test(test_sums_of_vertices),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
