/* Runs without crossings: which faces touch at the end, of which faces of the input the fine ones are, what crosses
 * before the run and what is refused. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "variables_setting.h"

#include "hessian/repulsion.h"
#include "mesh/similarity.h"
#include "mesh/subdivide.h"
#include "solve/no_crossings.h"

enum { SIDE = 4, POINTS = (SIDE + 1) * (SIDE + 1), FACES = SIDE * SIDE };

/* Two squares of SIDE x SIDE unit faces, facing each other: at distances from `low` at one side to `high` at the other,
 * negative behind. The second one's faces come in the opposite order. */
static cage sheets(double low, double high) {
    int32_t sizes[2 * FACES], vertices[8 * FACES], n = 0;
    double xyz[6 * POINTS];
    for (int sheet = 0; sheet < 2; sheet++)
        for (int i = 0; i <= SIDE; i++)
            for (int j = 0; j <= SIDE; j++) {
                double *x = xyz + 3 * (sheet * POINTS + i * (SIDE + 1) + j);
                x[0] = i;
                x[1] = j;
                x[2] = sheet * (low + (high - low) * i / SIDE);
            }
    for (int sheet = 0; sheet < 2; sheet++)
        for (int f = 0; f < FACES; f++, n++) {
            const int at = sheet ? FACES - 1 - f : f;
            const int32_t first = sheet * POINTS + at / SIDE * (SIDE + 1) + at % SIDE;
            const int32_t corner[4] = {first, first + SIDE + 1, first + SIDE + 2, first + 1};
            sizes[n] = 4;
            for (int k = 0; k < 4; k++)
                vertices[4 * n + k] = corner[sheet ? 3 - k : k];
        }
    return cage_of(2 * POINTS, n, sizes, vertices, xyz);
}

/* Faces of the first sheet touch those opposite to them, and may touch those beside these; each pair is there once. */
static void check_pairs(int32_t (*pair)[2], int32_t n) {
    int n_opposite = 0;
    for (int32_t k = 0; k < n; k++) {
        const int32_t one = pair[k][0], two = 2 * FACES - 1 - pair[k][1]; /* opposite to that */
        CHECK_BETWEEN(one, 0, FACES - 1);
        CHECK_BETWEEN(two, 0, FACES - 1);
        CHECK_BETWEEN(abs(one / SIDE - two / SIDE), 0, 1);
        CHECK_BETWEEN(abs(one % SIDE - two % SIDE), 0, 1);
        n_opposite += one == two;
        if (k > 0)
            CHECK_TRUE(one > pair[k - 1][0] || (one == pair[k - 1][0] && pair[k][1] > pair[k - 1][1]));
    }
    CHECK_INT(n_opposite, FACES);
}

/* What touches of a mesh at xyz within this reach, in the user's units, by that clearance; nothing where it is 0. */
static void check_touching(const curvopt_mesh *mesh, const double *xyz, co_no_crossings *c, double reach,
                           double least) {
    const size_t n = (size_t)mesh->info.n_vertices;
    double centroid[3], clearance, radius = co_similarity_mesh_frame(mesh, xyz, centroid),
                                   *x = calloc(3 * n, sizeof *x);
    int32_t(*pairs)[2] = NULL, n_pairs = -1;
    co_repulsion repulsion;
    curvopt_error error;
    CHECK_TRUE(x != NULL);
    for (size_t i = 0; i < 3 * n; i++)
        x[i] = (xyz[i] - centroid[i % 3]) / radius;
    CHECK_OK(co_repulsion_create(mesh, NULL, x, reach / radius, &c->exceptions, NULL, &repulsion, &error), &error);
    repulsion.weight = 1;
    CHECK_OK(co_no_crossings_touching(&repulsion, x, &pairs, &n_pairs, &clearance, &error), &error);
    if (least > 0) {
        check_pairs(pairs, n_pairs);
        CHECK_NEAR(clearance * radius, least, 1e-9);
    } else {
        CHECK_INT(n_pairs, 0);
        CHECK_TRUE(isnan(clearance));
    }
    free(pairs);
    free(x);
    co_repulsion_free(&repulsion);
}

