/* Any bytes as a small cage: it is refused with a message, or evaluated to finite figures.
 * SPDX-License-Identifier: GPL-3.0-or-later
 *
 * Byte 0: number of vertices; 1: of faces; 2: surface, and whether to be strict; 3: term; then a byte for each face's
 * size and for each corner's vertex, as long as there are bytes; what is left moves the vertices, which otherwise lie
 * on a sphere. */
#include "fuzz.h"

#include "curvopt.h"

#include <math.h>
#include <string.h>

const char fuzz_name[] = "mesh";

enum { MOST_VERTICES = 24, MOST_FACES = 24, MOST_SIZE = 9 };

typedef struct reader {
    const uint8_t *at, *end;
} reader;

static int next(reader *r) {
    return r->at < r->end ? *r->at++ : 0;
}

/* Mostly an index; sometimes a negative one. */
static int signed_next(reader *r) {
    int byte = next(r);
    return byte < 128 ? byte : byte - 256;
}

typedef struct input {
    int32_t n_vertices, n_faces, sizes[MOST_FACES], vertices[MOST_FACES * MOST_SIZE];
    double xyz[3 * MOST_VERTICES];
    curvopt_options options;
} input;

static void decode(const uint8_t *data, size_t size, input *in) {
    reader r = {data, data + size};
    int32_t n_corners = 0;
    in->n_vertices = next(&r) % (MOST_VERTICES + 1);
    in->n_faces = next(&r) % (MOST_FACES + 1);
    curvopt_options_init(&in->options, sizeof in->options);
    int surface = next(&r);
    in->options.surface = surface % 4;
    in->options.strict = surface / 4 % 8 == 1;
    in->options.weights[CURVOPT_TERM_WILLMORE] = 0;
    in->options.weights[next(&r) % CURVOPT_N_TERMS] = 1;
    in->options.tolerance = 0.5;
    in->options.threads = 1;
    for (int32_t f = 0; f < in->n_faces; f++)
        in->sizes[f] = next(&r) % (MOST_SIZE + 1);
    for (int32_t f = 0; f < in->n_faces; f++)
        for (int32_t k = 0; k < in->sizes[f]; k++)
            in->vertices[n_corners++] = signed_next(&r);
    for (int32_t v = 0; v < in->n_vertices; v++) {
        double z = 1 - (2 * v + 1) / (double)in->n_vertices, r_xy = sqrt(1 - z * z);
        in->xyz[3 * v] = r_xy * cos(2.4 * v);
        in->xyz[3 * v + 1] = r_xy * sin(2.4 * v);
        in->xyz[3 * v + 2] = z;
    }
    for (int32_t i = 0; i < 3 * in->n_vertices; i++) {
        int byte = next(&r);
        in->xyz[i] = byte == 255 ? (double)NAN : byte == 254 ? ldexp(in->xyz[i], 330) : in->xyz[i] + byte / 64.0;
    }
}

static void evaluate(const curvopt_mesh *mesh, const input *in) {
    curvopt_error error = {0};
    curvopt_problem *problem;
    curvopt_energies e;
    double gradient[3 * MOST_VERTICES];
    int32_t status = curvopt_problem_create(mesh, in->xyz, &in->options, &problem, &error);
    if (status == CURVOPT_OK)
        status = curvopt_problem_evaluate(problem, in->xyz, &e, sizeof e, gradient, &error);
    if (status == CURVOPT_OK) {
        FUZZ_CHECK(isfinite(e.objective) && e.objective >= 0 && e.area > 0 && e.n_samples > 0);
        for (int32_t i = 0; i < 3 * in->n_vertices; i++)
            FUZZ_CHECK(isfinite(gradient[i]));
    } else {
        FUZZ_CHECK(error.code == status && error.message[0] && memchr(error.message, 0, sizeof error.message));
        FUZZ_CHECK(status != CURVOPT_ERROR_MEMORY);
    }
    curvopt_problem_destroy(problem);
}

