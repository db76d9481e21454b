/* Chains of edges on curves: splines against polynomials and sines, what is held on each level, how long the rows of a
 * long chain are, what gives way. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "constraints/given_constraints.h"
#include "constraints/given_through.h"
#include "constraints/interpolation.h"
#include "constraints/pivots.h"
#include "linalg/cubic_spline.h"
#include "mesh/subdivide.h"

static const double TURN = 6.283185307179586;

/* ----------------------------------------------------------------------------------------------- splines -- */

/* A polynomial of the degree that so many knots can tell, and a line beside it. */
static void polynomial(int degree, double t, double jet[3][2]) {
    memset(jet, 0, 6 * sizeof(double));
    for (int k = 0; k <= degree; k++) {
        const double a = 1.5 - k;
        jet[0][0] += a * pow(t, k);
        jet[1][0] += k > 0 ? a * k * pow(t, k - 1) : 0;
        jet[2][0] += k > 1 ? a * k * (k - 1) * pow(t, k - 2) : 0;
    }
    jet[0][1] = 2 - t;
    jet[1][1] = -1;
}

static void test_open_splines_are_cubics_where_values_are(void **state) {
    (void)state;
    const double knot[7] = {-1, -0.25, 0.5, 0.75, 1.5, 1.625, 2.5};
    for (int32_t n = 2; n <= 7; n++) {
        const int degree = n < 4 ? n - 1 : 3;
        double value[14], jet[3][2], wanted[3][2];
        co_cubic_spline spline;
        curvopt_error error;
        for (int i = 0; i < n; i++) {
            polynomial(degree, knot[i], wanted);
            memcpy(value + (size_t)(2 * i), wanted[0], 2 * sizeof(double));
        }
        CHECK_OK(co_cubic_spline_create(n, 2, 0, knot, value, &spline, &error), &error);
        for (double t = -1.25; t < knot[n - 1] + 0.25; t += 0.0625) {
            co_cubic_spline_at(&spline, t, jet[0]);
            polynomial(degree, t, wanted);
            for (int k = 0; k < 6; k++)
                CHECK_NEAR(jet[k / 2][k % 2], wanted[k / 2][k % 2], 1e-12);
        }
        co_cubic_spline_free(&spline);
    }
}

/* Largest distance of the periodic spline through n uneven points of a sine from it, and of its second derivative's
 * jumps. */
static double periodic_error(int32_t n, double *jump) {
    double *knot = calloc(2 * (size_t)(n + 1), sizeof *knot), *value = knot + n + 1, most = 0;
    co_cubic_spline spline;
    curvopt_error error;
    CHECK_TRUE(knot != NULL);
    for (int32_t i = 0; i <= n; i++) {
        knot[i] = 0.5 + TURN * i / n + 0.2 * sin(TURN * i / n);
        value[i] = sin(knot[i]);
    }
    value[n] = value[0];
    CHECK_OK(co_cubic_spline_create(n + 1, 1, 1, knot, value, &spline, &error), &error);
    *jump = 0;
    for (int32_t i = 0; i < n; i++) {
        double before[3], after[3];
        co_cubic_spline_at(&spline, knot[i] - 1e-9, before);
        co_cubic_spline_at(&spline, knot[i] + 1e-9, after);
        *jump = fmax(*jump, fmax(fabs(after[1] - before[1]), fabs(after[2] - before[2])));
    }
    for (double t = -7; t < 14; t += 0.01) {
        double jet[3];
        co_cubic_spline_at(&spline, t, jet);
        most = fmax(most, fabs(jet[0] - sin(t)));
    }
    co_cubic_spline_free(&spline);
    free(knot);
    return most;
}

static void test_periodic_splines_come_to_a_sine_with_order_4(void **state) {
    (void)state;
    double jump, last = 0;
    CHECK_TRUE(periodic_error(3, &jump) < 0.5);
    CHECK_TRUE(jump < 1e-6);
    for (int32_t n = 16; n <= 128; n *= 2) {
        const double now = periodic_error(n, &jump);
        CHECK_TRUE(jump < 1e-6);
        if (n > 16)
            CHECK_BETWEEN(log2(last / now), 3.7, 4.6);
        last = now;
    }
}

/* ------------------------------------------------------------------------------------------------ chains -- */

enum { N_POINTS = 300 };

