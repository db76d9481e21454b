/* Parts of a surface: what they add up to. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"
#include "curvopt_experimental.h"

#include <stdlib.h>

enum { MOST_PARTS = 3 };
#ifdef __SANITIZE_ADDRESS__
enum { MORE_PARTS = 2 }; /* in 1 and 3: each takes ten times as long */
#else
enum { MORE_PARTS = 1 };
#endif

/* A face's part: of many faces runs, so that not every part needs all; of few, torn ones. */
static int part_of(int32_t face, int32_t n_faces, int n_parts) {
    return n_faces > 60 ? (int)((int64_t)face * n_parts / n_faces) : (int)face % n_parts;
}

static curvopt_options mixed_options(int32_t surface, int third) {
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    o.surface = surface;
    o.threads = 1;
    o.blend_width = 1;
    o.joshi_sequin = 1; /* no rule is changed by evaluating */
    if (third)
        o.weights[CURVOPT_TERM_MVS] = 0.1;
    return o;
}

/* Centroid 0, root mean square radius 1; returns the radius it had. */
static double normalize(int32_t n, double *xyz) {
    double centroid[3] = {0, 0, 0}, square = 0;
    for (int32_t i = 0; i < 3 * n; i++)
        centroid[i % 3] += xyz[i] / n;
    for (int32_t i = 0; i < 3 * n; i++) {
        xyz[i] -= centroid[i % 3];
        square += xyz[i] * xyz[i] / n;
    }
    for (int32_t i = 0; i < 3 * n; i++)
        xyz[i] /= sqrt(square);
    return sqrt(square);
}

/* Sums, gradients [3][3 n] and face errors of what is being added up. */
typedef struct totals {
    curvopt_sums sums;
    double *gradients, *errors;
} totals;

static totals totals_for(const curvopt_mesh_info *info) {
    totals t = {.sums = {.min_jacobian = INFINITY},
                .gradients = calloc(9 * (size_t)info->n_vertices, sizeof(double)),
                .errors = calloc((size_t)info->n_faces, sizeof(double))};
    CHECK_TRUE(t.gradients && t.errors);
    return t;
}

static void totals_free(totals *t) {
    free(t->gradients);
    free(t->errors);
}

/* Numbers of a part's vertices and faces in the whole; NULL: the same. */
static int32_t in_whole(const int32_t *of, int32_t i) {
    return of ? of[i] : i;
}

/* Adds what a problem on `info` finds at the whole's positions; rules are those of the whole's faces. */
static void add_problem(curvopt_problem *problem, const curvopt_mesh_info *info, const int32_t *vertex_of,
                        const int32_t *face_of, const curvopt_mesh_info *whole, const double *xyz, const int32_t *rules,
                        totals *t) {
    size_t n = 3 * (size_t)info->n_vertices, n_whole = 3 * (size_t)whole->n_vertices;
    double *x = calloc(n, sizeof *x), *gradients = calloc(3 * n, sizeof *x), *errors = calloc((size_t)info->n_faces, 8);
    int32_t *rule = calloc((size_t)info->n_faces, sizeof *rule), *read = calloc((size_t)info->n_faces, sizeof *rule);
    curvopt_sums s;
    curvopt_error error;
    CHECK_TRUE(x && gradients && errors && rule && read);
    for (size_t i = 0; i < n; i++)
        x[i] = xyz[3 * (size_t)in_whole(vertex_of, (int32_t)(i / 3)) + i % 3];
    for (int32_t f = 0; f < info->n_faces; f++)
        rule[f] = rules[in_whole(face_of, f)];
    CHECK_OK(curvopt_problem_set_rules(problem, rule, &error), &error);
    curvopt_problem_get_rules(problem, read);
    for (int32_t f = 0; f < info->n_faces; f++)
        CHECK_TRUE(read[f] == rule[f] || read[f] == -1);
    CHECK_OK(curvopt_problem_sum(problem, x, 1, gradients, &s, &error), &error);
    CHECK_OK(curvopt_problem_face_errors(problem, x, 2, 3, errors, &error), &error);
    t->sums.area += s.area;
    t->sums.second += s.second;
    t->sums.third += s.third;
    t->sums.gauss += s.gauss;
    t->sums.turning += s.turning;
    t->sums.samples += s.samples;
    t->sums.min_jacobian = fmin(t->sums.min_jacobian, s.min_jacobian);
    for (int k = 0; k < 8; k++)
        t->sums.term[k] += s.term[k];
    for (size_t k = 0; k < 3; k++)
        for (size_t i = 0; i < n; i++)
            t->gradients[k * n_whole + 3 * (size_t)in_whole(vertex_of, (int32_t)(i / 3)) + i % 3] +=
                gradients[k * n + i];
    for (int32_t f = 0; f < info->n_faces; f++)
        t->errors[in_whole(face_of, f)] += errors[f];
    free(x);
    free(gradients);
    free(errors);
    free(rule);
    free(read);
}

