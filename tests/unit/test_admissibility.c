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
    CHECK_OK(co_patches_create(mesh, NULL, NULL, CURVOPT_SURFACE_LIMIT, 1, NULL, &patches, error), error);
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
    CHECK_OK(check_creased(&c, &crease, CURVOPT_TERM_WILLMORE, limit, &allowed, &error), &error);
    CHECK_OK(check_creased(&c, &corner, CURVOPT_TERM_WILLMORE, limit, &allowed, &error), &error);
    CHECK_OK(check_creased(&c, &dart, CURVOPT_TERM_MVS, polynomial, &allowed, &error), &error);
    CHECK_INT(allowed, 1);
    CHECK_OK(check_creased(&c, &dart, CURVOPT_TERM_WILLMORE, limit, &allowed, &error), &error);
    CHECK_INT(allowed, 0);
    CHECK_REFUSED(check_creased(&c, &dart, CURVOPT_TERM_MVS, limit, &allowed, &error), &error, CURVOPT_ERROR_SURFACE, 0,
                  "no finite third-order energy at extraordinary vertices");
    cage_free(&c);
}

/* An open fan of four quads round vertex 0, which is a corner or not. */
static void test_corners_of_several_faces_are_refused(void **state) {
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
    CHECK_OK(check_creased(&c, &corners, CURVOPT_TERM_WILLMORE, CURVOPT_SURFACE_LIMIT, &allowed, &error), &error);
    CHECK_REFUSED(check_creased(&c, &corner, CURVOPT_TERM_WILLMORE, CURVOPT_SURFACE_LIMIT, &allowed, &error), &error,
                  CURVOPT_ERROR_SURFACE, 0, "vertex 0 is a corner of 4 faces");
    cage_free(&c);
}

/* ------------------------------------------------------------------------------------------------ exceptions -- */

/* vertex and face: for each the initial of its reason's name, or "." */
static void check_exceptions(const cage *c, const curvopt_creases *creases, int term, const int32_t *holes,
                             int32_t n_holes, const char *vertex, const char *face) {
    curvopt_mesh *mesh;
    curvopt_error error;
    curvopt_options options;
    int32_t of_vertex[64], of_face[64];
    curvopt_options_init(&options, sizeof options);
    options.weights[CURVOPT_TERM_WILLMORE] = 0;
    options.weights[term] = 1;
    options.holes = holes;
    options.n_holes = n_holes;
    options.strict = 1; /* is disregarded */
    CHECK_OK(curvopt_mesh_create_creased(c->n_vertices, c->n_faces, c->sizes, c->vertices, creases, &mesh, &error),
             &error);
    CHECK_OK(curvopt_mesh_find_exceptions(mesh, NULL, &options, of_vertex, of_face, &error), &error);
    for (int32_t v = 0; v < c->n_vertices; v++)
        CHECK_INT(of_vertex[v] < 0 ? '.' : curvopt_exception_name(of_vertex[v])[0], vertex[v]);
    for (int32_t f = 0; f < c->n_faces; f++)
        CHECK_INT(of_face[f] < 0 ? '.' : curvopt_exception_name(of_face[f])[0], face[f]);
    curvopt_mesh_destroy(mesh);
}

/* A cube whose top is bounded by a crease, with one face at each corner on its side; a dart, and poles on a boundary:
 * blends give them finite energies of every order. */
static void test_blends_leave_nothing_out_on_smooth_curves(void **state) {
    (void)state;
    cage c = cage_cube();
    int32_t ends[8];
    const double sharpness[4] = {10, 10, 10, 10};
    for (int k = 0; k < 4; k++) {
        ends[2 * k] = c.vertices[k];
        ends[2 * k + 1] = c.vertices[(k + 1) % 4];
    }
    const int32_t one[2] = {3, 1}, hole[1] = {2};
    const curvopt_creases round_face_0 = {ends, sharpness, NULL, NULL, 4, 0, 0, 0};
    const curvopt_creases dart = {one, sharpness, NULL, NULL, 1, 0, 0, 0};
    for (int term = CURVOPT_TERM_WILLMORE; term <= CURVOPT_TERM_MVS; term++) {
        char vertex[9] = "........", face[7] = "..h...";
        check_exceptions(&c, &round_face_0, term, NULL, 0, vertex, "......");
        check_exceptions(&c, &dart, term, NULL, 0, vertex, "......");
        for (int k = 0; k < 4; k++)
            vertex[c.vertices[8 + k]] = 'b';
        check_exceptions(&c, NULL, term, hole, 1, vertex, face);
    }
    cage_free(&c);
}

