/* Limit points of cage vertices. SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/vertex_mask.h"

#include "base/elementary.h"
#include "mesh/crease.h"

#include <math.h>

/* What decides about a vertex' limit point. */
typedef struct ring {
    int32_t n_faces, n_corners, n_sharp;
    int32_t sharp[2]; /* other ends of infinitely sharp edges, the first two */
    int fades;        /* whether an edge or the vertex does */
    int is_corner;
} ring;

static void see_edge(const curvopt_mesh *m, int32_t h, int32_t other, ring *r) {
    const double sharpness = co_crease_edge(m, h);
    r->fades |= co_crease_is_fading(sharpness);
    if (co_crease_is_infinite(sharpness) && r->n_sharp++ < 2)
        r->sharp[r->n_sharp - 1] = other;
}

static ring ring_of(const curvopt_mesh *m, int32_t v) {
    const double sharpness = co_crease_vertex(m, v);
    ring r = {.fades = co_crease_is_fading(sharpness), .is_corner = co_crease_is_infinite(sharpness)};
    int32_t h = m->vertex_corner[v];
    const int32_t first = h;
    while (h >= 0) {
        const int32_t before = co_mesh_prev(m, h);
        see_edge(m, h, co_mesh_destination(m, h), &r);
        r.n_faces++;
        r.n_corners += co_mesh_face_size(m, m->corner_face[h]);
        h = co_mesh_rotate(m, h);
        if (h < 0)
            see_edge(m, before, m->corner_vertex[before], &r);
        if (h == first)
            break;
    }
    r.is_corner |= r.n_sharp > 2;
    return r;
}

int co_vertex_mask_exists(const curvopt_mesh *m, int32_t v) {
    const ring r = ring_of(m, v);
    return r.n_faces > 0 && co_mesh_flaw_of(m, v) == CO_MESH_SOUND && (r.is_corner || (!r.fades && r.n_sharp != 1));
}

/* A mask: weights of the vertex, of each vertex at the other end of an edge (on a curve: of its edges), and of the
 * middle of each face. */
typedef struct weights {
    double vertex, edge, face;
} weights;

static weights limit_weights(const ring *r) {
    const double k = r->n_faces, unit = 1 / (k * (k + 5));
    return r->n_sharp == 2 ? (weights){4.0 / 6, 1.0 / 6, 0} : (weights){k * (k - 1) * unit, 2 * unit, 4 * unit};
}

/* One subdivision takes a vertex of a curve and the mean of its neighbours there to (3 v + w) / 4 and (v + w) / 2. */
static weights on_curve(int32_t subdivisions) {
    weights at = {1, 0, 0};
    for (int32_t i = 0; i < subdivisions; i++)
        at = (weights){0.75 * at.vertex + 0.5 * at.edge, 0.25 * at.vertex + 0.5 * at.edge, 0};
    return (weights){at.vertex, at.edge / 2, 0};
}

/* One subdivision takes a vertex, the mean of its n neighbours and that of its faces' middles, v, w, c, to v' =
 * ((n - 2) v + w + c) / n, w' = (v + w + 2 c) / 4 and (v' + 2 w' + c) / 4. */
static weights on_surface(double n, int32_t subdivisions) {
    weights at = {1, 0, 0};
    for (int32_t i = 0; i < subdivisions; i++) {
        const double v = at.vertex + at.face / 4, w = at.edge + at.face / 2;
        at = (weights){v * (n - 2) / n + w / 4, v / n + w / 4, v / n + w / 2 + at.face / 4};
    }
    return (weights){at.vertex, at.edge / n, at.face / n};
}

static void visit_weighted(const curvopt_mesh *m, int32_t v, const ring *r, weights at, co_vertex_mask_fn visit,
                           void *context) {
    visit(v, at.vertex, context);
    for (int i = 0; r->n_sharp == 2 && i < 2; i++)
        visit(r->sharp[i], at.edge, context);
    int32_t h = m->vertex_corner[v];
    for (int32_t i = 0; r->n_sharp != 2 && i < r->n_faces; i++, h = co_mesh_rotate(m, h)) {
        const int32_t f = m->corner_face[h];
        visit(co_mesh_destination(m, h), at.edge, context);
        for (int32_t c = m->face_start[f]; c < m->face_start[f + 1]; c++)
            visit(m->corner_vertex[c], at.face / co_mesh_face_size(m, f), context);
    }
}

void co_vertex_mask_visit(const curvopt_mesh *m, int32_t v, co_vertex_mask_fn visit, void *context) {
    co_vertex_mask_visit_after(m, v, CO_VERTEX_MASK_LIMIT, visit, context);
}

void co_vertex_mask_visit_after(const curvopt_mesh *m, int32_t v, int32_t subdivisions, co_vertex_mask_fn visit,
                                void *context) {
    const ring r = ring_of(m, v);
    if (r.is_corner)
        visit(v, 1, context);
    else
        visit_weighted(m, v, &r,
                       subdivisions == CO_VERTEX_MASK_LIMIT ? limit_weights(&r)
                       : r.n_sharp == 2                     ? on_curve(subdivisions)
                                                            : on_surface(r.n_faces, subdivisions),
                       visit, context);
}

