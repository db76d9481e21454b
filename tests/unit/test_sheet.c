/* An elastic sheet, against its definition and its differences. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "variables_setting.h"

#include "hessian/sheet.h"

static const double WEIGHT = 3, SMALL = 0.05, LARGE = 4;

static co_sheet sheet_of(const variables_setting *s, double rest) {
    return (co_sheet){.mesh = s->mesh, .dofs = &s->dofs, .weight = WEIGHT, .rest = rest};
}

/* The sheet's value at the variables s->z, and with g [n_variables] its gradient with respect to them. */
static double value(variables_setting *s, double rest, double *g) {
    const co_sheet sheet = sheet_of(s, rest);
    co_dof_map_expand(&s->dofs, s->z, s->x);
    if (!g)
        return co_sheet_value(&sheet, s->x, NULL);
    double *gradient = calloc(3 * (size_t)s->c.n_vertices, sizeof *gradient);
    CHECK_TRUE(gradient);
    double v = co_sheet_value(&sheet, s->x, gradient);
    co_dof_map_gradient(&s->dofs, gradient, g);
    free(gradient);
    return v;
}

/* f of a corner with edges a and b: Dirichlet's energies of the map from a regular polygon's corner with unit sides
 * and of its inverse, by lengths and angles. */
static double corner_energy(const double a[3], const double b[3], int size, double rest) {
    const double angle = acos(-1) * (size - 2) / size;
    double aa = 0, bb = 0, ab = 0;
    for (int c = 0; c < 3; c++) {
        aa += a[c] * a[c];
        bb += b[c] * b[c];
        ab += a[c] * b[c];
    }
    const double dirichlet = (aa + bb - 2 * cos(angle) * ab) / pow(sin(angle), 2);
    const double area = sqrt(aa * bb - ab * ab) / sin(angle);
    return dirichlet * (1 / rest + 1.0001 * rest / (area * area + 1e-4 * rest * rest));
}

static double expected(const variables_setting *s, const int *is_held) {
    double sum = 0;
    for (int32_t f = 0, h = 0; f < s->c.n_faces; h += s->c.sizes[f++])
        for (int32_t k = 0, n = s->c.sizes[f]; k < n; k++) {
            const int32_t v = s->c.vertices[h + k], to = s->c.vertices[h + (k + 1) % n],
                          from = s->c.vertices[h + (k + n - 1) % n];
            double a[3], b[3];
            for (int c = 0; c < 3; c++) {
                a[c] = s->x[3 * to + c] - s->x[3 * v + c];
                b[c] = s->x[3 * from + c] - s->x[3 * v + c];
            }
            sum += is_held && is_held[v] && is_held[to] && is_held[from] ? 0 : corner_energy(a, b, n, SMALL);
        }
    return sum;
}

static void test_value_is_the_sum_over_corners_that_move(void **state) {
    (void)state;
    static const int32_t face[4] = {0, 1, 5, 4}; /* its four corners do not move */
    static const int is_held[32] = {1, 1, 0, 0, 1, 1};
    const curvopt_constraints pins = {.vertices = face, .n = 4};
    for (int held = 0; held < 2; held++) {
        variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), held ? &pins : NULL, 0);
        const double sum = expected(&s, held ? is_held : NULL);
        CHECK_NEAR(value(&s, SMALL, NULL), WEIGHT * sum, 1e-12 * sum);
        variables_setting_free(&s);
    }
}

static void test_faces_of_any_size_aim_at_regular_polygons(void **state) {
    (void)state;
    variables_setting s = variables_setting_of(cage_prism(5), NULL, 0);
    const double sum = expected(&s, NULL);
    CHECK_NEAR(value(&s, SMALL, NULL), WEIGHT * sum, 1e-12 * sum);
    variables_setting_free(&s);
}

static void test_faces_that_are_left_out_have_no_part(void **state) {
    (void)state;
    uint8_t left_out[32] = {[5] = 1};
    variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), NULL, 0);
    const double *x = s.x;
    co_sheet sheet = sheet_of(&s, SMALL);
    const double all = co_sheet_value(&sheet, x, NULL);
    double own = 0;
    for (int k = 0; k < 4; k++) {
        const int32_t *face = s.c.vertices + 4 * 5;
        double a[3], b[3];
        for (int c = 0; c < 3; c++) {
            a[c] = x[3 * face[(k + 1) % 4] + c] - x[3 * face[k] + c];
            b[c] = x[3 * face[(k + 3) % 4] + c] - x[3 * face[k] + c];
        }
        own += corner_energy(a, b, 4, SMALL);
    }
    sheet.left_out = left_out;
    CHECK_NEAR(co_sheet_value(&sheet, x, NULL), all - WEIGHT * own, 1e-12 * all);
    variables_setting_free(&s);
}

