/* What a cage must be, and what is known of it then. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"
#include "mesh/mesh.h"
#include "mesh/submesh.h"

#include <stdlib.h>

typedef struct refusal {
    int32_t n_vertices, n_faces;
    const int32_t *sizes, *vertices;
    int32_t code, element;
    const char *part; /* of the message */
} refusal;

static void check_refusal(const refusal *r) {
    curvopt_error error = {.code = -1, .element = -2};
    curvopt_mesh *mesh = (curvopt_mesh *)(void *)&error;
    int32_t status = curvopt_mesh_create(r->n_vertices, r->n_faces, r->sizes, r->vertices, &mesh, &error);
    CHECK_REFUSED(status, &error, r->code, r->element, r->part);
    CHECK_TRUE(mesh == NULL);
    CHECK_INT(curvopt_mesh_create(r->n_vertices, r->n_faces, r->sizes, r->vertices, &mesh, NULL), r->code);
}

/* The cage is taken, and refused by a run that is strict. */
static void check_strict_refusal(const refusal *r) {
    curvopt_error error = {.code = -1, .element = -2};
    curvopt_mesh *mesh;
    curvopt_problem *problem;
    curvopt_options options;
    curvopt_options_init(&options, sizeof options);
    options.strict = 1;
    CHECK_OK(curvopt_mesh_create(r->n_vertices, r->n_faces, r->sizes, r->vertices, &mesh, &error), &error);
    CHECK_REFUSED(curvopt_problem_create(mesh, NULL, &options, &problem, &error), &error, r->code, r->element, r->part);
    CHECK_TRUE(problem == NULL);
    curvopt_mesh_destroy(mesh);
}

/* A tetrahedron with one number changed. */
static void check_changed_tetrahedron(int corner, int32_t vertex, int32_t element, const char *part) {
    cage c = cage_tetrahedron();
    c.vertices[corner] = vertex;
    check_refusal(&(refusal){4, 4, c.sizes, c.vertices, CURVOPT_ERROR_TOPOLOGY, element, part});
    cage_free(&c);
}

static void test_face_of_two_corners_is_refused(void **state) {
    (void)state;
    static const int32_t sizes[] = {3, 2, 3}, vertices[] = {0, 1, 2, 0, 1, 2, 1, 0};
    check_refusal(
        &(refusal){3, 3, sizes, vertices, CURVOPT_ERROR_TOPOLOGY, 1, "face 1 has 2 corners; at least 3 are needed"});
}

static void test_face_of_no_or_negative_corners_is_refused(void **state) {
    (void)state;
    static const int32_t none[] = {3, 0}, negative[] = {3, -5}, vertices[] = {0, 1, 2};
    check_refusal(&(refusal){3, 2, none, vertices, CURVOPT_ERROR_TOPOLOGY, 1, "face 1 has 0 corners"});
    check_refusal(&(refusal){3, 2, negative, vertices, CURVOPT_ERROR_TOPOLOGY, 1, "face 1 has -5 corners"});
}

static void test_index_out_of_range_is_refused(void **state) {
    (void)state;
    check_changed_tetrahedron(4, 4, 1, "face 1 names vertex 4; the cage has vertices 0 to 3");
    check_changed_tetrahedron(10, -1, 3, "face 3 names vertex -1");
    check_changed_tetrahedron(0, INT32_MAX, 0, "face 0 names vertex 2147483647");
    check_changed_tetrahedron(11, INT32_MIN, 3, "face 3 names vertex -2147483648");
}

static void test_repeated_vertex_is_refused(void **state) {
    (void)state;
    check_changed_tetrahedron(7, 1, 2, "vertex 1");
}

static void test_flipped_face_is_strictly_refused(void **state) {
    (void)state;
    static const int32_t sizes[] = {3, 3, 3, 3}, vertices[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 2, 3};
    check_strict_refusal(&(refusal){4, 4, sizes, vertices, CURVOPT_ERROR_TOPOLOGY, 3,
                                    "faces 0 and 3 both run from vertex 0 to 2: one of them is flipped"});
}