/* Flaws, and a list that names neither too much nor too little: a fin on an edge of a cube, and a loose vertex. */
static void test_a_fin_and_a_loose_vertex_are_held(void **state) {
    (void)state;
    cage cube = cage_cube();
    int32_t sizes[7], vertices[28];
    memcpy(sizes, cube.sizes, 6 * sizeof *sizes);
    memcpy(vertices, cube.vertices, 24 * sizeof *vertices);
    sizes[6] = 4;
    const int32_t fin[4] = {cube.vertices[0], cube.vertices[1], 8, 9};
    memcpy(vertices + 24, fin, sizeof fin);
    const double xyz[33] = {0};
    cage c = cage_of(11, 7, sizes, vertices, xyz);
    char face[8] = ".......", vertex[12] = "........bbi";
    for (int32_t f = 0; f < 7; f++)
        for (int k = 0; k < 4; k++)
            if (vertices[4 * f + k] == fin[0] || vertices[4 * f + k] == fin[1])
                face[f] = 'c';
    for (int32_t f = 0; f < 7; f++)
        for (int k = 0; k < 4; k++)
            if (face[f] == 'c' && vertex[vertices[4 * f + k]] == '.')
                vertex[vertices[4 * f + k]] = 'b';
    vertex[fin[0]] = vertex[fin[1]] = 'c';
    check_exceptions(&c, NULL, CURVOPT_TERM_WILLMORE, NULL, 0, vertex, face);
    cage_free(&c);
    cage_free(&cube);
}

