/* Which cages can carry which energies: refusals name the vertex. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "energy/admissibility.h"

static int32_t check_creased(const cage *c, const curvopt_creases *creases, int term, int32_t surface,
                             int *third_allowed, curvopt_error *error) {
    curvopt_mesh *mesh;
    CHECK_OK(curvopt_mesh_create_creased(c->n_vertices, c->n_faces, c->sizes, c->vertices, creases, &mesh, error),
             error);
    double weights[CURVOPT_N_TERMS] = {0};
    weights[term] = 1;
    co_functional functional = co_functional_of_weights(weights);
    co_patches patches;
    CHECK_OK(co_patches_create(mesh, NULL, 1, &patches, error), error);
    int32_t status = co_admissibility_check(mesh, &patches, &functional, surface, third_allowed, error);
    co_patches_free(&patches);
    curvopt_mesh_destroy(mesh);
    return status;
}

static int32_t check_cage(const cage *c, int term, int32_t surface, int *third_allowed, curvopt_error *error) {
    return check_creased(c, NULL, term, surface, third_allowed, error);
}

/* The torus' vertices are regular, the cube's, from number 16 on, are not. */
static void test_limit_names_the_extraordinary_vertex(void **state) {
    (void)state;
    cage c = cage_both(cage_torus(4, 4, 2, 1), cage_cube(), 8);
    curvopt_error error;
    int third_allowed;
    CHECK_REFUSED(check_cage(&c, CURVOPT_TERM_MVS, CURVOPT_SURFACE_LIMIT, &third_allowed, &error), &error,
                  CURVOPT_ERROR_SURFACE, 16, "vertex 16");
    CHECK_OK(check_cage(&c, CURVOPT_TERM_WILLMORE, CURVOPT_SURFACE_LIMIT, &third_allowed, &error), &error);
    CHECK_INT(third_allowed, 0);
    CHECK_OK(check_cage(&c, CURVOPT_TERM_MVS, CURVOPT_SURFACE_POLYNOMIAL, &third_allowed, &error), &error);
    CHECK_INT(third_allowed, 1);
    cage_free(&c);
}

/* An octahedron's vertices have valence 4: only the centres of its triangles are extraordinary. */
static void test_limit_names_the_face_with_an_extraordinary_centre(void **state) {
    (void)state;
    static const int32_t sizes[] = {3, 3, 3, 3, 3, 3, 3, 3};
    static const int32_t vertices[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    static const double xyz[] = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
    cage c = cage_of(6, 8, sizes, vertices, xyz);
    curvopt_error error;
    int third_allowed;
    CHECK_REFUSED(check_cage(&c, CURVOPT_TERM_MVS, CURVOPT_SURFACE_LIMIT, &third_allowed, &error), &error,
                  CURVOPT_ERROR_SURFACE, -1, "the centre of face 0, which has 3 sides");
    cage_free(&c);
}

/* Vertices at which the surface has no tangent plane, by the kind of their fan. */
static void test_infinite_energies_name_the_vertex(void **state) {
    (void)state;
    const int32_t sharp[1] = {5}, edges[6] = {3, 1, 3, 2, 3, 7}, two[4] = {3, 1, 3, 2}, one[2] = {3, 1};
    const double sharpness[3] = {10, 10, 10};
    const curvopt_creases cone = {NULL, NULL, sharp, sharpness, 0, 1, 0, 0},
                          dart = {one, sharpness, NULL, NULL, 1, 0, 0, 0},
                          crease = {two, sharpness, NULL, NULL, 2, 0, 0, 0},
                          corner = {edges, sharpness, NULL, NULL, 3, 0, 0, 0};
    cage c = cage_cube();
    curvopt_error error;
    int allowed;
    const int32_t limit = CURVOPT_SURFACE_LIMIT, polynomial = CURVOPT_SURFACE_POLYNOMIAL;
    CHECK_REFUSED(check_creased(&c, &cone, CURVOPT_TERM_WILLMORE, limit, &allowed, &error), &error,
                  CURVOPT_ERROR_SURFACE, 5, "vertex 5 is infinitely sharp: the surface has a cone there");
    CHECK_REFUSED(check_creased(&c, &crease, CURVOPT_TERM_WILLMORE, limit, &allowed, &error), &error,
                  CURVOPT_ERROR_SURFACE, 3, "vertex 3 has one face where boundary or crease run smoothly through it");
    CHECK_OK(check_creased(&c, &corner, CURVOPT_TERM_WILLMORE, limit, &allowed, &error), &error);
    CHECK_REFUSED(check_creased(&c, &dart, CURVOPT_TERM_MVS, polynomial, &allowed, &error), &error,
                  CURVOPT_ERROR_SURFACE, 1, "vertex 1 is extraordinary and lies on a boundary");
    CHECK_OK(check_creased(&c, &dart, CURVOPT_TERM_WILLMORE, polynomial, &allowed, &error), &error);
    CHECK_INT(allowed, 0);
    cage_free(&c);
}

/* Open fans of n quads round vertex 0, whose ends are infinitely sharp or not. */
static void test_too_many_faces_at_a_boundary_are_refused(void **state) {
    (void)state;
    enum { N = 4 };
    int32_t sizes[N], vertices[4 * N];
    double xyz[3 * (2 * N + 2)] = {0};
    const int32_t sharp[1] = {0};
    const double sharpness[1] = {10};
    const curvopt_creases corner = {NULL, NULL, sharp, sharpness, 0, 1, CURVOPT_BOUNDARY_RULE_CORNERS, 0},
                          corners = {.boundary_rule = CURVOPT_BOUNDARY_RULE_CORNERS};
    for (int32_t f = 0; f < N; f++) {
        int32_t face[4] = {0, 1 + 2 * f, 2 + 2 * f, 3 + 2 * f};
        sizes[f] = 4;
        memcpy(vertices + 4 * f, face, sizeof face);
    }
    for (int32_t v = 1; v < 2 * N + 2; v++) {
        xyz[3 * v] = cos(0.5 * v);
        xyz[3 * v + 1] = sin(0.5 * v);
    }
    cage c = cage_of(2 * N + 2, N, sizes, vertices, xyz);
    curvopt_error error;
    int allowed;
    CHECK_REFUSED(check_creased(&c, &corners, CURVOPT_TERM_WILLMORE, CURVOPT_SURFACE_LIMIT, &allowed, &error), &error,
                  CURVOPT_ERROR_SURFACE, 0, "vertex 0 has 4 faces on one side");
    CHECK_REFUSED(check_creased(&c, &corner, CURVOPT_TERM_WILLMORE, CURVOPT_SURFACE_LIMIT, &allowed, &error), &error,
                  CURVOPT_ERROR_SURFACE, 0, "vertex 0 is a corner of 4 faces");
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_limit_names_the_extraordinary_vertex),
        cmocka_unit_test(test_limit_names_the_face_with_an_extraordinary_centre),
        cmocka_unit_test(test_infinite_energies_name_the_vertex),
        cmocka_unit_test(test_too_many_faces_at_a_boundary_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
