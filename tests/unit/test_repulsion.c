/* What keeps a surface from crossing itself: value, gradient and Hessian against closed forms and differences.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "variables_setting.h"

#include "hessian/repulsion.h"
#include "measure/nearest.h"

enum { SIDE = 4, POINTS = (SIDE + 1) * (SIDE + 1) };

/* Two parallel squares of SIDE x SIDE unit faces, so far apart, facing each other. */
static cage sheets(double distance) {
    int32_t sizes[2 * SIDE * SIDE], vertices[8 * SIDE * SIDE], n = 0;
    double xyz[6 * POINTS];
    for (int sheet = 0; sheet < 2; sheet++)
        for (int i = 0; i <= SIDE; i++)
            for (int j = 0; j <= SIDE; j++) {
                double *x = xyz + 3 * (sheet * POINTS + i * (SIDE + 1) + j);
                x[0] = i;
                x[1] = j;
                x[2] = sheet * distance;
            }
    for (int sheet = 0; sheet < 2; sheet++)
        for (int i = 0; i < SIDE; i++)
            for (int j = 0; j < SIDE; j++, n++) {
                const int32_t first = sheet * POINTS + i * (SIDE + 1) + j;
                const int32_t corner[4] = {first, first + SIDE + 1, first + SIDE + 2, first + 1};
                sizes[n] = 4;
                for (int k = 0; k < 4; k++)
                    vertices[4 * n + k] = corner[sheet ? 3 - k : k];
            }
    return cage_of(2 * POINTS, n, sizes, vertices, xyz);
}

typedef struct setting {
    variables_setting v;
    int32_t n_refused;
    co_repulsion_exceptions exceptions;
    co_repulsion repulsion;
} setting;

/* Borrows nothing; the reach is in the normalized frame. */
static void begin(setting *s, cage c, int symmetric, double reach) {
    curvopt_error error;
    co_crossings none = {0};
    *s = (setting){.v = variables_setting_of(c, NULL, symmetric)};
    s->exceptions.n_refused = &s->n_refused;
    CHECK_OK(co_face_pairs_create(s->v.mesh, &none, &s->exceptions.pairs, &error), &error);
    CHECK_OK(co_repulsion_create(s->v.mesh, NULL, s->v.x, reach, &s->exceptions, NULL, &s->repulsion, &error), &error);
    s->repulsion.weight = 3;
}

static void end(setting *s) {
    co_repulsion_free(&s->repulsion);
    co_face_pairs_free(&s->exceptions.pairs);
    variables_setting_free(&s->v);
}

/* At s->v.z; gradient [n_variables] unless NULL. */
static double value(setting *s, double *gradient) {
    double *by_vertex = calloc(3 * (size_t)s->v.c.n_vertices, sizeof *by_vertex);
    CHECK_TRUE(by_vertex);
    co_dof_map_expand(&s->v.dofs, s->v.z, s->v.x);
    const double at = co_repulsion_value(&s->repulsion, s->v.x, gradient ? by_vertex : NULL);
    if (gradient)
        co_dof_map_gradient(&s->v.dofs, by_vertex, gradient);
    free(by_vertex);
    return at;
}

static void test_parallel_sheets(void **state) {
    (void)state;
    for (int k = 1; k < 8; k++) {
        const double distance = 0.051 * k;
        setting s;
        begin(&s, sheets(distance), 0, 1);
        s.repulsion.reach = 0.25 / s.v.radius;
        const double x = distance / 0.25, b = x < 1 ? -(x - 1) * (x - 1) * log(x) : 0;
        CHECK_NEAR(value(&s, NULL), 3 * b, 0.05 * b); /* but for the last eighths of faces at its corners */
        for (size_t i = 0; i < s.repulsion.facings.n; i++)
            CHECK_NEAR(s.repulsion.facings.pair[i].distance * s.v.radius, distance, 1e-12);
        CHECK_TRUE((s.repulsion.facings.n > 0) == (distance < 0.25));
        end(&s);
    }
}

static cage close_tori(void) {
    return cage_both(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.03), cage_torus(7, 5, 1, 0.4), 2.44);
}

/* Whether the point x of piece a is known to face y. */
static int faces(const co_facings *f, int32_t a, const double x[3], const double y[3]) {
    for (size_t i = 0; i < f->n; i++) {
        double square = 0;
        for (int c = 0; c < 3; c++) {
            const double d = x[c] - f->pair[i].distance * f->pair[i].along[c] - y[c];
            square += d * d;
        }
        if (f->pair[i].piece[0] == a && square < 1e-12)
            return 1;
    }
    return 0;
}

