/* Walls of corners, against their definition and its differences. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "variables_setting.h"

#include "base/vec3.h"
#include "hessian/corner_walls.h"

static const double WEIGHT = 3;

static void area_of(const cage *c, const double *x, int32_t h, int32_t n, int32_t k, double out[3]) {
    const double *o = x + 3 * c->vertices[h + k], *p = x + 3 * c->vertices[h + (k + 1) % n],
                 *q = x + 3 * c->vertices[h + (k + n - 1) % n];
    const double e[3] = {p[0] - o[0], p[1] - o[1], p[2] - o[2]}, f[3] = {q[0] - o[0], q[1] - o[1], q[2] - o[2]};
    co_cross3(e, f, out);
}

/* share [n_corners] of positions x; also, unless NULL, work [n_corners][3] = n A / A.A, what a_c counts by in it. */
static void shares_of(const cage *c, const double *x, double *share, double *by) {
    for (int32_t f = 0, h = 0; f < c->n_faces; h += c->sizes[f++]) {
        const int32_t n = c->sizes[f];
        double whole[3] = {0}, a[3];
        for (int32_t k = 0; k < n; k++) {
            area_of(c, x, h, n, k, a);
            for (int i = 0; i < 3; i++)
                whole[i] += a[i];
        }
        for (int32_t k = 0; k < n; k++) {
            area_of(c, x, h, n, k, a);
            share[h + k] = n * co_dot3(a, whole) / co_dot3(whole, whole);
            for (int i = 0; by && i < 3; i++)
                by[3 * (h + k) + i] = n * whole[i] / co_dot3(whole, whole);
        }
    }
}

static int32_t n_corners_of(const cage *c) {
    int32_t n = 0;
    for (int32_t f = 0; f < c->n_faces; f++)
        n += c->sizes[f];
    return n;
}

/* Walls of the positions s->x. */
static co_corner_walls walls_of(const variables_setting *s) {
    co_corner_walls walls;
    CHECK_INT(co_corner_walls_create(s->mesh, s->x, &walls, NULL), CURVOPT_OK);
    walls.cage = (co_cage_edges){.mesh = s->mesh, .dofs = &s->dofs};
    walls.weight = WEIGHT;
    return walls;
}

/* s->x moves away from where its corners have what they are to have: many are thin then, none is turned over. */
static void flatten(variables_setting *s, double amount) {
    for (int i = 0; i < s->dofs.n_variables; i++)
        s->z[i] += amount * sin(7 * i + 1);
    co_dof_map_expand(&s->dofs, s->z, s->x);
}

static void test_what_corners_may_have(void **state) {
    (void)state;
    variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.6), NULL, 0);
    const int32_t n = n_corners_of(&s.c);
    double *share = calloc((size_t)n, sizeof *share);
    CHECK_TRUE(share);
    co_corner_walls walls = walls_of(&s);
    shares_of(&s.c, s.x, share, NULL);
    int few = 0, many = 0;
    for (int32_t k = 0; k < n; k++) {
        few += share[k] < 0.05;
        many += share[k] > 1;
        CHECK_NEAR(walls.least[k], share[k] > 0.05 ? 0.6 * fmin(1, share[k]) : 0, 1e-12);
    }
    CHECK_TRUE(few > 0 && many > 0);
    free(share);
    co_corner_walls_free(&walls);
    variables_setting_free(&s);
}

static double sum_of_costs(const co_corner_walls *walls, int32_t n, const double *share, int *n_thin) {
    double sum = 0;
    *n_thin = 0;
    for (int32_t k = 0; k < n; k++) {
        const double t = walls->least[k] / share[k] - 1;
        sum += walls->least[k] > 0 && t > 0 ? WEIGHT * t * t * t : 0;
        *n_thin += walls->least[k] > 0 && t > 0;
    }
    return sum;
}

/* The value, its slope along a direction, and the form of the matrix on it: by differences in the shares, for the last
 * one in those with faces' areas as they are. */
