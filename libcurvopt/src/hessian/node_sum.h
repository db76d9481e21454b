/* A derivative by the variables of some nodes, summed vertex by vertex. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_NODE_SUM_H
#define CO_HESSIAN_NODE_SUM_H

#include "hessian/sparse_hessian.h"

typedef struct co_node_sum {
    int32_t *slot;            /* [n_nodes] place of a node in `part`; -1: none */
    co_node_derivative *part; /* [n] of capacity n_nodes */
    int32_t n;
} co_node_sum;

/* Empty. Free after failure as well. ERROR_MEMORY. */
int32_t co_node_sum_create(int32_t n_nodes, co_node_sum *out, curvopt_error *error);
void co_node_sum_free(co_node_sum *sum);
void co_node_sum_clear(co_node_sum *sum);
/* Adds factor times that by vertex v, `by`; nothing where v cannot move. */
void co_node_sum_add(co_node_sum *sum, const co_dof_map *dofs, int32_t v, const double by[3], double factor);
/* Its nodes ascend from here on, as co_sparse_hessian_add_square needs them. */
void co_node_sum_sort(co_node_sum *sum);

#endif
