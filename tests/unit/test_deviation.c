/* How far two limit surfaces are apart: bounds, closed forms, refusals. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "measure/correspondence.h"
#include "measure/deviation.h"
#include "measure/deviation_bound.h"

static curvopt_deviation measure(const cage *a, const cage *b, int32_t threads) {
    curvopt_mesh *one = cage_mesh(a), *two = cage_mesh(b);
    curvopt_deviation d;
    curvopt_error error;
    memset(&d, 0xff, sizeof d);
    CHECK_OK(curvopt_measure_deviation(one, a->xyz, two, b->xyz, threads, NULL, &d, sizeof d, NULL, &error), &error);
    curvopt_mesh_destroy(one);
    curvopt_mesh_destroy(two);
    return d;
}

/* A bicubic piece from a seed, about a unit square. */
static void piece_of(uint64_t seed, double bend, double out[CO_BEZIER]) {
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++)
            for (int c = 0; c < 3; c++) {
                seed = seed * 6364136223846793005u + 1442695040888963407u;
                out[12 * j + 3 * i + c] = (c == 0   ? i / 3.0
                                           : c == 1 ? j / 3.0
                                                    : 0) +
                                          bend * ((double)(seed >> 40) / (double)(1 << 24) - 0.5);
            }
}

static void test_parts_are_parts(void **state) {
    double piece[CO_BEZIER], part[CO_BEZIER], x[3], y[3];
    const double u[2] = {0.625, 0.125}, v[2] = {0.25, 0.75}; /* u runs backwards */
    (void)state;
    piece_of(3, 0.6, piece);
    co_bezier_part(piece, u, v, part);
    for (int k = 0; k < 9; k++) {
        const double s = k % 3 * 0.4, t = k / 3 * 0.3;
        co_bezier_point(part, s, t, x);
        co_bezier_point(piece, u[0] + s * (u[1] - u[0]), v[0] + t * (v[1] - v[0]), y);
        CHECK_NEAR(co_distance3_squared(x, y), 0, 1e-28);
    }
}

static void test_nearest_on_piece_is_least_of_a_grid(void **state) {
    static const double whole[2] = {0, 1};
    double piece[CO_BEZIER], y[3];
    (void)state;
    for (uint64_t seed = 1; seed < 20; seed++) {
        const double x[3] = {0.1 * (double)(seed % 11), 0.07 * (double)(seed % 13), 0.3};
        double uv[2] = {0.5, 0.5}, at[3], least = 1e300;
        piece_of(seed, 0.2, piece);
        const double got = co_nearest_on_piece(piece, x, whole, whole, uv, at, NULL);
        for (int k = 0; k <= 100; k++)
            for (int i = 0; i <= 100; i++) {
                co_bezier_point(piece, i / 100.0, k / 100.0, y);
                least = fmin(least, sqrt(co_distance3_squared(x, y)));
            }
        CHECK_BETWEEN(got, least - 1e-3, least + 1e-12);
        CHECK_NEAR(sqrt(co_distance3_squared(x, at)), got, 1e-14);
    }
}

/* An oriented box holds its piece: points of the piece are at distance 0, no point is nearer to the piece than to the
 * box, and a flat piece at a slant has a flat box. A piece that is one line has a box, too. */
static void test_oriented_boxes(void **state) {
    static const double whole[2] = {0, 1};
    double piece[CO_BEZIER], at[3];
    (void)state;
    for (uint64_t seed = 1; seed < 20; seed++) {
        const double x[3] = {0.3 * (double)(seed % 11) - 1, 0.2 * (double)(seed % 13) - 1, 0.7};
        double uv[2] = {0.5, 0.5}, y[3];
        piece_of(seed, seed % 3 ? 0.2 : 0, piece);
        for (size_t k = 0; k < 16; k++) { /* turned by a shear */
            piece[3 * k + 2] += 0.8 * piece[3 * k];
            if (seed == 6)
                piece[3 * k + 1] = 0;
        }
        const co_oriented_box box = co_oriented_box_of(piece);
        const double distance = co_nearest_on_piece(piece, x, whole, whole, uv, at, NULL);
        CHECK_BETWEEN(sqrt(co_oriented_box_distance_squared(&box, x)), 0, distance * (1 + 1e-12));
        for (int k = 0; k <= 100; k++) {
            co_bezier_point(piece, k / 10 * 0.1, k % 10 * 0.1, y);
            CHECK_NEAR(co_oriented_box_distance_squared(&box, y), 0, 1e-28);
        }
        if (seed % 3 == 0 && seed != 6)
            CHECK_NEAR(box.half[2], 0, 1e-15);
    }
}

