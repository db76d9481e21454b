/* Exported functions that measure and compare surfaces. SPDX-License-Identifier: GPL-3.0-or-later */
#include "api/api.h"
#include "base/cancel.h"
#include "base/memory.h"
#include "energy/admissibility.h"
#include "measure/correspondence.h"
#include "measure/crossings.h"
#include "measure/deviation.h"
#include "measure/location.h"
#include "mesh/similarity.h"
#include "surface/folds.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Steps of Newton's method that a measurement takes; .1 us each on one 2-GHz core
 * (notes/110-deviation-with-a-bound.md). */
enum { MOST_STEPS = 20000000 };
/* Of an extraordinary patch: how small the tip is at which its rings end. For deviation it is TIP_FIRST at first, which
 * is fine enough where tips are TIP_PART of the largest distance; of surfaces that are nearly the same it is TIP. */
#define TIP              2e-5
#define TIP_FIRST        (1.0 / 16)
#define TIP_OF_CROSSINGS (1.0 / 256)
#define TIP_PART         0.05
/* Rings are whole: up to one of the first cut may be counted twice, and each is smaller by this at least. */
#define TIP_RING 0.25

static int32_t start_threads(int32_t threads, co_thread_pool **pool, curvopt_error *error) {
    curvopt_options check;
    curvopt_options_init(&check, sizeof check);
    check.threads = threads;
    int32_t status = curvopt_options_validate(&check, error);
    return status == CURVOPT_OK ? co_thread_pool_create(threads, pool, error) : status;
}

/* Of lengths as they are given, products may be larger or smaller than numbers can be. Times 2^exponent the cage has a
 * size near 1, and what is measured has the same digits. */
static int exponent_for(const curvopt_mesh *mesh, const double *xyz) {
    double centroid[3];
    int exponent = 0;
    const double size = co_similarity_mesh_frame(mesh, xyz, centroid);
    if (size > 0 && size < INFINITY)
        frexp(size, &exponent);
    return -exponent;
}

/* xyz [3 n_vertices] times that; NULL without memory. */
static double *times_power(const curvopt_mesh *mesh, const double *xyz, int exponent) {
    const size_t n = 3 * (size_t)mesh->info.n_vertices;
    double *out = CO_NEW(double, n);
    for (size_t i = 0; out && i < n; i++)
        out[i] = ldexp(xyz[i], exponent);
    return out;
}

typedef struct vertices {
    const co_nearest *surface;
    const double *limits;
    double *distances;
    const curvopt_cancel *cancel;
} vertices;

static void measure_some(void *context, size_t begin, size_t end) {
    const vertices *v = context;
    co_surface_point near = {.part = -1};
    for (size_t k = begin; k < end; k++) {
        v->distances[k] = (double)NAN;
        if (v->limits[3 * k] == v->limits[3 * k] && !co_cancel_is_requested(v->cancel)) { /* not NAN */
            co_nearest_find(v->surface, v->limits + 3 * k, near.part, &near);
            v->distances[k] = near.distance;
        }
    }
}

static int32_t measure_vertices(const curvopt_mesh *mesh, const co_surface_pieces *pieces, const co_nearest *from,
                                co_thread_pool *pool, const curvopt_cancel *cancel, double *distances,
                                curvopt_error *error) {
    double *limits = CO_NEW(double, 3 * (size_t)mesh->info.n_vertices);
    if (!limits)
        return co_status_no_memory(error);
    co_location_limits(mesh, pieces, limits);
    vertices v = {.surface = from, .limits = limits, .distances = distances, .cancel = cancel};
    co_thread_pool_for(pool, (size_t)mesh->info.n_vertices, measure_some, &v);
    free(limits);
    return CURVOPT_OK;
}

/* The diagonal of the box of both cages, in which both surfaces are. */
static double joint_diagonal(const curvopt_mesh *mesh, const double *xyz, const curvopt_mesh *other,
                             const double *other_xyz) {
    double square = 0;
    for (int c = 0; c < 3; c++) {
        double low = xyz[c], high = xyz[c];
        for (size_t v = 0; v < (size_t)mesh->info.n_vertices; v++) {
            low = fmin(low, xyz[3 * v + c]);
            high = fmax(high, xyz[3 * v + c]);
        }
        for (size_t v = 0; v < (size_t)other->info.n_vertices; v++) {
            low = fmin(low, other_xyz[3 * v + c]);
            high = fmax(high, other_xyz[3 * v + c]);
        }
        square += (high - low) * (high - low);
    }
    return sqrt(square);
}

