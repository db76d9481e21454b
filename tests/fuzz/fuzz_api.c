/* Any bytes as a sequence of calls on one cage: every function refuses with a message, or gives finite figures, in any
 * order. SPDX-License-Identifier: GPL-3.0-or-later
 *
 * Byte 0: kind of cage; 1, 2: its size; 3: how many vertices are moved, three bytes each; then creases and options, and
 * the rest are calls. So nearly every input is a cage, and what is left to chance is what is asked of it. */
#include "fuzz.h"

#include "curvopt_experimental.h"
#include "solver_calls.h"

#include <math.h>
#include <string.h>

const char fuzz_name[] = "api";

enum { MOST_VERTICES = SOLVER_MOST_VERTICES, MOST_FACES = 40, MOST_CORNERS = 200, MOST_CREASES = 6, MOST_CALLS = 8 };

/* What the calls work on; xyz are the cage's. */
typedef struct state {
    int32_t n_vertices, n_faces, n_corners, sizes[MOST_FACES], corners[MOST_CORNERS];
    double xyz[3 * MOST_VERTICES];
    curvopt_options options;
    curvopt_mesh *mesh;
    curvopt_problem *problem;
} state;

static void check_refusal(int32_t status, const curvopt_error *error) {
    FUZZ_CHECK(status > 0 && status != CURVOPT_ERROR_MEMORY && error->code == status && error->message[0]);
    FUZZ_CHECK(memchr(error->message, 0, sizeof error->message));
}

static void check_finite(const double *x, int32_t n) {
    for (int32_t i = 0; i < n; i++)
        FUZZ_CHECK(isfinite(x[i]));
}

/* ------------------------------------------------------------------------------------------------- input -- */

static void add_face(state *s, int32_t n, const int32_t *corner) {
    memcpy(s->corners + s->n_corners, corner, sizeof *corner * (size_t)n);
    s->sizes[s->n_faces++] = n;
    s->n_corners += n;
}

/* A grid of quads that closes round both ways (2), one (1) or none (0). */
static void make_grid(state *s, int32_t n, int32_t m, int closed) {
    s->n_vertices = n * m;
    for (int32_t i = 0; i < (closed ? n : n - 1); i++)
        for (int32_t j = 0; j < (closed == 2 ? m : m - 1); j++) {
            const int32_t k = (i + 1) % n, l = (j + 1) % m;
            add_face(s, 4, (int32_t[]){i * m + j, k * m + j, k * m + l, i * m + l});
        }
    for (int32_t v = 0; v < n * m; v++) {
        const double a = 6.283185307179586 * (v / m) / n, b = 6.283185307179586 * (v % m) / m; /* NOLINT */
        const double r = closed == 2 ? 1 + 0.4 * cos(b) : 1;
        s->xyz[3 * v] = closed ? r * cos(a) : v / m; /* NOLINT */
        s->xyz[3 * v + 1] = closed ? r * sin(a) : v % m;
        s->xyz[3 * v + 2] = closed == 2 ? 0.4 * sin(b) : 0.5 * (v % m) * closed;
    }
}

/* A prism, or with `cone` a pyramid, with its caps. */
static void make_prism(state *s, int32_t n, int cone) {
    int32_t bottom[8], top[8];
    s->n_vertices = cone ? n + 1 : 2 * n;
    for (int32_t k = 0; k < n; k++) {
        const int32_t l = (k + 1) % n;
        bottom[n - 1 - k] = k;
        top[k] = n + k;
        for (int row = 0; row < (cone ? 1 : 2); row++)
            memcpy(s->xyz + 3 * (row * n + k), (double[]){cos(6.283 * k / n), sin(6.283 * k / n), row},
                   3 * sizeof(double));
        if (cone)
            add_face(s, 3, (int32_t[]){k, l, n});
        else
            add_face(s, 4, (int32_t[]){k, l, n + l, n + k});
    }
    add_face(s, n, bottom);
    if (cone)
        s->xyz[3 * n + 2] = 1;
    else
        add_face(s, n, top);
}

