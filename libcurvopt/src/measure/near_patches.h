/* Patches of a surface that come close to each other without being neighbours.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_NEAR_PATCHES_H
#define CO_MEASURE_NEAR_PATCHES_H

#include "measure/crossing_pair.h"
#include "measure/patch_neighbours.h"

typedef struct co_near_patches {
    const co_surface_pieces *pieces; /* the caller's */
    co_box *box;                     /* [n_pieces] */
    co_directions *directions;       /* [n_pieces] of pieces of patches that are near another one */
    size_t *start;                   /* [n_patches + 1] first near patch of each patch in `patch` */
    int32_t *patch; /* the patches that are near each one, in an order that depends on the boxes alone */
} co_near_patches;

/* Patches whose boxes, of all their pieces', are closer than `reach` along each axis. ERROR_MEMORY. */
int32_t co_near_patches_create(const co_surface_pieces *pieces, const co_patch_neighbours *neighbours, double reach,
                               co_thread_pool *pool, co_near_patches *out, curvopt_error *error);
void co_near_patches_free(co_near_patches *near);

#endif
