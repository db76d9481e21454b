/* Second derivatives with respect to the points of wide blends, taken back to the cage.
 *
 * Each of a disc's faces depends on all of the disc's points, some hundred, through 21 that are rows over them: such
 * rows are not multiplied out face by face. What the faces of a sector have to say of those points, among each other
 * and with the faces' own, is summed first, and then taken back once a disc.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_WIDE_MATRIX_H
#define CO_WIDE_MATRIX_H

#include "patches.h"

typedef struct co_wide_matrix {
    const co_patches *patches;
    int32_t *local; /* [n_cage] number of a vertex among its disc's points, of which no two discs share any; else -1 */
    size_t *start;  /* [n_discs + 1] of value: each sector's [3 TERMS][3 n + 3 TERMS], n the disc's points; columns are
                       the disc's points and then the sector's own. Nothing for discs that are not used */
    double *value;
} co_wide_matrix;

/* Which discs are used must not change any more. ERROR_MEMORY. */
int32_t co_wide_matrix_create(const co_patches *patches, co_wide_matrix *out, curvopt_error *error);
void co_wide_matrix_free(co_wide_matrix *matrix);
void co_wide_matrix_clear(co_wide_matrix *matrix);

/* The disc that a patch lies on, -1 for none. */
int32_t co_wide_matrix_disc_of(const co_patches *patches, int32_t patch);

/* A face's matrix over n_own points of the cage and the polynomial's, lower triangle by rows; `points` and `face` have
 * strides. What its own points have among themselves is left to the caller. */
typedef struct co_wide_share {
    int32_t patch, n_own;
    const int32_t *points;
    const double *face;
    size_t stride;
    double weight;
} co_wide_share;
void co_wide_matrix_add(co_wide_matrix *matrix, const co_wide_share *share);

/* half [3 n][3 n] of a disc, over its points: the matrix is half + its transpose. Spends the disc's sums. */
void co_wide_matrix_pull(co_wide_matrix *matrix, int32_t disc, double *half);

#endif