/* The cage once more, next to itself. */
static void add_copy(state *s) {
    const int32_t n_vertices = s->n_vertices, n_faces = s->n_faces, n_corners = s->n_corners;
    if (2 * n_vertices > MOST_VERTICES || 2 * n_faces > MOST_FACES || 2 * n_corners > MOST_CORNERS)
        return;
    for (int32_t i = 0; i < 3 * n_vertices; i++)
        s->xyz[3 * n_vertices + i] = s->xyz[i] + (i % 3 == 0 ? 4 : 0);
    for (int32_t f = 0; f < n_faces; f++)
        s->sizes[n_faces + f] = s->sizes[f];
    for (int32_t h = 0; h < n_corners; h++)
        s->corners[n_corners + h] = n_vertices + s->corners[h];
    s->n_vertices *= 2;
    s->n_faces *= 2;
    s->n_corners *= 2;
}

static void make_cage(reader *r, state *s) {
    const int kind = next(r) % 5, n = 3 + next(r) % 5, m = 3 + next(r) % 3;
    s->n_faces = s->n_corners = 0;
    memset(s->xyz, 0, sizeof s->xyz);
    if (kind < 3)
        make_grid(s, n, m, kind);
    else
        make_prism(s, n, kind == 4);
    for (int k = next(r) % 8; k > 0; k--) {
        const int vertex = next(r) % s->n_vertices, axis = next(r) % 4, by = next(r);
        if (axis == 3) /* one vertex in the place of another */
            memcpy(s->xyz + 3 * vertex, s->xyz + 3 * (by % s->n_vertices), 3 * sizeof(double));
        else
            s->xyz[3 * vertex + axis] += by == 255 ? 1e60 : (by - 100) / 64.0;
    }
    const int more = next(r) % 16;
    if (more == 1 && s->n_faces > 1) /* a hole in the surface, or another boundary */
        s->n_corners -= s->sizes[--s->n_faces];
    if (more == 2)
        add_copy(s);
}

/* Creases along edges of faces, sharp, fading and out of range, and corners. */
static void make_mesh(reader *r, state *s) {
    int32_t ends[2 * MOST_CREASES], corner[MOST_CREASES];
    double sharp[MOST_CREASES], sharp_corner[MOST_CREASES];
    curvopt_creases c = {.crease_vertices = ends, .crease_sharpness = sharp, .corner_vertices = corner};
    curvopt_error error = {0};
    c.corner_sharpness = sharp_corner;
    c.n_creases = next(r) % 3 ? 0 : next(r) % MOST_CREASES;
    for (int32_t k = 0; k < c.n_creases; k++) {
        const int32_t at = next(r) % (s->n_corners - 1);
        ends[2 * k] = s->corners[at];
        ends[2 * k + 1] = s->corners[at + 1];
        sharp[k] = next(r) / 16.0;
    }
    c.n_corners = next(r) % 4 ? 0 : next(r) % MOST_CREASES;
    for (int32_t k = 0; k < c.n_corners; k++) {
        corner[k] = next(r) % s->n_vertices;
        sharp_corner[k] = next(r) / 16.0 - 0.5;
    }
    c.boundary_rule = next(r) % 8 == 1;
    const int32_t status =
        curvopt_mesh_create_creased(s->n_vertices, s->n_faces, s->sizes, s->corners, &c, &s->mesh, &error);
    FUZZ_CHECK((s->mesh != NULL) == (status == CURVOPT_OK));
    if (status != CURVOPT_OK)
        check_refusal(status, &error);
}

