/* Values of the surface that are constrained, linear in the cage: points, at vertices and inside faces, and
 * tangent vectors and second derivatives there.
 *
 * What a user says of a point of the surface is that such values are held, on lines, or in planes. The
 * surface has the normal n where both tangents lie in the plane through 0 across n, and a tangent direction t where one
 * lies on the line through 0 along t. Curvatures are held by tangents and second derivatives (held_curvatures.h). The
 * same points of the surface are on every level: a vertex keeps its number, and a point of a face is in a child of it.
 *
 * Each value is the unknown in place of some cage vertex, its pivot (interpolation.h); or a spring draws it
 * (surface_springs.h), and it is one combination of vertices like any other.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_SURFACE_VALUES_H
#define CO_CONSTRAINTS_SURFACE_VALUES_H

#include "constraints/freedom.h"
#include "linalg/sparse_rows.h"
#include "mesh/mesh.h"

typedef struct co_surface_value {
    int32_t number;  /* of the user's entry that it is from; of an optional one of the chain (chains.h) */
    int32_t vertex;  /* at its limit point; -1: inside a face */
    int32_t corner;  /* half-edge: it leaves the vertex; or the corner of a face that uv start from, a quad's first */
    double uv[2];    /* inside a face, as in curvopt_sampler_jets */
    int32_t order;   /* of derivatives: 0: the point, 1: a tangent, 2: a second derivative */
    double along[3]; /* of a tangent: its coefficients over the two of co_vertex_mask_visit_tangents(), or S_u, S_v; of
                        a second derivative: over those three, or S_uu, S_uv, S_vv */
    int32_t freedom; /* as in co_constraints */
    double direction[3]; /* unit: along the line, or normal to the plane */
    double anchor[3];    /* where it is held, or a point of the line or plane, in the user's units; of tangents 0, but
                            where they are held as vectors */
    int32_t is_fixed; /* whether a tangent is held as the vector `anchor`; without, nothing of a second derivative is */
    double curvature[9]; /* of a second derivative: the symmetric tensor that the surface is to have there */
    int32_t pivot;       /* the vertex that it is the unknown in place of; -1: not chosen yet, or not held */
    int32_t
        is_optional; /* whether it is a chain's, made anew on each level; not held where others leave it no freedom */
    int32_t stands;  /* whether it is a point that is where it is to be, and nothing that it depends on may move, on the
                        first cage: not held where that is so */
    double stiffness; /* of a spring in place of that, as k_v of soft_constraints.h; 0: it is held exactly */
} co_surface_value;

typedef struct co_surface_values {
    int32_t n;
    co_surface_value *item; /* [n] entry by entry */
    co_sparse_rows rows;    /* the values over the cage's vertices; empty until made */
} co_surface_values;

/* A copy without rows. ERROR_MEMORY. */
int32_t co_surface_values_copy(const co_surface_values *from, co_surface_values *to, curvopt_error *error);
void co_surface_values_free(co_surface_values *values);
/* From a mesh to its subdivision; rows are dropped. Tangents that springs draw stay what they are; others get shorter,
 * as S_u does, and so do second derivatives, and anchors with them. */
void co_surface_values_subdivide(const curvopt_mesh *mesh, co_surface_values *values);
/* Makes the rows. ERROR_ARGUMENT where a place is not on its face, ERROR_TOPOLOGY, ERROR_MEMORY. */
int32_t co_surface_values_make_rows(const curvopt_mesh *mesh, co_surface_values *values, curvopt_error *error);

#endif
