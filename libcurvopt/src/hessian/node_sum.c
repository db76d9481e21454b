/* A derivative by the variables of some nodes. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/node_sum.h"

#include "base/memory.h"

#include <stdlib.h>

int32_t co_node_sum_create(int32_t n_nodes, co_node_sum *s, curvopt_error *error) {
    *s = (co_node_sum){.slot = CO_NEW(int32_t, n_nodes), .part = CO_NEW(co_node_derivative, n_nodes)};
    if (!s->slot || !s->part)
        return co_status_no_memory(error);
    for (int32_t k = 0; k < n_nodes; k++)
        s->slot[k] = -1;
    return CURVOPT_OK;
}

void co_node_sum_free(co_node_sum *s) {
    free(s->slot);
    free(s->part);
    *s = (co_node_sum){0};
}

void co_node_sum_clear(co_node_sum *s) {
    for (int32_t k = 0; k < s->n; k++)
        s->slot[s->part[k].node] = -1;
    s->n = 0;
}

void co_node_sum_add(co_node_sum *s, const co_dof_map *dofs, int32_t v, const double by[3], double factor) {
    const int32_t node = dofs->node[v];
    if (node < 0)
        return;
    if (s->slot[node] < 0) {
        s->slot[node] = s->n;
        s->part[s->n++] = (co_node_derivative){.node = node};
    }
    co_node_derivative *part = &s->part[s->slot[node]];
    for (int j = 0; j < co_dof_map_dimension(dofs, node); j++)
        for (int c = 0; c < 3; c++)
            part->by[j] += factor * by[c] * (dofs->plain ? c == j : dofs->basis[9 * (size_t)v + (size_t)(3 * c + j)]);
}

static int by_node(const void *a, const void *b) {
    const int32_t x = ((const co_node_derivative *)a)->node, y = ((const co_node_derivative *)b)->node;
    return (x > y) - (x < y);
}

void co_node_sum_sort(co_node_sum *s) {
    qsort(s->part, (size_t)s->n, sizeof *s->part, by_node);
    for (int32_t k = 0; k < s->n; k++)
        s->slot[s->part[k].node] = k;
}
