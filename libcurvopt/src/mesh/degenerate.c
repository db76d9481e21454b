/* Where edges of length 0 leave the limit surface without a tangent plane. SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/degenerate.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "mesh/ring.h"
#include "mesh/similarity.h"

#include <stdlib.h>

typedef struct search {
    const curvopt_mesh *mesh;
    const double *xyz; /* [3 n_vertices] */
    double tolerance;  /* lengths up to this are 0 */
    uint8_t *face;     /* [n_faces] whether an edge of the face has length 0 */
    uint8_t *is_done;  /* [n_corners] whether the corner's fan was looked at */
    double (
        *point)[3]; /* [2 largest valence + 1] of a fan, relative to its vertex: edges' other ends, means of faces */
} search;

static void difference(const search *s, int32_t to, int32_t from, double d[3]) {
    for (size_t c = 0; c < 3; c++)
        d[c] = s->xyz[3 * (size_t)to + c] - s->xyz[3 * (size_t)from + c];
}

static int is_near(const search *s, const double a[3], const double b[3]) {
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return co_length3(d) <= s->tolerance;
}

/* Whether there are edges of length 0 at all. */
static int mark_faces(search *s) {
    const curvopt_mesh *m = s->mesh;
    int any = 0;
    for (int32_t h = 0; h < m->info.n_corners; h++) {
        double d[3];
        difference(s, co_mesh_destination(m, h), m->corner_vertex[h], d);
        if (co_length3(d) <= s->tolerance)
            any = s->face[m->corner_face[h]] = 1;
    }
    return any;
}

static void mean_of_face(const search *s, int32_t face, int32_t origin, double mean[3]) {
    const curvopt_mesh *m = s->mesh;
    mean[0] = mean[1] = mean[2] = 0;
    for (int32_t h = m->face_start[face]; h < m->face_start[face + 1]; h++) {
        double d[3];
        difference(s, m->corner_vertex[h], origin, d);
        for (int c = 0; c < 3; c++)
            mean[c] += d[c] / co_mesh_face_size(m, face);
    }
}

/* The fan that begins at h, into s->point: first the edges' other ends, counter-clockwise. Returns the number of these,
 * or 0 if none of the fan's faces has an edge of length 0. */
static int32_t collect(search *s, int32_t h, int32_t fan) {
    const curvopt_mesh *m = s->mesh;
    int32_t v = m->corner_vertex[h], sectors = co_fan_sectors(fan), n = sectors + co_fan_is_open(fan), last = h;
    int any = 0;
    for (int32_t i = 0; i < sectors; i++, h = co_mesh_rotate(m, h)) {
        difference(s, co_mesh_destination(m, h), v, s->point[i]);
        mean_of_face(s, m->corner_face[h], v, s->point[n + i]);
        any |= s->face[m->corner_face[h]];
        s->is_done[h] = 1;
        last = h;
    }
    if (co_fan_is_open(fan))
        difference(s, m->corner_vertex[co_mesh_prev(m, last)], v, s->point[sectors]);
    return any ? n : 0;
}

/* Whether n points are on one line through 0, the farthest of them at the other end. */
static int are_collinear(const search *s, int32_t n) {
    const double *far = s->point[0];
    for (int32_t i = 1; i < n; i++)
        far = co_length3(s->point[i]) > co_length3(far) ? s->point[i] : far;
    double length = co_length3(far);
    for (int32_t i = 0; length > s->tolerance && i < n; i++) {
        const double *p = s->point[i];
        double along = co_dot3(p, far) / (length * length);
        const double foot[3] = {along * far[0], along * far[1], along * far[2]};
        if (!is_near(s, p, foot))
            return 0;
    }
    return 1;
}

/* n: what collect() has returned, not 0. */
static int is_degenerate(const search *s, int32_t fan, int32_t n) {
    const double *first = s->point[0], *last = s->point[n - 1], zero[3] = {0, 0, 0};
    if (co_fan_type_of(fan) == CO_FAN_CREASE && is_near(s, first, last))
        return 1;
    if (co_fan_type_of(fan) == CO_FAN_CORNER && (is_near(s, first, zero) || is_near(s, last, zero)))
        return 1;
    return are_collinear(s, n + co_fan_sectors(fan));
}

static void mark_fan(search *s, int32_t h, uint8_t *corner) {
    int32_t first, fan = co_ring_fan(s->mesh, h, &first), n = collect(s, first, fan);
    int found = n && is_degenerate(s, fan, n);
    for (int32_t i = 0; found && i < co_fan_sectors(fan); i++, first = co_mesh_rotate(s->mesh, first))
        corner[first] = 1;
}

int32_t co_degenerate_mark(const curvopt_mesh *m, const double *xyz, uint8_t *corner, curvopt_error *error) {
    double centroid[3];
    search s = {.mesh = m,
                .xyz = xyz,
                .tolerance = CURVOPT_COINCIDENT * co_similarity_mesh_frame(m, xyz, centroid),
                .face = CO_NEW(uint8_t, m->info.n_faces),
                .is_done = CO_NEW(uint8_t, m->info.n_corners),
                .point = co_memory_zeroed(2 * (size_t)m->info.max_valence + 1, sizeof *s.point)};
    int32_t status = s.face && s.is_done && s.point ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK && mark_faces(&s))
        for (int32_t h = 0; h < m->info.n_corners; h++)
            if (!s.is_done[h] && s.face[m->corner_face[h]] && co_mesh_flaw_of(m, m->corner_vertex[h]) == CO_MESH_SOUND)
                mark_fan(&s, h, corner);
    free(s.face);
    free(s.is_done);
    free(s.point);
    return status;
}