/* Whether x has one nearest point y on a piece, inside it and closer than the reach, wherever the search begins. */
static int has_one_inside(const double piece[CO_BEZIER], const double x[3], double reach, double y[3]) {
    static const double whole[2] = {0, 1};
    double first = 0, uv[2];
    for (int k = 0; k < 9; k++) {
        uv[0] = k % 3 * 0.5;
        uv[1] = k / 3 * 0.5;
        const double distance = co_nearest_on_piece(piece, x, whole, whole, uv, y, NULL);
        if (!(distance < reach) || fmin(uv[0], uv[1]) <= 0 || fmax(uv[0], uv[1]) >= 1 ||
            (k && fabs(distance - first) > 1e-9))
            return 0;
        first = distance;
    }
    return 1;
}

/* The number of such pairs of a grid's points of piece a and points of b, all of which must be known. */
static int check_facings_of(const co_repulsion *r, int32_t a, int32_t b) {
    int n = 0;
    for (int k = 0; k < 25; k++) {
        double x[3], y[3];
        co_bezier_point(co_pieces_bezier(&r->pieces, a), k % 5 / 4.0, k / 5 / 4.0, x);
        if (has_one_inside(co_pieces_bezier(&r->pieces, b), x, r->reach, y)) {
            CHECK_TRUE(faces(&r->facings, a, x, y));
            n++;
        }
    }
    return n;
}

/* What is left out without a look, because no normal leads there, is nothing: of rough surfaces, whose normals turn a
 * lot within a piece, all pairs of pieces. */
static void test_no_facing_is_left_out(void **state) {
    (void)state;
    for (int k = 0; k < 3; k++) {
        int n = 0;
        setting s;
        begin(&s, cage_both(cage_shaken(cage_torus(8, 6, 1, 0.4), 0.05 * (1 + k)), cage_torus(7, 5, 1, 0.4), 2.4), 0,
              0.5);
        value(&s, NULL);
        const co_surface_pieces *p = &s.repulsion.pieces;
        for (int32_t a = 0; a < p->n_pieces; a++)
            for (int32_t b = 0; b < p->n_pieces; b++)
                if (p->place[a].level == 0 && p->place[b].level <= 5 &&
                    !co_patch_neighbours_are(&s.repulsion.neighbours, p->patch[a], p->patch[b]))
                    n += check_facings_of(&s.repulsion, a, b);
        CHECK_TRUE(n > 100);
        end(&s);
    }
}

static void test_gradient_is_its_differences(void **state) {
    (void)state;
    for (int symmetric = 0; symmetric < 2; symmetric++) {
        setting s;
        cage c = symmetric ? cage_both(cage_torus(8, 6, 1, 0.4), cage_torus(8, 6, 1, 0.4), 2.44) : close_tori();
        const double step = 1e-5;
        begin(&s, c, symmetric, 0.15);
        const int n = s.v.dofs.n_variables;
        double *g = calloc((size_t)n, sizeof *g), largest = 0;
        CHECK_TRUE(g);
        CHECK_TRUE(value(&s, g) > 0 && s.repulsion.facings.n > 20);
        CHECK_TRUE(symmetric ? s.v.symmetry.order > 1 : n == 3 * s.v.c.n_vertices);
        for (int i = 0; i < n; i++)
            largest = fmax(largest, fabs(g[i]));
        for (int i = 0; i < n; i++) {
            const double at = s.v.z[i];
            s.v.z[i] = at + step;
            const double above = value(&s, NULL);
            s.v.z[i] = at - step;
            const double below = value(&s, NULL);
            s.v.z[i] = at;
            CHECK_NEAR(g[i], (above - below) / (2 * step), 2e-6 * largest);
        }
        free(g);
        end(&s);
    }
}

