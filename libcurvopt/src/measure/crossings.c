/* Where a limit surface crosses itself. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/crossings.h"

#include "base/memory.h"
#include "measure/box_tree.h"

#include <stdlib.h>

/* Pieces that one thread looks round one after the other, about; and pairs of these that are too close to tell, after
 * which the others are hardly cut: they lie where sheets lie on each other. */
enum { RUN = 64, ENOUGH_UNRESOLVED = 40 };

typedef struct found {
    co_face_pair *pair;
    size_t n, room;
    int failed; /* memory is out */
} found;

typedef struct work {
    co_crossing_search search;
    co_box *box;                 /* [n_pieces] */
    co_box *of_patch;            /* [n_patches] */
    co_directions *directions;   /* [n_patches] */
    co_box_tree tree;            /* of the patches */
    const co_near_patches *near; /* NULL: all patches, by the tree */
    const curvopt_cancel *cancel;
    found *of_thread; /* [n_threads] */
} work;

static void bound_patches(void *context, size_t begin, size_t end) {
    const work *w = context;
    const co_surface_pieces *s = w->search.pieces;
    for (size_t p = begin; p < end && !co_cancel_is_requested(w->cancel); p++) {
        w->of_patch[p] = co_pieces_bound(s, (int32_t)p, w->box);
        w->directions[p] = co_directions_of(co_pieces_bezier(s, s->first[p]), s->first[p + 1] - s->first[p]);
    }
}

static void add_pair(const work *w, int32_t a, int32_t b, co_crossing what, found *f) {
    const int32_t one = w->search.pieces->place[a].face, two = w->search.pieces->place[b].face;
    const co_face_pair pair = {.face = {one < two ? one : two, one < two ? two : one}, .what = what};
    if (f->n && f->pair[f->n - 1].face[0] == pair.face[0] && f->pair[f->n - 1].face[1] == pair.face[1] &&
        f->pair[f->n - 1].what >= (int32_t)what)
        return;
    if (f->n == f->room) {
        co_face_pair *more = CO_RESIZED(f->pair, 2 * f->room + 16);
        if (!more) {
            f->failed = 1;
            return;
        }
        f->pair = more;
        f->room = 2 * f->room + 16;
    }
    f->pair[f->n++] = pair;
}

/* Looks at the pieces of two patches, which may be the same. *n_unresolved: of the run's pairs so far. */
static void look_at(const work *w, int32_t p, int32_t q, int32_t *n_unresolved, found *f) {
    const co_surface_pieces *s = w->search.pieces;
    const co_box *box = w->search.box;
    for (int32_t a = s->first[p]; a < s->first[p + 1] && !co_cancel_is_requested(w->cancel); a++) {
        if (!co_box_overlap(&box[a], &w->of_patch[q]))
            continue;
        for (int32_t b = p == q ? a : s->first[q]; b < s->first[q + 1]; b++) {
            if (!co_box_overlap(&box[a], &box[b]))
                continue;
            const co_crossing what = co_crossing_of(
                &w->search, a, b, *n_unresolved < ENOUGH_UNRESOLVED ? CO_CROSSING_PARTS : CO_CROSSING_FEWEST_PARTS);
            *n_unresolved += what == CO_CROSSING_UNRESOLVED;
            if (what != CO_CROSSING_NONE)
                add_pair(w, a, b, what, f);
        }
    }
}

static co_location place_of(const work *w, int32_t patch) {
    static const double whole[2] = {0, 1};
    return co_location_of(&w->search.pieces->patches.place[patch], whole, whole);
}

/* Whether directions of whole patches prove that they do not cross, or a patch itself. */
static int are_clear(const work *w, int32_t p, int32_t q) {
    if (p == q)
        return w->directions[p].are_apart;
    const co_location a = place_of(w, p), b = place_of(w, q);
    return co_location_contact(w->search.mesh, &a, &b) == CO_CONTACT_EDGE &&
           co_directions_edge_is_clear(&w->directions[p], &w->directions[q]);
}

/* Looks at patch p with itself and with all patches of larger numbers whose boxes overlap its own. */
static void look_round(const work *w, int32_t p, int32_t *n_unresolved, found *f) {
    co_box_walk walk;
    int32_t q;
    co_box_walk_begin(&w->tree, &w->of_patch[p], &walk);
    while (!co_cancel_is_requested(w->cancel) && (q = co_box_walk_next(&walk)) >= 0)
        if (q >= p && co_box_overlap(&w->of_patch[p], &w->of_patch[q]) && !are_clear(w, p, q))
            look_at(w, p, q, n_unresolved, f);
}

