/* Patches that come close to each other. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/near_patches.h"

#include "base/memory.h"
#include "measure/box_tree.h"

#include <stdlib.h>

typedef struct work {
    co_near_patches *near;
    const co_patch_neighbours *neighbours;
    double reach;
    co_box *box; /* [n_patches] */
    co_box_tree tree;
    size_t room; /* for near->patch */
} work;

static void bound_patches(void *context, size_t begin, size_t end) {
    const work *w = context;
    for (size_t p = begin; p < end; p++)
        w->box[p] = co_pieces_bound(w->near->pieces, (int32_t)p, w->near->box);
}

static void direct_pieces(void *context, size_t begin, size_t end) {
    const work *w = context;
    const co_surface_pieces *s = w->near->pieces;
    for (size_t p = begin; p < end; p++)
        for (int32_t k = s->first[p]; k < s->first[p + 1] && w->near->start[p + 1] > w->near->start[p]; k++)
            w->near->directions[k] = co_directions_of(co_pieces_bezier(s, k), 1);
}

static int add(work *w, size_t n, int32_t patch) {
    if (n == w->room) {
        int32_t *more = CO_RESIZED(w->near->patch, 2 * w->room + 64);
        if (!more)
            return 0;
        w->near->patch = more;
        w->room = 2 * w->room + 64;
    }
    w->near->patch[n] = patch;
    return 1;
}

/* Appends what is near patch p; 0: memory is out. */
static int find_near(work *w, int32_t p) {
    size_t n = w->near->start[p];
    co_box box = w->box[p];
    co_box_walk walk;
    for (int c = 0; c < 3; c++) {
        box.low[c] -= w->reach;
        box.high[c] += w->reach;
    }
    co_box_walk_begin(&w->tree, &box, &walk);
    for (int32_t q; (q = co_box_walk_next(&walk)) >= 0;)
        if (co_box_overlap(&box, &w->box[q]) && !co_patch_neighbours_are(w->neighbours, p, q) && !add(w, n++, q))
            return 0;
    w->near->start[p + 1] = n;
    return 1;
}

int32_t co_near_patches_create(const co_surface_pieces *pieces, const co_patch_neighbours *neighbours, double reach,
                               co_thread_pool *pool, co_near_patches *near, curvopt_error *error) {
    const int32_t n = pieces->patches.n_patches;
    work w = {.near = near, .neighbours = neighbours, .reach = reach, .box = CO_NEW(co_box, n)};
    *near = (co_near_patches){.pieces = pieces,
                              .box = CO_NEW(co_box, pieces->n_pieces),
                              .directions = CO_NEW(co_directions, pieces->n_pieces),
                              .start = CO_NEW(size_t, (size_t)n + 1)};
    int32_t status = w.box && near->box && near->directions && near->start ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        co_thread_pool_for(pool, (size_t)n, bound_patches, &w);
        status = co_box_tree_create(n, w.box, NULL, &w.tree, error);
    }
    for (int32_t p = 0; status == CURVOPT_OK && p < n; p++)
        if (!find_near(&w, p))
            status = co_status_no_memory(error);
    if (status == CURVOPT_OK)
        co_thread_pool_for(pool, (size_t)n, direct_pieces, &w);
    else
        co_near_patches_free(near);
    co_box_tree_free(&w.tree);
    free(w.box);
    return status;
}

void co_near_patches_free(co_near_patches *near) {
    free(near->box);
    free(near->directions);
    free(near->start);
    free(near->patch);
    *near = (co_near_patches){0};
}