/* Squares of distances' slopes: of two sheets that move along their normals there is nothing else. */
static void test_hessian_of_parallel_sheets(void **state) {
    (void)state;
    setting s;
    curvopt_options o;
    curvopt_error error;
    co_basis_table_cache tables;
    co_assembly assembly;
    co_sparse_hessian hessian;
    co_couplings couplings;
    begin(&s, sheets(0.1), 0, 1);
    s.repulsion.reach = 0.25 / s.v.radius;
    curvopt_options_init(&o, sizeof o);
    o.surface = CURVOPT_SURFACE_LIMIT;
    co_basis_table_cache_create(o.surface, &tables);
    CHECK_OK(co_assembly_create(s.v.mesh, NULL, NULL, &o, &tables, NULL, &assembly, &error), &error);
    const double middle = value(&s, NULL);
    CHECK_OK(co_repulsion_couplings(&s.repulsion, &couplings, &error), &error);
    CHECK_OK(co_sparse_hessian_create(&assembly, &s.v.dofs, NULL, &hessian, &error), &error);
    CHECK_TRUE(!co_repulsion_is_covered(&s.repulsion, &hessian.pattern, &s.v.dofs));
    co_sparse_hessian_free(&hessian);
    CHECK_OK(co_sparse_hessian_create(&assembly, &s.v.dofs, &couplings, &hessian, &error), &error);
    CHECK_TRUE(co_repulsion_is_covered(&s.repulsion, &hessian.pattern, &s.v.dofs));
    co_repulsion_add_hessian(&s.repulsion, &hessian);
    const int n = s.v.dofs.n_variables;
    double *move = calloc(2 * (size_t)n, sizeof *move), *bent = move + n, sum = 0;
    CHECK_TRUE(move);
    for (int v = 0; v < s.v.c.n_vertices; v++)
        move[3 * v + 2] = v < POINTS ? 0.7 : -0.2;
    co_sparse_hessian_multiply(&hessian, move, bent);
    for (int i = 0; i < n; i++)
        sum += move[i] * bent[i];
    const double step = 1e-4;
    double side[2];
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < n; i++)
            s.v.z[i] += (k ? -2 : 1) * step * move[i];
        side[k] = value(&s, NULL);
    }
    CHECK_NEAR(sum, (side[0] - 2 * middle + side[1]) / (step * step), 1e-4 * sum);
    free(move);
    co_couplings_free(&couplings);
    co_sparse_hessian_free(&hessian);
    co_assembly_free(&assembly);
    co_basis_table_cache_free(&tables);
    end(&s);
}

static void test_crossings_are_infinite(void **state) {
    (void)state;
    setting s;
    begin(&s, close_tori(), 0, 0.15);
    const double before = value(&s, NULL);
    CHECK_TRUE(isfinite(before));
    CHECK_INT(s.n_refused, 0);
    for (int v = 48; v < s.v.c.n_vertices; v++) /* the second torus, into the first one */
        s.v.z[3 * v] -= 0.2;
    CHECK_TRUE(!isfinite(value(&s, NULL)));
    CHECK_INT(s.n_refused, 1);
    end(&s);
}

/* Where a look found no crossing there is no second one, unless it is to be more thorough. */
static void test_a_second_look_at_the_same_points(void **state) {
    (void)state;
    setting s;
    begin(&s, close_tori(), 0, 0.15);
    co_repulsion *r = &s.repulsion;
    CHECK_TRUE(isfinite(value(&s, NULL)));
    r->is_thorough = 1;
    r->clearance = -1; /* a look writes it */
    CHECK_TRUE(isfinite(value(&s, NULL)) && r->clearance > 0);
    r->clearance = -1;
    CHECK_TRUE(isfinite(value(&s, NULL)) && r->clearance == -1);
    for (int v = 48; v < s.v.c.n_vertices; v++)
        s.v.z[3 * v] -= 0.2;
    CHECK_TRUE(!isfinite(value(&s, NULL))); /* no look was there */
    memcpy(r->clear, r->pieces.points, 3 * sizeof *r->clear * (size_t)r->pieces.patches.n_points);
    r->clear_look = CO_LOOK_CURSORY; /* as if that had found none */
    CHECK_TRUE(!isfinite(value(&s, NULL)));
    end(&s);
}

/* Positions that stand in place of a vertex may move by less than it does: then, too, there is a look for crossings. */
static void test_crossings_of_substituted_vertices(void **state) {
    (void)state;
    const int32_t at[1] = {POINTS + SIDE / 2 * (SIDE + 2)}; /* in the middle of the second sheet */
    const double least = 100;                               /* times as far as its position */
    setting s;
    co_sparse_rows rows;
    curvopt_error error;
    begin(&s, sheets(0.1), 0, 1);
    co_repulsion_free(&s.repulsion);
    CHECK_OK(co_sparse_rows_allocate(&rows, 1, s.v.c.n_vertices, 1, &error), &error);
    rows.column[0] = at[0];
    rows.value[0] = least;
    rows.start[1] = 1;
    for (int c = 0; c < 3; c++)
        s.v.x[3 * at[0] + c] /= least;
    const co_substitution substitution = {at, &rows};
    CHECK_OK(co_repulsion_create(s.v.mesh, &substitution, s.v.x, 0.25 / s.v.radius, &s.exceptions, NULL, &s.repulsion,
                                 &error),
             &error);
    s.repulsion.weight = 1;
    CHECK_TRUE(isfinite(co_repulsion_value(&s.repulsion, s.v.x, NULL)));
    s.v.x[3 * at[0] + 2] -= 0.5 / s.v.radius / least;
    CHECK_TRUE(!isfinite(co_repulsion_value(&s.repulsion, s.v.x, NULL)));
    CHECK_INT(s.n_refused, 1);
    co_sparse_rows_free(&rows);
    end(&s);
}

