/* Walls of corners, against their definition and its differences. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "variables_setting.h"

#include "base/vec3.h"
#include "hessian/corner_walls.h"

static const double WEIGHT = 3;

static int32_t n_corners_of(const cage *c) {
    int32_t n = 0;
    for (int32_t f = 0; f < c->n_faces; f++)
        n += c->sizes[f];
    return n;
}

/* share [n_corners] of the faces of cage x. */
static void shares_of(const variables_setting *s, const double *x, double *share) {
    const cage *c = &s->c;
    for (int32_t f = 0, h = 0; f < c->n_faces; h += c->sizes[f++]) {
        const int32_t n = c->sizes[f];
        double a[16][3], whole[3] = {0};
        for (int32_t k = 0; k < n; k++) {
            const double *o = x + 3 * c->vertices[h + k], *p = x + 3 * c->vertices[h + (k + 1) % n],
                         *q = x + 3 * c->vertices[h + (k + n - 1) % n];
            const double e[3] = {p[0] - o[0], p[1] - o[1], p[2] - o[2]}, g[3] = {q[0] - o[0], q[1] - o[1], q[2] - o[2]};
            co_cross3(e, g, a[k]);
            for (int i = 0; i < 3; i++)
                whole[i] += a[k][i];
        }
        for (int32_t k = 0; k < n; k++)
            share[h + k] = n * co_dot3(a[k], whole) / co_dot3(whole, whole);
    }
}

/* Of one corner: t^3, and below a tenth of the least share the cube of t's tangent there. */
static double cost_of(double least, double share) {
    const double low = 0.1 * least,
                 t = share > low ? least / share - 1 : least / low - 1 - least / (low * low) * (share - low);
    return least > 0 && t > 0 ? WEIGHT * t * t * t : 0;
}

static double sum_of_costs(const co_corner_walls *walls, int32_t n, const double *share, int *n_thin) {
    double sum = 0;
    *n_thin = 0;
    for (int32_t k = 0; k < n; k++) {
        const double cost = cost_of(walls->least[k], share[k]);
        sum += cost;
        *n_thin += cost > 0;
    }
    return sum;
}

/* Walls of the cage s->x. */
static co_corner_walls walls_of(const variables_setting *s) {
    co_corner_walls walls;
    CHECK_INT(co_corner_walls_create(s->mesh, NULL, s->x, &walls, NULL), CURVOPT_OK);
    walls.cage = (co_cage_edges){.mesh = s->mesh, .dofs = &s->dofs};
    walls.weight = WEIGHT;
    return walls;
}

/* The k-th of many moves, each another way. */
static void move(variables_setting *s, int k, double amount) {
    for (int i = 0; i < s->dofs.n_variables; i++)
        s->z[i] += amount * sin(7 * i + 1 + k * (i % 5));
    co_dof_map_expand(&s->dofs, s->z, s->x);
}

static void test_what_corners_may_have(void **state) {
    (void)state;
    variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 2), NULL, 0);
    const int32_t n = n_corners_of(&s.c);
    double *share = calloc((size_t)n, sizeof *share);
    CHECK_TRUE(share);
    co_corner_walls walls = walls_of(&s);
    shares_of(&s, s.x, share);
    int few = 0, many = 0;
    for (int32_t k = 0; k < n; k++) {
        few += share[k] < 0.05;
        many += share[k] > 1;
        CHECK_NEAR(walls.least[k], share[k] > 0.05 ? 0.6 * fmin(1, share[k]) : 0, 1e-12);
    }
    CHECK_TRUE(few > 0 && many > 0);
    uint8_t *left_out = calloc((size_t)s.c.n_faces, 1);
    co_corner_walls some;
    CHECK_TRUE(left_out);
    left_out[1] = 1;
    CHECK_INT(co_corner_walls_create(s.mesh, left_out, s.x, &some, NULL), CURVOPT_OK);
    for (int32_t k = 0; k < n; k++)
        CHECK_NEAR(some.least[k], k / 4 == 1 ? 0 : walls.least[k], 0);
    co_corner_walls_free(&some);
    free(left_out);
    CHECK_TRUE(co_corner_walls_value(&walls, s.x, NULL) == 0); /* where they begin nothing is too thin */
    free(share);
    co_corner_walls_free(&walls);
    variables_setting_free(&s);
}

/* The value; its slope along a direction, by differences; and the form of the matrix on it, by differences of the
 * costs in the shares and of the shares in the variables. Corners are moved until so many are thin, or any is below. */
