/* Second derivatives with respect to the points of wide blends, taken back to the cage.
 *
 * Each of a disc's faces depends on all of the disc's points, some hundred, through 21 that are rows over them: such
 * rows are not multiplied out face by face. What the faces of a sector have to say of those points, among each other
 * and with the faces' own, is summed first, and then taken back once a disc, to the variables that are left of the
 * disc's points.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_BLEND_DISC_HESSIAN_H
#define CO_HESSIAN_BLEND_DISC_HESSIAN_H

#include "constraints/dof_map.h"
#include "surface/patches.h"

typedef struct co_blend_disc_hessian {
    const co_patches *patches;
    const co_dof_map *reduction;
    int32_t *local; /* [n_cage] number of a vertex among its disc's points, of which no two discs share any; else -1 */
    size_t *start;  /* [n_discs + 1] of value: each sector's [3 TERMS][3 n + 3 TERMS], n the disc's points; columns are
                       the disc's points and then the sector's own. Nothing for discs that are not used */
    double *value;
    size_t *node_start; /* [n_discs + 1] of node: */
    int32_t *node;      /* the nodes that a disc's points move with, ascending; none of discs that are not used */
    int32_t *first; /* by the places of co_blend_discs.column: number of the point's first variable among its disc's, -1
                       if it does not move */
    double *fit,
        *sums; /* [3 TERMS][variables of any disc] work: the polynomial's points over them, and what is summed */
} co_blend_disc_hessian;

/* Which discs are used must not change any more; the reduction's nodes are of the patches' cage. ERROR_MEMORY. */
int32_t co_blend_disc_hessian_create(const co_patches *patches, const co_dof_map *reduction, co_blend_disc_hessian *out,
                                     curvopt_error *error);
void co_blend_disc_hessian_free(co_blend_disc_hessian *matrix);
void co_blend_disc_hessian_clear(co_blend_disc_hessian *matrix);

/* The disc that a patch lies on, -1 for none. */
int32_t co_blend_disc_hessian_disc_of(const co_patches *patches, int32_t patch);

/* A face's matrix over n_own points of the cage and the polynomial's, lower triangle by rows; `points` and `face` have
 * strides. What its own points have among themselves is left to the caller. */
typedef struct co_blend_disc_face_matrix {
    int32_t patch, n_own;
    const int32_t *points;
    const double *face;
    size_t stride;
    double weight;
} co_blend_disc_face_matrix;
void co_blend_disc_hessian_add(co_blend_disc_hessian *matrix, const co_blend_disc_face_matrix *share);

/* How many variables a disc's nodes have together. */
size_t co_blend_disc_hessian_n_variables(const co_blend_disc_hessian *matrix, int32_t disc);
/* Over them, those of the disc's first node first: out [n][n], its lower triangle by columns. Spends the disc's sums.
 */
void co_blend_disc_hessian_collect(co_blend_disc_hessian *matrix, int32_t disc, double *out);

#endif