/* A first cage may go on as it is, but not with more pairs of faces. */
static void test_crossings_of_the_first_cage(void **state) {
    (void)state;
    cage c = cage_both(cage_torus(12, 8, 1, 0.4), cage_torus(12, 8, 1, 0.4), 2.6);
    curvopt_mesh *mesh = cage_mesh(&c);
    co_surface_pieces pieces;
    co_crossings found = {0}, again = {0};
    co_face_pairs pairs;
    curvopt_error error;
    CHECK_OK(co_pieces_create(mesh, c.xyz, CO_REPULSION_TIP, NULL, NULL, &pieces, &error), &error);
    CHECK_OK(co_crossings_find(mesh, &pieces, NULL, NULL, &found, &error), &error);
    CHECK_OK(co_face_pairs_create(mesh, &found, &pairs, &error), &error);
    CHECK_TRUE(pairs.n_crossing > 2);
    for (size_t k = 0; k < found.n; k++)
        CHECK_TRUE(co_face_pairs_have(&pairs, found.pair[k].face[1], found.pair[k].face[0]));
    for (int apart = 0; apart < 3; apart++) { /* as it is; farther apart; far into each other */
        for (int v = 96; v < c.n_vertices; v++)
            c.xyz[3 * v] += apart == 1 ? 0.1 : apart == 2 ? -0.6 : 0;
        CHECK_OK(co_pieces_place(&pieces, c.xyz, NULL, NULL), &error);
        CHECK_OK(co_crossings_find(mesh, &pieces, NULL, NULL, &again, &error), &error);
        CHECK_INT(co_face_pairs_allow(&pairs, &again), apart < 2);
        if (apart == 2) {
            co_crossings_free(&again);
            CHECK_OK(co_crossings_find(mesh, &pieces, NULL, NULL, &again, &error), &error);
            co_face_pairs_accept(&pairs, &again);
            CHECK_INT(co_face_pairs_allow(&pairs, &again), 1);
        }
        co_crossings_free(&again);
    }
    co_face_pairs_free(&pairs);
    co_crossings_free(&found);
    co_pieces_free(&pieces);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Weights of a piece's points, against the piece, on faces with and without extraordinary vertices. */
static void test_rows_of_pieces(void **state) {
    (void)state;
    cage cages[] = {cage_shaken(cage_cube(), 0.2), cage_prism(7), cage_half_star(5, 2), cage_torus(5, 4, 1, 0.4)};
    for (size_t k = 0; k < sizeof cages / sizeof *cages; k++) {
        curvopt_mesh *mesh = cage_mesh(&cages[k]);
        co_surface_pieces pieces;
        curvopt_error error;
        double row[600];
        CHECK_OK(co_pieces_create(mesh, cages[k].xyz, CO_REPULSION_TIP, NULL, NULL, &pieces, &error), &error);
        for (int32_t p = 0; p < pieces.n_pieces; p++) {
            const int32_t patch = pieces.patch[p], n = co_patches_own_size(pieces.patches.kind[patch]);
            const double u = 0.1 + 0.05 * (p % 17), v = 1 - 0.07 * (p % 13);
            double at[3], sum[3] = {0};
            CHECK_TRUE(n <= 600);
            co_bezier_point(co_pieces_bezier(&pieces, p), u, v, at);
            co_pieces_row(&pieces, p, u, v, row);
            for (int32_t i = 0; i < n; i++)
                for (int c = 0; c < 3; c++)
                    sum[c] += row[i] *
                              pieces.points[3 * (size_t)pieces.patches.points[pieces.patches.start[patch] + (size_t)i] +
                                            (size_t)c];
            for (int c = 0; c < 3; c++)
                CHECK_NEAR(sum[c], at[c], 1e-13);
        }
        co_pieces_free(&pieces);
        curvopt_mesh_destroy(mesh);
        cage_free(&cages[k]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parallel_sheets),
        cmocka_unit_test(test_no_facing_is_left_out),
        cmocka_unit_test(test_gradient_is_its_differences),
        cmocka_unit_test(test_hessian_of_parallel_sheets),
        cmocka_unit_test(test_crossings_are_infinite),
        cmocka_unit_test(test_a_second_look_at_the_same_points),
        cmocka_unit_test(test_crossings_of_substituted_vertices),
        cmocka_unit_test(test_crossings_of_the_first_cage),
        cmocka_unit_test(test_rows_of_pieces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