typedef struct point_sum {
    const double *xyz;
    double *at;
} point_sum;

static void add_point(int32_t vertex, double weight, void *context) {
    const point_sum *sum = context;
    for (int c = 0; c < 3; c++)
        sum->at[c] += weight * sum->xyz[3 * (size_t)vertex + (size_t)c];
}

void co_vertex_mask_point(const curvopt_mesh *m, int32_t v, const double *xyz, double out[3]) {
    out[0] = out[1] = out[2] = 0;
    co_vertex_mask_visit(m, v, add_point, &(point_sum){xyz, out});
}

size_t co_vertex_mask_most(const curvopt_mesh *m, int32_t v) {
    const ring r = ring_of(m, v);
    return (size_t)r.n_corners + (size_t)r.n_faces + 3;
}

int co_vertex_mask_has_tangents(const curvopt_mesh *m, int32_t v) {
    const ring r = ring_of(m, v);
    return r.n_faces > 0 && co_mesh_flaw_of(m, v) == CO_MESH_SOUND && !r.is_corner && !r.fades && r.n_sharp == 0;
}

/* A below, of n faces. */
static double weight_of_edges(int32_t n) {
    const double turn = 2.0 / n; /* over pi */
    return 1 + co_cos_pi(turn) + co_cos_pi(turn / 2) * sqrt(2 * (9 + co_cos_pi(turn)));
}

/* The subdominant eigenvalue of subdivision there (Halstead et al., appendix A). */
double co_vertex_mask_tangents_shrink(const curvopt_mesh *m, int32_t v) {
    return (weight_of_edges(ring_of(m, v).n_faces) + 4) / 16;
}

/* With e_i the fine ring's vertices on edges, (v + w_i + c_(i-1) + c_i) / 4, and c_i the middles of faces, the tangents
 * are the sums of A cos_i e_i + (cos_i + cos_(i+1)) c_i, and with sines; that of v is 0. */
void co_vertex_mask_visit_tangents(const curvopt_mesh *m, int32_t h, co_vertex_tangents_fn visit, void *context) {
    const int n = ring_of(m, m->corner_vertex[h]).n_faces;
    const double turn = 2.0 / n; /* over pi */
    const double edge = weight_of_edges(n);
    const double unit = 1 / (1.5 * edge);
    for (int i = 0; i < n; i++, h = co_mesh_rotate(m, h)) {
        const int32_t f = m->corner_face[h];
        const double here[2] = {co_cos_pi(i * turn), co_sin_pi(i * turn)};
        const double next[2] = {co_cos_pi((i + 1) * turn), co_sin_pi((i + 1) * turn)};
        const double along = unit * edge / 4, middle = unit * (1 + edge / 4) / co_mesh_face_size(m, f);
        const double of_edge[2] = {along * here[0], along * here[1]};
        const double of_face[2] = {middle * (here[0] + next[0]), middle * (here[1] + next[1])};
        visit(co_mesh_destination(m, h), of_edge, context);
        for (int32_t c = m->face_start[f]; c < m->face_start[f + 1]; c++)
            visit(m->corner_vertex[c], of_face, context);
    }
}

int co_vertex_mask_has_second(const curvopt_mesh *m, int32_t v) {
    return co_vertex_mask_has_tangents(m, v) && ring_of(m, v).n_faces == 4;
}

/* With the fine ring as above, S_uu is 4 (4 (e_0 + e_2) + sum c_i - 8 v' - 2 (e_1 + e_3)) / 6 and S_uv is c_0 - c_1 +
 * c_2 - c_3; with v' = (8 v + sum w_i + sum c_i) / 16 that is (2 sum c_i - 6 v + w_0 + w_2 - 2 (w_1 + w_3)) / 3. */
void co_vertex_mask_visit_second(const curvopt_mesh *m, int32_t h, co_vertex_second_fn visit, void *context) {
    const double of_vertex[3] = {-2, 0, -2}, of_edge[2][3] = {{1.0 / 3, 0, -2.0 / 3}, {-2.0 / 3, 0, 1.0 / 3}};
    visit(m->corner_vertex[h], of_vertex, context);
    for (int i = 0; i < 4; i++, h = co_mesh_rotate(m, h)) {
        const int32_t f = m->corner_face[h];
        const double part = 1.0 / co_mesh_face_size(m, f);
        const double of_face[3] = {2 * part / 3, i % 2 ? -part : part, 2 * part / 3};
        visit(co_mesh_destination(m, h), of_edge[i % 2], context);
        for (int32_t c = m->face_start[f]; c < m->face_start[f + 1]; c++)
            visit(m->corner_vertex[c], of_face, context);
    }
}
