/* Patches of a cage some of whose vertices stand for something else. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_SUBSTITUTION_H
#define CO_SURFACE_SUBSTITUTION_H

#include "surface/patches.h"

/* Cage vertex vertex[i] is row i of `rows`, over n_cage columns, of what stands in the vertices' places; every other
 * vertex stands for itself. */
typedef struct co_substitution {
    const int32_t *vertex; /* [rows->n_rows] */
    const co_sparse_rows *rows;
} co_substitution;

/* Such vertices become derived points, and all derived points combinations of what stands in the vertices' places;
 * whoever goes by co_patches_row() sees no difference. ERROR_MEMORY. */
int32_t co_patches_substitute(co_patches *patches, const co_substitution *substitution, curvopt_error *error);

#endif
