/* Soft constraints: stiffness by weight and patch, and its distribution over a subdivision.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "constraints/soft_constraints.h"
#include "mesh/subdivide.h"

enum { N_U = 8, N_V = 8, N = N_U * N_V };

typedef struct setting {
    cage c;
    curvopt_mesh *mesh;
    double weight[N], direction[3 * N];
    uint8_t freedom[N];
    co_soft_constraints springs;
} setting;

static void set_up(setting *s) {
    *s = (setting){.c = cage_torus(N_U, N_V, 2, 1)};
    s->mesh = cage_mesh(&s->c);
}

static void create(setting *s) {
    curvopt_error error;
    CHECK_OK(co_soft_constraints_create(s->mesh, s->c.xyz, s->weight, s->freedom, s->direction, &s->springs, &error),
             &error);
}

static void tear_down(setting *s) {
    co_soft_constraints_free(&s->springs);
    curvopt_mesh_destroy(s->mesh);
    cage_free(&s->c);
}

static int32_t vertex(int u, int v) {
    return N_V * u + v;
}

/* Besides those that are there. */
static void test_all_vertices_are_pulled_back(void **state) {
    (void)state;
    setting s;
    curvopt_error error;
    double more[N];
    set_up(&s);
    s.weight[vertex(0, 0)] = s.weight[vertex(4, 4)] = 0.5;
    s.freedom[vertex(4, 4)] = 2;
    s.direction[3 * vertex(4, 4)] = 1;
    create(&s);
    assert_false(co_soft_constraints_has_end(&s.springs, vertex(0, 0)));
    for (int v = 0; v < N; v++)
        more[v] = 1 + v;
    CHECK_OK(co_soft_constraints_add_all(s.mesh, s.c.xyz, more, 0.25, &s.springs, &error), &error);
    for (int v = 0; v < N; v++) {
        int slides = v == vertex(4, 4), had = v == vertex(0, 0);
        CHECK_NEAR(s.springs.stiffness[v], slides ? 1 : more[v] + had, 1e-14);
        CHECK_INT(s.springs.freedom[v], slides ? 2 : 0);
        CHECK_INT(co_soft_constraints_has_end(&s.springs, v), !slides);
    }
    CHECK_NEAR(s.springs.reach, 0.25, 0);
    tear_down(&s);
}

/* Two patches, of vertices (0..2, 0..1) and (5, 5), (5, 6), the second one with an exact constraint in it. */
static void test_a_patch_is_one_handle(void **state) {
    (void)state;
    setting s;
    set_up(&s);
    for (int u = 0; u < 3; u++)
        for (int v = 0; v < 2; v++)
            s.weight[vertex(u, v)] = 0.5;
    s.weight[vertex(1, 1)] = 0.8;
    s.weight[vertex(5, 5)] = 0.25;
    s.weight[vertex(5, 6)] = 1;
    create(&s);
    const double mass = 0.8 / (5 * 0.5 + 0.8);
    CHECK_NEAR(s.springs.stiffness[vertex(0, 0)], mass * 0.5 / 0.5, 1e-15);
    CHECK_NEAR(s.springs.stiffness[vertex(1, 1)], mass * 0.8 / 0.2, 1e-14);
    CHECK_NEAR(s.springs.stiffness[vertex(5, 5)], 1 / 1.25 * 0.25 / 0.75, 1e-15);
    CHECK_NEAR(s.springs.stiffness[vertex(5, 6)], 0, 0);
    CHECK_NEAR(s.springs.stiffness[vertex(4, 4)], 0, 0);
    CHECK_NEAR(s.springs.anchor[3 * vertex(1, 1)], s.c.xyz[3 * vertex(1, 1)], 0);
    tear_down(&s);
}

static void test_alike(void **state) {
    (void)state;
    setting s;
    set_up(&s);
    s.weight[0] = s.weight[1] = s.weight[2] = 0.5;
    s.weight[3] = 0.25;
    s.freedom[2] = CO_FREEDOM_LINE;
    s.freedom[10] = CO_FREEDOM_PLANE;
    CHECK_INT(co_soft_constraints_alike(&s.springs, 0, 3), 1); /* there are none */
    create(&s);
    CHECK_INT(co_soft_constraints_alike(&s.springs, 0, 1), 1);
    CHECK_INT(co_soft_constraints_alike(&s.springs, 0, 2), 0);   /* another freedom */
    CHECK_INT(co_soft_constraints_alike(&s.springs, 0, 3), 0);   /* another stiffness */
    CHECK_INT(co_soft_constraints_alike(&s.springs, 10, 20), 1); /* freedoms without springs do not count */
    CHECK_TRUE(s.springs.stiffness != NULL);
    if (!s.springs.stiffness)
        return;
    s.springs.stiffness[1] *= 1 + 1e-12;
    CHECK_INT(co_soft_constraints_alike(&s.springs, 0, 1), 1);
    s.springs.stiffness[1] *= 1 + 1e-6;
    CHECK_INT(co_soft_constraints_alike(&s.springs, 0, 1), 0);
    tear_down(&s);
}

