/* Where a sparse Hessian has entries: which nodes are neighbours, and where their rows stand.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_SPARSITY_H
#define CO_HESSIAN_SPARSITY_H

#include "base/cancel.h"
#include "constraints/dof_map.h"
#include "surface/patches.h"

/* The lower triangle of a symmetric matrix over the variables of a dof_map, by columns, as CHOLMOD takes it. A column
 * has the rows of its own node from itself on, then those of each neighbour of larger number. For example with node 0
 * of two variables, node 2 of three and node 5 of one, neighbours of each other, the columns of node 0 hold:
 *
 *     column of     own node   node 2     node 5
 *     variable 0    0 1        r r+1 r+2  s            neighbour      = {2, 5, ...}
 *     variable 1      1        r r+1 r+2  s            neighbour_row  = {0, 3, ...}
 *
 * with r and s the first variables of nodes 2 and 5. */
typedef struct co_sparsity {
    size_t n_entries;
    size_t *neighbour_start; /* [n_nodes + 1] place of each node's first entry in `neighbour` */
    int32_t *neighbour;      /* larger nodes that share a patch or a blend disc with a node, ascending */
    int32_t *neighbour_row;  /* place of each neighbour's rows in a column, counted from the end of the own block */
    int32_t *column_start;   /* [n_variables + 1] */
    int32_t *row;            /* [n_entries] */
} co_sparsity;

/* Groups of vertices that depend on each other beside those of patches. */
typedef struct co_couplings {
    int32_t n;
    size_t *start;   /* [n + 1] first vertex of each group */
    int32_t *vertex; /* [start[n]] of the cage; one may be there twice */
} co_couplings;
void co_couplings_free(co_couplings *couplings);

/* couplings: NULL, or more of them. cancel: NULL, or what ends it. ERROR_SIZE if there are more entries than 32-bit
 * indices count, ERROR_MEMORY, CO_CANCELLED. */
int32_t co_sparsity_create(const co_patches *patches, const co_dof_map *dofs, const co_couplings *couplings,
                           co_cancel *cancel, co_sparsity *out, curvopt_error *error);
void co_sparsity_free(co_sparsity *sparsity);

/* Whether there are entries for two nodes, in any order; for a node with itself, and with -1, which does not move, yes.
 */
int co_sparsity_has(const co_sparsity *sparsity, int32_t one, int32_t other);

#endif