static void test_edge_of_three_faces_is_strictly_refused(void **state) {
    (void)state;
    static const int32_t sizes[] = {3, 3, 3}, vertices[] = {0, 1, 2, 1, 0, 3, 0, 1, 4};
    check_strict_refusal(&(refusal){5, 3, sizes, vertices, CURVOPT_ERROR_TOPOLOGY, 2,
                                    "between vertices 0 and 1 is not manifold: 3 faces"});
}

static void test_isolated_vertex_is_strictly_refused(void **state) {
    (void)state;
    cage c = cage_tetrahedron();
    check_strict_refusal(
        &(refusal){5, 4, c.sizes, c.vertices, CURVOPT_ERROR_TOPOLOGY, 4, "vertex 4 is isolated: no face uses it"});
    for (int k = 0; k < 12; k++)
        c.vertices[k] += c.vertices[k] >= 2; /* vertex 2 is the one left out */
    check_strict_refusal(&(refusal){5, 4, c.sizes, c.vertices, CURVOPT_ERROR_TOPOLOGY, 2, "vertex 2 is isolated"});
    cage_free(&c);
}

static void test_absurdly_many_vertices_are_refused_before_allocation(void **state) {
    (void)state;
    cage c = cage_tetrahedron();
    check_refusal(
        &(refusal){INT32_MAX, 4, c.sizes, c.vertices, CURVOPT_ERROR_SIZE, -1, "more than 268435455 vertices"});
    cage_free(&c);
}

static void test_two_fans_at_a_vertex_are_strictly_refused(void **state) {
    (void)state;
    cage c = cage_both(cage_tetrahedron(), cage_tetrahedron(), 3);
    for (int k = 12; k < 24; k++)
        c.vertices[k] = c.vertices[k] == 4 ? 0 : c.vertices[k] - 1; /* both share vertex 0 */
    check_strict_refusal(&(refusal){7, 8, c.sizes, c.vertices, CURVOPT_ERROR_TOPOLOGY, 0,
                                    "vertex 0 joins separate fans of faces: 3 of its 6"});
    cage_free(&c);
}

static const int32_t triple_sizes[] = {3, 3, 3}, triple_vertices[] = {0, 1, 2, 1, 0, 3, 0, 1, 4};

/* The three half-edges between vertices 0 and 1 have no twins, but are one edge. */
static void test_edge_of_three_faces_is_one_edge(void **state) {
    (void)state;
    curvopt_error error;
    curvopt_mesh *m;
    CHECK_OK(curvopt_mesh_create(6, 3, triple_sizes, triple_vertices, &m, &error), &error);
    CHECK_INT(m->info.n_edges, 7);
    CHECK_INT(m->info.n_flawed_edges, 1);
    CHECK_INT(m->info.n_boundary_edges, 6);
    CHECK_INT(m->info.n_isolated, 1);
    CHECK_INT(m->info.euler, 5 - 7 + 3);
    CHECK_INT(m->edge[0], m->edge[3]);
    CHECK_INT(m->edge[0], m->edge[6]);
    CHECK_INT(m->twin[0], -1);
    CHECK_INT(m->flaw[0], CO_MESH_CROWDED);
    CHECK_INT(m->flaw[1], CO_MESH_CROWDED);
    CHECK_INT(m->flaw[2], CO_MESH_SOUND);
    CHECK_INT(m->flaw[5], CO_MESH_ISOLATED);
    CHECK_INT(m->vertex_corner[5], -1);
    curvopt_mesh_destroy(m);
}

/* Round a face that is there three times two edges of three faces meet at each vertex: a curve, as OpenSubdiv has it.
 */