typedef struct setting {
    cage cage;
    curvopt_mesh *mesh;
    double curve[3 * N_POINTS];
    int32_t vertices[256];
    curvopt_chain chain;
    curvopt_through through;
    curvopt_options options;
    co_constraints held;
} setting;

/* A chain of n vertices round the axis of a torus, outside, on a circle that is a little wider. */
static void set_up(setting *s, int32_t n_u, int32_t n_v, int32_t n, int is_closed) {
    memset(s, 0, sizeof *s);
    s->cage = cage_torus(n_u, n_v, 1, 0.4);
    s->mesh = cage_mesh(&s->cage);
    for (int i = 0; i < N_POINTS; i++) {
        s->curve[3 * i] = 1.4 * cos(TURN * i / N_POINTS);
        s->curve[3 * i + 1] = 1.4 * sin(TURN * i / N_POINTS);
    }
    for (int32_t i = 0; i < n; i++)
        s->vertices[i] = n_v * i;
    s->chain = (curvopt_chain){.vertices = s->vertices,
                               .curve = s->curve,
                               .n_vertices = n,
                               .n_points = N_POINTS,
                               .is_closed = is_closed,
                               .is_curve_closed = 1};
    s->through = (curvopt_through){.struct_size = sizeof s->through, .chains = &s->chain, .n_chains = 1};
    curvopt_options_init(&s->options, sizeof s->options);
    s->options.through = &s->through;
    s->options.levels = 1;
}

static void tear_down(setting *s) {
    co_constraints_free(&s->held);
    curvopt_mesh_destroy(s->mesh);
    cage_free(&s->cage);
}

/* The next level, with what is held on it. */
static void subdivide(setting *s) {
    curvopt_mesh *fine;
    co_sparse_rows rows;
    curvopt_error error;
    CHECK_OK(co_subdivide(s->mesh, &fine, &rows, &error), &error);
    double *xyz = calloc(3 * (size_t)rows.n_rows, sizeof *xyz);
    CHECK_TRUE(xyz != NULL);
    co_sparse_rows_apply(&rows, s->cage.xyz, xyz);
    CHECK_OK(co_constraints_subdivide(s->mesh, fine, &rows, xyz, &s->held, &error), &error);
    co_sparse_rows_free(&rows);
    curvopt_mesh_destroy(s->mesh);
    free(s->cage.xyz);
    s->mesh = fine;
    s->cage.xyz = xyz;
}

static double off_circle(const double *p) {
    return hypot(hypot(p[0], p[1]) - 1.4, p[2]);
}

/* Each vertex of the chain, those on the finer level too, and two middles. */
static void test_every_level_holds_the_chain_anew(void **state) {
    (void)state;
    setting s;
    curvopt_error error;
    set_up(&s, 12, 5, 5, 0);
    CHECK_OK(co_given_through_create(s.mesh, s.cage.xyz, &s.options, &s.held, &error), &error);
    for (int level = 1; level <= 3; level++) {
        const int n = 4 * (1 << (level - 1)) + 1, n_vertices = s.mesh->info.n_vertices;
        const co_chain *chain = &s.held.chains.item[0];
        int n_held = 0;
        CHECK_INT(chain->n, n);
        CHECK_INT(s.held.values.n, 2);
        for (int k = 0; k < 2; k++)
            CHECK_TRUE(s.held.values.item[k].is_optional && off_circle(s.held.values.item[k].anchor) < 1e-8);
        for (int32_t v = 0; v < n_vertices; v++) {
            n_held += s.held.freedom[v] != CO_FREEDOM_ALL;
            if (s.held.freedom[v] != CO_FREEDOM_ALL)
                CHECK_TRUE(s.held.of_limit[v] == CO_OF_OWN_POINT && off_circle(s.held.anchor + 3 * v) < 1e-8);
        }
        CHECK_INT(n_held, n);
        for (int i = 0; i < n; i++)
            CHECK_TRUE(s.held.of_limit[chain->vertex[i]] &&
                       (i == 0 || co_chains_find_edge(s.mesh, chain->vertex[i - 1], chain->vertex[i]) >= 0));
        subdivide(&s);
    }
    tear_down(&s);
}

/* A right angle in the middle of a curve through one point for each vertex: the spline bends by more than a radian
 * along its end edges on the first level, and by a quarter of that on the third. Held or drawn, there the middles
 * count. */