static void make_options(reader *r, state *s) {
    curvopt_options *o = &s->options;
    curvopt_options_init(o, sizeof *o);
    o->surface = next(r) % 4;
    o->weights[CURVOPT_TERM_WILLMORE] = next(r) % 4 == 0 ? 1e-30 : 1;
    o->weights[next(r) % CURVOPT_N_TERMS] += next(r) % 8 == 7 ? CURVOPT_WEIGHT_MAX / 2 : 1;
    o->levels = 1 + (next(r) % 8 == 1);
    o->max_iterations = next(r) % 4;
    o->tolerance = 0.5;
    o->threads = 1 + next(r) % 2;
    o->boundary = next(r) % 4;
    o->symmetry = next(r) % 4;
    o->spacing = next(r) % 3;
    o->strength = next(r) % 4 == 1 ? 0.3 : 1;
    o->blend_width = 1 + next(r) % 8;
    o->slide = next(r) % 4 == 1;
    o->joshi_sequin = next(r) % 8 == 1;
    /* of numbers that were drawn: the corpus stays. Rarely: where vertices coincide it takes most of the time */
    o->no_crossings = !o->slide && !o->joshi_sequin && o->blend_width == 7 && o->levels == 1;
    o->strict = next(r) % 8 == 1;
    o->verify = next(r) % 8 == 1;
    o->escape = next(r) % 8 == 1;
    if (next(r) % 4 == 1)
        o->scalar_rule[next(r) % CURVOPT_N_SCALARS] = CURVOPT_SCALAR_RULE_KEEP;
}

/* ------------------------------------------------------------------------------------------------- calls -- */

static void call_copies(state *s) {
    int32_t sizes[MOST_FACES], corners[MOST_CORNERS], n_creases, n_corners;
    int32_t ends[2 * MOST_CORNERS], vertex[MOST_VERTICES];
    double sharp[MOST_CORNERS], sharp_corner[MOST_VERTICES];
    curvopt_mesh_get_faces(s->mesh, sizes, corners);
    FUZZ_CHECK(memcmp(sizes, s->sizes, sizeof *sizes * (size_t)s->n_faces) == 0);
    FUZZ_CHECK(memcmp(corners, s->corners, sizeof *corners * (size_t)s->n_corners) == 0);
    curvopt_mesh_count_creases(s->mesh, &n_creases, &n_corners);
    FUZZ_CHECK(n_creases >= 0 && n_creases <= MOST_CREASES && n_corners >= 0 && n_corners <= s->n_vertices);
    curvopt_mesh_get_creases(s->mesh, ends, sharp, vertex, sharp_corner);
    for (int32_t k = 0; k < n_creases; k++)
        FUZZ_CHECK(sharp[k] > 0 && ends[2 * k] != ends[2 * k + 1]);
    for (int32_t k = 0; k < n_corners; k++)
        FUZZ_CHECK(sharp_corner[k] > 0 && vertex[k] >= 0 && vertex[k] < s->n_vertices);
}

static void call_refine(state *s) {
    double fine_xyz[3 * (MOST_VERTICES + MOST_FACES + MOST_CORNERS)];
    curvopt_mesh *fine;
    curvopt_mesh_info info;
    curvopt_error error = {0};
    const int32_t status = curvopt_mesh_refine(s->mesh, s->xyz, &fine, fine_xyz, &error);
    if (status != CURVOPT_OK) {
        check_refusal(status, &error);
        return;
    }
    curvopt_mesh_get_info(fine, &info, sizeof info);
    check_finite(fine_xyz, 3 * info.n_vertices);
    curvopt_mesh_destroy(fine);
}

static void call_evaluate(state *s) {
    double gradient[3 * MOST_VERTICES];
    curvopt_energies e;
    curvopt_error error = {0};
    int32_t status = CURVOPT_OK;
    if (!s->problem)
        status = curvopt_problem_create(s->mesh, s->xyz, &s->options, &s->problem, &error);
    if (status == CURVOPT_OK)
        status = curvopt_problem_evaluate(s->problem, s->xyz, &e, sizeof e, gradient, &error);
    if (status == CURVOPT_OK) {
        FUZZ_CHECK(isfinite(e.objective) && e.objective >= 0);
        check_finite(gradient, 3 * s->n_vertices);
    } else {
        check_refusal(status, &error);
    }
}

/* A callback that ends an evaluation at the last of so many calls. */
static int32_t count_down(const curvopt_progress *p, void *user) {
    int *left = user;
    FUZZ_CHECK(p->iteration >= 0 && p->iteration == p->evaluations && !p->mesh && p->seconds >= 0);
    return --*left == 0;
}

