/* Wide blends round extraordinary vertices. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"
#include "mesh/crease.h"
#include "surface/basis_table_cache.h"
#include "surface/face_rule.h"
#include "surface/patches.h"

/* Patches with wide blends; frees the cage. */
static co_patches patches_of(curvopt_mesh *mesh) {
    co_patches patches;
    curvopt_error error;
    CHECK_OK(
        co_patches_create(mesh, NULL, NULL, CURVOPT_SURFACE_POLYNOMIAL, CO_BLEND_DISC_LARGEST, NULL, &patches, &error),
        &error);
    return patches;
}

static int32_t width_of(const co_blend_discs *w, int32_t disc) {
    return co_blend_disc_fit_of(w, &w->disc[disc])->width;
}

/* Each disc's faces, of every place in every sector one; and each patch's points. */
static void check_faces(const curvopt_mesh *m, const co_patches *p) {
    const co_blend_discs *w = &p->wide;
    int32_t wanted = 0, found = 0, *times = calloc((size_t)m->info.n_faces, sizeof *times);
    CHECK_TRUE(times != NULL);
    for (int32_t k = 0; k < w->n_discs; k++)
        wanted += co_blend_disc_fit_of(w, &w->disc[k])->valence * width_of(w, k) * width_of(w, k);
    for (int32_t i = 0; i < p->n_patches; i++) {
        int32_t kind = p->kind[i], size = (int32_t)(p->start[i + 1] - p->start[i]);
        times[p->place[i].face]++;
        CHECK_INT(size, co_patches_size(kind));
        for (int32_t j = 0; j < size; j++) {
            int32_t point = p->points[p->start[i] + (size_t)j];
            int is_wide = co_fan_is_wide(kind) && j >= size - CO_BLEND_DISC_TERMS;
            CHECK_BETWEEN(point, is_wide ? p->n_points - w->n_points : 0, is_wide ? p->n_points - 1 : p->n_cage - 1);
        }
        found += co_fan_is_wide(kind);
    }
    CHECK_INT(found, wanted);
    for (int32_t f = 0; f < m->info.n_faces; f++)
        CHECK_INT(times[f], 1);
    free(times);
}

static void test_width_is_a_quarter_of_the_distance(void **state) {
    (void)state;
    static const int width[7] = {[3] = 2, [4] = 4, [5] = 8, [6] = 8}; /* 2^halvings faces from vertex to vertex */
    for (int halvings = 2; halvings <= 6; halvings++) {
        cage c = cage_refined(cage_cube(), halvings);
        curvopt_mesh *mesh = cage_mesh(&c);
        co_patches p = patches_of(mesh);
        CHECK_INT(p.wide.n_discs, halvings > 2 ? 8 : 0);
        CHECK_INT(p.wide.n_fits, halvings > 2);
        for (int32_t k = 0; k < p.wide.n_discs; k++)
            CHECK_INT(width_of(&p.wide, k), width[halvings]);
        if (p.wide.n_discs)
            check_faces(mesh, &p);
        co_patches_free(&p);
        curvopt_mesh_destroy(mesh);
        cage_free(&c);
    }
}

static void test_regular_and_other_surfaces_have_none(void **state) {
    (void)state;
    cage torus = cage_torus(40, 40, 1, 0.4), cube = cage_refined(cage_cube(), 3);
    curvopt_mesh *mesh[2] = {cage_mesh(&torus), cage_mesh(&cube)};
    co_patches without, p = patches_of(mesh[0]);
    curvopt_error error;
    CHECK_OK(co_patches_create(mesh[1], NULL, NULL, CURVOPT_SURFACE_LIMIT, 1, NULL, &without, &error), &error);
    CHECK_INT(p.wide.n_discs, 0);
    CHECK_INT(without.wide.n_discs, 0);
    CHECK_INT(without.n_points, without.n_cage);
    co_patches_free(&p);
    co_patches_free(&without);
    for (int i = 0; i < 2; i++)
        curvopt_mesh_destroy(mesh[i]);
    cage_free(&torus);
    cage_free(&cube);
}