/* What is known of two surfaces before anything of them was measured. */
static void leave_unmeasured(const curvopt_mesh *other, co_deviation *out, double *distances) {
    *out = (co_deviation){.rms = (double)NAN, .bound = (double)INFINITY};
    for (int c = 0; c < 3; c++)
        out->point[0][c] = out->point[1][c] = (double)NAN;
    for (int32_t v = 0; distances && v < other->info.n_vertices; v++)
        distances[v] = (double)NAN;
}

/* Two limit surfaces, to be measured from one another. */
typedef struct surfaces {
    const curvopt_mesh *mesh[2];
    const double *xyz[2];
    co_surface_pieces pieces[2];
    co_nearest nearest[2];
} surfaces;

static void free_pieces(surfaces *s) {
    for (int k = 0; k < 2; k++) {
        co_nearest_free(&s->nearest[k]);
        co_pieces_free(&s->pieces[k]);
        s->pieces[k] = (co_surface_pieces){.n_pieces = 0};
    }
}

static int32_t cut_with_tip(surfaces *s, double tip, co_thread_pool *pool, const curvopt_cancel *cancel,
                            curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    free_pieces(s);
    for (int k = 0; status == CURVOPT_OK && k < 2; k++)
        status = co_pieces_create(s->mesh[k], s->xyz[k], tip, pool, cancel, &s->pieces[k], error);
    for (int k = 0; status == CURVOPT_OK && k < 2; k++)
        status = co_nearest_create(&s->pieces[k], cancel, &s->nearest[k], error);
    return status;
}

/* Tips as small as the distance asks for. */
static int32_t cut_into_pieces(surfaces *s, co_thread_pool *pool, const curvopt_cancel *cancel, curvopt_error *error) {
    double radius = 0, distance;
    int32_t status = cut_with_tip(s, TIP_FIRST, pool, cancel, error);
    if (status != CURVOPT_OK)
        return status;
    for (int k = 0; k < 2; k++)
        for (int32_t t = 0; t < s->pieces[k].n_tips; t++)
            radius = fmax(radius, s->pieces[k].tip[t].radius);
    status = co_deviation_glimpse(s->nearest, pool, cancel, &distance, error);
    const double part = TIP_PART * distance / radius;
    if (status == CURVOPT_OK && part < 1)
        status = cut_with_tip(s, fmax(TIP, TIP_FIRST * TIP_RING * part), pool, cancel, error);
    return status;
}

