/* What is known of where pieces are, and where they face. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_PIECE_BOUNDS_H
#define CO_MEASURE_PIECE_BOUNDS_H

#include "measure/box_tree.h"
#include "measure/crossing_pair.h"

typedef struct co_piece_bounds {
    const co_surface_pieces *pieces; /* the caller's */
    co_box *box;                     /* [n_pieces] */
    co_directions *directions;       /* [n_pieces] */
    co_box_tree tree;                /* of the boxes */
} co_piece_bounds;

/* ERROR_MEMORY, CO_CANCELLED. */
int32_t co_piece_bounds_create(const co_surface_pieces *pieces, co_thread_pool *pool, const curvopt_cancel *cancel,
                               co_piece_bounds *out, curvopt_error *error);
void co_piece_bounds_free(co_piece_bounds *bounds);

#endif