/* Every n_threads-th run of patches, of about RUN pieces each. */
static void look(void *context, int32_t thread, int32_t n_threads) {
    const work *w = context;
    const co_surface_pieces *s = w->search.pieces;
    found *f = &w->of_thread[thread];
    int32_t n_unresolved = 0, last = -1;
    for (int32_t p = 0; p < s->patches.n_patches && !f->failed && !co_cancel_is_requested(w->cancel); p++) {
        const int32_t run = s->first[p] / RUN;
        if (run % n_threads != thread)
            continue;
        if (run != last)
            n_unresolved = 0;
        last = run;
        look_round(w, p, &n_unresolved, f);
    }
}

static int compare(const void *a, const void *b) {
    const co_face_pair *x = a, *y = b;
    for (int k = 0; k < 2; k++)
        if (x->face[k] != y->face[k])
            return x->face[k] < y->face[k] ? -1 : 1;
    return x->what > y->what ? -1 : x->what < y->what;
}

/* All threads' pairs in order, each once. */
static int32_t gather(const work *w, int32_t n_threads, co_crossings *out, curvopt_error *error) {
    size_t n = 0;
    for (int32_t t = 0; t < n_threads; t++) {
        if (w->of_thread[t].failed)
            return co_status_no_memory(error);
        n += w->of_thread[t].n;
    }
    out->pair = CO_NEW(co_face_pair, n);
    if (!out->pair)
        return co_status_no_memory(error);
    n = 0;
    for (int32_t t = 0; t < n_threads; t++)
        for (size_t k = 0; k < w->of_thread[t].n; k++)
            out->pair[n++] = w->of_thread[t].pair[k];
    qsort(out->pair, n, sizeof *out->pair, compare);
    for (size_t k = 0; k < n; k++) {
        const co_face_pair *last = out->n ? &out->pair[out->n - 1] : NULL, here = out->pair[k];
        if (!last || last->face[0] != here.face[0] || last->face[1] != here.face[1])
            out->pair[out->n++] = here;
    }
    return CURVOPT_OK;
}

/* Every n_threads-th patch, with those of larger numbers that are near it. */
static void look_near(void *context, int32_t thread, int32_t n_threads) {
    const work *w = context;
    const co_surface_pieces *s = w->search.pieces;
    found *f = &w->of_thread[thread];
    for (int32_t p = thread; p < s->patches.n_patches && !f->failed; p += n_threads)
        for (size_t k = w->near->start[p]; k < w->near->start[p + 1]; k++) {
            const int32_t q = w->near->patch[k];
            for (int32_t a = s->first[p]; a < s->first[p + 1] && q > p; a++)
                for (int32_t b = s->first[q]; b < s->first[q + 1]; b++) {
                    if (!co_box_overlap(&w->search.box[a], &w->search.box[b]))
                        continue;
                    const co_crossing what = co_crossing_of(&w->search, a, b, CO_CROSSING_FEW_PARTS);
                    if (what != CO_CROSSING_NONE)
                        add_pair(w, a, b, what, f);
                }
        }
}

static int32_t run(work *w, co_thread_pool *pool, co_crossings *out, curvopt_error *error) {
    const int32_t n_threads = co_thread_pool_size(pool);
    w->of_thread = CO_NEW(found, n_threads);
    if (!w->of_thread)
        return co_status_no_memory(error);
    co_thread_pool_run(pool, w->near ? look_near : look, w);
    const int32_t status = gather(w, n_threads, out, error);
    for (int32_t t = 0; t < n_threads; t++)
        free(w->of_thread[t].pair);
    free(w->of_thread);
    return status;
}

int32_t co_crossings_find(const curvopt_mesh *mesh, const co_surface_pieces *pieces, co_thread_pool *pool,
                          const curvopt_cancel *cancel, co_crossings *out, curvopt_error *error) {
    const int32_t n = pieces->patches.n_patches;
    work w = {.search = {.mesh = mesh, .pieces = pieces},
              .box = CO_NEW(co_box, pieces->n_pieces),
              .of_patch = CO_NEW(co_box, n),
              .directions = CO_NEW(co_directions, n),
              .cancel = cancel};
    w.search.box = w.box;
    *out = (co_crossings){0};
    int32_t status = w.box && w.of_patch && w.directions ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        co_thread_pool_for(pool, (size_t)n, bound_patches, &w);
        status = co_box_tree_create(n, w.of_patch, cancel, &w.tree, error);
    }
    if (status == CURVOPT_OK)
        status = run(&w, pool, out, error);
    free(w.box);
    free(w.of_patch);
    free(w.directions);
    co_box_tree_free(&w.tree);
    return status;
}

int32_t co_crossings_find_near(const curvopt_mesh *mesh, const co_near_patches *near, co_thread_pool *pool,
                               co_crossings *out, curvopt_error *error) {
    work w = {.search = {.mesh = mesh, .pieces = near->pieces, .directions = near->directions, .box = near->box},
              .near = near};
    *out = (co_crossings){0};
    return run(&w, pool, out, error);
}

void co_crossings_free(co_crossings *crossings) {
    free(crossings->pair);
    *crossings = (co_crossings){0};
}
