/* What an even spacing is worth, against its definition and its differences. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "check.h"
#include "variables_setting.h"

#include "hessian/spacing.h"

static const double WEIGHT = 3, SMALL = 0.05, LARGE = 2; /* areas; the torus' mean corner has .36 */

static co_spacing spacing_of(const variables_setting *s, double least) {
    return (co_spacing){.mesh = s->mesh, .dofs = &s->dofs, .weight = WEIGHT, .least = least};
}

/* The spacing of the variables s->z, and with g [n_variables] its gradient with respect to them. */
static double value(variables_setting *s, double least, double *g) {
    const co_spacing spacing = spacing_of(s, least);
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

/* A corner with edges a and b, by lengths and angles: the two squares of singular values have the sum and the product
 * of Dirichlet's energy of the map from a regular polygon's corner and of its squared area. */
static double corner_value(const double a[3], const double b[3], int size, double least, double *area) {
    const double angle = acos(-1) * (size - 2) / size, soft = 1e-3 * least;
    double aa = 0, bb = 0, ab = 0;
    for (int c = 0; c < 3; c++) {
        aa += a[c] * a[c];
        bb += b[c] * b[c];
        ab += a[c] * b[c];
    }
    const double sum = (aa + bb - 2 * cos(angle) * ab) / pow(sin(angle), 2);
    *area = sqrt(fmax(0, aa * bb - ab * ab)) / sin(angle);
    const double root = sqrt(fmax(0, sum * sum / 4 - *area * *area)), p = sum / 2 + root, q = *area * *area / p;
    return pow(least, 3) * (1 / (p + soft) + 1 / (q + soft));
}

/* Over pairs of corners that follow each other in a face, each of which is seen from both sides of the edge, and over
 * corners. */
static double expected(const variables_setting *s, const int *is_held, double least, double *mean) {
    double sum = 0, areas = 0, n_corners = 0;
    for (int32_t f = 0, h = 0; f < s->c.n_faces; h += s->c.sizes[f++])
        for (int32_t k = 0, n = s->c.sizes[f]; k < n; k++) {
            const int32_t v = s->c.vertices[h + k], to = s->c.vertices[h + (k + 1) % n],
                          from = s->c.vertices[h + (k + n - 1) % n];
            double a[3], b[3], square = 0, area;
            for (int c = 0; c < 3; c++) {
                a[c] = s->x[3 * to + c] - s->x[3 * v + c];
                b[c] = s->x[3 * from + c] - s->x[3 * v + c];
                square += a[c] * a[c];
            }
            const double corner = corner_value(a, b, n, least, &area);
            sum += is_held && is_held[v] && is_held[to] ? 0 : square * square / 2;
            if (is_held && is_held[v] && is_held[to] && is_held[from])
                continue;
            sum += corner;
            areas += area;
            n_corners++;
        }
    *mean = areas / n_corners;
    return sum;
}

static void test_value_is_the_sum_over_edges_and_corners_that_move(void **state) {
    (void)state;
    static const int32_t face[4] = {0, 1, 5, 4}; /* its four edges and corners do not move */
    static const int is_held[32] = {1, 1, 0, 0, 1, 1};
    const curvopt_constraints pins = {.vertices = face, .n = 4};
    for (int held = 0; held < 2; held++) {
        variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), held ? &pins : NULL, 0);
        const co_spacing spacing = spacing_of(&s, LARGE);
        double mean;
        const double sum = expected(&s, held ? is_held : NULL, LARGE, &mean);
        CHECK_NEAR(value(&s, LARGE, NULL), WEIGHT * sum, 1e-12 * WEIGHT * sum);
        CHECK_NEAR(co_spacing_mean_corner(&spacing, s.x), mean, 1e-12 * mean);
        variables_setting_free(&s);
    }
}

static void test_faces_of_any_size_aim_at_regular_polygons(void **state) {
    (void)state;
    variables_setting s = variables_setting_of(cage_prism(5), NULL, 0);
    double mean;
    const double sum = expected(&s, NULL, LARGE, &mean);
    CHECK_NEAR(value(&s, LARGE, NULL), WEIGHT * sum, 1e-12 * WEIGHT * sum);
    variables_setting_free(&s);
}

/* How the value falls to a face of four corners that shrinks to a point, or whose edges come together in pairs: it
 * never does. A corner without area is worth 1 / delta of each singular value that is 0. */
static void test_pressure_rises_to_the_end(void **state) {
    (void)state;
    for (int along = 0; along < 2; along++) {
        double last = 0;
        for (int k = 0; k <= 60; k++) {
            variables_setting s = variables_setting_of(cage_cube(), NULL, 0);
            const double factor = k < 60 ? pow(0.8, k) : 0, edge = 1e-2;
            for (int32_t v = 0; v < s.c.n_vertices; v++)
                for (int c = 0; c < 3; c++)
                    s.x[3 * v + c] *= edge * (c == 0 || !along ? factor : 1);
            const co_spacing spacing = spacing_of(&s, 1e-3); /* tension is 1e-12 here */
            const double v = co_spacing_value(&spacing, s.x, NULL);
            CHECK_TRUE(isfinite(v) && v > last);
            last = v;
            variables_setting_free(&s);
        }
        const double most = WEIGHT * 1e-9 / 1e-6; /* a^3 / delta; 24 corners: all have both, or 16 one */
        CHECK_NEAR(last, most * (along ? 16 : 48), 0.02 * last);
    }
}

