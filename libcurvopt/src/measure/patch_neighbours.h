/* Which patches of a surface have a point in common. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_PATCH_NEIGHBOURS_H
#define CO_MEASURE_PATCH_NEIGHBOURS_H

#include "measure/location.h"

typedef struct co_patch_neighbours {
    size_t *start;  /* [n_patches + 1] first neighbour of each patch in `patch` */
    int32_t *patch; /* each patch's neighbours, ascending, itself among them */
} co_patch_neighbours;

/* By their places alone: of all positions. ERROR_MEMORY. */
int32_t co_patch_neighbours_create(const curvopt_mesh *mesh, const co_patches *patches, co_patch_neighbours *out,
                                   curvopt_error *error);
void co_patch_neighbours_free(co_patch_neighbours *neighbours);
int co_patch_neighbours_are(const co_patch_neighbours *neighbours, int32_t one, int32_t other);

#endif
