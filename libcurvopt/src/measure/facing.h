/* Where parts of a surface that are no neighbours face each other.
 *
 * From points x of a grid on each piece, the points y of pieces that are no neighbours of it (location.h) at which the
 * distance |x - y| has a minimum along the surface: there x - y is normal to it, or y is on a boundary or a crease. So
 * the distance changes smoothly with both surfaces, and its derivative by them is that of |x - y| with parameters
 * fixed.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_FACING_H
#define CO_MEASURE_FACING_H

#include "measure/face_pairs.h"

typedef struct co_facing {
    int32_t piece[2]; /* of x and y */
    double uv[2][2];  /* their parameters */
    double along[3];  /* unit vector from y to x; 0 where they are one point */
    double distance;
    double weight; /* what x stands for, in parts of its piece */
} co_facing;

typedef struct co_facings {
    size_t n;
    co_facing *pair; /* [n] by pieces and points, in order */
} co_facings;

/* All that are closer than `reach`, which `near` was made for, but for pairs of faces that `left_out` has. The same for
 * any number of threads. ERROR_MEMORY. */
int32_t co_facings_find(const curvopt_mesh *mesh, const co_near_patches *near, double reach,
                        const co_face_pairs *left_out, co_thread_pool *pool, co_facings *out, curvopt_error *error);
void co_facings_free(co_facings *facings);

#endif