static void check_setting(variables_setting *s) {
    const int32_t n = n_corners_of(&s->c), nv = 3 * s->c.n_vertices, nz = s->dofs.n_variables;
    const double h = 1e-6;
    co_corner_walls walls = walls_of(s);
    double *work = calloc((size_t)(6 * n + 3 * nv + 2 * nz), sizeof *work), *share = work, *above = share + n,
           *below = above + n, *by = below + n, *gradient = by + 3 * n, *up = gradient + nv, *down = up + nv,
           *v = down + nv, *column = v + nz;
    CHECK_TRUE(work);
    int n_thin = 0, other;
    double sum = 0;
    for (int k = 0; k < 500 && n_thin < 2; k++) {
        flatten(s, 0.02);
        shares_of(&s->c, s->x, share, by);
        sum = sum_of_costs(&walls, n, share, &n_thin);
    }
    CHECK_TRUE(n_thin > 1);
    CHECK_NEAR(co_corner_walls_value(&walls, s->x, gradient), sum, 1e-12 * sum);
    co_sparse_hessian hessian = variables_hessian(s);
    CHECK_INT(co_corner_walls_add_hessian(&walls, s->x, &hessian, NULL), CURVOPT_OK);
    double slope = 0, form = 0, wanted = 0;
    for (int i = 0; i < nz; i++)
        v[i] = sin(3 * i + 1);
    for (int i = 0; i < nz; i++)
        s->z[i] += h * v[i];
    co_dof_map_expand(&s->dofs, s->z, up);
    for (int i = 0; i < nz; i++)
        s->z[i] -= 2 * h * v[i];
    co_dof_map_expand(&s->dofs, s->z, down);
    shares_of(&s->c, up, above, NULL);
    shares_of(&s->c, down, below, NULL);
    for (int i = 0; i < nv; i++)
        slope += gradient[i] * (up[i] - down[i]) / (2 * h);
    const double difference =
        (sum_of_costs(&walls, n, above, &other) - sum_of_costs(&walls, n, below, &other)) / (2 * h);
    CHECK_NEAR(slope, difference, 1e-6 * fabs(difference));
    for (int32_t f = 0, first = 0; f < s->c.n_faces; first += s->c.sizes[f++])
        for (int32_t k = 0; k < s->c.sizes[f]; k++) {
            const double least = walls.least[first + k], r = share[first + k], t = least / r - 1;
            double a[3], b[3];
            if (!(least > 0 && t > 0))
                continue;
            area_of(&s->c, up, first, s->c.sizes[f], k, a);
            area_of(&s->c, down, first, s->c.sizes[f], k, b);
            const double change = (co_dot3(a, by + 3 * (first + k)) - co_dot3(b, by + 3 * (first + k))) / (2 * h);
            wanted += WEIGHT * (6 * t * least * least / pow(r, 4) + 6 * t * t * least / pow(r, 3)) * change * change;
        }
    for (int j = 0; j < nz; j++) {
        variables_hessian_column(&hessian, j, column);
        for (int i = 0; i < nz; i++)
            form += v[i] * column[i] * v[j];
    }
    CHECK_TRUE(wanted > 0);
    CHECK_NEAR(form, wanted, 1e-6 * wanted);
    co_sparse_hessian_free(&hessian);
    co_corner_walls_free(&walls);
    free(work);
}

static void test_value_gradient_and_matrix(void **state) {
    (void)state;
    static const int32_t some[3] = {0, 9, 14}, freedom[3] = {0, 1, 2};
    static const double direction[9] = {0, 0, 0, 1, 2, 3, 0, 1, -1};
    const curvopt_constraints pins = {.vertices = some, .n = 3, .freedom = freedom, .directions = direction};
    for (int k = 0; k < 4; k++) { /* plain; held; with nodes of several vertices; a prism */
        variables_setting s = variables_setting_of(k == 3   ? cage_prism(5)
                                                   : k == 2 ? cage_torus(8, 4, 3, 1.2)
                                                            : cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1),
                                                   k == 1 ? &pins : NULL, k == 2);
        if (k == 3)
            for (int i = 0; i < s.dofs.n_variables; i++)
                s.z[i] += 0.1 * sin(5 * i + 2);
        check_setting(&s);
        variables_setting_free(&s);
    }
}

/* Neither size nor place counts. What has turned over costs more than anything, until walls are weighed: then it has
 * none any more. */
static void test_corners_that_turn_over(void **state) {
    (void)state;
    variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), NULL, 0);
    co_corner_walls walls = walls_of(&s);
    flatten(&s, 0.08);
    const double before = co_corner_walls_value(&walls, s.x, NULL);
    for (int i = 0; i < 3 * s.c.n_vertices; i++)
        s.x[i] = 1e-3 * s.x[i] + i % 3;
    CHECK_NEAR(co_corner_walls_value(&walls, s.x, NULL), before, 1e-6 * before);
    const int32_t *v = s.c.vertices; /* the first corner beyond the middle of the face's diagonal */
    for (int i = 0; i < 3; i++)
        s.x[3 * v[0] + i] += 0.9 * (s.x[3 * v[2] + i] - s.x[3 * v[0] + i]);
    CHECK_TRUE(isinf(co_corner_walls_value(&walls, s.x, NULL)));
    co_corner_walls_weigh(&walls, s.x, WEIGHT * n_corners_of(&s.c));
    CHECK_NEAR(walls.weight, WEIGHT, 1e-15);
    CHECK_TRUE(walls.least[0] == 0 && isfinite(co_corner_walls_value(&walls, s.x, NULL)));
    co_corner_walls_free(&walls);
    variables_setting_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_corners_may_have),
        cmocka_unit_test(test_value_gradient_and_matrix),
        cmocka_unit_test(test_corners_that_turn_over),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