static void test_flaws_of_repeated_and_flipped_faces(void **state) {
    (void)state;
    static const int32_t sizes[] = {3, 3, 3}, twice[] = {0, 1, 2, 0, 1, 2, 3, 4, 5},
                         thrice[] = {0, 1, 2, 2, 1, 0, 1, 2, 0};
    curvopt_error error;
    curvopt_mesh *m;
    CHECK_OK(curvopt_mesh_create(6, 3, sizes, twice, &m, &error), &error);
    CHECK_INT(m->info.n_flawed_edges, 3);
    CHECK_INT(m->flaw[0], CO_MESH_FLIPPED);
    CHECK_INT(m->flaw[3], CO_MESH_SOUND);
    curvopt_mesh_destroy(m);
    CHECK_OK(curvopt_mesh_create(3, 3, sizes, thrice, &m, &error), &error);
    CHECK_INT(m->flaw[0], CO_MESH_CURVE);
    curvopt_mesh_destroy(m);
}

/* Without flaws there is no list of them. */
static void test_a_sound_cage_has_no_flaws(void **state) {
    (void)state;
    cage c = cage_tetrahedron();
    curvopt_error error;
    curvopt_mesh *m;
    CHECK_OK(curvopt_mesh_create(4, 4, c.sizes, c.vertices, &m, &error), &error);
    CHECK_TRUE(m->flaw == NULL && m->isolated == NULL);
    CHECK_OK(co_mesh_check_manifold(m, &error), &error);
    curvopt_mesh_destroy(m);
    cage_free(&c);
}

static void test_counts_below_one_are_refused(void **state) {
    (void)state;
    cage c = cage_tetrahedron();
    check_refusal(&(refusal){0, 4, c.sizes, c.vertices, CURVOPT_ERROR_ARGUMENT, -1, "0 vertices"});
    check_refusal(&(refusal){4, 0, c.sizes, c.vertices, CURVOPT_ERROR_ARGUMENT, -1, "0 faces"});
    check_refusal(&(refusal){-7, 4, c.sizes, c.vertices, CURVOPT_ERROR_ARGUMENT, -1, "-7 vertices"});
    check_refusal(&(refusal){4, -1, c.sizes, c.vertices, CURVOPT_ERROR_ARGUMENT, -1, "-1 faces"});
    cage_free(&c);
}

static void test_absurd_face_sizes_are_refused(void **state) {
    (void)state;
    static const int32_t one[] = {INT32_MAX}, two[] = {INT32_MAX / 8, 3}, vertices[] = {0, 1, 2};
    check_refusal(&(refusal){3, 1, one, vertices, CURVOPT_ERROR_SIZE, 0, "face corners"});
    check_refusal(&(refusal){3, 2, two, vertices, CURVOPT_ERROR_SIZE, 1, "more than 268435455 face corners"});
}

static void test_null_arrays_are_refused(void **state) {
    (void)state;
    cage c = cage_tetrahedron();
    curvopt_error error;
    check_refusal(&(refusal){4, 4, NULL, c.vertices, CURVOPT_ERROR_ARGUMENT, -1, "NULL"});
    check_refusal(&(refusal){4, 4, c.sizes, NULL, CURVOPT_ERROR_ARGUMENT, -1, "NULL"});
    int32_t status = curvopt_mesh_create(4, 4, c.sizes, c.vertices, NULL, &error);
    CHECK_REFUSED(status, &error, CURVOPT_ERROR_ARGUMENT, -1, "out is NULL");
    cage_free(&c);
}

static void test_destroying_nothing_is_allowed(void **state) {
    (void)state;
    curvopt_mesh_destroy(NULL);
    curvopt_problem_destroy(NULL);
    curvopt_result_destroy(NULL);
    curvopt_cancel_destroy(NULL);
}

typedef struct counts {
    int32_t vertices, edges, faces, components, extraordinary, max_valence, all_quads;
} counts;