static void check_equal(const curvopt_mesh_info *info, const totals *whole, const totals *parts) {
    const double *a = &whole->sums.area, *b = &parts->sums.area;
    for (size_t k = 0; k < sizeof(curvopt_sums) / sizeof(double); k++)
        CHECK_TRUE((isnan(a[k]) && isnan(b[k])) || fabs(a[k] - b[k]) <= 1e-12 * (1 + fabs(a[k])));
    for (size_t k = 0, n = 3 * (size_t)info->n_vertices; k < 3; k++) {
        double largest = 0;
        for (size_t i = 0; i < n; i++)
            largest = fmax(largest, fabs(whole->gradients[k * n + i]));
        for (size_t i = 0; i < n; i++)
            CHECK_NEAR(parts->gradients[k * n + i], whole->gradients[k * n + i], 1e-12 * largest);
    }
    for (int32_t f = 0; f < info->n_faces; f++)
        CHECK_NEAR(parts->errors[f], whole->errors[f], 1e-11 * (1 + fabs(whole->sums.second + 2 * whole->sums.third)));
}

static int32_t *some_rules(int32_t n_faces) {
    int32_t *rules = calloc((size_t)n_faces, sizeof *rules);
    CHECK_TRUE(rules != NULL);
    for (int32_t f = 0; f < n_faces; f++)
        rules[f] = f % 3;
    return rules;
}

/* A mesh as one; totals_free frees it. */
static totals whole_of(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options) {
    curvopt_mesh_info info;
    curvopt_error error;
    curvopt_problem *problem;
    curvopt_mesh_get_info(mesh, &info, sizeof info);
    totals whole = totals_for(&info);
    int32_t *rules = some_rules(info.n_faces);
    CHECK_OK(curvopt_problem_create(mesh, NULL, options, &problem, &error), &error);
    add_problem(problem, &info, NULL, NULL, &info, xyz, rules, &whole);
    curvopt_problem_destroy(problem);
    free(rules);
    return whole;
}

/* The same mesh in parts. */
static void check_parts(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                        const totals *whole, int n_parts) {
    curvopt_mesh_info info, part_info;
    int32_t n_kept = 0;
    curvopt_error error;
    curvopt_problem *problem;
    curvopt_mesh_get_info(mesh, &info, sizeof info);
    totals sum = totals_for(&info);
    int32_t *rules = some_rules(info.n_faces);
    double *weight = calloc((size_t)info.n_faces, sizeof *weight);
    int32_t *vertex_of = calloc((size_t)info.n_vertices, 4), *face_of = calloc((size_t)info.n_faces, 4);
    CHECK_TRUE(weight && vertex_of && face_of);
    for (int p = 0; p < n_parts; p++) {
        curvopt_mesh *part;
        for (int32_t f = 0; f < info.n_faces; f++)
            weight[f] = part_of(f, info.n_faces, n_parts) == p;
        CHECK_OK(curvopt_mesh_part(mesh, weight, &part, vertex_of, face_of, &error), &error);
        curvopt_mesh_get_info(part, &part_info, sizeof part_info);
        n_kept += part_info.n_faces;
        for (int32_t f = 0; f < part_info.n_faces; f++)
            weight[f] = part_of(face_of[f], info.n_faces, n_parts) == p;
        CHECK_OK(curvopt_problem_create_part(part, weight, options, &problem, &error), &error);
        add_problem(problem, &part_info, vertex_of, face_of, &info, xyz, rules, &sum);
        curvopt_problem_destroy(problem);
        curvopt_mesh_destroy(part);
    }
    check_equal(&info, whole, &sum);
    CHECK_TRUE(info.n_faces < 300 || n_kept < 2 * info.n_faces); /* a halo, not the whole */
    totals_free(&sum);
    free(rules);
    free(weight);
    free(vertex_of);
    free(face_of);
}