/* Pieces that are one line but for rounding, whose normals are nothing but rounding. */
static void test_oriented_boxes_of_lines(void **state) {
    double piece[CO_BEZIER], y[3];
    (void)state;
    for (int seed = 1; seed < 200; seed++) {
        const double direction[3] = {sin(1.3 * seed), cos(2.7 * seed), sin(0.77 * seed + 1)}, x[3] = {1, 2, -1};
        double least = INFINITY;
        for (int k = 0; k < 16; k++)
            for (int c = 0; c < 3; c++)
                piece[3 * k + c] = 0.1 * c + (k % 4 / 3.0 + 0.7 * (k / 4) / 3.0) * direction[c];
        const co_oriented_box box = co_oriented_box_of(piece);
        for (int k = 0; k <= 400; k++) {
            co_bezier_point(piece, k / 400.0, k / 400.0, y);
            least = fmin(least, sqrt(co_distance3_squared(x, y)));
            CHECK_NEAR(co_oriented_box_distance_squared(&box, y), 0, 1e-28);
        }
        CHECK_BETWEEN(sqrt(co_oriented_box_distance_squared(&box, x)), 0, least * (1 + 1e-12));
    }
}

/* The bound holds at all points of a grid, and is close for small parts. */
static void test_bound_of_a_part(void **state) {
    static const double whole[2] = {0, 1};
    double a[CO_BEZIER], b[CO_BEZIER], part[CO_BEZIER], x[3], at[3];
    int32_t n_steps = 0;
    (void)state;
    for (uint64_t seed = 1; seed < 40; seed++) {
        const double side = seed % 2 ? 0.25 : 0.0625, u[2] = {0.3, 0.3 + side}, v[2] = {0.4, 0.4 + side};
        double uv[2] = {0.35, 0.45}, largest = 0;
        piece_of(seed, 0.3, a);
        piece_of(seed + 100, 0.3, b);
        co_bezier_part(a, u, v, part);
        co_bezier_point(part, 0.5, 0.5, x);
        co_nearest_on_piece(b, x, whole, whole, uv, at, NULL);
        const double bound = co_deviation_bound(part, b, uv, &n_steps);
        for (int k = 0; k <= 20; k++)
            for (int i = 0; i <= 20; i++) {
                double near[2] = {uv[0], uv[1]};
                co_bezier_point(part, i / 20.0, k / 20.0, x);
                largest = fmax(largest, co_nearest_on_piece(b, x, whole, whole, near, at, NULL));
            }
        CHECK_TRUE(bound >= largest * (1 - 1e-12));
        if (side < 0.1)
            CHECK_TRUE(bound < largest + 0.02);
    }
}

static void test_translation_and_units(void **state) {
    cage a = cage_torus(8, 6, 1, 0.4), b = cage_torus(8, 6, 1, 0.4);
    (void)state;
    for (int32_t v = 0; v < b.n_vertices; v++)
        b.xyz[3 * v + 2] += 0.01;
    curvopt_deviation d = measure(&a, &b, 2);
    CHECK_BETWEEN(d.max, 0.0098, 0.01 + 1e-12);
    CHECK_BETWEEN(d.bound, 0.01 - 1e-12, 0.012);
    CHECK_BETWEEN(d.rms, 0.004, 0.01);
    for (int32_t i = 0; i < 3 * a.n_vertices; i++) {
        a.xyz[i] *= 8;
        b.xyz[i] *= 8;
    }
    curvopt_deviation big = measure(&a, &b, 1);
    CHECK_NEAR(big.max, 8 * d.max, 1e-9);
    CHECK_NEAR(big.bound, 8 * d.bound, 1e-9);
    CHECK_NEAR(big.size, 8 * d.size, 1e-12);
    cage_free(&a);
    cage_free(&b);
}

/* Of a cage with corners of three and four faces and triangles: what is found near a point is never farther than a
 * dense sample of the surface, tips included. */
