/* A tree of boxes. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/box_tree.h"

#include "base/memory.h"

#include <stdlib.h>

/* Twice the centre of a box along an axis. */
static double centre(const co_box *box, int32_t k, int axis) {
    return box[k].low[axis] + box[k].high[axis];
}

static int is_before(const co_box *box, int axis, int32_t a, int32_t b) {
    const double x = centre(box, a, axis), y = centre(box, b, axis);
    return x < y || (x == y && a < b);
}

/* Moves what belongs before place `middle` before it (Hoare's selection). */
static void select_median(const co_box *box, int axis, int32_t *order, int32_t begin, int32_t end, int32_t middle) {
    while (end - begin > 1) {
        const int32_t pivot = order[begin + (end - begin) / 2];
        int32_t i = begin, j = end - 1;
        while (i <= j) {
            while (is_before(box, axis, order[i], pivot))
                i++;
            while (is_before(box, axis, pivot, order[j]))
                j--;
            if (i <= j) {
                const int32_t swap = order[i];
                order[i++] = order[j];
                order[j--] = swap;
            }
        }
        if (middle <= j)
            end = j + 1;
        else if (middle >= i)
            begin = i;
        else
            return;
    }
}

/* The box of some boxes, and the axis along which their centres spread most. */
static co_box enclose(const co_box *box, const int32_t *order, int32_t begin, int32_t end, int *axis) {
    co_box all = box[order[begin]];
    double low[3], high[3];
    for (int c = 0; c < 3; c++)
        low[c] = high[c] = centre(box, order[begin], c);
    for (int32_t k = begin + 1; k < end; k++) {
        co_box_add(&all, box[order[k]].low, box[order[k]].high);
        for (int c = 0; c < 3; c++) {
            const double x = centre(box, order[k], c);
            low[c] = x < low[c] ? x : low[c];
            high[c] = x > high[c] ? x : high[c];
        }
    }
    *axis = 0;
    for (int c = 1; c < 3; c++)
        if (high[c] - low[c] > high[*axis] - low[*axis])
            *axis = c;
    return all;
}

/* Fills in the nodes of order[begin .. end - 1] from node t->n_nodes on: depth first, with a stack of second halves. */
static void fill_nodes(co_box_tree *t, const co_box *box, int32_t n, const curvopt_cancel *cancel) {
    struct {
        int32_t begin, end, parent;
    } stack[CO_BOX_TREE_DEPTH];
    int depth = 0;
    stack[depth].begin = 0;
    stack[depth].end = n;
    stack[depth++].parent = -1;
    while (depth) {
        int32_t begin = stack[--depth].begin, end = stack[depth].end;
        if (stack[depth].parent >= 0)
            t->node[stack[depth].parent].second = t->n_nodes;
        while (!co_cancel_is_requested(cancel)) {
            int axis;
            const int32_t at = t->n_nodes++, middle = begin + (end - begin) / 2;
            t->node[at] = (co_box_node){.box = enclose(box, t->order, begin, end, &axis), .begin = begin, .end = end};
            if (end - begin <= CO_BOX_TREE_LEAF)
                break;
            select_median(box, axis, t->order, begin, end, middle);
            stack[depth].begin = middle;
            stack[depth].end = end;
            stack[depth++].parent = at;
            end = middle;
        }
    }
}

int32_t co_box_tree_create(int32_t n, const co_box *box, const curvopt_cancel *cancel, co_box_tree *t,
                           curvopt_error *error) {
    *t = (co_box_tree){0};
    t->order = CO_NEW(int32_t, n);
    t->node = CO_NEW(co_box_node, (size_t)n + 1); /* a leaf has two boxes at least, unless it is the only node */
    if (!t->order || !t->node) {
        co_box_tree_free(t);
        return co_status_no_memory(error);
    }
    for (int32_t k = 0; k < n; k++)
        t->order[k] = k;
    fill_nodes(t, box, n, cancel);
    if (!co_cancel_is_requested(cancel))
        return CURVOPT_OK;
    co_box_tree_free(t);
    return CO_CANCELLED;
}

void co_box_tree_free(co_box_tree *t) {
    free(t->node);
    free(t->order);
    *t = (co_box_tree){0};
}

void co_box_walk_begin(const co_box_tree *tree, const co_box *box, co_box_walk *walk) {
    walk->tree = tree;
    walk->box = *box;
    walk->stack[0] = 0;
    walk->depth = 1;
    walk->next = walk->end = 0;
}

int32_t co_box_walk_next(co_box_walk *w) {
    while (w->next == w->end && w->depth) {
        const int32_t at = w->stack[--w->depth];
        const co_box_node *node = &w->tree->node[at];
        if (!co_box_overlap(&node->box, &w->box))
            continue;
        if (node->second) {
            w->stack[w->depth++] = node->second;
            w->stack[w->depth++] = at + 1;
        } else {
            w->next = node->begin;
            w->end = node->end;
        }
    }
    return w->next < w->end ? w->tree->order[w->next++] : -1;
}
