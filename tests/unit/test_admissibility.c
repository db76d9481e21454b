/* Which cages can carry which energies: refusals name the vertex. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "energy/admissibility.h"

static int32_t check_cage(const cage *c, int term, int32_t surface, int *third_allowed, curvopt_error *error) {
    curvopt_mesh *mesh = cage_mesh(c);
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_limit_names_the_extraordinary_vertex),
        cmocka_unit_test(test_limit_names_the_face_with_an_extraordinary_centre),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