static void test_bad_holes_are_refused(void **state) {
    (void)state;
    cage c = cage_cube();
    const int32_t holes[7] = {0, 1, 2, 3, 4, 5, 6};
    curvopt_mesh *mesh;
    curvopt_problem *problem;
    curvopt_error error;
    curvopt_options options;
    curvopt_options_init(&options, sizeof options);
    CHECK_OK(curvopt_mesh_create(8, 6, c.sizes, c.vertices, &mesh, &error), &error);
    options.holes = holes;
    options.n_holes = 7;
    CHECK_REFUSED(curvopt_problem_create(mesh, NULL, &options, &problem, &error), &error, CURVOPT_ERROR_ARGUMENT, 6,
                  "hole 6 is face 6; the cage has faces 0 to 5");
    options.n_holes = 6;
    CHECK_REFUSED(curvopt_problem_create(mesh, NULL, &options, &problem, &error), &error, CURVOPT_ERROR_SURFACE, -1,
                  "no face is left in the energy: all 6 are holes");
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* n x n quads over [0, 1]^2. */
static cage make_grid(int32_t n) {
    int32_t sizes[36], vertices[4 * 36];
    double xyz[3 * 49];
    for (int32_t v = 0; v < (n + 1) * (n + 1); v++) {
        xyz[3 * v] = v % (n + 1) / (double)n;
        xyz[3 * v + 1] = v / (n + 1) / (double)n;
        xyz[3 * v + 2] = 0.1 * xyz[3 * v] * xyz[3 * v + 1];
    }
    for (int32_t f = 0; f < n * n; f++) {
        int32_t v = f / n * (n + 1) + f % n, face[4] = {v, v + 1, v + n + 2, v + n + 1};
        sizes[f] = 4;
        memcpy(vertices + 4 * f, face, sizeof face);
    }
    return cage_of((n + 1) * (n + 1), n * n, sizes, vertices, xyz);
}

/* The grid with vertices `at` [n] in one place, but for `apart` radii; `boundary_rule` as in curvopt.h. left_out: its
 * faces, by "." and "d". */
static void check_degenerate(const int32_t *at, int n, double apart, int32_t boundary_rule, const char *left_out) {
    cage c = make_grid(4);
    curvopt_mesh *mesh;
    curvopt_error error;
    curvopt_options options;
    const curvopt_creases creases = {.boundary_rule = boundary_rule};
    int32_t face[16];
    for (int i = 1; i < n; i++)
        memcpy(c.xyz + 3 * at[i], c.xyz + 3 * at[0], 3 * sizeof *c.xyz);
    c.xyz[3 * at[n - 1]] += apart * 0.5; /* the radius is .5 */
    curvopt_options_init(&options, sizeof options);
    CHECK_OK(curvopt_mesh_create_creased(c.n_vertices, c.n_faces, c.sizes, c.vertices, &creases, &mesh, &error),
             &error);
    CHECK_OK(curvopt_mesh_find_exceptions(mesh, c.xyz, &options, NULL, face, &error), &error);
    for (int32_t f = 0; f < 16; f++)
        CHECK_INT(face[f] < 0 ? '.' : curvopt_exception_name(face[f])[0], left_out[f]);
    CHECK_OK(curvopt_mesh_find_exceptions(mesh, NULL, &options, NULL, face, &error), &error);
    for (int32_t f = 0; f < 16; f++)
        CHECK_INT(face[f], -1);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Where edges of length 0 leave a tangent plane nothing is left out, and never the faces that have one. */
static void test_edges_of_length_0(void **state) {
    (void)state;
    const int32_t smooth = CURVOPT_BOUNDARY_RULE_SMOOTH, corners = CURVOPT_BOUNDARY_RULE_CORNERS;
    const int32_t pole[5] = {0, 1, 2, 3, 4}, three[3] = {1, 2, 3}, pair[2] = {2, 3}, corner[2] = {0, 1},
                  inner[4] = {6, 7, 11, 12}, block[9] = {6, 7, 8, 11, 12, 13, 16, 17, 18};
    check_degenerate(pole, 5, 0, smooth, "dddd............");
    check_degenerate(three, 3, 0, smooth, ".dd.............");
    check_degenerate(three, 3, 1e-7, smooth, ".dd.............");
    check_degenerate(three, 3, 1e-5, smooth, "................");
    check_degenerate(pair, 2, 0, smooth, "................");
    check_degenerate(corner, 2, 0, smooth, "................");
    check_degenerate(corner, 2, 0, corners, "d...............");
    check_degenerate(inner, 4, 0, smooth, "................");
    check_degenerate(block, 9, 0, smooth, ".....dd..dd.....");
}

static void test_degenerate_cages_are_strictly_refused(void **state) {
    (void)state;
    cage c = make_grid(4);
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_problem *problem;
    curvopt_error error;
    curvopt_options options;
    curvopt_options_init(&options, sizeof options);
    for (int v = 2; v < 4; v++)
        memcpy(c.xyz + 3 * v, c.xyz + 3, 3 * sizeof *c.xyz);
    CHECK_OK(curvopt_problem_create(mesh, c.xyz, &options, &problem, &error), &error);
    curvopt_problem_destroy(problem);
    options.strict = 1;
    CHECK_REFUSED(curvopt_problem_create(mesh, c.xyz, &options, &problem, &error), &error, CURVOPT_ERROR_GEOMETRY, 2,
                  "edges of length 0 leave the surface no tangent plane at vertex 2");
    const int32_t holes[2] = {1, 2}; /* what is a hole counts for nothing */
    options.holes = holes;
    options.n_holes = 2;
    CHECK_OK(curvopt_problem_create(mesh, c.xyz, &options, &problem, &error), &error);
    curvopt_problem_destroy(problem);
    c.xyz[5] = NAN;
    CHECK_REFUSED(curvopt_problem_create(mesh, c.xyz, &options, &problem, &error), &error, CURVOPT_ERROR_GEOMETRY, 1,
                  "vertex 1 has coordinate z");
    CHECK_REFUSED(curvopt_mesh_find_exceptions(mesh, c.xyz, &options, NULL, NULL, &error), &error,
                  CURVOPT_ERROR_GEOMETRY, 1, "vertex 1 has coordinate z");
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_limit_names_the_extraordinary_vertex),
        cmocka_unit_test(test_limit_names_the_face_with_an_extraordinary_centre),
        cmocka_unit_test(test_infinite_energies_name_the_vertex),
        cmocka_unit_test(test_corners_of_several_faces_are_refused),
        cmocka_unit_test(test_blends_leave_nothing_out_on_smooth_curves),
        cmocka_unit_test(test_a_fin_and_a_loose_vertex_are_held),
        cmocka_unit_test(test_bad_holes_are_refused),
        cmocka_unit_test(test_edges_of_length_0),
        cmocka_unit_test(test_degenerate_cages_are_strictly_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