/* The same as call_evaluate(), with a flag that may be raised and a callback that may end it. */
static void call_interruptible(reader *r, state *s) {
    double gradient[3 * MOST_VERTICES];
    curvopt_energies e;
    curvopt_cancel *cancel;
    curvopt_error error = {0};
    int32_t status = CURVOPT_OK;
    int left = next(r) % 16;
    FUZZ_CHECK(curvopt_cancel_create(&cancel, &error) == CURVOPT_OK);
    if (next(r) % 8 == 1)
        curvopt_cancel_request(cancel);
    if (!s->problem)
        status = curvopt_problem_create_interruptible(s->mesh, s->xyz, &s->options, count_down, &left, cancel,
                                                      &s->problem, &error);
    if (status == CURVOPT_OK)
        status = curvopt_problem_evaluate_interruptible(s->problem, s->xyz, count_down, &left, cancel, &e, sizeof e,
                                                        gradient, &error);
    if (status == CURVOPT_OK)
        check_finite(gradient, 3 * s->n_vertices);
    else
        check_refusal(status, &error);
    curvopt_cancel_destroy(cancel);
}

static void call_sampler(reader *r, state *s) {
    enum { POINTS = 4 };
    int32_t face[POINTS], corner[POINTS];
    double uv[2 * POINTS], jets[30 * POINTS];
    curvopt_sampler *sampler;
    curvopt_error error = {0};
    int32_t status = curvopt_sampler_create(s->mesh, s->xyz, &s->options, &sampler, &error);
    for (int32_t k = 0; k < POINTS; k++) {
        face[k] = next(r) % (s->n_faces + (next(r) % 16 == 1));
        corner[k] = face[k] < s->n_faces && s->sizes[face[k]] == 4 ? 0 : next(r) % 4;
        uv[2 * k] = next(r) / 255.0;
        uv[2 * k + 1] = next(r) / 250.0;
    }
    if (status == CURVOPT_OK)
        status = curvopt_sampler_jets(sampler, POINTS, face, corner, uv, jets, &error);
    if (status != CURVOPT_OK)
        check_refusal(status, &error);
    for (int32_t k = 0; status == CURVOPT_OK && k < POINTS; k++)
        check_finite(jets + 30 * (size_t)k, 3);
    curvopt_sampler_destroy(sampler);
}

static void call_measure(reader *r, state *s) {
    double other[3 * MOST_VERTICES], distances[MOST_VERTICES];
    int32_t pairs[2 * 8];
    curvopt_crossings c;
    curvopt_deviation d;
    curvopt_cancel *cancel;
    curvopt_error error = {0};
    FUZZ_CHECK(curvopt_cancel_create(&cancel, &error) == CURVOPT_OK);
    if (next(r) % 4 != 1) /* seconds, of cages that are as bad as most here: rarely to the end */
        curvopt_cancel_request(cancel);
    for (int32_t i = 0; i < 3 * s->n_vertices; i++)
        other[i] = s->xyz[i] * (1 + (i == next(r) % 8) / 4.0);
    int32_t status = curvopt_find_crossings(s->mesh, s->xyz, 1, cancel, 8, pairs, &c, sizeof c, &error);
    if (status == CURVOPT_OK)
        FUZZ_CHECK(c.n_pairs >= 0 && c.n_listed <= 8 && c.n_listed <= c.n_pairs);
    else
        check_refusal(status, &error);
    int32_t folded[MOST_FACES], n_folded = 0;
    status = curvopt_find_folds(s->mesh, s->xyz, &s->options, cancel, folded, &n_folded, &error);
    if (status == CURVOPT_OK)
        for (int32_t f = 0; f < s->n_faces; f++)
            n_folded -= folded[f];
    else
        check_refusal(status, &error);
    FUZZ_CHECK(n_folded == 0);
    status = curvopt_measure_deviation(s->mesh, s->xyz, s->mesh, other, 1, cancel, &d, sizeof d, distances, &error);
    if (status == CURVOPT_OK)
        FUZZ_CHECK(d.max >= 0 && d.bound >= d.max && isfinite(d.bound) && d.size > 0);
    else
        check_refusal(status, &error);
    curvopt_cancel_destroy(cancel);
}

/* A callback that raises the flag of its run, or ends it itself, at the first step. */
typedef struct stopper {
    curvopt_cancel *cancel;
    int how;
} stopper;