static void check_counts(cage c, const counts *expected) {
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_mesh_info info;
    curvopt_mesh_get_info(mesh, &info, sizeof info);
    CHECK_INT(info.n_vertices, expected->vertices);
    CHECK_INT(info.n_edges, expected->edges);
    CHECK_INT(info.n_faces, expected->faces);
    CHECK_INT(info.euler, expected->vertices - expected->edges + expected->faces);
    CHECK_INT(info.n_corners, 2 * expected->edges);
    CHECK_INT(info.n_components, expected->components);
    CHECK_INT(info.n_boundary_edges, 0);
    CHECK_INT(info.n_extraordinary, expected->extraordinary);
    CHECK_INT(info.max_valence, expected->max_valence);
    CHECK_INT(info.all_quads, expected->all_quads);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_counts_of_known_solids(void **state) {
    (void)state;
    check_counts(cage_tetrahedron(), &(counts){4, 6, 4, 1, 4, 3, 0});
    check_counts(cage_cube(), &(counts){8, 12, 6, 1, 8, 3, 1});
    check_counts(cage_torus(8, 6, 1, 0.4), &(counts){48, 96, 48, 1, 0, 4, 1});
    check_counts(cage_trapezohedron(7), &(counts){16, 28, 14, 1, 16, 7, 1});
    check_counts(cage_prism(5), &(counts){10, 15, 7, 1, 10, 3, 0});
}

static void test_components_are_counted(void **state) {
    (void)state;
    cage three = cage_both(cage_cube(), cage_both(cage_torus(5, 4, 1, 0.4), cage_tetrahedron(), 5), 9);
    check_counts(three, &(counts){32, 58, 30, 3, 12, 4, 0});
}

static void test_open_cage_counts_its_boundary(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh;
    curvopt_mesh_info info;
    curvopt_error error;
    CHECK_OK(curvopt_mesh_create(8, 5, c.sizes, c.vertices, &mesh, &error), &error);
    curvopt_mesh_get_info(mesh, &info, sizeof info);
    CHECK_INT(info.n_boundary_edges, 4);
    CHECK_INT(info.n_extraordinary, 4);
    CHECK_INT(info.euler, 1);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_half_edges_are_consistent(void **state) {
    (void)state;
    cage c = cage_prism(6);
    curvopt_mesh *m = cage_mesh(&c);
    for (int32_t h = 0; h < m->info.n_corners; h++) {
        CHECK_INT(m->twin[m->twin[h]], h);
        CHECK_INT(co_mesh_destination(m, m->twin[h]), m->corner_vertex[h]);
        CHECK_INT(co_mesh_prev(m, co_mesh_next(m, h)), h);
        CHECK_INT(m->edge[m->twin[h]], m->edge[h]);
        CHECK_INT(m->corner_vertex[co_mesh_rotate(m, h)], m->corner_vertex[h]);
    }
    for (int32_t v = 0; v < m->info.n_vertices; v++) {
        int32_t first = m->vertex_corner[v], h = first, n = 0;
        do {
            n++;
            h = co_mesh_rotate(m, h);
        } while (h != first);
        CHECK_INT(m->corner_vertex[first], v);
        CHECK_INT(n, m->valence[v]);
    }
    curvopt_mesh_destroy(m);
    cage_free(&c);
}

static void test_faces_come_back_as_given(void **state) {
    (void)state;
    cage c = cage_prism(5);
    int32_t sizes[7], vertices[30];
    curvopt_mesh *mesh = cage_mesh(&c), *copy;
    curvopt_error error;
    CHECK_OK(co_submesh_copy(mesh, &copy, &error), &error);
    curvopt_mesh_destroy(mesh);
    curvopt_mesh_get_faces(copy, sizes, vertices);
    assert_memory_equal(sizes, c.sizes, sizeof sizes);
    assert_memory_equal(vertices, c.vertices, sizeof vertices);
    curvopt_mesh_destroy(copy);
    cage_free(&c);
}

static void test_extracted_faces_keep_order_and_vertices(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&c), *part;
    static const uint8_t keep[6] = {0, 1, 0, 0, 0, 1};
    int32_t *vertex_of;
    curvopt_error error;
    CHECK_OK(co_submesh_extract(mesh, keep, &part, &vertex_of, &error), &error);
    CHECK_INT(part->info.n_faces, 2);
    CHECK_INT(part->info.n_vertices, 6);
    CHECK_INT(part->info.n_boundary_edges, 6);
    for (int k = 0; k < 8; k++)
        CHECK_INT(vertex_of[part->corner_vertex[k]], c.vertices[k < 4 ? 4 + k : 16 + k]);
    free(vertex_of);
    curvopt_mesh_destroy(part);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Edges once each: of a box the four of each direction, of one quad all four. Areas: of all sides, and of one. */
static void test_mean_edge_and_area(void **state) {
    const int32_t size = 4, square[4] = {0, 1, 2, 3};
    const double flat[12] = {0, 0, 0, 1, 0, 0, 1, 7, 0, 0, 7, 0};
    curvopt_mesh *mesh;
    curvopt_error error;
    (void)state;
    cage c = cage_cube();
    for (int32_t v = 0; v < 8; v++) {
        c.xyz[3 * v] *= 2;
        c.xyz[3 * v + 1] *= 3;
    }
    mesh = cage_mesh(&c);
    CHECK_NEAR(co_mesh_mean_edge(mesh, NULL, c.xyz), (4.0 + 6 + 2) / 3, 1e-15);
    CHECK_NEAR(co_mesh_area(mesh, NULL, c.xyz), 2 * (4.0 * 6 + 6 * 2 + 2 * 4), 1e-13);
    const uint8_t all_but_one[6] = {1, 1, 1, 0, 1, 1};
    const int32_t *kept = mesh->corner_vertex + mesh->face_start[3];
    double sides = 1;
    for (int k = 0; k < 2; k++) {
        const double *a = c.xyz + 3 * kept[k], *b = c.xyz + 3 * kept[k + 1];
        sides *= fabs(a[0] - b[0]) + fabs(a[1] - b[1]) + fabs(a[2] - b[2]);
    }
    CHECK_NEAR(co_mesh_area(mesh, all_but_one, c.xyz), sides, 1e-14);
    co_mesh_destroy(mesh);
    cage_free(&c);
    CHECK_OK(curvopt_mesh_create(4, 1, &size, square, &mesh, &error), &error);
    CHECK_NEAR(co_mesh_mean_edge(mesh, NULL, flat), 4, 1e-15);
    co_mesh_destroy(mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_face_of_two_corners_is_refused),
        cmocka_unit_test(test_face_of_no_or_negative_corners_is_refused),
        cmocka_unit_test(test_index_out_of_range_is_refused),
        cmocka_unit_test(test_repeated_vertex_is_refused),
        cmocka_unit_test(test_edge_of_three_faces_is_one_edge),
        cmocka_unit_test(test_flaws_of_repeated_and_flipped_faces),
        cmocka_unit_test(test_a_sound_cage_has_no_flaws),
        cmocka_unit_test(test_flipped_face_is_strictly_refused),
        cmocka_unit_test(test_edge_of_three_faces_is_strictly_refused),
        cmocka_unit_test(test_isolated_vertex_is_strictly_refused),
        cmocka_unit_test(test_absurdly_many_vertices_are_refused_before_allocation),
        cmocka_unit_test(test_two_fans_at_a_vertex_are_strictly_refused),
        cmocka_unit_test(test_counts_below_one_are_refused),
        cmocka_unit_test(test_absurd_face_sizes_are_refused),
        cmocka_unit_test(test_null_arrays_are_refused),
        cmocka_unit_test(test_destroying_nothing_is_allowed),
        cmocka_unit_test(test_counts_of_known_solids),
        cmocka_unit_test(test_components_are_counted),
        cmocka_unit_test(test_open_cage_counts_its_boundary),
        cmocka_unit_test(test_half_edges_are_consistent),
        cmocka_unit_test(test_faces_come_back_as_given),
        cmocka_unit_test(test_extracted_faces_keep_order_and_vertices),
        cmocka_unit_test(test_mean_edge_and_area),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
