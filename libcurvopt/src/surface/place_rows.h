/* A point of the limit surface inside a face, and its derivatives, as rows over the cage.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_PLACE_ROWS_H
#define CO_SURFACE_PLACE_ROWS_H

#include "linalg/sparse_rows.h"
#include "mesh/mesh.h"

/* A place on a cage, as in curvopt_sampler_jets. */
typedef struct co_face_place {
    int32_t face, corner;
    double uv[2];
    int32_t has_second; /* whether second derivatives are wanted */
} co_face_place;

enum { CO_PLACE_ROWS = 6 };
/* Told of a vertex and its weights in S, S_u, S_v, S_uu, S_uv and S_vv of place i; the last three are 0 where they are
 * not wanted. */
typedef void (*co_place_rows_fn)(int32_t i, int32_t vertex, const double weight[CO_PLACE_ROWS], void *context);
/* Visits the rows of n places on the Catmull-Clark limit surface, place by place; a vertex may come more than once.
 * ERROR_ARGUMENT, the element the place's index, where a place is not on its face or is a vertex of it or the middle of
 * a face that is no quad, where there are no derivatives; ERROR_TOPOLOGY, ERROR_MEMORY. */
int32_t co_place_rows_visit(const curvopt_mesh *mesh, const co_face_place *place, int32_t n, co_place_rows_fn visit,
                            void *context, curvopt_error *error);

#endif