static void check_setting(variables_setting *s, int most_thin, double below) {
    const int32_t n = n_corners_of(&s->c), nv = 3 * s->c.n_vertices, nz = s->dofs.n_variables;
    const double h = 1e-6;
    co_corner_walls walls = walls_of(s);
    double *work = calloc(3 * (size_t)n + 3 * (size_t)nv + 2 * (size_t)nz, sizeof *work), *share = work,
           *above = share + n, *under = above + n, *gradient = under + n, *up = gradient + nv, *down = up + nv,
           *v = down + nv, *column = v + nz;
    CHECK_TRUE(work);
    int n_thin = 0, other;
    double sum = 0, least = 1;
    for (int k = 0; k < 2000 && (n_thin < most_thin || least > below); k++) {
        move(s, k, 0.05);
        shares_of(s, s->x, share);
        sum = sum_of_costs(&walls, n, share, &n_thin);
        least = 1;
        for (int32_t c = 0; c < n; c++)
            least = walls.least[c] > 0 ? fmin(least, share[c] / walls.least[c]) : least;
    }
    CHECK_TRUE(n_thin >= most_thin && least <= below);
    CHECK_NEAR(co_corner_walls_value(&walls, s->x, gradient), sum, 1e-10 * sum);
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
    shares_of(s, up, above);
    shares_of(s, down, under);
    for (int i = 0; i < nv; i++)
        slope += gradient[i] * (up[i] - down[i]) / (2 * h);
    const double difference =
        (sum_of_costs(&walls, n, above, &other) - sum_of_costs(&walls, n, under, &other)) / (2 * h);
    CHECK_NEAR(slope, difference, 1e-5 * fabs(difference));
    for (int32_t c = 0; c < n; c++) {
        const double w = walls.least[c], d = 1e-4 * w,
                     bend = (cost_of(w, share[c] + d) + cost_of(w, share[c] - d) - 2 * cost_of(w, share[c])) / (d * d),
                     change = (above[c] - under[c]) / (2 * h);
        wanted += w > 0 ? bend * change * change : 0;
    }
    for (int j = 0; j < nz; j++) {
        variables_hessian_column(&hessian, j, column);
        for (int i = 0; i < nz; i++)
            form += v[i] * column[i] * v[j];
    }
    CHECK_TRUE(wanted > 0);
    CHECK_NEAR(form, wanted, 1e-3 * wanted);
    co_sparse_hessian_free(&hessian);
    co_corner_walls_free(&walls);
    free(work);
}

static void test_value_gradient_and_matrix(void **state) {
    (void)state;
    static const int32_t some[3] = {0, 9, 14}, freedom[3] = {0, 1, 2};
    static const double direction[9] = {0, 0, 0, 1, 2, 3, 0, 1, -1};
    const curvopt_constraints pins = {.vertices = some, .n = 3, .freedom = freedom, .directions = direction};
    for (int k = 0; k < 5; k++) { /* plain; held; with nodes of several vertices; a prism; with a corner turned over */
        variables_setting s = variables_setting_of(k == 3   ? cage_prism(5)
                                                   : k == 2 ? cage_torus(8, 4, 3, 1.2)
                                                            : cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1),
                                                   k == 1 ? &pins : NULL, k == 2);
        if (k == 3)
            for (int i = 0; i < s.dofs.n_variables; i++)
                s.z[i] += 0.1 * sin(5 * i + 2);
        check_setting(&s, 2, k == 4 ? -0.05 : 0.99);
        variables_setting_free(&s);
    }
}

/* Neither size nor place counts. Walls that are weighed where corners have turned over do not drown the rest. */
static void test_size_and_weight(void **state) {
    (void)state;
    variables_setting s = variables_setting_of(cage_shaken(cage_torus(8, 4, 3, 1.2), 0.1), NULL, 0);
    co_corner_walls walls = walls_of(&s);
    const int32_t n = n_corners_of(&s.c);
    co_corner_walls_weigh(&walls, s.x, WEIGHT * n);
    CHECK_NEAR(walls.weight, WEIGHT, 1e-15);
    double before = 0;
    for (int k = 0; k < 500 && !(before > 0); k++) {
        move(&s, k, 0.05);
        before = co_corner_walls_value(&walls, s.x, NULL);
    }
    CHECK_TRUE(before > 0);
    for (int i = 0; i < 3 * s.c.n_vertices; i++)
        s.x[i] = 1e-3 * s.x[i] + i % 3;
    CHECK_NEAR(co_corner_walls_value(&walls, s.x, NULL), before, 1e-6 * before);
    for (int i = 0; i < 3 * s.c.n_vertices; i++)
        s.x[i] += 0.01 * sin(7 * i);
    CHECK_TRUE(co_corner_walls_value(&walls, s.x, NULL) > 100 * WEIGHT * n);
    co_corner_walls_weigh(&walls, s.x, WEIGHT * n);
    CHECK_NEAR(co_corner_walls_value(&walls, s.x, NULL), 100 * WEIGHT * n, 1e-9 * WEIGHT * n);
    co_corner_walls_free(&walls);
    variables_setting_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_corners_may_have),
        cmocka_unit_test(test_value_gradient_and_matrix),
        cmocka_unit_test(test_size_and_weight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