/* On each surface; they are one where all vertices are regular and nothing is open, but for what is integrated. */
static void check_mesh(const curvopt_mesh *mesh, const double *xyz, int open) {
    curvopt_mesh_info info;
    curvopt_mesh_get_info(mesh, &info, sizeof info);
    for (int32_t surface = CURVOPT_SURFACE_LIMIT; surface <= CURVOPT_SURFACE_POLYNOMIAL; surface++) {
        curvopt_options o = mixed_options(surface, !open && surface != CURVOPT_SURFACE_LIMIT);
        if (surface == CURVOPT_SURFACE_PLANE && info.n_extraordinary == 0 && !open && !long_tests())
            continue;
        totals whole = whole_of(mesh, xyz, &o);
        for (int n_parts = 1; n_parts <= MOST_PARTS; n_parts += MORE_PARTS)
            check_parts(mesh, xyz, &o, &whole, n_parts);
        totals_free(&whole);
    }
}

/* Positions of the subdivision; *fine is the caller's, and so is what is returned. */
static double *refined(const curvopt_mesh *mesh, const double *xyz, curvopt_mesh **fine) {
    curvopt_mesh_info info;
    curvopt_error error;
    curvopt_mesh_get_info(mesh, &info, sizeof info);
    double *out = calloc(3 * (size_t)(info.n_vertices + info.n_edges + info.n_faces), sizeof *out);
    CHECK_TRUE(out != NULL);
    CHECK_OK(curvopt_mesh_refine(mesh, xyz, fine, out, &error), &error);
    return out;
}

enum { MANY_FACES = 100 };

