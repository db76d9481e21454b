/* Second derivatives of an objective over the cage's coordinates, sparse. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#ifndef CO_HESSIAN_SPARSE_HESSIAN_H
#define CO_HESSIAN_SPARSE_HESSIAN_H

#include "constraints/dof_map.h"
#include "energy/assembly.h"
#include "hessian/blend_disc_hessian.h"

/* Symmetric, its lower triangle by columns (as CHOLMOD takes it), over a reduction's variables: a column has the rows
 * of its own node from itself on, then those of each neighbour of larger number. The pattern is that of one
 * connectivity: made once. */
typedef struct co_sparse_hessian {
    const co_dof_map *reduction; /* the caller's */
    size_t n_entries;
    size_t *neighbour_start;    /* [n_nodes + 1] */
    int32_t *neighbour;         /* larger nodes that share a patch or a wide blend, ascending */
    int32_t *neighbour_row;     /* where their rows begin below the own block */
    int32_t *column_start;      /* [n_variables + 1] */
    int32_t *row;               /* [n_entries] */
    double *value;              /* [n_entries] */
    co_element_batches batches; /* of the rules that were used last, */
    int32_t rules_key;          /* which say what they were */
    double *chunk;              /* blocks of a few dozen element blocks, on their way into the matrix */
    size_t matrix_stride, work_stride;
    double *work;
    co_blend_disc_hessian wide; /* of wide blends' points, on its way too, */
    double *whole;              /* and a disc's, over its variables */
    double *before;             /* [3 n_points] where a step began; made when first needed */
} co_sparse_hessian;

/* ERROR_SIZE if the matrix has more entries than 32-bit indices count, ERROR_MEMORY. */
int32_t co_sparse_hessian_create(const co_assembly *assembly, const co_dof_map *reduction, co_sparse_hessian *out,
                                 curvopt_error *error);
void co_sparse_hessian_free(co_sparse_hessian *hessian);
/* Of a surface that the assembly has only a part of. */
typedef struct co_whole {
    double area, third; /* A and T below */
} co_whole;

/* By which rules of quadrature. */
typedef enum co_second_rules {
    CO_SECOND_USUAL,  /* the Hessian by the assembly's own, the Gauss-Newton matrix by the coarsest */
    CO_SECOND_OWN,    /* the assembly's own */
    CO_SECOND_COARSER /* one step coarser: where the Hessian only leads on, and may cost less */
} co_second_rules;

/* Which matrix. */
typedef struct co_second_kind {
    int exact; /* the Hessian, not the Gauss-Newton matrix, */
    const double
        *before; /* and if not NULL, as the lifted Newton method wants it after a step from here (element_kernel.c) */
    const co_whole *whole; /* NULL: the assembly's faces are all there are */
    co_second_rules rules;
} co_second_kind;

/* Values at positions x [3 n_vertices], normalized as kind->before is. Of an objective A T, area times a third-order
 * integral, every kind leaves out the dense grad A grad T^T + grad T grad A^T; the Gauss-Newton matrix T grad^2 A as
 * well. ERROR_MEMORY. */
int32_t co_sparse_hessian_assemble(co_assembly *assembly, const double *x, const co_second_kind *kind,
                                   co_sparse_hessian *hessian, curvopt_error *error);
double co_sparse_hessian_mean_diagonal(const co_sparse_hessian *hessian);

#endif
