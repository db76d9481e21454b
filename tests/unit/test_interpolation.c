/* Vertices given by their limit points: masks, the map and its inverse, and the patches that it changes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "constraints/given_constraints.h"
#include "constraints/interpolation.h"
#include "energy/assembly_sums.h"
#include "hessian/sparse_hessian.h"
#include "mesh/crease.h"
#include "mesh/subdivide.h"
#include "surface/vertex_mask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct point_sum {
    const double *xyz;
    double at[3];
} point_sum;

static void add(int32_t vertex, double weight, void *context) {
    point_sum *sum = context;
    for (int c = 0; c < 3; c++)
        sum->at[c] += weight * sum->xyz[3 * vertex + c];
}

static point_sum limit_of(const curvopt_mesh *m, int32_t v, const double *xyz) {
    point_sum sum = {.xyz = xyz};
    co_vertex_mask_visit(m, v, add, &sum);
    return sum;
}

static void check_same(const point_sum *a, const double b[3]) {
    for (int k = 0; k < 3; k++)
        CHECK_NEAR(a->at[k], b[k], 1e-14);
}

/* After one subdivision a vertex is where that puts it, after more where the finer cage's is after one less. */
static void check_after(const curvopt_mesh *mesh, const curvopt_mesh *fine, int32_t v, const double *xyz,
                        const double *fine_xyz) {
    for (int32_t n = 1; n <= 5; n++) {
        point_sum coarse = {.xyz = xyz}, finer = {.xyz = fine_xyz};
        co_vertex_mask_visit_after(mesh, v, n, add, &coarse);
        co_vertex_mask_visit_after(fine, v, n - 1, add, &finer);
        check_same(&coarse, finer.at);
        if (n == 1)
            check_same(&coarse, fine_xyz + 3 * v);
    }
}

