/* Second derivatives of an objective over the cage's coordinates, sparse.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_SPARSE_HESSIAN_H
#define CO_HESSIAN_SPARSE_HESSIAN_H

#include "constraints/dof_map.h"
#include "energy/assembly.h"
#include "hessian/blend_disc_hessian.h"
#include "hessian/row_sums.h"
#include "hessian/stencils.h"

/* A symmetric matrix over the variables of a dof_map. */
typedef struct co_sparse_hessian {
    const co_dof_map *dofs;     /* the caller's */
    co_sparsity pattern;        /* where it has entries: made once */
    co_stencils stencils;       /* what the points of each face's matrix are in terms of vertices */
    double *value;              /* [pattern.n_entries] */
    co_element_batches batches; /* by the rules that were used last */
    int64_t rules_key;          /* identifies those rules */
    double *chunk;              /* [CHUNK_BLOCKS][matrix_stride] matrices of some blocks, on their way into `value` */
    size_t matrix_stride;       /* doubles of one block's matrices */
    double *work;               /* [n_threads][work_stride] work space of the kernels */
    size_t work_stride;         /* doubles that one thread needs */
    double *fold;               /* [n_threads][fold_stride] one face's matrix, on its way from points to vertices */
    int32_t *panel;             /* [n_threads][stencils.most_points] places of a face's own points in that matrix */
    size_t fold_stride;
    const co_row_sums *sums;
    co_blend_disc_hessian discs; /* sums over the faces of wide blends, on their way into `value` */
    double *disc_matrix;         /* matrix of one blend disc over its variables */
    double *before;              /* [3 n_points] points where a step began; made when first needed */
} co_sparse_hessian;

/* couplings: as co_sparsity_create. ERROR_SIZE if the matrix has more entries than 32-bit indices count, ERROR_MEMORY,
 * CO_CANCELLED. */
int32_t co_sparse_hessian_create(const co_assembly *assembly, const co_dof_map *dofs, const co_couplings *couplings,
                                 co_sparse_hessian *out, curvopt_error *error);
void co_sparse_hessian_free(co_sparse_hessian *hessian);

/* Integrals over the whole surface, of which the assembly has only a part. */
typedef struct co_whole {
    double area, third; /* A and T below */
} co_whole;

/* co_second_kind.coarser: more steps than there are below any rule, so that all become the coarsest. */
enum { CO_COARSEST_RULES = CO_N_RULES };

/* The matrix that is wanted. */
typedef struct co_second_kind {
    int exact;                /* 1: the Hessian; 0: the Gauss-Newton matrix */
    const double *before;     /* [3 n_vertices] where the last step began, for the Hessian: the lifted Newton method's
                                 matrix  (element_kernel.c); NULL: the Hessian itself */
    const co_whole *whole;    /* NULL: the assembly's faces are all there are */
    const co_integrand *more; /* added to the Hessian's: what holds numbers of the surface; NULL: nothing */
    int coarser; /* steps from the assembly's rules to coarser ones, at most to the coarsest of their kinds */
} co_second_kind;

/* Values at positions x [3 n_vertices], normalized as kind->before is. Of an objective A T, area times a third-order
 * integral, every kind leaves out the dense grad A grad T^T + grad T grad A^T; the Gauss-Newton matrix T grad^2 A as
 * well. ERROR_MEMORY. */
int32_t co_sparse_hessian_assemble(co_assembly *assembly, const double *x, const co_second_kind *kind,
                                   co_sparse_hessian *hessian, curvopt_error *error);
/* A vertex in a sum of some. */
typedef struct co_weighted_vertex {
    co_numbered_vertex at; /* of a node that is no -1 */
    double weight;
} co_weighted_vertex;

/* Adds second derivatives, a symmetric 3 x 3 block, by the sum of weight x over n vertices, each once; their nodes
 * ascend, and all pairs of them have entries. */
void co_sparse_hessian_add_sum(co_sparse_hessian *hessian, size_t n, const co_weighted_vertex *sum,
                               const double block[9]);
/* A derivative by the variables of a node. */
typedef struct co_node_derivative {
    int32_t node;
    double by[3];
} co_node_derivative;

/* Adds factor d d^T, d being the derivative by the variables of n nodes, which ascend; all pairs of them have entries.
 */
void co_sparse_hessian_add_square(co_sparse_hessian *hessian, int32_t n, const co_node_derivative *d, double factor);
/* out = matrix v, [n_variables] both. */
void co_sparse_hessian_multiply(const co_sparse_hessian *hessian, const double *v, double *out);
double co_sparse_hessian_mean_diagonal(const co_sparse_hessian *hessian);

#endif
