/* Polygon meshes as half-edges, one half-edge per face corner, numbered face by face. A corner table (Rossignac,
 * Safonova, Szymczak, "3D compression made simple: Edgebreaker on a corner-table", SMI 2001) for faces of any size, so
 * that next and previous corners come from face_start.
 *
 *     3-----2-----5      faces 0 1 2 3 and 1 4 5 2: half-edges 0 1 2 3 (0->1, 1->2, 2->3, 3->0) and
 *     |  0  |  1  |                                            4 5 6 7 (1->4, 4->5, 5->2, 2->1)
 *     0-----1-----4      twin[1] = 7, twin[7] = 1, all others -1; vertex_corner[1] = 4, the clockwise-most one
 *
 * A cage need not be a manifold (co_mesh_flaw). The half-edges of an edge that three or more faces share, or two that
 * run the same way, have no twins, but are one edge, which is infinitely sharp. Vertices on such edges, but for those
 * of CO_MESH_CURVE, and those that join several fans of faces keep their place: subdivision is OpenSubdiv's
 * (libcurvopt/notes/84-held-and-left-out.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_MESH_H
#define CO_MESH_MESH_H

#include "base/status.h"

/* Why a vertex has no neighbourhood like a disc's or a half disc's. */
typedef enum co_mesh_flaw {
    CO_MESH_SOUND,    /* it has one */
    CO_MESH_ISOLATED, /* no face uses the vertex */
    CO_MESH_CURVE,    /* two edges of three or more faces run through it, or it halves a flawed edge */
    CO_MESH_CROWDED,  /* it ends edges of three or more faces in another way */
    CO_MESH_FLIPPED,  /* it ends an edge of two faces that run the same way over it */
    CO_MESH_PINCHED   /* its faces are several fans */
} co_mesh_flaw;

/* Half-edge h runs from corner_vertex[h] to the vertex of the next corner of its face. */
struct curvopt_mesh {
    curvopt_mesh_info info;
    int32_t *face_start;      /* [n_faces + 1] first corner of each face */
    int32_t *corner_vertex;   /* [n_corners] vertex that each half-edge leaves */
    int32_t *corner_face;     /* [n_corners] face of each half-edge */
    int32_t *twin;            /* [n_corners] opposite half-edge; -1 on the boundary and on flawed edges */
    int32_t *edge;            /* [n_corners] edge of the half-edge */
    int32_t *vertex_corner;   /* [n_vertices] a half-edge leaving the vertex; on a boundary the clockwise-most one, of
                                 several fans one of an open fan if there is one; -1: isolated */
    int32_t *valence;         /* [n_vertices] edges at the vertex; where it is flawed, faces */
    uint8_t *flaw;            /* [n_vertices] co_mesh_flaw; NULL: all are sound */
    int32_t *isolated;        /* [info.n_isolated] isolated vertices, ascending; NULL: there are none */
    int32_t *edge_corner;     /* [n_edges] a half-edge of each edge */
    double *edge_sharpness;   /* [n_edges] or NULL: no creases (crease.h); boundary edges are infinitely sharp anyway */
    double *vertex_sharpness; /* [n_vertices] or NULL: no sharp vertices */
    int32_t boundary_rule;    /* curvopt_boundary_rule; its effect is part of vertex_sharpness already */
};

static inline int32_t co_mesh_next(const curvopt_mesh *m, int32_t h) {
    int32_t f = m->corner_face[h];
    return h + 1 == m->face_start[f + 1] ? m->face_start[f] : h + 1;
}
static inline int32_t co_mesh_prev(const curvopt_mesh *m, int32_t h) {
    int32_t f = m->corner_face[h];
    return h == m->face_start[f] ? m->face_start[f + 1] - 1 : h - 1;
}
static inline int32_t co_mesh_destination(const curvopt_mesh *m, int32_t h) {
    return m->corner_vertex[co_mesh_next(m, h)];
}
/* The next half-edge leaving the same vertex, counter-clockwise; -1 across a boundary or a flawed edge. */
static inline int32_t co_mesh_rotate(const curvopt_mesh *m, int32_t h) {
    return m->twin[co_mesh_prev(m, h)];
}
static inline int32_t co_mesh_face_size(const curvopt_mesh *m, int32_t f) {
    return m->face_start[f + 1] - m->face_start[f];
}
static inline int co_mesh_is_boundary_vertex(const curvopt_mesh *m, int32_t v) {
    return m->vertex_corner[v] >= 0 && m->twin[m->vertex_corner[v]] < 0;
}
/* Whether the vertex keeps its place because the cage is no manifold there. */
static inline int co_mesh_is_fixed(const curvopt_mesh *m, int32_t v) {
    return m->flaw && m->flaw[v] != CO_MESH_SOUND && m->flaw[v] != CO_MESH_CURVE;
}
static inline co_mesh_flaw co_mesh_flaw_of(const curvopt_mesh *m, int32_t v) {
    return m->flaw ? (co_mesh_flaw)m->flaw[v] : CO_MESH_SOUND;
}

/* Implements curvopt_mesh_create, which describes arguments and errors. Linear time: half-edges are paired by two
 * counting sorts. */
int32_t co_mesh_create(int32_t n_vertices, int32_t n_faces, const int32_t *face_sizes, const int32_t *face_vertices,
                       curvopt_mesh **out, curvopt_error *error);
/* ERROR_TOPOLOGY unless all vertices are sound; the sentence names the first that is not, or its face. */
int32_t co_mesh_check_manifold(const curvopt_mesh *mesh, curvopt_error *error);
void co_mesh_destroy(curvopt_mesh *mesh);

/* Areas round the vertices at x [3 n_vertices], and their sum: half of each triangle's, where faces are cut into
 * triangles from their middles, goes to either of its vertices. area [n_vertices]. */
double co_mesh_vertex_areas(const curvopt_mesh *mesh, const double *x, double *area);
/* Sum of these triangles of faces that are not left out; left_out [n_faces] or NULL: none is. */
double co_mesh_area(const curvopt_mesh *mesh, const uint8_t *left_out, const double *x);
/* Mean length, at x [3 n_vertices], of the edges of faces that are not left out; left_out [n_faces] or NULL: none is.
 */
double co_mesh_mean_edge(const curvopt_mesh *mesh, const uint8_t *left_out, const double *x);

#endif