static void test_opposite_faces_touch(void **state) {
    (void)state;
    cage c = sheets(0.02, 0.02);
    curvopt_mesh *mesh = cage_mesh(&c);
    co_no_crossings none;
    int32_t refused = 0;
    curvopt_error error;
    CHECK_OK(co_no_crossings_create(mesh, c.xyz, c.xyz, NULL, NULL, &none, &error), &error);
    none.exceptions.n_refused = &refused;
    CHECK_INT(none.exceptions.pairs.n_crossing, 0);
    check_touching(mesh, c.xyz, &none, 0.03, 0.02);
    check_touching(mesh, c.xyz, &none, 0.01, 0);
    co_no_crossings_free(&none);
    CHECK_TRUE(!none.origin);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Subdivided twice, each piece is one of the face that it comes from. */
static void test_fine_faces_are_of_the_input(void **state) {
    (void)state;
    cage c = sheets(0.02, 0.02);
    curvopt_mesh *mesh = cage_mesh(&c), *fine;
    double *xyz = calloc(3 * (size_t)c.n_vertices, sizeof *xyz);
    co_no_crossings none;
    int32_t refused = 0;
    curvopt_error error;
    CHECK_TRUE(xyz != NULL);
    memcpy(xyz, c.xyz, 3 * (size_t)c.n_vertices * sizeof *xyz);
    CHECK_OK(co_no_crossings_create(mesh, c.xyz, c.xyz, NULL, NULL, &none, &error), &error);
    none.exceptions.n_refused = &refused;
    for (int level = 0; level < 2; level++) {
        co_sparse_rows rows;
        CHECK_OK(co_subdivide(mesh, &fine, &rows, &error), &error);
        double *finer = calloc(3 * (size_t)rows.n_rows, sizeof *finer);
        CHECK_TRUE(finer != NULL);
        co_sparse_rows_apply(&rows, xyz, finer);
        CHECK_OK(co_no_crossings_subdivide(mesh, fine, finer, NULL, NULL, &none, &error), &error);
        co_sparse_rows_free(&rows);
        curvopt_mesh_destroy(mesh);
        free(xyz);
        mesh = fine;
        xyz = finer;
        for (int32_t f = 0; f < mesh->info.n_faces; f++)
            CHECK_INT(none.origin[f], f / (level ? 16 : 4));
        CHECK_INT(none.exceptions.pairs.n_crossing, 0);
        check_touching(mesh, xyz, &none, 0.03, 0.02);
    }
    co_no_crossings_free(&none);
    curvopt_mesh_destroy(mesh);
    free(xyz);
    cage_free(&c);
}

/* Crossings that are found first on a finer cage were the surface's before, and may go on. */
static void test_crossings_of_the_finer_cage(void **state) {
    (void)state;
    cage c = sheets(0.5, 0.5), through = sheets(-0.55, 0.5);
    curvopt_mesh *mesh = cage_mesh(&c), *fine;
    co_no_crossings none;
    co_sparse_rows rows;
    curvopt_error error;
    CHECK_OK(co_no_crossings_create(mesh, c.xyz, c.xyz, NULL, NULL, &none, &error), &error);
    CHECK_OK(co_subdivide(mesh, &fine, &rows, &error), &error);
    double *xyz = calloc(3 * (size_t)rows.n_rows, sizeof *xyz);
    CHECK_TRUE(xyz != NULL);
    co_sparse_rows_apply(&rows, through.xyz, xyz);
    CHECK_OK(co_no_crossings_subdivide(mesh, fine, xyz, NULL, NULL, &none, &error), &error);
    CHECK_BETWEEN(none.exceptions.pairs.n_crossing, SIDE, 3 * SIDE); /* of the first cage's faces */
    for (int f = 0; f < FACES; f++)                                  /* the planes meet in the third row */
        CHECK_TRUE(f / SIDE != 2 || none.exceptions.pairs.is_near[f]);
    co_no_crossings_free(&none);
    co_sparse_rows_free(&rows);
    free(xyz);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
    cage_free(&through);
}

/* What crosses in the input may cross at the start; what does not, may not, and is named by faces that do. */
static void test_crossings_at_the_start(void **state) {
    (void)state;
    cage c = sheets(0.5, 0.5), through = sheets(-0.55, 0.5);
    curvopt_mesh *mesh = cage_mesh(&c);
    co_no_crossings none;
    curvopt_error error;
    int32_t status = co_no_crossings_create(mesh, c.xyz, through.xyz, NULL, NULL, &none, &error);
    CHECK_BETWEEN(error.element / SIDE, 2, 2); /* the planes meet at 2.095 */
    CHECK_REFUSED(status, &error, CURVOPT_ERROR_GEOMETRY, error.element, "crosses itself, for example at faces");
    CHECK_TRUE(!none.origin && !none.exceptions.pairs.n_crossing);
    CHECK_OK(co_no_crossings_create(mesh, through.xyz, through.xyz, NULL, NULL, &none, &error), &error);
    CHECK_BETWEEN(none.exceptions.pairs.n_crossing, SIDE, 3 * SIDE);
    co_no_crossings_free(&none);
    through.xyz[2] += 1e-3; /* other places, and the same faces cross */
    cage other = sheets(-0.55, 0.5);
    CHECK_OK(co_no_crossings_create(mesh, through.xyz, other.xyz, NULL, NULL, &none, &error), &error);
    co_no_crossings_free(&none);
    cage_free(&other);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
    cage_free(&through);
}

/* Whether any pair of faces crosses, of a surface. */
static int crosses(const curvopt_mesh *mesh, const double *xyz) {
    curvopt_crossings found;
    curvopt_error error;
    CHECK_OK(curvopt_find_crossings(mesh, xyz, 1, NULL, 0, NULL, &found, sizeof found, &error), &error);
    return found.n_pairs > 0;
}

/* Two sheets whose middles springs draw through each other: they go through, and with the option end apart, held by
 * faces in the middle. */
static void test_a_run(void **state) {
    (void)state;
    static const int32_t middle[2] = {POINTS / 2, POINTS + POINTS / 2};
    static const double weight[2] = {0.61, 0.61}, place[6] = {2, 2, 0.7, 2, 2, -0.2};
    const curvopt_constraints springs = {
        .vertices = middle, .n = 2, .weights = weight, .has_places = 1, .places = place};
    cage c = sheets(0.5, 0.5);
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_options o;
    curvopt_error error;
    curvopt_options_init(&o, sizeof o);
    o.threads = 1;
    o.constraints = &springs;
    o.levels = 2;
    for (o.no_crossings = 0; o.no_crossings < 2; o.no_crossings++) {
        curvopt_result *result;
        curvopt_summary summary;
        int32_t pair[2 * FACES * FACES];
        CHECK_OK(curvopt_minimize(mesh, c.xyz, &o, NULL, NULL, NULL, &result, &error), &error);
        curvopt_result_get_summary(result, &summary, sizeof summary);
        double *xyz = calloc(3 * (size_t)summary.n_vertices, sizeof *xyz);
        CHECK_TRUE(xyz != NULL);
        curvopt_result_get_positions(result, xyz);
        CHECK_INT(crosses(curvopt_result_mesh(result), xyz), !o.no_crossings);
        CHECK_INT(summary.n_crossing_before, 0);
        CHECK_INT(summary.n_touching > 0, o.no_crossings);
        CHECK_INT(isnan(summary.clearance) != 0, !o.no_crossings);
        curvopt_result_get_touching(result, pair);
        for (int32_t k = 0; k < summary.n_touching; k++) {
            const int32_t two = 2 * FACES - 1 - pair[2 * k + 1];
            CHECK_BETWEEN(pair[2 * k] / SIDE, 1,
                          2); /* of the middle, and opposite to that, and so on the second sheet */
            CHECK_BETWEEN(pair[2 * k] % SIDE, 1, 2);
            CHECK_BETWEEN(two / SIDE, 1, 2);
            CHECK_BETWEEN(two % SIDE, 1, 2);
        }
        if (o.no_crossings)
            CHECK_BETWEEN(summary.clearance, 1e-6, 0.1); /* a fifth of a mean edge on the second level */
        free(xyz);
        curvopt_result_destroy(result);
    }
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_opposite_faces_touch),
        cmocka_unit_test(test_fine_faces_are_of_the_input),
        cmocka_unit_test(test_crossings_of_the_finer_cage),
        cmocka_unit_test(test_crossings_at_the_start),
        cmocka_unit_test(test_a_run),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