static void check_cage(cage c, double shake) {
    cage_perturb(&c, shake, 9);
    normalize(c.n_vertices, c.xyz);
    curvopt_mesh *mesh = cage_mesh(&c), *fine;
    double *fine_xyz = refined(mesh, c.xyz, &fine);
    check_mesh(mesh, c.xyz, 0);
    if (c.n_faces < MANY_FACES || long_tests())
        check_mesh(fine, fine_xyz, 0);
    free(fine_xyz);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_parts_of_closed_cages_add_up(void **state) {
    (void)state;
    check_cage(cage_torus(7, 5, 1, 0.4), 0.05);
    check_cage(cage_torus(25, 4, 1, 0.4), 0.02);
    check_cage(cage_trapezohedron(5), 0.05);
    check_cage(cage_prism(5), 0.05);
    check_cage(cage_tetrahedron(), 0.05);
}

/* A torus with one ring of faces left out: a tube; one crease for ever along it, one that fades across it, and a vertex
 * that is sharp for a while. */
static curvopt_mesh *creased_tube(const cage *c, int32_t n_v) {
    const int32_t edges[6] = {n_v + 1, 2 * n_v + 1, 2 * n_v + 1, 3 * n_v + 1, 5 * n_v, 5 * n_v + 1}, corner[1] = {8};
    const double sharpness[3] = {10, 10, 1.25}, corner_sharpness[1] = {0.5};
    const curvopt_creases creases = {edges, sharpness, corner, corner_sharpness, 3, 1, 0, 0};
    curvopt_mesh *mesh;
    curvopt_error error;
    CHECK_OK(
        curvopt_mesh_create_creased(c->n_vertices, c->n_faces - n_v, c->sizes, c->vertices, &creases, &mesh, &error),
        &error);
    return mesh;
}

static void test_parts_of_open_creased_cages_add_up(void **state) {
    (void)state;
    cage c = cage_torus(16, 5, 1, 0.4);
    cage_perturb(&c, 0.03, 5);
    normalize(c.n_vertices, c.xyz);
    curvopt_mesh *mesh = creased_tube(&c, 5), *fine;
    double *fine_xyz = refined(mesh, c.xyz, &fine);
    check_mesh(mesh, c.xyz, 1);
    check_mesh(fine, fine_xyz, 1);
    free(fine_xyz);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Sums over the children of the faces with a weight, in a part that was refined by itself. */
static curvopt_sums sums_of_refined_part(const curvopt_mesh *mesh, const double *xyz, const double *weight,
                                         const curvopt_options *options) {
    curvopt_mesh *part, *fine;
    curvopt_mesh_info info, fine_info;
    curvopt_problem *problem;
    curvopt_error error;
    curvopt_sums sums;
    curvopt_mesh_get_info(mesh, &info, sizeof info);
    int32_t *vertex_of = calloc((size_t)info.n_vertices, 4), *face_of = calloc((size_t)info.n_faces, 4);
    CHECK_OK(curvopt_mesh_part(mesh, weight, &part, vertex_of, face_of, &error), &error);
    curvopt_mesh_get_info(part, &info, sizeof info);
    double *x = calloc(3 * (size_t)info.n_vertices, sizeof *x),
           *fine_weight = calloc((size_t)info.n_corners, sizeof *x);
    int32_t *sizes = calloc((size_t)info.n_faces, 4), *vertices = calloc((size_t)info.n_corners, 4);
    CHECK_TRUE(x && fine_weight && sizes && vertices);
    for (int32_t i = 0; i < 3 * info.n_vertices; i++)
        x[i] = xyz[3 * (size_t)vertex_of[i / 3] + (size_t)(i % 3)];
    double *fine_xyz = refined(part, x, &fine);
    curvopt_mesh_get_info(fine, &fine_info, sizeof fine_info);
    curvopt_mesh_get_faces(part, sizes, vertices);
    for (int32_t f = 0, child = 0; f < info.n_faces; f++)
        for (int32_t k = 0; k < sizes[f]; k++)
            fine_weight[child++] = weight[face_of[f]];
    CHECK_OK(curvopt_problem_create_part(fine, fine_weight, options, &problem, &error), &error);
    CHECK_OK(curvopt_problem_sum(problem, fine_xyz, 1, NULL, &sums, &error), &error);
    curvopt_problem_destroy(problem);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(part);
    free(vertex_of);
    free(face_of);
    free(x);
    free(fine_weight);
    free(fine_xyz);
    free(sizes);
    free(vertices);
    return sums;
}

static void test_parts_can_be_refined_by_themselves(void **state) {
    (void)state;
    cage c = cage_prism(5);
    curvopt_options o = mixed_options(CURVOPT_SURFACE_POLYNOMIAL, 1);
    curvopt_error error;
    curvopt_problem *problem;
    curvopt_sums whole;
    cage_perturb(&c, 0.05, 3);
    normalize(c.n_vertices, c.xyz);
    curvopt_mesh *mesh = cage_mesh(&c), *fine, *finest;
    curvopt_mesh_info info;
    double *fine_xyz = refined(mesh, c.xyz, &fine), *finest_xyz = refined(fine, fine_xyz, &finest), weight[64];
    curvopt_mesh_get_info(fine, &info, sizeof info);
    CHECK_OK(curvopt_problem_create(finest, NULL, &o, &problem, &error), &error);
    CHECK_OK(curvopt_problem_sum(problem, finest_xyz, 1, NULL, &whole, &error), &error);
    curvopt_problem_destroy(problem);
    for (int p = 0; p < 2; p++) {
        for (int32_t f = 0; f < info.n_faces; f++)
            weight[f] = f < 9 ? p : 1 - p;
        curvopt_sums part = sums_of_refined_part(fine, fine_xyz, weight, &o);
        for (int k = 0; k < 8; k++)
            whole.term[k] -= part.term[k];
    }
    for (int k = 0; k < CURVOPT_N_TERMS; k++)
        CHECK_NEAR(whole.term[k], 0, 1e-11);
    free(fine_xyz);
    free(finest_xyz);
    curvopt_mesh_destroy(finest);
    curvopt_mesh_destroy(fine);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* out [3 n] = gradient of second + area third + third area, at xyz, the factors being given. */
static void gradient_of(curvopt_problem *problem, size_t n, const double *xyz, double area, double third, double *out) {
    double *g = calloc(3 * n, sizeof *g);
    curvopt_sums sums;
    curvopt_error error;
    CHECK_OK(curvopt_problem_sum(problem, xyz, 0, g, &sums, &error), &error);
    for (size_t i = 0; i < n; i++)
        out[i] = g[i] + area * g[n + i] + third * g[2 * n + i];
    free(g);
}

static void multiply(const curvopt_matrix *m, const double *v, double *out) {
    for (int32_t j = 0; j < m->n; j++)
        for (int32_t e = m->column_start[j]; e < m->column_start[j + 1]; e++) {
            int32_t i = m->row[e];
            out[i] += m->value[e] * v[j];
            if (i != j)
                out[j] += m->value[e] * v[i];
        }
}

/* The Hessian of half a torus against differences of its gradient. */
static void test_hessian_of_a_part_agrees_with_differences(void **state) {
    (void)state;
    cage c = cage_torus(7, 5, 1, 0.4);
    curvopt_options o = mixed_options(CURVOPT_SURFACE_POLYNOMIAL, 1);
    curvopt_problem *problem;
    curvopt_hessian *hessian;
    curvopt_matrix matrix;
    curvopt_error error;
    enum { N = 3 * 35 };
    double weight[35], v[N], plus[N], minus[N], product[N] = {0}, x[N], largest = 0, step = 1e-5;
    uint64_t random = 7;
    cage_perturb(&c, 0.05, 3);
    normalize(c.n_vertices, c.xyz);
    curvopt_mesh *mesh = cage_mesh(&c);
    for (int f = 0; f < 35; f++)
        weight[f] = f < 17 ? 1.5 : 0;
    CHECK_OK(curvopt_problem_create_part(mesh, weight, &o, &problem, &error), &error);
    CHECK_OK(curvopt_hessian_create(problem, &hessian, &error), &error);
    CHECK_OK(curvopt_hessian_assemble(hessian, c.xyz, 1, 2, 3, &error), &error);
    curvopt_hessian_get(hessian, &matrix);
    CHECK_INT(matrix.n, N);
    for (int i = 0; i < N; i++)
        v[i] = check_random(&random);
    multiply(&matrix, v, product);
    for (int i = 0; i < N; i++)
        x[i] = c.xyz[i] + step * v[i];
    gradient_of(problem, N, x, 2, 3, plus);
    for (int i = 0; i < N; i++)
        x[i] = c.xyz[i] - step * v[i];
    gradient_of(problem, N, x, 2, 3, minus);
    for (int i = 0; i < N; i++)
        largest = fmax(largest, fabs(product[i]));
    for (int i = 0; i < N; i++)
        CHECK_NEAR(product[i], (plus[i] - minus[i]) / (2 * step), 1e-6 * largest);
    curvopt_hessian_destroy(hessian);
    curvopt_problem_destroy(problem);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* The whole is a part too: its energy and its gradient are the ones that curvopt_problem_evaluate gives. */
static void test_a_whole_makes_the_energy_that_evaluation_gives(void **state) {
    (void)state;
    cage c = cage_torus(7, 5, 1, 0.4);
    curvopt_options o = mixed_options(CURVOPT_SURFACE_POLYNOMIAL, 1);
    curvopt_problem *problem;
    curvopt_error error;
    curvopt_energies e;
    curvopt_sums s;
    enum { N = 3 * 35 };
    double gradient[N], mine[N], mean[3] = {0}, radial = 0, largest = 0;
    cage_perturb(&c, 0.05, 3);
    normalize(c.n_vertices, c.xyz);
    curvopt_mesh *mesh = cage_mesh(&c);
    CHECK_OK(curvopt_problem_create(mesh, NULL, &o, &problem, &error), &error);
    CHECK_OK(curvopt_problem_evaluate(problem, c.xyz, &e, sizeof e, gradient, &error), &error);
    CHECK_OK(curvopt_problem_sum(problem, c.xyz, 1, NULL, &s, &error), &error);
    CHECK_NEAR(s.second + s.area * s.third, e.objective, 1e-13 * e.objective);
    CHECK_NEAR(s.area * s.term[CURVOPT_TERM_VARIATION], e.term[CURVOPT_TERM_VARIATION], 1e-10);
    gradient_of(problem, N, c.xyz, s.area, s.third, mine);
    for (int i = 0; i < N; i++) {
        mean[i % 3] += mine[i] / 35;
        radial += mine[i] * c.xyz[i] / 35;
        largest = fmax(largest, fabs(mine[i]));
    }
    for (int i = 0; i < N; i++)
        CHECK_NEAR(mine[i] - mean[i % 3] - radial * c.xyz[i], gradient[i], 1e-13 * largest);
    curvopt_problem_destroy(problem);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_bad_parts_are_refused(void **state) {
    (void)state;
    cage c = cage_torus(5, 4, 1, 0.4);
    curvopt_options o = mixed_options(CURVOPT_SURFACE_LIMIT, 0);
    curvopt_mesh *mesh = cage_mesh(&c), *part;
    curvopt_problem *problem;
    curvopt_energies e;
    curvopt_error error;
    double weight[20] = {0};
    int32_t map[20], rules[20] = {0};
    CHECK_REFUSED(curvopt_mesh_part(mesh, weight, &part, map, map, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "no face counts");
    CHECK_REFUSED(curvopt_problem_create_part(mesh, weight, &o, &problem, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "no face counts");
    weight[3] = -1;
    CHECK_REFUSED(curvopt_problem_create_part(mesh, weight, &o, &problem, &error), &error, CURVOPT_ERROR_ARGUMENT, 3,
                  "face_weight[3] is -1");
    weight[3] = 1;
    CHECK_OK(curvopt_problem_create_part(mesh, weight, &o, &problem, &error), &error);
    CHECK_REFUSED(curvopt_problem_evaluate(problem, c.xyz, &e, sizeof e, NULL, &error), &error, CURVOPT_ERROR_ARGUMENT,
                  -1, "curvopt_problem_sum");
    curvopt_options wide = mixed_options(CURVOPT_SURFACE_POLYNOMIAL, 1);
    curvopt_problem *none;
    wide.blend_width = 2;
    CHECK_REFUSED(curvopt_problem_create_part(mesh, weight, &wide, &none, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "blend_width is 2; for a part it must be 1");
    curvopt_options bent = mixed_options(CURVOPT_SURFACE_LIMIT, 1);
    bent.spontaneous_curvature = 2;
    CHECK_REFUSED(curvopt_problem_create_part(mesh, weight, &bent, &none, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "spontaneous_curvature is 2; for a part it must be 0");
    rules[3] = CURVOPT_FINEST_RULE + 1;
    CHECK_REFUSED(curvopt_problem_set_rules(problem, rules, &error), &error, CURVOPT_ERROR_ARGUMENT, 3,
                  "must be 0 to 6");
    rules[3] = CURVOPT_FINEST_RULE;
    CHECK_OK(curvopt_problem_set_rules(problem, rules, &error), &error);
    curvopt_problem_destroy(problem);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts_of_closed_cages_add_up),
        cmocka_unit_test(test_parts_of_open_creased_cages_add_up),
        cmocka_unit_test(test_parts_can_be_refined_by_themselves),
        cmocka_unit_test(test_hessian_of_a_part_agrees_with_differences),
        cmocka_unit_test(test_a_whole_makes_the_energy_that_evaluation_gives),
        cmocka_unit_test(test_bad_parts_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