static void test_nearest_is_the_least_of_all_patches(void **state) {
    enum { SIDE = 12 };
    cage c = cage_shaken(cage_both(cage_prism(5), cage_tetrahedron(), 1.5), 0.2);
    curvopt_mesh *mesh = cage_mesh(&c);
    co_surface_pieces pieces;
    co_nearest nearest;
    co_thread_pool *pool;
    curvopt_error error;
    double y[3];
    uint64_t seed = 7;
    (void)state;
    CHECK_OK(co_thread_pool_create(1, &pool, &error), &error);
    CHECK_OK(co_pieces_create(mesh, c.xyz, 1.0 / 16, pool, NULL, &pieces, &error), &error);
    CHECK_OK(co_nearest_create(&pieces, NULL, &nearest, &error), &error);
    CHECK_INT(nearest.first[pieces.patches.n_patches], nearest.n_parts);
    for (int n = 0; n < 200; n++) {
        const double x[3] = {3 * check_random(&seed) - 1, 3 * check_random(&seed) - 1.5, 3 * check_random(&seed) - 1.5};
        double least = (double)INFINITY;
        co_surface_point found[2];
        for (int32_t k = 0; k < pieces.n_pieces; k++)
            for (int i = 0; i < SIDE * SIDE; i++) {
                co_bezier_point(co_pieces_bezier(&pieces, k), i / SIDE / (SIDE - 1.0), i % SIDE / (SIDE - 1.0), y);
                least = fmin(least, sqrt(co_distance3_squared(x, y)));
            }
        for (int32_t t = 0; t < pieces.n_tips; t++)
            least = fmin(least, sqrt(co_distance3_squared(x, pieces.tip[t].at)));
        co_nearest_find(&nearest, x, -1, &found[0]);
        co_nearest_find(&nearest, x, n % nearest.n_parts, &found[1]);
        CHECK_BETWEEN(found[0].distance, least - 0.02, least + 1e-12);
        CHECK_NEAR(found[1].distance, found[0].distance, 1e-12);
    }
    for (int32_t t = 0; t < pieces.n_tips; t++) { /* a patch's box holds its tip */
        co_surface_point found;
        co_nearest_find(&nearest, pieces.tip[t].at, -1, &found);
        CHECK_NEAR(found.distance, 0, 1e-12);
    }
    co_nearest_free(&nearest);
    co_pieces_free(&pieces);
    co_thread_pool_destroy(pool);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* With that many steps of Newton's method, by pieces with tips of 1e-3. */
static co_deviation measured_with(const cage of[2], size_t budget) {
    curvopt_mesh *mesh[2];
    co_surface_pieces pieces[2];
    co_nearest nearest[2];
    co_thread_pool *pool;
    co_deviation out;
    curvopt_error error;
    CHECK_OK(co_thread_pool_create(1, &pool, &error), &error);
    for (int k = 0; k < 2; k++) {
        mesh[k] = cage_mesh(&of[k]);
        CHECK_OK(co_pieces_create(mesh[k], of[k].xyz, 1e-3, pool, NULL, &pieces[k], &error), &error);
        CHECK_OK(co_nearest_create(&pieces[k], NULL, &nearest[k], &error), &error);
    }
    CHECK_OK(co_deviation_measure(nearest, budget, pool, NULL, &out, &error), &error);
    for (int k = 0; k < 2; k++) {
        co_nearest_free(&nearest[k]);
        co_pieces_free(&pieces[k]);
        curvopt_mesh_destroy(mesh[k]);
    }
    co_thread_pool_destroy(pool);
    return out;
}

/* With few steps the bound is larger, and still one. Of many patches only groups are looked at then. */
static void test_few_steps(void **state) {
    cage small[2] = {cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), cage_torus(8, 6, 1, 0.4)},
         large[2] = {cage_torus(120, 60, 1, 0.4), cage_torus(120, 60, 1, 0.5)};
    (void)state;
    co_deviation many = measured_with(small, 20000000), few = measured_with(small, many.n_steps / 3);
    CHECK_TRUE(few.n_parts >= 96 && few.n_steps <= many.n_steps / 3 && few.n_parts < many.n_parts);
    CHECK_TRUE(few.bound >= many.max && few.bound > many.bound);
    CHECK_BETWEEN(many.bound, many.max, 1.2 * many.max);
    many = measured_with(large, 20000000);
    few = measured_with(large, 1);
    CHECK_INT(few.n_parts, 0);
    CHECK_BETWEEN(few.bound, many.max, 4 * many.max);
    for (int k = 0; k < 2; k++) {
        cage_free(&small[k]);
        cage_free(&large[k]);
    }
}

static void test_same_surface(void **state) {
    cage a = cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05),
         b = cage_refined(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), 1);
    (void)state;
    curvopt_deviation d = measure(&a, &b, 2);
    CHECK_BETWEEN(d.bound, 0, 1e-9);
    CHECK_BETWEEN(d.max, 0, d.bound);
    cage_free(&a);
    cage_free(&b);
}

