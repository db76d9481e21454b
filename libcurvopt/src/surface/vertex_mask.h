/* Limit points of cage vertices, as combinations of the vertices round them: Halstead, Kass, DeRose, "Efficient, fair
 * interpolation using Catmull-Clark surfaces", SIGGRAPH 1993. With valence k, neighbours w and the middles f of faces
 * of any size, (k (k - 1) v + 2 sum w + 4 sum f) / (k (k + 5)): the mask of quads after one subdivision, by whose
 * rules. Boundaries and infinitely sharp creases are cubic B-splines, (4 v + w_1 + w_2) / 6; corners stay.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_VERTEX_MASK_H
#define CO_SURFACE_VERTEX_MASK_H

#include "mesh/mesh.h"

/* Whether a vertex has such a mask: not where creases fade or one ends, the cage is no manifold, or there is no face.
 */
int co_vertex_mask_exists(const curvopt_mesh *mesh, int32_t vertex);
/* Told of a vertex and its weight. */
typedef void (*co_vertex_mask_fn)(int32_t vertex, double weight, void *context);
/* The mask of a vertex that has one, entry by entry; a vertex may come more than once. */
void co_vertex_mask_visit(const curvopt_mesh *mesh, int32_t vertex, co_vertex_mask_fn visit, void *context);
/* The same of where such a vertex is after so many subdivisions. */
enum { CO_VERTEX_MASK_LIMIT = -1 }; /* infinitely many */
void co_vertex_mask_visit_after(const curvopt_mesh *mesh, int32_t vertex, int32_t subdivisions, co_vertex_mask_fn visit,
                                void *context);
/* The limit point of such a vertex of the cage xyz [3 n_vertices]. */
void co_vertex_mask_point(const curvopt_mesh *mesh, int32_t vertex, const double *xyz, double out[3]);
/* The largest number of entries that it can have; of tangents' masks as well. */
size_t co_vertex_mask_most(const curvopt_mesh *mesh, int32_t vertex);

/* Whether the limit surface has masks of tangents at a vertex that are known here: inside smooth parts. */
int co_vertex_mask_has_tangents(const curvopt_mesh *mesh, int32_t vertex);
/* Told of a vertex and its weights in both tangents. */
typedef void (*co_vertex_tangents_fn)(int32_t vertex, const double weight[2], void *context);
/* Two tangents at the limit point of the vertex that half-edge h leaves, which has such masks: along the edge of h, and
 * a quarter of the way round the vertex, counterclockwise. Halstead et al. give them for quads; here on the ring after
 * one subdivision, so that faces may have any size. At a regular vertex the first is S_u, elsewhere as long as one gets
 * by that edge's other end. A vertex may come more than once. */
void co_vertex_mask_visit_tangents(const curvopt_mesh *mesh, int32_t h, co_vertex_tangents_fn visit, void *context);
/* Whether the limit surface has second derivatives at a vertex: inside smooth parts, where four faces meet. */
int co_vertex_mask_has_second(const curvopt_mesh *mesh, int32_t vertex);
/* Told of a vertex and its weights in S_uu, S_uv and S_vv. */
typedef void (*co_vertex_second_fn)(int32_t vertex, const double weight[3], void *context);
/* The second derivatives at the limit point of the vertex that half-edge h leaves, which has them, by the parameters
 * whose tangents co_vertex_mask_visit_tangents() gives: those of a bicubic B-spline on the ring after one subdivision,
 * so that faces may have any size. A vertex may come more than once. */
void co_vertex_mask_visit_second(const curvopt_mesh *mesh, int32_t h, co_vertex_second_fn visit, void *context);
/* By how much both tangents get shorter with each subdivision. */
double co_vertex_mask_tangents_shrink(const curvopt_mesh *mesh, int32_t vertex);

#endif