/* A patch of 3 x 3 vertices, 4 faces, of one kind; a vertex alone; and in the patch's other row a face of two kinds. */
static void test_subdivision_distributes_the_stiffness(void **state) {
    (void)state;
    setting s;
    curvopt_mesh *fine;
    co_sparse_rows rows;
    curvopt_error error;
    set_up(&s);
    for (int u = 0; u < 3; u++)
        for (int v = 0; v < 3; v++)
            s.weight[vertex(u, v)] = 0.5;
    s.weight[vertex(6, 6)] = 0.5;
    create(&s);
    double before = 0, after = 0, k = s.springs.stiffness[vertex(1, 1)], alone = s.springs.stiffness[vertex(6, 6)];
    for (int32_t v = 0; v < N; v++)
        before += s.springs.stiffness[v];
    CHECK_OK(co_subdivide(s.mesh, &fine, &rows, &error), &error);
    CHECK_OK(co_soft_constraints_subdivide(s.mesh, fine, &rows, &s.springs, &error), &error);
    int n_springs = 0;
    for (int32_t v = 0; v < fine->info.n_vertices; v++) {
        after += s.springs.stiffness[v];
        n_springs += s.springs.stiffness[v] > 0;
        if (s.springs.stiffness[v] > 0 && v != vertex(6, 6)) /* to where the input is after subdivision */
            CHECK_NEAR(s.springs.anchor[3 * v + 1], s.springs.original[3 * v + 1], 0);
    }
    CHECK_NEAR(after, before, 1e-14 * before);
    CHECK_INT(n_springs, 25 + 1);
    CHECK_NEAR(s.springs.stiffness[vertex(1, 1)], k / 4, 1e-15);
    CHECK_NEAR(s.springs.stiffness[vertex(0, 0)], k / 4, 1e-15); /* a quarter of what its one face gets */
    CHECK_NEAR(s.springs.stiffness[vertex(6, 6)], alone, 0);
    CHECK_NEAR(s.springs.anchor[3 * vertex(6, 6)], s.c.xyz[3 * vertex(6, 6)], 0);
    co_sparse_rows_free(&rows);
    curvopt_mesh_destroy(fine);
    tear_down(&s);
}

/* Faces whose lines differ are no piece of surface: every vertex keeps its spring. */
static void test_faces_of_several_kinds_keep_their_springs(void **state) {
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        setting s;
        curvopt_mesh *fine;
        co_sparse_rows rows;
        curvopt_error error;
        int n_springs = 0;
        set_up(&s);
        for (int32_t v = 0; v < N; v++) {
            s.freedom[v] = CO_FREEDOM_LINE;
            s.direction[3 * v + 2] = 1;
        }
        for (int k = 0; k < 4; k++)
            s.weight[vertex(k / 2, k % 2)] = 0.5;
        if (kind == 1) /* another freedom at one corner */
            s.freedom[vertex(1, 1)] = CO_FREEDOM_PLANE;
        if (kind == 2) { /* another direction at one corner */
            s.direction[3 * vertex(1, 1)] = 0.6;
            s.direction[3 * vertex(1, 1) + 2] = 0.8;
        }
        create(&s);
        CHECK_OK(co_subdivide(s.mesh, &fine, &rows, &error), &error);
        CHECK_OK(co_soft_constraints_subdivide(s.mesh, fine, &rows, &s.springs, &error), &error);
        for (int32_t v = 0; v < fine->info.n_vertices; v++)
            n_springs += s.springs.stiffness[v] > 0;
        CHECK_INT(n_springs, kind == 0 ? 9 : 4);
        co_sparse_rows_free(&rows);
        curvopt_mesh_destroy(fine);
        tear_down(&s);
    }
}

static void test_copies_are_apart(void **state) {
    (void)state;
    setting s;
    co_soft_constraints copy, none = {0};
    curvopt_error error;
    set_up(&s);
    CHECK_OK(co_soft_constraints_copy(s.mesh, &none, &copy, &error), &error);
    CHECK_TRUE(!copy.stiffness);
    s.weight[7] = 0.5;
    create(&s);
    CHECK_OK(co_soft_constraints_copy(s.mesh, &s.springs, &copy, &error), &error);
    CHECK_TRUE(s.springs.stiffness && s.springs.original);
    if (!s.springs.stiffness || !s.springs.original)
        return;
    s.springs.stiffness[7] = s.springs.original[0] = 0;
    CHECK_NEAR(copy.stiffness[7], 1, 1e-15);
    CHECK_NEAR(copy.original[0], s.c.xyz[0], 0);
    co_soft_constraints_free(&copy);
    tear_down(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_vertices_are_pulled_back),
        cmocka_unit_test(test_a_patch_is_one_handle),
        cmocka_unit_test(test_alike),
        cmocka_unit_test(test_subdivision_distributes_the_stiffness),
        cmocka_unit_test(test_faces_of_several_kinds_keep_their_springs),
        cmocka_unit_test(test_copies_are_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