static int32_t on_step(const curvopt_progress *p, void *user) {
    stopper *stop = user;
    FUZZ_CHECK(p->struct_size == (int32_t)sizeof *p && p->n_vertices > 0);
    if (stop->how == 1)
        curvopt_cancel_request(stop->cancel);
    return stop->how == 2;
}

static void check_result(const state *s, const curvopt_result *result) {
    static double xyz[3 * (MOST_VERTICES + MOST_FACES + MOST_CORNERS)];
    curvopt_summary summary;
    curvopt_energies start, end;
    curvopt_level_report level;
    curvopt_mesh_info info;
    curvopt_error error = {0};
    curvopt_result_get_summary(result, &summary, sizeof summary);
    curvopt_result_get_energies(result, &start, &end, sizeof end);
    int32_t *pairs = calloc(2 * (size_t)summary.n_touching + 1, sizeof *pairs);
    FUZZ_CHECK(pairs && summary.n_touching >= 0);
    curvopt_result_get_touching(result, pairs);
    for (int32_t k = 0; k < 2 * summary.n_touching; k++)
        FUZZ_CHECK(pairs[k] >= 0 && pairs[k] < MOST_FACES);
    free(pairs);
    curvopt_mesh_get_info(curvopt_result_mesh(result), &info, sizeof info);
    FUZZ_CHECK(info.n_vertices == summary.n_vertices && info.n_vertices >= s->n_vertices);
    FUZZ_CHECK((size_t)info.n_vertices * 3 <= sizeof xyz / sizeof *xyz);
    curvopt_result_get_positions(result, xyz);
    check_finite(xyz, 3 * info.n_vertices);
    FUZZ_CHECK(summary.stop == CURVOPT_STOP_CANCELLED || isfinite(end.objective));
    for (int32_t k = 0; k < summary.n_levels; k++)
        FUZZ_CHECK(curvopt_result_get_level(result, k, &level, sizeof level, &error) == CURVOPT_OK);
    FUZZ_CHECK(curvopt_result_get_level(result, summary.n_levels, &level, sizeof level, &error) != CURVOPT_OK);
}

/* What the surface goes through: up to three entries, and arrays that are there or not. */
typedef struct wish {
    curvopt_through through;
    int32_t vertex[3], face[3], corner[3], freedom[3], toward[3];
    double uv[6], direction[9], place[9], normal[9], tangent[9], weight[3], parameter[3], chain_weight, curvature[6];
    curvopt_chain chain;
} wish;

static void any_vectors(reader *r, double *out, double unit) {
    for (int i = 0; i < 9; i++)
        out[i] = (next(r) - 100) * unit;
    if (next(r) % 2)
        out[0] = out[1] = out[2] = (double)NAN;
}

/* Corners that follow each other, mostly of one face, on the places as a curve. */
static void make_chain(reader *r, const state *s, wish *w) {
    const int kind = next(r), from = next(r) % (s->n_corners - 2);
    for (int k = 0; k < 3; k++)
        w->parameter[k] = next(r) / 100.0;
    w->chain = (curvopt_chain){.vertices = s->corners + from,
                               .curve = w->place,
                               .parameters = kind & 4 ? w->parameter : NULL,
                               .n_vertices = 1 + kind / 8 % 3,
                               .n_points = kind / 64,
                               .is_closed = kind & 2,
                               .is_curve_closed = kind & 16};
    w->chain_weight = kind & 32 ? 0.25 * (kind / 8 % 4) : 1;
    w->through.chain_weights = kind & 4 ? &w->chain_weight : NULL;
    w->through.chains = &w->chain;
    w->through.n_chains = kind & 1;
}

