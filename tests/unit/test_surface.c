/* Points of surfaces: refining a cage must not change its limit surface. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include <stdlib.h>

enum { JET = 30 };

static const int order_u[10] = {0, 1, 0, 2, 1, 0, 3, 2, 1, 0}, order_v[10] = {0, 0, 1, 0, 1, 2, 0, 1, 2, 3};

static curvopt_sampler *sampler_of(const curvopt_mesh *mesh, const double *xyz, int32_t surface, int32_t blend_width) {
    curvopt_options o;
    curvopt_sampler *sampler;
    curvopt_error error;
    curvopt_options_init(&o, sizeof o);
    o.surface = surface;
    o.blend_width = blend_width;
    CHECK_OK(curvopt_sampler_create(mesh, xyz, &o, &sampler, &error), &error);
    return sampler;
}

static void jets_at(const curvopt_mesh *mesh, const double *xyz, int32_t surface, int32_t face, int32_t corner,
                    double u, double v, double *jets) {
    const double uv[2] = {u, v};
    curvopt_error error;
    curvopt_sampler *sampler = sampler_of(mesh, xyz, surface, CURVOPT_MAX_BLEND_WIDTH);
    CHECK_OK(curvopt_sampler_jets(sampler, 1, &face, &corner, uv, jets, &error), &error);
    curvopt_sampler_destroy(sampler);
}

/* The same place on the cage and on its subdivision, whose child k of a face has its corner 0 at the face's corner k.
 */
static void check_refined(cage c, double u, double v) {
    curvopt_mesh *mesh = cage_mesh(&c), *fine;
    curvopt_mesh_info info;
    curvopt_error error;
    curvopt_mesh_get_info(mesh, &info, sizeof info);
    double *xyz = calloc(3 * (size_t)(info.n_vertices + info.n_edges + info.n_faces), sizeof *xyz);
    CHECK_TRUE(xyz != NULL);
    CHECK_OK(curvopt_mesh_refine(mesh, c.xyz, &fine, xyz, &error), &error);
    for (int32_t f = 0, child = 0; f < c.n_faces; f++)
        for (int32_t k = 0; k < c.sizes[f]; k++, child++) {
            double coarse_jets[JET], fine_jets[JET];
            /* where the child's (u, v) lies on a quad: its corner k turned to the front */
            double x[4] = {u / 2, 1 - v / 2, 1 - u / 2, v / 2}, y[4] = {v / 2, u / 2, 1 - v / 2, 1 - u / 2};
            int quad = c.sizes[f] == 4;
            jets_at(fine, xyz, CURVOPT_SURFACE_LIMIT, child, 0, u, v, fine_jets);
            if (quad)
                jets_at(mesh, c.xyz, CURVOPT_SURFACE_LIMIT, f, 0, x[k], y[k], coarse_jets);
            else
                jets_at(mesh, c.xyz, CURVOPT_SURFACE_LIMIT, f, k, u, v, coarse_jets);
            for (int i = 0; i < JET; i++) {
                int order = order_u[i / 3] + order_v[i / 3];
                if (order > 0 && quad && k > 0) /* directions differ; positions tell */
                    continue;
                double scale = quad ? pow(0.5, order) : 1;
                CHECK_NEAR(scale * coarse_jets[i], fine_jets[i], 1e-12 * (1 + fabs(fine_jets[i])));
            }
        }
    free(xyz);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_subdivision_keeps_the_limit_surface(void **state) {
    (void)state;
    static const double places[][2] = {{0.3, 0.6}, {0.9, 0.05}, {0.02, 0.01}};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        double u = places[i][0], v = places[i][1];
        check_refined(cage_cube(), u, v);
        check_refined(cage_tetrahedron(), u, v);
        check_refined(cage_prism(5), u, v);
        check_refined(cage_trapezohedron(7), u, v);
        check_refined(cage_torus(5, 4, 1, 0.3), u, v);
    }
}