/* A cage, and the same subdivided and moved: vertices correspond. Turned faces are others. */
static void test_corresponding_cages(void **state) {
    cage a = cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), turned = cage_torus(8, 6, 1, 0.4),
         b = cage_refined(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05), 2);
    (void)state;
    b.xyz[5] += 0.25;
    b.xyz[31] -= 0.5;
    const int32_t first = turned.vertices[0]; /* its face begins with another corner */
    memmove(turned.vertices, turned.vertices + 1, 3 * sizeof first);
    turned.vertices[3] = first;
    curvopt_mesh *mesh[3] = {cage_mesh(&a), cage_mesh(&b), cage_mesh(&turned)};
    const curvopt_mesh *both[2] = {mesh[0], mesh[1]};
    const double *xyz[2] = {a.xyz, b.xyz};
    curvopt_error error;
    double farthest = 0;
    for (int order = 0; order < 2; order++) {
        CHECK_OK(co_correspondence_farthest(both, xyz, &farthest, &error), &error);
        CHECK_NEAR(farthest, 0.5, 1e-12);
        both[0] = mesh[1];
        both[1] = mesh[0];
        xyz[0] = b.xyz;
        xyz[1] = a.xyz;
    }
    curvopt_deviation d = measure(&a, &b, 1);
    CHECK_BETWEEN(d.bound, d.max, 0.5);
    both[0] = mesh[2];
    xyz[0] = turned.xyz;
    CHECK_OK(co_correspondence_farthest(both, xyz, &farthest, &error), &error);
    assert_true(isinf(farthest));
    for (int k = 0; k < 3; k++)
        curvopt_mesh_destroy(mesh[k]);
    cage_free(&a);
    cage_free(&b);
    cage_free(&turned);
}

/* With many patches they are looked at in groups, and the mean takes one point of each: of the same surface by fewer
 * patches all is the same. */
static void test_many_patches(void **state) {
    curvopt_deviation d[2];
    (void)state;
    for (int k = 0; k < 2; k++) { /* 1 536 and 24 576 faces */
        cage a = cage_refined(cage_shaken(cage_refined(cage_cube(), 1), 0.1), k ? 5 : 3),
             b = cage_refined(cage_cube(), 2);
        d[k] = measure(&a, &b, 2);
        cage_free(&a);
        cage_free(&b);
    }
    CHECK_BETWEEN(d[0].rms, 1e-3, 1);
    CHECK_NEAR(d[1].rms, d[0].rms, 1e-3 * d[0].rms);
    CHECK_NEAR(d[1].max, d[0].max, 1e-3 * d[0].max);
    CHECK_BETWEEN(d[1].bound, d[0].max, 1.15 * d[1].max);
}

/* Every quad cut in two. */
static cage triangles(cage c) {
    cage out = {.n_vertices = c.n_vertices, .n_faces = 2 * c.n_faces, .xyz = c.xyz};
    out.sizes = malloc(sizeof *out.sizes * (size_t)out.n_faces);
    out.vertices = malloc(sizeof *out.vertices * 3 * (size_t)out.n_faces);
    for (int32_t f = 0; f < out.n_faces; f++) {
        const int32_t *quad = c.vertices + 4 * (size_t)(f / 2);
        out.sizes[f] = 3;
        for (int k = 0; k < 3; k++)
            out.vertices[3 * f + k] = quad[(k + 2 * (f % 2)) % 4];
    }
    c.xyz = NULL;
    cage_free(&c);
    return out;
}

/* With many patches one at an extraordinary vertex has one point that stands for a quarter of it four times. One in
 * eight of 31 104 is such a patch; of the same surface by 7 776 one in two, but there are many points in each. */
static void test_mean_of_many_extraordinary_patches(void **state) {
    double rms[2];
    (void)state;
    for (int k = 0; k < 2; k++) {
        cage a = triangles(cage_torus(18, 18, 1, 0.4)), b = cage_torus(18, 18, 1, 0.4);
        for (int32_t v = 0; v < a.n_vertices; v += 7)
            for (int c = 0; c < 3; c++)
                a.xyz[3 * v + c] *= 1.2;
        a = cage_refined(a, 3 * k);
        rms[k] = measure(&a, &b, 2).rms;
        cage_free(&a);
        cage_free(&b);
    }
    CHECK_NEAR(rms[1], rms[0], 1e-3 * rms[0]);
}

/* The largest distance of a surface's vertices, and of points between them: of the vertices of the cage refined. */
static double largest_distance(const cage *a, const cage *b) {
    cage fine = cage_of(b->n_vertices, b->n_faces, b->sizes, b->vertices, b->xyz);
    fine = cage_refined(fine, 1);
    curvopt_mesh *mesh[2] = {cage_mesh(a), cage_mesh(&fine)};
    double *distances = malloc(sizeof *distances * (size_t)fine.n_vertices), largest = 0;
    curvopt_deviation d;
    curvopt_error error;
    CHECK_OK(curvopt_measure_deviation(mesh[0], a->xyz, mesh[1], fine.xyz, 2, NULL, &d, sizeof d, distances, &error),
             &error);
    for (int32_t k = 0; k < fine.n_vertices; k++)
        largest = fmax(largest, distances[k]);
    free(distances);
    for (int k = 0; k < 2; k++)
        curvopt_mesh_destroy(mesh[k]);
    cage_free(&fine);
    return largest;
}