static void test_the_rest_square_is_a_part_of_an_even_cages_corner(void **state) {
    (void)state;
    variables_setting s = variables_setting_of(cage_cube(), NULL, 0);
    const double side = sqrt(pow(s.x[0] - s.x[3], 2) + pow(s.x[1] - s.x[4], 2) + pow(s.x[2] - s.x[5], 2));
    const co_sheet sheet = sheet_of(&s, 0);
    CHECK_NEAR(co_sheet_rest(&sheet, s.x, 0.5), 0.5 * side * side, 5e-3 * side * side);
    variables_setting_free(&s);
}

/* Under tension, where nothing of the Hessian is left out. */
static void check_differences(variables_setting *s) {
    int n = s->dofs.n_variables;
    const double step = 1e-5;
    double *g = calloc(4 * (size_t)n, sizeof *g), *up = g + n, *down = g + 2 * n, *column = g + 3 * n;
    co_sparse_hessian hessian = variables_hessian(s);
    CHECK_TRUE(g);
    double whole = value(s, SMALL, g);
    const co_sheet sheet = sheet_of(s, SMALL);
    co_sheet_add_hessian(&sheet, s->x, &hessian);
    for (int i = 0; i < n; i++) {
        double at = s->z[i];
        s->z[i] = at + step;
        double above = value(s, SMALL, up);
        s->z[i] = at - step;
        double below = value(s, SMALL, down);
        s->z[i] = at;
        CHECK_NEAR(g[i], (above - below) / (2 * step), 1e-6 * whole);
        variables_hessian_column(&hessian, i, column);
        for (int j = 0; j < n; j++)
            CHECK_NEAR(column[j], (up[j] - down[j]) / (2 * step), 1e-6 * whole);
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

/* Where the sheet is compressed, the Hessian is above the function's, and positive. */
static void test_hessian_leaves_out_what_is_negative(void **state) {
    (void)state;
    variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), NULL, 0);
    const int n = s.dofs.n_variables;
    const double step = 1e-4;
    double *up = calloc(4 * (size_t)n, sizeof *up), *down = up + n, *column = down + n, *move = column + n;
    co_sparse_hessian hessian = variables_hessian(&s);
    const co_sheet sheet = sheet_of(&s, LARGE);
    int n_above = 0;
    CHECK_TRUE(up);
    value(&s, LARGE, NULL);
    co_sheet_add_hessian(&sheet, s.x, &hessian);
    for (int trial = 0; trial < 50; trial++) {
        double of_hessian = 0, of_differences = 0;
        for (int i = 0; i < n; i++)
            move[i] = sin(1 + i * (trial + 1.3));
        for (int side = -1; side <= 1; side += 2) {
            for (int i = 0; i < n; i++)
                s.z[i] += side * step * move[i];
            value(&s, LARGE, side > 0 ? up : down);
            for (int i = 0; i < n; i++)
                s.z[i] -= side * step * move[i];
        }
        for (int i = 0; i < n; i++) {
            of_differences += move[i] * (up[i] - down[i]) / (2 * step);
            variables_hessian_column(&hessian, i, column);
            for (int j = 0; j < n; j++)
                of_hessian += move[i] * column[j] * move[j];
        }
        CHECK_TRUE(of_hessian >= 0);
        CHECK_TRUE(of_hessian >= of_differences - 1e-4 * of_hessian);
        n_above += of_hessian > of_differences + 1e-3 * of_hessian;
    }
    CHECK_TRUE(n_above > 0);
    co_sparse_hessian_free(&hessian);
    free(up);
    variables_setting_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_value_is_the_sum_over_corners_that_move),
        cmocka_unit_test(test_faces_of_any_size_aim_at_regular_polygons),
        cmocka_unit_test(test_the_rest_square_is_a_part_of_an_even_cages_corner),
        cmocka_unit_test(test_faces_that_are_left_out_have_no_part),
        cmocka_unit_test(test_gradient_and_hessian_are_its_differences),
        cmocka_unit_test(test_hessian_leaves_out_what_is_negative),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
