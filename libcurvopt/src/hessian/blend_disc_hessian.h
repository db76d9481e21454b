/* Second derivatives with respect to the coefficients of discs (blend_disc.h), taken back to the cage.
 *
 * Each of a disc's faces depends on all of the disc's points, some hundred, through some 20 coefficients, which are
 * rows over them. Such rows are not multiplied out face by face: second derivatives with respect to the coefficients
 * are summed over the faces first, and taken back once a disc to the variables of the disc's points.
 *
 *     face matrix                  sums of the disc                        matrix of the disc
 *     (own, terms) x (own, terms)  (terms) x (disc's points, terms)        (variables) x (variables)
 *                   --add, by sector 0's coefficients-->     --collect-->
 *
 * libcurvopt/notes/44-second-derivatives-of-wide-blends.md has the costs.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_BLEND_DISC_HESSIAN_H
#define CO_HESSIAN_BLEND_DISC_HESSIAN_H

#include "constraints/dof_map.h"
#include "surface/patches.h"

/* A disc's point in terms of one of its variables' nodes: a vertex of the cage. */
typedef struct co_blend_disc_entry {
    int32_t vertex, first; /* number of the vertex' first variable among the disc's */
    double weight;
} co_blend_disc_entry;

/* Places of discs' points are those of co_blend_discs.column. */
typedef struct co_blend_disc_hessian {
    const co_patches *patches;  /* the caller's */
    const co_dof_map *dofs;     /* the caller's */
    int32_t *sorted;            /* [n_columns] numbers of each disc's points among the disc's, by their points */
    size_t *start;              /* [n_discs + 1] place of each disc's sums in `value`; one that is not used has none */
    double *value;              /* sums by disc: [3 TERMS][3 n + 3 TERMS], n the disc's points; columns are the disc's
                                   points, then the coefficients of sector 0 */
    size_t *node_start;         /* [n_discs + 1] place of each disc's first entry in `node` */
    int32_t *node;              /* nodes that a disc's points move with, ascending; none of discs that are not used */
    size_t *entry_start;        /* [n_columns + 1] first entry of each point */
    co_blend_disc_entry *entry; /* vertices that move */
    double *fit;                /* [3 TERMS][variables of any disc] work: coefficients over the variables */
    double *sums;               /* [3 TERMS][variables of any disc] work: one disc's sums over the variables */
} co_blend_disc_hessian;

/* Which discs are used must not change any more; the nodes are of the patches' cage. ERROR_MEMORY. */
int32_t co_blend_disc_hessian_create(const co_patches *patches, const co_dof_map *dofs, co_blend_disc_hessian *out,
                                     curvopt_error *error);
void co_blend_disc_hessian_free(co_blend_disc_hessian *matrix);
void co_blend_disc_hessian_clear(co_blend_disc_hessian *matrix);

/* The disc that a patch lies on, -1 for none. */
int32_t co_blend_disc_hessian_disc_of(const co_patches *patches, int32_t patch);

/* The matrix of one face of a disc, over n_own points of the patch and then n_terms coefficients. */
typedef struct co_blend_disc_face_matrix {
    int32_t patch, n_own, n_terms;
    const int32_t *points; /* [n_own + n_terms] with stride `stride` */
    const double *face;    /* lower triangle by rows, with stride `stride` */
    size_t stride;
    double weight; /* factor of the face */
} co_blend_disc_face_matrix;
/* Adds the rows of the coefficients. Own points are the disc's, or phantoms (ring.h) made of the disc's. Entries of the
 * face's own points among themselves are left to the caller. */
void co_blend_disc_hessian_add(co_blend_disc_hessian *matrix, const co_blend_disc_face_matrix *face);

/* Number of variables of a disc's nodes together. */
size_t co_blend_disc_hessian_n_variables(const co_blend_disc_hessian *matrix, int32_t disc);
/* The disc's sums as a matrix over its variables, those of its first node first: out [n][n], its lower triangle by
 * columns. Spends the sums. */
void co_blend_disc_hessian_collect(co_blend_disc_hessian *matrix, int32_t disc, double *out);

#endif