static void make_wish(reader *r, const state *s, wish *w) {
    *w = (wish){.through = {.struct_size = sizeof w->through, .n = next(r) % 4}};
    for (int k = 0; k < 3; k++) {
        w->vertex[k] = next(r) % 3 ? next(r) % s->n_vertices : -1;
        w->face[k] = next(r) % s->n_faces;
        w->corner[k] = next(r) % 8 ? 0 : next(r) % 5;
        w->freedom[k] = next(r) % 4;
        w->toward[k] = next(r) % s->n_vertices;
        w->uv[2 * k] = next(r) / 200.0;
        w->uv[2 * k + 1] = next(r) / 200.0;
    }
    any_vectors(r, w->direction, 1);
    any_vectors(r, w->place, 0.01);
    any_vectors(r, w->normal, 1);
    any_vectors(r, w->tangent, 1);
    const int has = next(r);
    w->through.vertices = w->vertex;
    w->through.faces = w->face;
    w->through.corners = w->corner;
    w->through.uv = w->uv;
    w->through.freedom = has & 1 ? w->freedom : NULL;
    w->through.directions = w->direction;
    w->through.places = has & 2 ? w->place : NULL;
    w->through.normals = has & 4 ? w->normal : NULL;
    w->through.tangents = has & 8 ? w->tangent : NULL;
    w->through.toward = w->toward;
    for (int k = 0; k < 3; k++) /* by bits that are of nothing else: one, or all, or all but one are springs */
        w->weight[k] = has >> 5 & 1 << k ? 1 - 0.125 * (1 + k) : 1;
    w->through.weights = has & 16 ? w->weight : NULL;
    for (int k = 0; k < 6; k++) /* by the places' bytes, so that older seeds still mean the same calls */
        w->curvature[k] = has & 2 ? 100 * w->place[k] : 1;
    w->through.curvatures = (has & 96) == 96 ? w->curvature : NULL;
    w->through.curvature_directions = has & 1 ? w->tangent : w->direction;
    make_chain(r, s, w);
}

static void call_minimize(reader *r, state *s) {
    wish wish;
    int32_t vertex[3], freedom[3], level, status;
    double direction[9], weight[3];
    curvopt_constraints pins = {.vertices = vertex, .freedom = freedom, .directions = direction, .weights = weight};
    stopper stop = {.how = next(r) % 4};
    curvopt_result *result;
    curvopt_error error = {0};
    pins.n = next(r) % 4;
    for (int32_t k = 0; k < pins.n; k++) {
        vertex[k] = next(r) % s->n_vertices;
        freedom[k] = next(r) % 3 + CURVOPT_FREEDOM_OF_LIMIT_POINT * (next(r) % 4 == 1);
        weight[k] = next(r) % 4 == 1 ? 0.5 : 1;
        for (int c = 0; c < 3; c++)
            direction[3 * k + c] = next(r) - 100;
    }
    s->options.constraints = pins.n ? &pins : NULL;
    make_wish(r, s, &wish);
    s->options.through = &wish.through;
    FUZZ_CHECK(curvopt_cancel_create(&stop.cancel, &error) == CURVOPT_OK);
    status = curvopt_find_moving_level(s->mesh, s->xyz, &s->options, &level, &error);
    if (status != CURVOPT_OK)
        check_refusal(status, &error);
    status = curvopt_minimize(s->mesh, s->xyz, &s->options, on_step, &stop, stop.cancel, &result, &error);
    if (status == CURVOPT_OK)
        check_result(s, result);
    else
        check_refusal(status, &error);
    s->options.constraints = NULL;
    s->options.through = NULL;
    curvopt_result_destroy(result);
    curvopt_cancel_destroy(stop.cancel);
}

static void call_hessian(state *s, curvopt_problem *problem, int exact) {
    curvopt_hessian *hessian;
    curvopt_matrix matrix;
    curvopt_error error = {0};
    int32_t status = curvopt_hessian_create(problem, &hessian, &error);
    if (status == CURVOPT_OK)
        status = curvopt_hessian_assemble(hessian, s->xyz, exact, 1, 1, &error);
    if (status != CURVOPT_OK) {
        check_refusal(status, &error);
    } else {
        curvopt_hessian_get(hessian, &matrix);
        FUZZ_CHECK(matrix.n == 3 * s->n_vertices && matrix.column_start[0] == 0);
        for (int32_t k = 0; k < matrix.n; k++)
            FUZZ_CHECK(matrix.row[matrix.column_start[k]] == k);
    }
    curvopt_hessian_destroy(hessian);
}