/* 24 000 patches each, which are looked at in groups: what one patch has is not hidden by the others of its group. */
static void test_groups_of_patches(void **state) {
    cage a = cage_torus(160, 150, 1, 0.4), b = cage_torus(160, 150, 1, 0.4);
    (void)state;
    for (int32_t v = 9775; v < b.n_vertices; v += 9770) { /* a dent of one vertex */
        b.xyz[3 * v + 2] += 0.02;
        const curvopt_deviation d = measure(&a, &b, 2);
        const double largest = largest_distance(&a, &b);
        CHECK_BETWEEN(d.max, 0.9999 * largest, d.bound);
        CHECK_BETWEEN(d.bound, largest, 1.15 * d.max);
        b.xyz[3 * v + 2] -= 0.02;
    }
    cage_free(&a);
    cage_free(&b);
}

static void test_refusals(void **state) {
    cage a = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&a);
    curvopt_deviation d;
    curvopt_error error;
    (void)state;
    CHECK_REFUSED(curvopt_measure_deviation(mesh, a.xyz, mesh, NULL, 1, NULL, &d, sizeof d, NULL, &error), &error,
                  CURVOPT_ERROR_ARGUMENT, -1, "other_xyz");
    CHECK_REFUSED(curvopt_measure_deviation(mesh, a.xyz, NULL, a.xyz, 1, NULL, &d, sizeof d, NULL, &error), &error,
                  CURVOPT_ERROR_ARGUMENT, -1, "other");
    CHECK_REFUSED(curvopt_measure_deviation(mesh, a.xyz, mesh, a.xyz, -1, NULL, &d, sizeof d, NULL, &error), &error,
                  CURVOPT_ERROR_ARGUMENT, -1, "threads");
    a.xyz[4] = (double)NAN;
    CHECK_REFUSED(curvopt_measure_deviation(mesh, a.xyz, mesh, a.xyz, 1, NULL, &d, sizeof d, NULL, &error), &error,
                  CURVOPT_ERROR_GEOMETRY, 1, "1");
    curvopt_mesh_destroy(mesh);
    cage_free(&a);
}

static void test_cancelled_bound_still_holds(void **state) {
    cage a = cage_torus(8, 6, 1, 0.4), b = cage_torus(8, 6, 1, 0.5);
    curvopt_mesh *mesh = cage_mesh(&a);
    curvopt_cancel *cancel = NULL;
    curvopt_deviation d;
    curvopt_error error;
    (void)state;
    curvopt_deviation whole = measure(&a, &b, 1);
    CHECK_OK(curvopt_cancel_create(&cancel, &error), &error);
    curvopt_cancel_request(cancel);
    double distances[48] = {0};
    CHECK_OK(curvopt_measure_deviation(mesh, a.xyz, mesh, b.xyz, 1, cancel, &d, sizeof d, distances, &error), &error);
    CHECK_TRUE(d.bound >= whole.max && d.max <= whole.bound && isnan(d.rms) && isnan(distances[47]));
    CHECK_TRUE(isfinite(d.bound) && d.max == 0 && isnan(d.point[0]) && isnan(d.other_point[2]));
    CHECK_NEAR(d.size, whole.size, 1e-12);
    curvopt_cancel_destroy(cancel);
    curvopt_mesh_destroy(mesh);
    cage_free(&a);
    cage_free(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts_are_parts),
        cmocka_unit_test(test_nearest_on_piece_is_least_of_a_grid),
        cmocka_unit_test(test_oriented_boxes),
        cmocka_unit_test(test_oriented_boxes_of_lines),
        cmocka_unit_test(test_nearest_is_the_least_of_all_patches),
        cmocka_unit_test(test_few_steps),
        cmocka_unit_test(test_bound_of_a_part),
        cmocka_unit_test(test_translation_and_units),
        cmocka_unit_test(test_same_surface),
        cmocka_unit_test(test_corresponding_cages),
        cmocka_unit_test(test_many_patches),
        cmocka_unit_test(test_mean_of_many_extraordinary_patches),
        cmocka_unit_test(test_groups_of_patches),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_cancelled_bound_still_holds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