/* Each derivative against the difference of the one before it; 6 entries have derivatives within the jet. */
static void check_differences(int32_t surface, cage c, int32_t face) {
    curvopt_mesh *mesh = cage_mesh(&c);
    const double u = 0.41, v = 0.23, h = 1e-4;
    double at[JET], u_plus[JET], u_minus[JET], v_plus[JET], v_minus[JET];
    jets_at(mesh, c.xyz, surface, face, 0, u, v, at);
    jets_at(mesh, c.xyz, surface, face, 0, u + h, v, u_plus);
    jets_at(mesh, c.xyz, surface, face, 0, u - h, v, u_minus);
    jets_at(mesh, c.xyz, surface, face, 0, u, v + h, v_plus);
    jets_at(mesh, c.xyz, surface, face, 0, u, v - h, v_minus);
    for (int k = 0; k < 6; k++) {
        int order = order_u[k] + order_v[k] + 1, q = order_v[k];
        int by_u = order * (order + 1) / 2 + q, by_v = by_u + 1;
        for (int i = 0; i < 3; i++) {
            double scale = 1 + fabs(at[3 * by_u + i]) + fabs(at[3 * by_v + i]);
            CHECK_NEAR((u_plus[3 * k + i] - u_minus[3 * k + i]) / (2 * h), at[3 * by_u + i], 2e-4 * scale);
            CHECK_NEAR((v_plus[3 * k + i] - v_minus[3 * k + i]) / (2 * h), at[3 * by_v + i], 2e-4 * scale);
        }
    }
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_derivatives_are_slopes(void **state) {
    (void)state;
    check_differences(CURVOPT_SURFACE_LIMIT, cage_torus(6, 5, 1, 0.4), 7);
    for (int32_t face = 0; face < 4; face++) {
        check_differences(CURVOPT_SURFACE_LIMIT, cage_trapezohedron(5), face);
        check_differences(CURVOPT_SURFACE_PLANE, cage_trapezohedron(5), face);
    }
}

static void test_corner_of_a_regular_face_is_its_limit_mask(void **state) {
    (void)state;
    cage c = cage_torus(6, 5, 1, 0.4);
    curvopt_mesh *mesh = cage_mesh(&c);
    static const double mask[3] = {1.0 / 6, 2.0 / 3, 1.0 / 6};
    double jets[JET], expected[3] = {0};
    jets_at(mesh, c.xyz, CURVOPT_SURFACE_LIMIT, 7, 0, 0, 0, jets); /* face 7 begins at vertex 7 = (1, 2) */
    for (int i = -1; i <= 1; i++)
        for (int j = -1; j <= 1; j++)
            for (int k = 0; k < 3; k++)
                expected[k] += mask[i + 1] * mask[j + 1] * c.xyz[3 * (5 * (1 + i) + 2 + j) + k];
    for (int k = 0; k < 3; k++)
        CHECK_NEAR(jets[k], expected[k], 1e-15);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* AUTO is the surface that the weights ask for. */
static void test_sampler_takes_the_surface_of_its_options(void **state) {
    (void)state;
    cage c = cage_trapezohedron(5);
    curvopt_mesh *mesh = cage_mesh(&c);
    for (int third = 0; third < 2; third++) {
        curvopt_options o;
        curvopt_sampler *sampler;
        curvopt_error error;
        const int32_t face = 0, corner = 0;
        const double uv[2] = {0.1, 0.2};
        double got[JET], expected[JET];
        curvopt_options_init(&o, sizeof o);
        o.weights[CURVOPT_TERM_MVS] = third;
        CHECK_OK(curvopt_sampler_create(mesh, c.xyz, &o, &sampler, &error), &error);
        CHECK_OK(curvopt_sampler_jets(sampler, 1, &face, &corner, uv, got, &error), &error);
        jets_at(mesh, c.xyz, third ? CURVOPT_SURFACE_POLYNOMIAL : CURVOPT_SURFACE_LIMIT, 0, 0, 0.1, 0.2, expected);
        CHECK_TRUE(memcmp(got, expected, sizeof got) == 0);
        jets_at(mesh, c.xyz, third ? CURVOPT_SURFACE_LIMIT : CURVOPT_SURFACE_POLYNOMIAL, 0, 0, 0.1, 0.2, expected);
        CHECK_TRUE(memcmp(got, expected, sizeof got) != 0);
        curvopt_sampler_destroy(sampler);
    }
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_points_off_the_surface_are_refused(void **state) {
    (void)state;
    cage c = cage_prism(5);
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_sampler *sampler = sampler_of(mesh, c.xyz, CURVOPT_SURFACE_LIMIT, 1);
    curvopt_error error;
    double jets[2 * JET];
    static const struct {
        int32_t face, corner;
        double u, v;
        const char *part;
    } bad[] = {{7, 0, 0.5, 0.5, "face 7 of 7"},        {-1, 0, 0.5, 0.5, "face -1 of 7"},
               {2, 1, 0.5, 0.5, "corner 1"},           {0, 5, 0.5, 0.5, "corner 5"},
               {0, -1, 0.5, 0.5, "corner -1"},         {2, 0, 1.001, 0.5, "u = 1.001"},
               {2, 0, 0.5, -1e-9, "is not on face 2"}, {2, 0, (double)NAN, 0.5, "is not on face 2"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const int32_t face[2] = {2, bad[i].face}, corner[2] = {0, bad[i].corner};
        const double uv[4] = {0.5, 0.5, bad[i].u, bad[i].v};
        CHECK_REFUSED(curvopt_sampler_jets(sampler, 2, face, corner, uv, jets, &error), &error, CURVOPT_ERROR_ARGUMENT,
                      1, bad[i].part);
    }
    curvopt_sampler_destroy(sampler);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_bad_arguments_are_refused(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_error error;
    curvopt_options o;
    curvopt_sampler *sampler;
    const int32_t zero = 0, code = CURVOPT_ERROR_ARGUMENT;
    const double uv[2] = {0.5, 0.5};
    double jets[JET];
    curvopt_options_init(&o, sizeof o);
    CHECK_REFUSED(curvopt_sampler_create(mesh, c.xyz, &o, NULL, &error), &error, code, -1, "out is NULL");
    CHECK_REFUSED(curvopt_sampler_create(NULL, c.xyz, &o, &sampler, &error), &error, code, -1, "mesh is NULL");
    CHECK_REFUSED(curvopt_sampler_create(mesh, NULL, &o, &sampler, &error), &error, code, -1, "xyz is NULL");
    CHECK_REFUSED(curvopt_sampler_create(mesh, c.xyz, NULL, &sampler, &error), &error, code, -1, "options is NULL");
    CHECK_TRUE(sampler == NULL);
    o.surface = 4;
    CHECK_REFUSED(curvopt_sampler_create(mesh, c.xyz, &o, &sampler, &error), &error, code, -1, "surface is 4");
    curvopt_sampler_destroy(NULL);
    sampler = sampler_of(mesh, c.xyz, CURVOPT_SURFACE_AUTO, 1);
    CHECK_REFUSED(curvopt_sampler_jets(NULL, 1, &zero, &zero, uv, jets, &error), &error, code, -1, "sampler is NULL");
    CHECK_REFUSED(curvopt_sampler_jets(sampler, 1, NULL, &zero, uv, jets, &error), &error, code, -1, "face is NULL");
    CHECK_REFUSED(curvopt_sampler_jets(sampler, 1, &zero, NULL, uv, jets, &error), &error, code, -1, "corner is NULL");
    CHECK_REFUSED(curvopt_sampler_jets(sampler, 1, &zero, &zero, NULL, jets, &error), &error, code, -1, "uv is NULL");
    CHECK_REFUSED(curvopt_sampler_jets(sampler, 1, &zero, &zero, uv, NULL, &error), &error, code, -1, "jets is NULL");
    CHECK_REFUSED(curvopt_sampler_jets(sampler, -3, &zero, &zero, uv, jets, &error), &error, code, -1, "n is -3");
    CHECK_OK(curvopt_sampler_jets(sampler, 0, &zero, &zero, uv, jets, &error), &error);
    curvopt_sampler_destroy(sampler);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_subdivision_keeps_the_limit_surface),
        cmocka_unit_test(test_derivatives_are_slopes),
        cmocka_unit_test(test_corner_of_a_regular_face_is_its_limit_mask),
        cmocka_unit_test(test_sampler_takes_the_surface_of_its_options),
        cmocka_unit_test(test_points_off_the_surface_are_refused),
        cmocka_unit_test(test_bad_arguments_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
