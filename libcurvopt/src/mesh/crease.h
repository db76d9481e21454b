/* Sharp edges and vertices of a mesh.
 *
 * Follows: DeRose, Kass, Truong, "Subdivision surfaces in character animation", SIGGRAPH 1998, with OpenSubdiv's
 * uniform creasing: every subdivision takes 1 off a sharpness, down to 0.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_CREASE_H
#define CO_MESH_CREASE_H

#include "mesh/mesh.h"

static inline int co_crease_is_infinite(double sharpness) {
    return sharpness >= CURVOPT_SHARPNESS_INFINITE;
}
/* Whether two sharpnesses mean the same: all infinite ones do. */
static inline int co_crease_alike(double a, double b) {
    return a == b || (co_crease_is_infinite(a) && co_crease_is_infinite(b));
}
/* Whether an edge or vertex is sharp now, but not after enough subdivisions. */
static inline int co_crease_is_fading(double sharpness) {
    return sharpness > 0 && sharpness < CURVOPT_SHARPNESS_INFINITE;
}
/* The sharpness after one subdivision. */
static inline double co_crease_softened(double sharpness) {
    return co_crease_is_infinite(sharpness) ? sharpness : sharpness > 1 ? sharpness - 1 : 0;
}
/* Sharpness of the edge that half-edge h belongs to; a boundary is an infinitely sharp edge, and so is an edge that is
 * no manifold's (mesh.h). */
static inline double co_crease_edge(const curvopt_mesh *m, int32_t h) {
    return m->twin[h] < 0 ? CURVOPT_SHARPNESS_INFINITE : m->edge_sharpness ? m->edge_sharpness[m->edge[h]] : 0;
}
/* Sharpness of a vertex. */
static inline double co_crease_vertex(const curvopt_mesh *m, int32_t v) {
    return co_mesh_is_fixed(m, v) ? CURVOPT_SHARPNESS_INFINITE : m->vertex_sharpness ? m->vertex_sharpness[v] : 0;
}

/* Checks creases and puts them into a mesh that has none yet. ERROR_ARGUMENT, ERROR_MEMORY. */
int32_t co_crease_set(curvopt_mesh *mesh, const curvopt_creases *creases, curvopt_error *error);
/* Gives the creases of `from` to *to, made of those of its faces for which keep[f] != 0 (NULL: all), in their order;
 * vertex v of *to is vertex_of[v] (NULL: v). Destroys *to on failure. */
int32_t co_crease_inherit(const curvopt_mesh *from, const uint8_t *keep, const int32_t *vertex_of, curvopt_mesh **to,
                          curvopt_error *error);
/* Gives the creases of `from`, one softer, to *fine, its subdivision (subdivide.h). Destroys *fine on failure. */
int32_t co_crease_soften(const curvopt_mesh *from, curvopt_mesh **fine, curvopt_error *error);
/* Largest sharpness that fades; 0 if there is none. */
double co_crease_largest_fading(const curvopt_mesh *mesh);

#endif
