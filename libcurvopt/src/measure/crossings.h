/* Where a limit surface crosses itself: a tree of pieces' boxes, then crossing_pair.h.
 * notes/111-crossings.md. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_CROSSINGS_H
#define CO_MEASURE_CROSSINGS_H

#include "base/cancel.h"
#include "measure/near_patches.h"

typedef struct co_face_pair {
    int32_t face[2]; /* ascending */
    int32_t what;    /* co_crossing */
} co_face_pair;

typedef struct co_crossings {
    size_t n;
    co_face_pair *pair; /* [n] ascending, each pair once, by what matters most in it */
} co_crossings;

/* Pieces of the mesh. The same for any number of threads. When cancelled, what was found until then. ERROR_MEMORY. */
int32_t co_crossings_find(const curvopt_mesh *mesh, const co_surface_pieces *pieces, co_thread_pool *pool,
                          const curvopt_cancel *cancel, co_crossings *out, curvopt_error *error);
/* A look on the way: only patches that are near each other, and more pairs are unresolved. ERROR_MEMORY. */
int32_t co_crossings_find_near(const curvopt_mesh *mesh, const co_near_patches *near, co_thread_pool *pool,
                               co_crossings *out, curvopt_error *error);
void co_crossings_free(co_crossings *crossings);

#endif
