/* The vertices of the cage that each patch depends on, and where their pairs stand in a sparse Hessian.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_STENCILS_H
#define CO_HESSIAN_STENCILS_H

#include "base/cancel.h"
#include "hessian/sparsity.h"

/* A vertex and its node in a dof_map, and their order: by nodes, then by vertices. Of what begins with one, too. */
typedef struct co_numbered_vertex {
    int32_t node, vertex;
} co_numbered_vertex;
int co_numbered_vertex_compare(const void *a, const void *b);

/* With x_p the own points of a patch (patches.h) and z_v its vertices, x_p = sum over v of T_pv z_v. A patch's own
 * points are vertices, or derived from as many as some fifty; its vertices are those of all own points together that
 * its surface can depend on.
 *
 * Vertices that cannot move are left out. Those of one patch stand in the order of their nodes, so that of two vertices
 * the one that stands later has the rows, as in co_sparsity. T is stored by columns: for example of a patch with the
 * points 7 and (7 + 8) / 2 the vertex 7 has the column {0: 1, 1: 1/2}, the vertex 8 the column {1: 1/2}. */
typedef struct co_stencils {
    size_t *start;   /* [n_patches + 1] first vertex of each patch, in `vertex` and `column` */
    int32_t *vertex; /* [start[n_patches]] */
    size_t *column;  /* [start[n_patches] + 1] first entry of each vertex's column of T */
    int32_t *point;  /* number of each entry's point among the patch's points */
    double *weight;  /* value of each entry */
    size_t *pair;    /* [n_patches + 1] first pair of each patch, in `place` */
    int32_t *place;  /* of the pairs (i, j), j < i, in the order (1, 0), (2, 0), (2, 1), ...: where the rows of i's node
                        begin in the columns of j's (neighbour_row); 0 for two vertices of one node */
    int32_t most_points; /* largest number of own points of a patch */
    int32_t most_used;   /* of those that its surface can depend on (co_patches_own_is_used) */
} co_stencils;

/* cancel: NULL, or what ends it. ERROR_MEMORY, CO_CANCELLED. */
int32_t co_stencils_create(const co_patches *patches, const co_dof_map *dofs, const co_sparsity *pattern,
                           co_cancel *cancel, co_stencils *out, curvopt_error *error);
void co_stencils_free(co_stencils *stencils);

#endif