/* One step, symmetries looked for, vertex 0 sometimes pinned. */
static void minimize(const curvopt_mesh *mesh, input *in, int pinned) {
    const int32_t first = 0;
    const curvopt_constraints pins = {.vertices = &first, .n = 1};
    curvopt_error error = {0};
    curvopt_result *result;
    in->options.levels = in->options.max_iterations = 1;
    in->options.constraints = pinned ? &pins : NULL;
    int32_t status = curvopt_minimize(mesh, in->xyz, &in->options, NULL, NULL, NULL, &result, &error);
    in->options.constraints = NULL;
    if (status == CURVOPT_OK) {
        double xyz[3 * MOST_VERTICES];
        curvopt_summary summary;
        curvopt_energies end;
        curvopt_result_get_summary(result, &summary, sizeof summary);
        curvopt_result_get_energies(result, NULL, &end, sizeof end);
        curvopt_result_get_positions(result, xyz);
        FUZZ_CHECK(summary.symmetry_order >= 1 && isfinite(end.objective));
        for (int32_t i = 0; i < 3 * in->n_vertices; i++)
            FUZZ_CHECK(isfinite(xyz[i]));
        FUZZ_CHECK(!pinned || memcmp(xyz, in->xyz, 3 * sizeof *xyz) == 0);
        int32_t vertex[MOST_VERTICES];
        FUZZ_CHECK(curvopt_mesh_find_exceptions(mesh, in->xyz, &in->options, vertex, NULL, &error) == CURVOPT_OK);
        for (int32_t v = 0; v < in->n_vertices; v++)
            FUZZ_CHECK(in->options.strict || vertex[v] < 0 ||
                       memcmp(xyz + 3 * v, in->xyz + 3 * v, 3 * sizeof *xyz) == 0);
    } else {
        FUZZ_CHECK(error.code == status && error.message[0] && status != CURVOPT_ERROR_MEMORY);
    }
    curvopt_result_destroy(result);
}

/* Vertices of faces that are left out are held, and those alone, besides isolated ones. */
static void check_exceptions(const curvopt_mesh *mesh, const input *in) {
    int32_t vertex[MOST_VERTICES], face[MOST_FACES], beside[MOST_VERTICES] = {0};
    curvopt_error error = {0};
    FUZZ_CHECK(curvopt_mesh_find_exceptions(mesh, NULL, &in->options, vertex, face, &error) == CURVOPT_OK);
    for (int32_t f = 0, at = 0; f < in->n_faces; at += in->sizes[f++])
        for (int32_t k = 0; k < in->sizes[f]; k++)
            beside[in->vertices[at + k]] |= face[f] >= 0;
    for (int32_t v = 0; v < in->n_vertices; v++)
        FUZZ_CHECK((vertex[v] >= 0) == (beside[v] || vertex[v] == CURVOPT_EXCEPTION_ISOLATED));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static input in; /* what the last one left is no harm */
    curvopt_error error = {0};
    curvopt_mesh *mesh, *fine;
    curvopt_mesh_info info;
    decode(data, size, &in);
    int32_t status = curvopt_mesh_create(in.n_vertices, in.n_faces, in.sizes, in.vertices, &mesh, &error);
    FUZZ_CHECK((mesh != NULL) == (status == CURVOPT_OK));
    if (!mesh) {
        FUZZ_CHECK(error.code == status && error.message[0]);
        return 0;
    }
    curvopt_mesh_get_info(mesh, &info, sizeof info);
    FUZZ_CHECK(info.euler == info.n_vertices - info.n_isolated - info.n_edges + info.n_faces);
    if (info.n_flawed_edges == 0)
        FUZZ_CHECK(2 * info.n_edges == info.n_corners + info.n_boundary_edges);
    check_exceptions(mesh, &in);
    FUZZ_CHECK(curvopt_mesh_refine(mesh, NULL, &fine, NULL, &error) == CURVOPT_OK);
    curvopt_mesh_destroy(fine);
    evaluate(mesh, &in);
    minimize(mesh, &in, in.n_faces % 2);
    curvopt_mesh_destroy(mesh);
    return 0;
}