static void test_middles_wait_for_a_level_that_is_fine_enough(void **state) {
    (void)state;
    static const double curve[15] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 2, 1, 0, 2, 2, 0}, at[5] = {0, 1, 2, 3, 4};
    const double weight = 0.75;
    for (int is_drawn = 0; is_drawn < 2; is_drawn++) {
        setting s;
        curvopt_error error;
        set_up(&s, 12, 5, 5, 0);
        memcpy(s.curve, curve, sizeof curve);
        s.chain.parameters = at;
        s.chain.n_points = 5;
        s.chain.is_curve_closed = 0;
        s.through.chain_weights = is_drawn ? &weight : NULL;
        CHECK_OK(co_given_through_create(s.mesh, s.cage.xyz, &s.options, &s.held, &error), &error);
        for (int level = 1; level <= 3; level++) {
            const int n_middles = level < 3 ? 0 : 2, n = 4 * (1 << (level - 1)) + 1;
            double sum = 0;
            CHECK_INT(s.held.values.n, is_drawn ? 0 : n_middles);
            CHECK_INT(s.held.drawn.n, is_drawn ? n + n_middles : 0);
            for (int k = 0; k < s.held.drawn.n; k++)
                sum += s.held.drawn.item[k].stiffness;
            CHECK_NEAR(sum, is_drawn ? 3.0 * 4 : 0, 1e-12);
            subdivide(&s);
        }
        tear_down(&s);
    }
}

/* Springs of a chain: none of its points is held, all are on the circle, and their stiffnesses add up to that of its
 * edges on the first level, on every one: with middles of end edges or without. */
static void test_a_drawn_chain_is_as_stiff_on_every_level(void **state) {
    (void)state;
    const double weight = 0.75;
    for (int is_closed = 0; is_closed < 2; is_closed++) {
        setting s;
        curvopt_error error;
        const int n_edges = is_closed ? 12 : 4;
        set_up(&s, 12, 5, is_closed ? 12 : 5, is_closed);
        s.through.chain_weights = &weight;
        CHECK_OK(co_given_through_create(s.mesh, s.cage.xyz, &s.options, &s.held, &error), &error);
        for (int level = 1; level <= 3; level++) {
            const int n = n_edges * (1 << (level - 1)) + (is_closed ? 0 : 3);
            double sum = 0;
            CHECK_INT(s.held.values.n, 0);
            CHECK_INT(s.held.drawn.n, n);
            for (int k = 0; k < n; k++) {
                const co_surface_value *f = &s.held.drawn.item[k];
                CHECK_TRUE(f->is_optional && f->stiffness > 0 && off_circle(f->anchor) < 1e-8);
                sum += f->stiffness;
            }
            CHECK_NEAR(sum, 3.0 * n_edges, 1e-12 * n_edges);
            for (int32_t v = 0; v < s.mesh->info.n_vertices; v++)
                CHECK_INT(s.held.freedom[v], CO_FREEDOM_ALL);
            subdivide(&s);
        }
        tear_down(&s);
    }
}

/* Entries of the inverse fall by .27 from vertex to vertex: rows of 61 chain vertices and the three rows of neighbours
 * are left of 200 and theirs, and the map there and back is the identity. */
static void test_rows_do_not_grow_with_the_chain(void **state) {
    (void)state;
    setting s;
    curvopt_error error;
    co_interpolation map;
    set_up(&s, 200, 5, 200, 1);
    CHECK_OK(co_given_through_create(s.mesh, s.cage.xyz, &s.options, &s.held, &error), &error);
    CHECK_OK(co_pivots_choose(s.mesh, NULL, &s.held, &error), &error);
    CHECK_OK(co_interpolation_create(s.mesh, &s.held, &map, &error), &error);
    CHECK_INT(map.limit.n_rows, 200);
    for (int32_t i = 0; i < 200; i++)
        CHECK_BETWEEN(map.cage.start[i + 1] - map.cage.start[i], 150, 210);
    double *xyz = calloc(3 * 1000, sizeof *xyz);
    CHECK_TRUE(xyz != NULL);
    memcpy(xyz, s.cage.xyz, 3 * 1000 * sizeof *xyz);
    co_interpolation_from_cage(&map, xyz);
    co_interpolation_to_cage(&map, xyz);
    for (int i = 0; i < 3 * 1000; i++)
        CHECK_NEAR(xyz[i], s.cage.xyz[i], 1e-14);
    free(xyz);
    co_interpolation_free(&map);
    tear_down(&s);
}