/* One sharp edge in the middle of a side of the cube: 8 faces from that side's corners, 16 and more from the others. */
static void test_creases_leave_less_room(void **state) {
    (void)state;
    cage c = cage_refined(cage_cube(), 4);
    curvopt_mesh *mesh = cage_mesh(&c);
    int32_t centre = 0, edge[2], narrow = 0, wide = 0;
    double sharpness = 2.5;
    curvopt_error error;
    for (int32_t v = 1; v < c.n_vertices; v++)
        if (fabs(c.xyz[3 * v + 1]) + fabs(c.xyz[3 * v + 2]) - c.xyz[3 * v] <
            fabs(c.xyz[3 * centre + 1]) + fabs(c.xyz[3 * centre + 2]) - c.xyz[3 * centre])
            centre = v;
    edge[0] = centre;
    edge[1] = co_mesh_destination(mesh, mesh->vertex_corner[centre]);
    curvopt_creases creases = {.crease_vertices = edge, .crease_sharpness = &sharpness, .n_creases = 1};
    CHECK_OK(co_crease_set(mesh, &creases, &error), &error);
    co_patches p = patches_of(mesh);
    for (int32_t k = 0; k < p.wide.n_discs; k++) {
        int32_t v = p.wide.column[p.wide.disc[k].column];
        narrow += c.xyz[3 * v] > 0 && width_of(&p.wide, k) == 2;
        wide += c.xyz[3 * v] < 0 && width_of(&p.wide, k) == 4;
    }
    CHECK_INT(p.wide.n_discs, 8);
    CHECK_INT(narrow, 4);
    CHECK_INT(wide, 4);
    co_patches_free(&p);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* A tube of n faces round, open at its far end, whose other end goes on as a quarter of the plane glued to itself: one
 * vertex of valence 5 on the seam, all others regular. Ring k > 0 of the plane has n + 2 k vertices, its corner first.
 */
enum { LENGTH = 24 };
static curvopt_mesh *funnel(int32_t n) {
    int32_t n_faces = 0, n_vertices = 0, first[2 * LENGTH + 1], *faces = calloc(4 * 2 * LENGTH * 80, sizeof *faces);
    curvopt_mesh *mesh;
    curvopt_error error;
    CHECK_TRUE(faces != NULL && n + 2 * LENGTH < 80);
    for (int ring = -LENGTH; ring <= LENGTH; ring++) {
        first[ring + LENGTH] = n_vertices;
        n_vertices += n + (ring > 0 ? 2 * ring : 0);
    }
    for (int ring = -LENGTH; ring < LENGTH; ring++) {
        int32_t size = n + (ring > 0 ? 2 * ring : 0), here = first[ring + LENGTH], next = first[ring + LENGTH + 1];
        int32_t turn = ring >= 0, next_size = size + 2 * turn;
        for (int32_t i = 0; i < size + turn; i++) {
            int32_t *f = faces + 4 * n_faces++;
            f[0] = here + i % size;
            f[1] = i == size ? next + 1 : here + (i + 1) % size;
            f[2] = i == size ? next : next + (i + turn + 1) % next_size;
            f[3] = i == size ? next + next_size - 1 : next + (i + turn) % next_size;
        }
    }
    int32_t *sizes = calloc((size_t)n_faces, sizeof *sizes);
    CHECK_TRUE(sizes != NULL);
    for (int32_t f = 0; f < n_faces; f++)
        sizes[f] = 4;
    CHECK_OK(curvopt_mesh_create(n_vertices, n_faces, sizes, faces, &mesh, &error), &error);
    CHECK_INT(mesh->info.n_extraordinary, 1);
    free(sizes);
    free(faces);
    return mesh;
}

static void test_discs_do_not_meet_themselves_round_a_tube(void **state) {
    (void)state;
    for (int32_t n = 3; n <= 14; n++) {
        curvopt_mesh *mesh = funnel(n);
        co_patches p = patches_of(mesh);
        int32_t width = n / 2 < LENGTH / 4 ? n / 2 : LENGTH / 4;
        CHECK_INT(p.wide.n_discs, width > 1);
        if (width > 1)
            CHECK_INT(width_of(&p.wide, 0), width);
        co_patches_free(&p);
        curvopt_mesh_destroy(mesh);
    }
}

static void test_points_of_the_polynomial_are_affine_in_the_disc(void **state) {
    (void)state;
    cage c = cage_refined(cage_trapezohedron(5), 3);
    curvopt_mesh *mesh = cage_mesh(&c);
    co_patches p = patches_of(mesh);
    CHECK_TRUE(p.wide.n_discs > 0);
    for (int32_t k = 0; k < p.wide.n_fits; k++) {
        const co_blend_disc_fit *f = &p.wide.fit[k];
        for (int a = 0; a < CO_BLEND_DISC_TERMS; a++) {
            double sum = 0;
            for (int32_t i = 0; i < f->n_points; i++)
                sum += f->matrix[a * f->n_points + i];
            CHECK_NEAR(sum, a < CO_BLEND_FIT_TERMS, 1e-12); /* the means are those of discs of width 1 */
            for (int32_t s = 0; s < f->valence; s++) {
                sum = 0;
                for (int b = 0; b < CO_BLEND_DISC_TERMS; b++)
                    sum += f->turn[(s * CO_BLEND_DISC_TERMS + a) * CO_BLEND_DISC_TERMS + b];
                CHECK_NEAR(sum, 1, 1e-12);
            }
        }
    }
    co_patches_free(&p);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* x.A^T y = y.A x for the map from the cage to the polynomials' points, and of its size. */
static void test_gradients_go_back_by_the_transpose(void **state) {
    (void)state;
    cage c = cage_refined(cage_cube(), 3);
    curvopt_mesh *mesh = cage_mesh(&c);
    co_patches p = patches_of(mesh);
    size_t n = 3 * (size_t)p.n_points;
    double *points = calloc(n, sizeof *points), *slope = calloc(n, sizeof *slope), *back = calloc(n, sizeof *back);
    double there = 0, here = 0;
    CHECK_TRUE(points && slope && back);
    for (size_t i = 0; i < n; i++) {
        points[i] = i < 3 * (size_t)p.n_cage ? c.xyz[i] : 0;
        slope[i] = i < 3 * (size_t)p.n_cage ? 0 : sin(1.3 * (double)i);
    }
    co_patches_derive(&p, points);
    co_patches_add_derived(&p, slope, back);
    for (size_t i = 0; i < n; i++) {
        there += slope[i] * points[i];
        here += i < 3 * (size_t)p.n_cage ? back[i] * c.xyz[i] : 0;
    }
    CHECK_TRUE(fabs(there) > 0.1);
    CHECK_NEAR(here, there, 1e-12 * fabs(there));
    free(points);
    free(slope);
    free(back);
    co_patches_free(&p);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* A disc of width 1 alone: its two-ring [n], then the coefficients of all sectors; the cage of its sector 0. */
static double *disc_points(int32_t valence, co_blend_discs *discs) {
    curvopt_error error;
    const int32_t n = co_fan_n_points(valence);
    CHECK_OK(co_blend_discs_add(valence, 1, discs, &error), &error);
    discs->disc[0].first_point = n;
    double *points = calloc(3 * (size_t)(n + CO_BLEND_DISC_TERMS * valence), sizeof *points);
    CHECK_TRUE(points != NULL);
    for (int32_t i = 0; i < n; i++)
        discs->column[i] = i;
    for (int32_t i = 0; i < 3 * n; i++)
        points[i] = sin(1.7 * i * i);
    co_blend_discs_apply(discs, points);
    return points;
}

/* The jets of all samples of a table, one after the other. */
static double *jets_of(const co_basis_table *t, const double *points) {
    double *jets = calloc((size_t)t->n_samples * 3 * CO_JET, sizeof *jets);
    CHECK_TRUE(jets != NULL);
    for (int32_t i = 0; i < t->n_samples; i++)
        for (int32_t p = 0; p < t->n_points; p++)
            for (int k = 0; k < CO_JET; k++)
                for (int c = 0; c < 3; c++)
                    jets[(i * 3 + c) * CO_JET + k] +=
                        t->rows[(i * t->n_points + p) * CO_JET + k] * points[3 * t->support[p] + c];
    return jets;
}

/* At a vertex of high valence the same surface as without a disc, on fewer points. */
static void test_discs_of_width_1_change_no_surface(void **state) {
    (void)state;
    static const struct {
        int32_t valence, rule;
        double least; /* of points without and with a disc, the ratio */
    } of[] = {{8, 1, 1}, {32, 1, 2}, {24, 7, 1}, {100, 2, 5}, {32, 6, 2}, {100, 7, 4}};
    const size_t n_tables = sizeof of / sizeof *of - (long_tests() ? 0 : 2);
    const int32_t surface = CURVOPT_SURFACE_POLYNOMIAL;
    for (size_t i = 0; i < n_tables; i++) {
        const int32_t n = of[i].valence;
        co_basis_table *plain, *disc;
        curvopt_error error;
        co_blend_discs discs = {0};
        double *points = disc_points(n, &discs);
        CHECK_OK(co_basis_table_create(surface, n, of[i].rule, &plain, &error), &error);
        CHECK_OK(co_basis_table_create(surface, co_fan_make_wide(n, 1, 0, 0), of[i].rule, &disc, &error), &error);
        CHECK_INT(disc->n_samples, plain->n_samples);
        CHECK_TRUE(plain->n_points > of[i].least * disc->n_points);
        double *here = jets_of(plain, points), *there = jets_of(disc, points);
        for (int k = 0; k < CO_JET; k++) {
            double largest = 0, off = 0;
            for (int32_t j = k; j < 3 * CO_JET * plain->n_samples; j += CO_JET) {
                largest = fmax(largest, fabs(here[j]));
                off = fmax(off, fabs(here[j] - there[j]));
            }
            CHECK_BETWEEN(off, 0, 1e-11 * largest);
        }
        free(here);
        free(there);
        free(points);
        co_basis_table_destroy(plain);
        co_basis_table_destroy(disc);
        co_blend_discs_free(&discs);
    }
}

/* Hessians are scattered by co_patches_own_is_used, which knows no rule: every table's points must be among them. */
static void test_no_rule_has_points_that_no_patch_expects(void **state) {
    (void)state;
    const int32_t kinds[] = {co_fan_make_wide(2 * CO_STAM_WINDOW + 4, 1, 0, 0), /* the least that leaves points out */
                             3, 5, 7},
                  surfaces[] = {CURVOPT_SURFACE_LIMIT, CURVOPT_SURFACE_PLANE, CURVOPT_SURFACE_POLYNOMIAL};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
        for (size_t s = k == 0 ? 2 : 0; s < 3; s++) {
            int32_t n_used = 0, n_all = co_patches_own_size(kinds[k]);
            for (int32_t i = 0; i < n_all; i++)
                n_used += co_patches_own_is_used(surfaces[s], kinds[k], i);
            for (int32_t rule = co_face_rule_coarsest(surfaces[s], kinds[k]); rule < CO_LADDER_RULES; rule++) {
                co_basis_table *t;
                curvopt_error error;
                CHECK_OK(co_basis_table_create(surfaces[s], kinds[k], rule, &t, &error), &error);
                for (int32_t p = 0; p < t->n_own; p++)
                    CHECK_TRUE(co_patches_own_is_used(surfaces[s], kinds[k], t->support[p]));
                if (k > 0)
                    CHECK_INT(t->n_own, n_used); /* and no more */
                co_basis_table_destroy(t);
            }
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_width_is_a_quarter_of_the_distance),
        cmocka_unit_test(test_regular_and_other_surfaces_have_none),
        cmocka_unit_test(test_creases_leave_less_room),
        cmocka_unit_test(test_discs_do_not_meet_themselves_round_a_tube),
        cmocka_unit_test(test_points_of_the_polynomial_are_affine_in_the_disc),
        cmocka_unit_test(test_gradients_go_back_by_the_transpose),
        cmocka_unit_test(test_discs_of_width_1_change_no_surface),
        cmocka_unit_test(test_no_rule_has_points_that_no_patch_expects),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
