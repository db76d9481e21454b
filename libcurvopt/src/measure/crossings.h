/* Where a limit surface crosses itself: a tree of pieces' boxes, then crossing_pair.h.
 * notes/111-crossings.md. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_CROSSINGS_H
#define CO_MEASURE_CROSSINGS_H

#include "base/cancel.h"
#include "measure/piece_bounds.h"

typedef struct co_face_pair {
    int32_t face[2]; /* ascending */
    int32_t what;    /* co_crossing */
} co_face_pair;

typedef struct co_crossings {
    size_t n;
    co_face_pair *pair; /* [n] ascending, each pair once, by what matters most in it */
} co_crossings;

/* Of pieces of the mesh, left_out as in co_crossing_search. The same for any number of threads. When cancelled, what
 * was found until then. ERROR_MEMORY. */
int32_t co_crossings_find(const curvopt_mesh *mesh, const co_piece_bounds *bounds, const co_patch_neighbours *left_out,
                          co_thread_pool *pool, const curvopt_cancel *cancel, co_crossings *out, curvopt_error *error);
/* The same of pieces that are not wanted for anything else, for a report; also CO_CANCELLED. */
int32_t co_crossings_of_pieces(const curvopt_mesh *mesh, const co_surface_pieces *pieces, co_thread_pool *pool,
                               const curvopt_cancel *cancel, co_crossings *out, curvopt_error *error);
void co_crossings_free(co_crossings *crossings);

#endif