/* A normal at an open chain's first vertex is one of the curve's two freedoms at that end: the middle there yields. */
static void test_middles_yield_to_entries(void **state) {
    (void)state;
    const int32_t vertex = 0, free_point = CO_FREEDOM_ALL;
    const double normal[3] = {1, 0.1, 0.2};
    curvopt_error error;
    for (int has_normal = 0; has_normal < 2; has_normal++) {
        setting s;
        set_up(&s, 12, 5, 9, 0);
        s.through.n = has_normal;
        s.through.vertices = &vertex;
        s.through.freedom = &free_point;
        s.through.normals = normal;
        CHECK_OK(co_given_through_create(s.mesh, s.cage.xyz, &s.options, &s.held, &error), &error);
        CHECK_INT(s.held.values.n, 2 + 2 * has_normal);
        CHECK_OK(co_given_constraints_place(s.mesh, &s.held, CURVOPT_BOUNDARY_FREE, s.cage.xyz, &error), &error);
        CHECK_OK(co_pivots_choose(s.mesh, NULL, &s.held, &error), &error);
        for (int k = 0; k < s.held.values.n; k++) {
            const co_surface_value *f = &s.held.values.item[k];
            const int yields = has_normal && f->is_optional && k == 2;
            CHECK_INT(f->pivot < 0, yields);
        }
        tear_down(&s);
    }
}

/* Across a boundary a chain's limit curve ends without curvature, and has no freedom that a middle could hold; along
 * one it goes on. Of chains of a grid of 5 x 5 vertices, how many middles there are. */
static void test_no_middles_where_a_surface_ends(void **state) {
    (void)state;
    static const int32_t chains[5][4] = {
        {10, 11, 12, 13}, {11, 12, 13, 14}, {11, 12, 13, -1}, {11, 12, -1, -1}, {1, 2, 3, -1}};
    static const int32_t middles[5] = {1, 1, 2, 1, 2};
    static const double curve[6] = {-2, 0, 0.1, 6, 0, 0.1};
    int32_t sizes[16], corners[64], n = 0;
    double xyz[75];
    curvopt_error error;
    for (int i = 0; i < 25; i++) {
        xyz[3 * i] = i % 5;
        xyz[3 * i + 1] = i / 5;
        xyz[3 * i + 2] = 0;
        if (i % 5 == 4 || i >= 20)
            continue;
        const int32_t quad[4] = {i, i + 1, i + 6, i + 5};
        memcpy(corners + (size_t)(4 * n), quad, sizeof quad);
        sizes[n++] = 4;
    }
    cage c = cage_of(25, 16, sizes, corners, xyz);
    curvopt_mesh *mesh = cage_mesh(&c);
    for (int k = 0; k < 5; k++) {
        co_constraints held = {0};
        curvopt_chain chain = {.vertices = chains[k], .curve = curve, .n_points = 2};
        const curvopt_through through = {.struct_size = sizeof through, .chains = &chain, .n_chains = 1};
        curvopt_options o;
        curvopt_options_init(&o, sizeof o);
        o.through = &through;
        while (chain.n_vertices < 4 && chains[k][chain.n_vertices] >= 0)
            chain.n_vertices++;
        CHECK_OK(co_given_through_create(mesh, c.xyz, &o, &held, &error), &error);
        CHECK_INT(held.values.n, middles[k]);
        co_constraints_free(&held);
    }
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_open_splines_are_cubics_where_values_are),
        cmocka_unit_test(test_periodic_splines_come_to_a_sine_with_order_4),
        cmocka_unit_test(test_every_level_holds_the_chain_anew),
        cmocka_unit_test(test_middles_wait_for_a_level_that_is_fine_enough),
        cmocka_unit_test(test_a_drawn_chain_is_as_stiff_on_every_level),
        cmocka_unit_test(test_rows_do_not_grow_with_the_chain),
        cmocka_unit_test(test_middles_yield_to_entries),
        cmocka_unit_test(test_no_middles_where_a_surface_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
