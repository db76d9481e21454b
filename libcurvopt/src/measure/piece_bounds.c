/* What is known of where pieces are. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/piece_bounds.h"

#include "base/memory.h"

#include <stdlib.h>

typedef struct work {
    co_piece_bounds *bounds;
    const curvopt_cancel *cancel;
} work;

static void bound_pieces(void *context, size_t begin, size_t end) {
    const work *w = context;
    for (size_t k = begin; k < end && !co_cancel_is_requested(w->cancel); k++) {
        const double *bezier = co_pieces_bezier(w->bounds->pieces, (int32_t)k);
        w->bounds->box[k] = co_box_of(bezier, 16);
        w->bounds->directions[k] = co_directions_of(bezier);
    }
}

int32_t co_piece_bounds_create(const co_surface_pieces *pieces, co_thread_pool *pool, const curvopt_cancel *cancel,
                               co_piece_bounds *b, curvopt_error *error) {
    const int32_t n = pieces->n_pieces;
    work w = {b, cancel};
    *b = (co_piece_bounds){.pieces = pieces, .box = CO_NEW(co_box, n), .directions = CO_NEW(co_directions, n)};
    int32_t status = b->box && b->directions ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        co_thread_pool_for(pool, (size_t)n, bound_pieces, &w);
        status = co_box_tree_create(n, b->box, cancel, &b->tree, error);
    }
    if (status != CURVOPT_OK)
        co_piece_bounds_free(b);
    return status;
}

void co_piece_bounds_free(co_piece_bounds *b) {
    free(b->box);
    free(b->directions);
    co_box_tree_free(&b->tree);
    *b = (co_piece_bounds){0};
}