/* Second derivatives in direction move: by the Hessian and by differences of the gradient. */
static void curvatures(variables_setting *s, const co_sparse_hessian *hessian, double least, const double *move,
                       double *of_hessian, double *of_differences) {
    const int n = s->dofs.n_variables;
    const double step = 1e-6;
    double *up = calloc(3 * (size_t)n, sizeof *up), *down = up + n, *column = down + n;
    CHECK_TRUE(up);
    *of_hessian = *of_differences = 0;
    for (int side = -1; side <= 1; side += 2) {
        for (int i = 0; i < n; i++)
            s->z[i] += side * step * move[i];
        value(s, least, side > 0 ? up : down);
        for (int i = 0; i < n; i++)
            s->z[i] -= side * step * move[i];
    }
    for (int i = 0; i < n; i++) {
        *of_differences += move[i] * (up[i] - down[i]) / (2 * step);
        variables_hessian_column(hessian, i, column);
        for (int j = 0; j < n; j++)
            *of_hessian += move[i] * column[j] * move[j];
    }
    free(up);
}

/* Where tension makes up for pressure nothing of the Hessian is left out. */
static void check_differences(variables_setting *s, double least) {
    int n = s->dofs.n_variables;
    const double step = 1e-5;
    double *g = calloc(4 * (size_t)n, sizeof *g), *up = g + n, *down = g + 2 * n, *column = g + 3 * n;
    co_sparse_hessian hessian = variables_hessian(s);
    CHECK_TRUE(g);
    double whole = value(s, least, g);
    const co_spacing spacing = spacing_of(s, least);
    co_spacing_add_hessian(&spacing, s->x, &hessian);
    for (int i = 0; i < n; i++) {
        double at = s->z[i];
        s->z[i] = at + step;
        double above = value(s, least, up);
        s->z[i] = at - step;
        double below = value(s, least, down);
        s->z[i] = at;
        CHECK_NEAR(g[i], (above - below) / (2 * step), 1e-7 * whole);
        variables_hessian_column(&hessian, i, column);
        for (int j = 0; j < n; j++)
            CHECK_NEAR(column[j], (up[j] - down[j]) / (2 * step), 1e-7 * whole);
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
    check_differences(&s, SMALL);
    variables_setting_free(&s);
    s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), &pins, 0);
    check_differences(&s, SMALL);
    variables_setting_free(&s);
    s = variables_setting_of(cage_shaken(cage_prism(5), 0.05), NULL, 0);
    check_differences(&s, SMALL);
    variables_setting_free(&s);
    s = variables_setting_of(cage_torus(8, 4, 3, 1.2), NULL, 1); /* edges within one orbit, too */
    CHECK_TRUE(s.symmetry.order > 8);
    check_differences(&s, SMALL);
    variables_setting_free(&s);
}

/* Under pressure the Hessian is above the function's, and positive: on a shaken cage, and where faces have no area. */
static void test_hessian_is_positive_under_pressure(void **state) {
    (void)state;
    for (int flat = 0; flat < 2; flat++) {
        variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), NULL, 0);
        const int n = s.dofs.n_variables;
        double *move = calloc((size_t)n, sizeof *move);
        int n_above = 0;
        CHECK_TRUE(move);
        if (flat) /* two of its vertices at one place, and a third in line with them */
            for (int c = 0; c < 3; c++) {
                s.z[3 + c] = s.z[c];
                s.z[12 + c] = 0.5 * (s.z[c] + s.z[15 + c]);
            }
        co_sparse_hessian hessian = variables_hessian(&s);
        const co_spacing spacing = spacing_of(&s, LARGE);
        CHECK_TRUE(isfinite(value(&s, LARGE, NULL)));
        co_spacing_add_hessian(&spacing, s.x, &hessian);
        for (int trial = 0; trial < 50; trial++) {
            double of_hessian, of_differences;
            for (int i = 0; i < n; i++)
                move[i] = sin(1 + i * (trial + 1.3));
            curvatures(&s, &hessian, LARGE, move, &of_hessian, &of_differences);
            CHECK_TRUE(of_hessian >= 0);
            CHECK_TRUE(of_hessian >= of_differences - 1e-4 * of_hessian);
            n_above += of_hessian > of_differences + 1e-3 * of_hessian;
        }
        CHECK_TRUE(n_above > 0);
        co_sparse_hessian_free(&hessian);
        free(move);
        variables_setting_free(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_value_is_the_sum_over_edges_and_corners_that_move),
        cmocka_unit_test(test_faces_of_any_size_aim_at_regular_polygons),
        cmocka_unit_test(test_pressure_rises_to_the_end),
        cmocka_unit_test(test_gradient_and_hessian_are_its_differences),
        cmocka_unit_test(test_hessian_is_positive_under_pressure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