/* A limit point is that of the subdivided cage, too. Which vertices have masks: all but without[]. */
static void check_masks(cage c, const curvopt_creases *creases, int32_t n_without, const int32_t *without) {
    curvopt_mesh *mesh = cage_mesh(&c), *fine;
    co_sparse_rows rows;
    curvopt_error error;
    if (creases)
        CHECK_OK(co_crease_set(mesh, creases, &error), &error);
    CHECK_OK(co_subdivide(mesh, &fine, &rows, &error), &error);
    double *xyz = calloc(3 * (size_t)rows.n_rows, sizeof *xyz);
    CHECK_TRUE(xyz != NULL);
    co_sparse_rows_apply(&rows, c.xyz, xyz);
    for (int32_t v = 0; v < c.n_vertices; v++) {
        int expected = 1;
        for (int32_t i = 0; i < n_without; i++)
            expected &= without[i] != v;
        CHECK_INT(co_vertex_mask_exists(mesh, v), expected);
        if (!expected)
            continue;
        const point_sum coarse = limit_of(mesh, v, c.xyz), finer = limit_of(fine, v, xyz);
        check_same(&coarse, finer.at);
        check_after(mesh, fine, v, c.xyz, xyz);
    }
    free(xyz);
    co_sparse_rows_free(&rows);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_masks_follow_subdivision(void **state) {
    (void)state;
    const int32_t edge[4] = {0, 1, 1, 5}, fading[2] = {0, 1}, lone[2] = {0, 1};
    const double sharp[2] = {10, 10}, soft[1] = {2}, one[1] = {10}, corner_sharpness[1] = {10};
    const int32_t corner[1] = {1}, ends[2] = {0, 1}, crease_ends[2] = {0, 5};
    check_masks(cage_shaken(cage_tetrahedron(), 0.1), NULL, 0, NULL);
    check_masks(cage_shaken(cage_torus(5, 4, 1, 0.4), 0.05), NULL, 0, NULL);
    check_masks(cage_shaken(cage_prism(7), 0.1), NULL, 0, NULL);
    check_masks(cage_shaken(cage_trapezohedron(9), 0.05), NULL, 0, NULL);
    check_masks(cage_shaken(cage_half_star(3, 4), 0.02), NULL, 0, NULL); /* with a boundary */
    check_masks(cage_shaken(cage_cube(), 0.1),
                &(curvopt_creases){.crease_vertices = edge, .crease_sharpness = sharp, .n_creases = 2}, 2, crease_ends);
    check_masks(cage_shaken(cage_cube(), 0.1),
                &(curvopt_creases){.crease_vertices = fading, .crease_sharpness = soft, .n_creases = 1}, 2, ends);
    check_masks(cage_shaken(cage_cube(), 0.1),
                &(curvopt_creases){.crease_vertices = lone, .crease_sharpness = one, .n_creases = 1}, 2, ends);
    check_masks(cage_shaken(cage_cube(), 0.1),
                &(curvopt_creases){.corner_vertices = corner, .corner_sharpness = corner_sharpness, .n_corners = 1}, 0,
                NULL);
}

/* A cage with held limit points. */
typedef struct setting {
    cage c;
    curvopt_mesh *mesh;
    co_constraints held;
    co_interpolation map;
} setting;

static setting setting_of(cage c, int32_t n, const int32_t *vertices) {
    setting s = {.c = c, .mesh = cage_mesh(&c)};
    curvopt_error error;
    int32_t *freedom = malloc((size_t)n * sizeof *freedom);
    CHECK_TRUE(freedom != NULL);
    for (int32_t i = 0; i < n; i++)
        freedom[i] = CURVOPT_FREEDOM_OF_LIMIT_POINT;
    const curvopt_constraints wanted = {.vertices = vertices, .freedom = freedom, .n = n};
    CHECK_OK(co_given_constraints_create(s.mesh, c.xyz, &wanted, &s.held, &error), &error);
    CHECK_OK(co_interpolation_create(s.mesh, &s.held, &s.map, &error), &error);
    free(freedom);
    return s;
}

static void setting_free(setting *s) {
    co_interpolation_free(&s->map);
    co_constraints_free(&s->held);
    curvopt_mesh_destroy(s->mesh);
    cage_free(&s->c);
}

static void test_map_and_its_inverse(void **state) {
    (void)state;
    const int32_t touching[7] = {0, 1, 2, 4, 5, 13, 20};
    setting s = setting_of(cage_shaken(cage_torus(6, 4, 1, 0.4), 0.05), 7, touching);
    double xyz[72], back[72];
    CHECK_INT(s.map.limit.n_rows, 7);
    memcpy(xyz, s.c.xyz, sizeof xyz);
    co_interpolation_from_cage(&s.map, xyz);
    for (int32_t v = 0; v < 24; v++) {
        const point_sum limit = limit_of(s.mesh, v, s.c.xyz);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(xyz[3 * v + c], s.held.of_limit[v] ? limit.at[c] : s.c.xyz[3 * v + c], 1e-15);
    }
    memcpy(back, xyz, sizeof back);
    co_interpolation_to_cage(&s.map, back);
    for (int i = 0; i < 72; i++)
        CHECK_NEAR(back[i], s.c.xyz[i], 1e-13);
    setting_free(&s);
}

/* Where nothing in the masks can move, the vertices are held themselves. */
static void test_what_cannot_move_is_no_unknown(void **state) {
    (void)state;
    int32_t all[24];
    for (int32_t v = 0; v < 24; v++)
        all[v] = v;
    setting s = setting_of(cage_torus(6, 4, 1, 0.4), 24, all);
    CHECK_INT(s.map.limit.n_rows, 0);
    CHECK_INT(s.held.of_limit[5], 0);
    CHECK_INT(s.held.freedom[5], CO_FREEDOM_NONE);
    setting_free(&s);
}

static void test_too_many_that_touch_are_refused(void **state) {
    (void)state;
    enum { N = 40 * 40, FREE = 10 };
    cage c = cage_torus(40, 40, 1, 0.4);
    curvopt_mesh *mesh = cage_mesh(&c);
    co_constraints held = {0};
    co_interpolation map;
    curvopt_error error;
    int32_t vertices[N], freedom[N];
    for (int32_t v = 0; v < N - FREE; v++) {
        vertices[v] = v;
        freedom[v] = CURVOPT_FREEDOM_OF_LIMIT_POINT;
    }
    const curvopt_constraints wanted = {.vertices = vertices, .freedom = freedom, .n = N - FREE};
    CHECK_OK(co_given_constraints_create(mesh, c.xyz, &wanted, &held, &error), &error);
    CHECK_REFUSED(co_interpolation_create(mesh, &held, &map, &error), &error, CURVOPT_ERROR_ARGUMENT, N - FREE,
                  "limit points of 1590 vertices that touch each other");
    CHECK_TRUE(map.vertex == NULL);
    co_constraints_free(&held);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_places_are_read_where_the_caller_has_them(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_error error;
    const int32_t vertex = 3;
    const double place[3] = {2, 3, 4};
    for (int32_t has = 0; has < 2; has++) {
        co_constraints held = {0};
        const curvopt_constraints wanted = {.vertices = &vertex, .n = 1, .has_places = has, .places = place};
        CHECK_OK(co_given_constraints_create(mesh, c.xyz, &wanted, &held, &error), &error);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(held.anchor[3 * vertex + k], has ? place[k] : c.xyz[3 * vertex + k], 0);
        co_constraints_free(&held);
    }
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_bad_constraints_are_refused(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&c);
    co_constraints held = {0};
    curvopt_error error;
    const int32_t vertices[2] = {3, 3}, of_limit[2] = {4, 4}, both[2] = {4, 0}, beyond[1] = {7};
    const double half[1] = {0.5}, sharpness[1] = {2};
    const int32_t edge[2] = {3, 1};
    curvopt_constraints wanted = {.vertices = vertices, .freedom = of_limit, .n = 1, .weights = half};
    CHECK_REFUSED(co_given_constraints_create(mesh, c.xyz, &wanted, &held, &error), &error, CURVOPT_ERROR_ARGUMENT, 0,
                  "limit point of vertex 3 has the weight 0.5; it must be 1");
    wanted = (curvopt_constraints){.vertices = vertices, .freedom = both, .n = 2};
    CHECK_REFUSED(co_given_constraints_create(mesh, c.xyz, &wanted, &held, &error), &error, CURVOPT_ERROR_ARGUMENT, 1,
                  "two constraints that contradict");
    wanted = (curvopt_constraints){.vertices = vertices, .freedom = beyond, .n = 1};
    CHECK_REFUSED(co_given_constraints_create(mesh, c.xyz, &wanted, &held, &error), &error, CURVOPT_ERROR_ARGUMENT, 0,
                  "leaves vertex 3 7 dimensions");
    CHECK_OK(co_crease_set(mesh,
                           &(curvopt_creases){.crease_vertices = edge, .crease_sharpness = sharpness, .n_creases = 1},
                           &error),
             &error);
    wanted = (curvopt_constraints){.vertices = vertices, .freedom = of_limit, .n = 1};
    CHECK_REFUSED(co_given_constraints_create(mesh, c.xyz, &wanted, &held, &error), &error, CURVOPT_ERROR_ARGUMENT, 0,
                  "limit point of vertex 3, where a crease fades");
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Value, gradient [3 n] and the Hessian's product with d [3 n] of a cage, or of positions that stand for one. */
static double energy(setting *s, const co_substitution *substitution, double *xyz, const double *d, double *gradient,
                     double *product) {
    curvopt_options o;
    curvopt_error error;
    co_assembly assembly;
    co_basis_table_cache tables;
    co_dof_map all;
    co_sparse_hessian hessian;
    co_values values;
    curvopt_options_init(&o, sizeof o);
    o.surface = CURVOPT_SURFACE_POLYNOMIAL;
    o.threads = 1;
    const size_t n = 3 * (size_t)s->c.n_vertices;
    co_basis_table_cache_create(o.surface, &tables);
    CHECK_OK(co_assembly_create(s->mesh, s->c.xyz, substitution, &o, &tables, NULL, &assembly, &error), &error);
    co_assembly_evaluate(&assembly, xyz, &(co_request){.gradient = gradient}, &values);
    CHECK_OK(co_dof_map_identity(s->c.n_vertices, &all, &error), &error);
    CHECK_OK(co_sparse_hessian_create(&assembly, &all, NULL, &hessian, &error), &error);
    const co_second_kind kind = {.exact = 1};
    CHECK_OK(co_sparse_hessian_assemble(&assembly, xyz, &kind, &hessian, &error), &error);
    memset(product, 0, n * sizeof *product);
    for (int32_t j = 0; j < (int32_t)n; j++)
        for (int32_t e = hessian.pattern.column_start[j]; e < hessian.pattern.column_start[j + 1]; e++) {
            const int32_t i = hessian.pattern.row[e];
            product[i] += hessian.value[e] * d[j];
            product[j] += i == j ? 0 : hessian.value[e] * d[i];
        }
    co_sparse_hessian_free(&hessian);
    co_dof_map_free(&all);
    co_assembly_free(&assembly);
    co_basis_table_cache_free(&tables);
    return values.objective;
}

/* x = S y: the value is the same, the gradient is S^T g, the Hessian S^T H S. */
static void check_substitution(cage c, int32_t n, const int32_t *vertices) {
    setting s = setting_of(c, n, vertices);
    const size_t size = 3 * (size_t)c.n_vertices;
    double *work = calloc(8 * size, sizeof *work), *y = work, *d = y + size, *moved = d + size, *g = moved + size,
           *product = g + size, *g_y = product + size, *product_y = g_y + size, scale = 0, scale_2 = 0;
    uint64_t seed = 7;
    CHECK_TRUE(work != NULL);
    memcpy(y, c.xyz, size * sizeof *y);
    co_interpolation_from_cage(&s.map, y);
    for (size_t i = 0; i < size; i++)
        moved[i] = d[i] = check_random(&seed);
    co_interpolation_to_cage(&s.map, moved); /* S d */
    const co_substitution substitution = {s.map.vertex, &s.map.cage};
    const double value = energy(&s, NULL, c.xyz, moved, g, product),
                 value_y = energy(&s, &substitution, y, d, g_y, product_y);
    CHECK_NEAR(value_y, value, 1e-11 * value);
    for (size_t i = 0; i < size; i++) {
        scale = fmax(scale, fabs(g[i]));
        scale_2 = fmax(scale_2, fabs(product[i]));
    }
    for (int which = 0; which < 2; which++) { /* S^T */
        double *at = which ? product : g, held[3 * 16];
        CHECK_TRUE(n <= 16);
        for (int32_t i = 0; i < n; i++)
            for (int k = 0; k < 3; k++) {
                held[3 * i + k] = at[3 * s.map.vertex[i] + k];
                at[3 * s.map.vertex[i] + k] = 0;
            }
        co_sparse_rows_add_transposed(&s.map.cage, held, at);
    }
    for (size_t i = 0; i < size; i++) {
        CHECK_NEAR(g_y[i], g[i], 1e-10 * scale);
        CHECK_NEAR(product_y[i], product[i], 1e-9 * scale_2);
    }
    free(work);
    setting_free(&s);
}

static void test_energies_are_those_of_the_cage(void **state) {
    (void)state;
    const int32_t some[4] = {0, 1, 5, 14}, two[2] = {1, 3}, poles[3] = {0, 1, 4}, far[2] = {2, 30};
    check_substitution(cage_shaken(cage_torus(6, 4, 1, 0.4), 0.05), 4, some);
    check_substitution(cage_shaken(cage_tetrahedron(), 0.1), 2, two);           /* derived points */
    check_substitution(cage_shaken(cage_prism(9), 0.05), 3, poles);             /* discs of these */
    check_substitution(cage_refined(cage_shaken(cage_cube(), 0.1), 3), 2, far); /* wide discs */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_masks_follow_subdivision),
        cmocka_unit_test(test_map_and_its_inverse),
        cmocka_unit_test(test_what_cannot_move_is_no_unknown),
        cmocka_unit_test(test_too_many_that_touch_are_refused),
        cmocka_unit_test(test_places_are_read_where_the_caller_has_them),
        cmocka_unit_test(test_bad_constraints_are_refused),
        cmocka_unit_test(test_energies_are_those_of_the_cage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
