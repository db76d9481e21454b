/* A tree of boxes: which of many boxes are near a point, and which pairs overlap.
 *
 * Built from the top by halving at the median of centres along the longest side; a leaf has at most CO_BOX_TREE_LEAF
 * boxes. A node's first child follows it. Ericson, "Real-time collision detection", 2005, chapter 6.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_BOX_TREE_H
#define CO_MEASURE_BOX_TREE_H

#include "base/cancel.h"
#include "base/status.h"
#include "measure/bezier.h"

enum {
    CO_BOX_TREE_LEAF = 4,
    CO_BOX_TREE_DEPTH = 64 /* nodes on a stack that goes through a tree: more than its depth of 31 */
};

typedef struct co_box_node {
    co_box box;
    int32_t begin, end; /* its boxes in `order` */
    int32_t second;     /* its second child; 0: a leaf */
} co_box_node;

typedef struct co_box_tree {
    int32_t n_nodes;
    co_box_node *node; /* [n_nodes] the first is the root */
    int32_t *order;    /* [n] numbers of the boxes, leaf by leaf */
} co_box_tree;

/* n >= 1 boxes. O(n log n). ERROR_MEMORY, CO_CANCELLED. */
int32_t co_box_tree_create(int32_t n, const co_box *box, const curvopt_cancel *cancel, co_box_tree *out,
                           curvopt_error *error);
void co_box_tree_free(co_box_tree *tree);

/* A way through the leaves that overlap a box. */
typedef struct co_box_walk {
    const co_box_tree *tree;
    co_box box;
    int32_t stack[CO_BOX_TREE_DEPTH];
    int32_t depth, next, end; /* nodes to look at; what is left of the leaf, in `order` */
} co_box_walk;

void co_box_walk_begin(const co_box_tree *tree, const co_box *box, co_box_walk *walk);
/* The number of the next box of a leaf that overlaps, whether or not it does so itself; -1 at the end. */
int32_t co_box_walk_next(co_box_walk *walk);

#endif