int32_t curvopt_measure_deviation(const curvopt_mesh *mesh, const double *xyz, const curvopt_mesh *other,
                                  const double *other_xyz, int32_t threads, const curvopt_cancel *cancel,
                                  curvopt_deviation *out, size_t size, double *distances, curvopt_error *error) {
    co_deviation found;
    co_thread_pool *pool = NULL;
    double farthest = (double)INFINITY;
    if (!mesh || !xyz || !other || !other_xyz || !out)
        return co_api_null(error, !mesh ? "mesh" : !xyz ? "xyz" : !other ? "other" : !out ? "out" : "other_xyz");
    const int exponent = exponent_for(mesh, xyz);
    double *mine = times_power(mesh, xyz, exponent), *theirs = times_power(other, other_xyz, exponent);
    surfaces s = {.mesh = {mesh, other}, .xyz = {mine, theirs}};
    int32_t status = mine && theirs ? start_threads(threads, &pool, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = cut_into_pieces(&s, pool, cancel, error);
    if (status == CURVOPT_OK)
        status = co_deviation_measure(s.nearest, MOST_STEPS, pool, cancel, &found, error);
    if (status == CURVOPT_OK)
        status = co_correspondence_farthest(s.mesh, s.xyz, &farthest, error);
    if (status == CURVOPT_OK && distances)
        status = measure_vertices(other, &s.pieces[1], &s.nearest[0], pool, cancel, distances, error);
    if (status == CO_CANCELLED) {
        leave_unmeasured(other, &found, distances);
        status = CURVOPT_OK;
    }
    if (status == CURVOPT_OK) {
        double centroid[3], bound = fmax(found.max, fmin(found.bound, farthest));
        if (co_cancel_is_requested(cancel))
            bound = fmin(bound, joint_diagonal(mesh, mine, other, theirs));
        curvopt_deviation measured = {.max = ldexp(found.max, -exponent),
                                      .rms = ldexp(found.rms, -exponent),
                                      .bound = ldexp(bound, -exponent),
                                      .size = co_similarity_mesh_frame(mesh, xyz, centroid)};
        for (int c = 0; c < 3; c++) {
            measured.point[c] = ldexp(found.point[0][c], -exponent);
            measured.other_point[c] = ldexp(found.point[1][c], -exponent);
        }
        for (int32_t v = 0; distances && v < other->info.n_vertices; v++)
            distances[v] = ldexp(distances[v], -exponent);
        co_api_copy_out(out, size, &measured, sizeof measured);
    }
    free_pieces(&s);
    free(mine);
    free(theirs);
    co_thread_pool_destroy(pool);
    return status;
}

/* The counts, and the pairs that cross as far as there is room. */
static void list_crossings(const co_crossings *found, int32_t n_room, int32_t *pairs, curvopt_crossings *out) {
    *out = (curvopt_crossings){0};
    for (size_t k = 0; k < found->n; k++) {
        const co_face_pair *pair = &found->pair[k];
        out->n_pairs += pair->what == CO_CROSSING_PROVEN;
        out->n_contacts += pair->what == CO_CROSSING_CONTACT;
        out->n_unresolved += pair->what == CO_CROSSING_UNRESOLVED;
        if (pair->what == CO_CROSSING_PROVEN && out->n_listed < n_room) {
            pairs[2 * (size_t)out->n_listed] = pair->face[0];
            pairs[2 * (size_t)out->n_listed++ + 1] = pair->face[1];
        }
    }
}

int32_t curvopt_find_folds(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                           const curvopt_cancel *cancel, int32_t *folded, int32_t *n_folded, curvopt_error *error) {
    curvopt_options own;
    co_exceptions exceptions = {0};
    co_cancel flag;
    int32_t n = 0;
    if (!mesh || !xyz || !options)
        return co_api_null(error, !mesh ? "mesh" : !xyz ? "xyz" : "options");
    co_cancel_start_at_once(&flag, cancel);
    const int32_t n_faces = mesh->info.n_faces;
    double *scaled = times_power(mesh, xyz, exponent_for(mesh, xyz));
    uint8_t *left_out = CO_NEW(uint8_t, n_faces), *found = CO_NEW(uint8_t, n_faces);
    int32_t status = scaled && left_out && found ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = co_api_take_options(options, &own, error);
    if (status == CURVOPT_OK)
        status = co_similarity_check(mesh->info.n_vertices, xyz, error);
    if (status == CURVOPT_OK)
        status = co_exceptions_find(mesh, xyz, &own, &exceptions, error);
    for (int32_t f = 0; status == CURVOPT_OK && f < n_faces; f++)
        left_out[f] = exceptions.face[f] >= 0;
    if (status == CURVOPT_OK)
        status = co_folds_find(mesh, scaled, left_out, &flag, found, &n, error);
    if (status == CO_CANCELLED)
        status = CURVOPT_OK;
    for (int32_t f = 0; status == CURVOPT_OK && folded && f < n_faces; f++)
        folded[f] = found[f];
    if (status == CURVOPT_OK && n_folded)
        *n_folded = n;
    co_exceptions_free(&exceptions);
    free(scaled);
    free(left_out);
    free(found);
    return status;
}

int32_t curvopt_find_crossings(const curvopt_mesh *mesh, const double *xyz, int32_t threads,
                               const curvopt_cancel *cancel, int32_t n_room, int32_t *pairs, curvopt_crossings *out,
                               size_t size, curvopt_error *error) {
    co_surface_pieces pieces = {.n_pieces = 0};
    co_crossings found = {.n = 0};
    co_thread_pool *pool = NULL;
    if (!mesh || !xyz || !out || (n_room > 0 && !pairs))
        return co_api_null(error, !mesh ? "mesh" : !xyz ? "xyz" : !out ? "out" : "pairs");
    if (n_room < 0)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "n_room is %d; it must be 0 or more", n_room);
    double *scaled = times_power(mesh, xyz, exponent_for(mesh, xyz));
    int32_t status = scaled ? start_threads(threads, &pool, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = co_pieces_create(mesh, scaled, TIP_OF_CROSSINGS, pool, cancel, &pieces, error);
    if (status == CURVOPT_OK)
        status = co_crossings_find(mesh, &pieces, pool, cancel, &found, error);
    if (status == CO_CANCELLED)
        status = CURVOPT_OK;
    if (status == CURVOPT_OK) {
        curvopt_crossings theirs;
        list_crossings(&found, n_room, pairs, &theirs);
        theirs.is_complete = !co_cancel_is_requested(cancel);
        co_api_copy_out(out, size, &theirs, sizeof theirs);
    }
    co_crossings_free(&found);
    co_pieces_free(&pieces);
    free(scaled);
    co_thread_pool_destroy(pool);
    return status;
}