/* A problem of some faces; its rules set to what they are, or to any. */
static void call_part(reader *r, state *s) {
    double weight[MOST_FACES], errors[MOST_FACES], gradients[9 * MOST_VERTICES];
    int32_t rules[MOST_FACES];
    curvopt_problem *problem;
    curvopt_sums sums;
    curvopt_energies e;
    curvopt_error error = {0};
    for (int32_t f = 0; f < s->n_faces; f++)
        weight[f] = next(r) % 4 / 2.0;
    int32_t status = curvopt_problem_create_part(s->mesh, weight, &s->options, &problem, &error);
    if (status != CURVOPT_OK) {
        check_refusal(status, &error);
        return;
    }
    FUZZ_CHECK(curvopt_problem_evaluate(problem, s->xyz, &e, sizeof e, NULL, &error) == CURVOPT_ERROR_ARGUMENT);
    curvopt_problem_get_rules(problem, rules);
    for (int32_t f = 0; f < s->n_faces; f++)
        rules[f] = next(r) % 4 == 1 ? next(r) % 10 - 1 : rules[f];
    status = curvopt_problem_set_rules(problem, rules, &error);
    if (status != CURVOPT_OK)
        check_refusal(status, &error);
    FUZZ_CHECK(curvopt_problem_sum(problem, s->xyz, next(r) % 2, gradients, &sums, &error) == CURVOPT_OK);
    status = curvopt_problem_face_errors(problem, s->xyz, 1, 1, errors, &error);
    if (status != CURVOPT_OK)
        check_refusal(status, &error);
    call_hessian(s, problem, next(r) % 2);
    curvopt_problem_destroy(problem);
}

/* The mesh that some faces depend on, made again from its polygons. */
static void call_mesh_part(reader *r, state *s) {
    double weight[MOST_FACES];
    int32_t vertex_of[MOST_VERTICES], face_of[MOST_FACES], sizes[MOST_FACES], corners[MOST_CORNERS];
    curvopt_mesh *part, *again;
    curvopt_mesh_info info;
    curvopt_error error = {0};
    for (int32_t f = 0; f < s->n_faces; f++)
        weight[f] = next(r) % 4 == 1;
    int32_t status = curvopt_mesh_part(s->mesh, weight, &part, vertex_of, face_of, &error);
    if (status != CURVOPT_OK) {
        check_refusal(status, &error);
        return;
    }
    curvopt_mesh_get_info(part, &info, sizeof info);
    for (int32_t f = 0; f < info.n_faces; f++)
        FUZZ_CHECK(face_of[f] >= 0 && face_of[f] < s->n_faces);
    curvopt_mesh_get_faces(part, sizes, corners);
    status = curvopt_mesh_create_part(info.n_vertices, info.n_faces, sizes, corners, NULL, &again, &error);
    if (status != CURVOPT_OK)
        check_refusal(status, &error);
    curvopt_mesh_destroy(again);
    curvopt_mesh_destroy(part);
}

static void call(reader *r, state *s) {
    switch (next(r) % 10) {
    case 9:
        call_solver(r, s->mesh, s->n_vertices, s->xyz, &s->options);
        break;
    case 8:
        call_interruptible(r, s);
        break;
    case 0:
        call_copies(s);
        break;
    case 1:
        call_refine(s);
        break;
    case 2:
        call_sampler(r, s);
        break;
    case 3:
        call_measure(r, s);
        break;
    case 4:
        call_minimize(r, s);
        break;
    case 5:
        call_part(r, s);
        break;
    case 6:
        call_mesh_part(r, s);
        break;
    default:
        call_evaluate(s);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static state s; /* what the last one left is no harm */
    reader r = {data, data + size};
    s.mesh = NULL;
    s.problem = NULL;
    make_cage(&r, &s);
    make_mesh(&r, &s);
    make_options(&r, &s);
    for (int k = 0; s.mesh && k < MOST_CALLS && r.at < r.end; k++)
        call(&r, &s);
    curvopt_problem_destroy(s.problem);
    curvopt_mesh_destroy(s.mesh);
    return 0;
}
