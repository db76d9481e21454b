/* How far two limit surfaces are from each other (deviation.h). SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/deviation.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "measure/deviation_bound.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A part of one surface that may be far from the other one. */
typedef struct item {
    double upper;    /* bound of its distance */
    double lower;    /* distance of one of its points */
    double u, v;     /* corner of least parameters on the piece */
    double side;     /* in the piece's parameters */
    int32_t piece;   /* -1 - p: what patch p has from ring `ring` on, at its tip */
    int32_t ring;    /* counted from 0 */
    int32_t hint;    /* part of the other surface where the nearest point was */
    int32_t of;      /* 0, 1: the surface that it is part of */
    int32_t n_steps; /* of Newton's method that its bound took */
    int32_t group;   /* node of the surface's tree: `piece` stands for all patches there; -1: for itself */
} item;

typedef struct search {
    const co_nearest *surface; /* [2] */
    const curvopt_cancel *cancel;
    item *now; /* [n_now] */
    size_t n_now;
    item farthest; /* the item of the largest distance found */
    int n_promising;
    item promising[CO_DEVIATION_CLIMBS]; /* items not cut of the largest bounds, these falling */
} search;

/* Largest distance from a patch's tip to a control point of the rings from `ring` on. */
static double rings_radius(const co_surface_pieces *s, int32_t patch, int32_t ring) {
    const co_tip *tip = &s->tip[s->tip_of[patch]];
    double largest = tip->radius * tip->radius;
    for (int32_t k = s->first[patch] + CO_RING_CELLS * ring; k < s->first[patch + 1]; k++)
        for (int i = 0; i < 16; i++)
            largest = fmax(largest, co_distance3_squared(co_pieces_bezier(s, k) + 3 * (size_t)i, tip->at));
    return sqrt(largest);
}

/* Largest distance of the points of two patches at fans of one type and number of sectors: a bound of what is between
 * the fans' surfaces. Closed fans are turned to where it is least, for each of their patches counts from its own
 * sector. */
static double distance_of_fans(const co_surface_pieces *a, int32_t p, const co_surface_pieces *b, int32_t q) {
    const int32_t one = a->patches.kind[p], two = b->patches.kind[q], n = co_fan_sectors(one);
    double least = (double)INFINITY;
    if (one == CO_FAN_REGULAR || two == CO_FAN_REGULAR || n != co_fan_sectors(two) ||
        co_fan_type_of(one) != co_fan_type_of(two))
        return least;
    const int closed = co_fan_type_of(one) == CO_FAN_CLOSED || co_fan_type_of(one) == CO_FAN_CONE;
    const int32_t *of_a = a->patches.points + a->patches.start[p], *of_b = b->patches.points + b->patches.start[q];
    for (int32_t turn = 0; turn < (closed ? n : 1); turn++) {
        double largest = co_distance3_squared(a->points + 3 * (size_t)of_a[0], b->points + 3 * (size_t)of_b[0]);
        for (int32_t i = 1; i < co_fan_n_points(one) && largest < least; i++) {
            const int32_t k = closed ? 1 + (i - 1 + CO_FAN_SECTOR_POINTS * turn) % (CO_FAN_SECTOR_POINTS * n) : i;
            const double *x = a->points + 3 * (size_t)of_a[i], *y = b->points + 3 * (size_t)of_b[k];
            largest = fmax(largest, co_distance3_squared(x, y));
        }
        least = fmin(least, largest);
    }
    return sqrt(least);
}

/* What is nearest to a point of an item. */
static void look_from(const search *s, item *it, const double x[3], co_surface_point *near) {
    co_nearest_find(&s->surface[!it->of], x, it->hint, near);
    it->lower = near->distance;
    it->hint = near->part;
    it->n_steps = near->n_steps;
}

static void bound_tip(const search *s, item *it) {
    const co_surface_pieces *own = s->surface[it->of].pieces;
    const int32_t patch = -1 - it->piece;
    co_surface_point near;
    look_from(s, it, own->tip[own->tip_of[patch]].at, &near);
    it->upper = fmin(it->upper, near.distance + rings_radius(own, patch, it->ring));
    const co_surface_pieces *other = s->surface[!it->of].pieces;
    if (near.piece < 0)
        it->upper = fmin(it->upper, distance_of_fans(own, patch, other, other->tip[-1 - near.piece].patch));
}

static void bound_part(const search *s, item *it) {
    const co_nearest *other = &s->surface[!it->of];
    const double u[2] = {it->u, it->u + it->side}, v[2] = {it->v, it->v + it->side};
    double part[CO_BEZIER], middle[3], radius = 0;
    co_surface_point near;
    co_bezier_part(co_pieces_bezier(s->surface[it->of].pieces, it->piece), u, v, part);
    co_bezier_point(part, 0.5, 0.5, middle);
    look_from(s, it, middle, &near);
    for (size_t k = 0; k < 16; k++)
        radius = fmax(radius, co_distance3_squared(part + 3 * k, middle));
    it->upper = fmin(it->upper, near.distance + sqrt(radius));
    if (near.piece >= 0) {
        const double *piece = co_pieces_bezier(other->pieces, near.piece);
        const double bound = co_deviation_bound(part, piece, near.uv, &it->n_steps);
        it->upper = fmin(it->upper, bound);
    }
}

/* A group's bound is by the point that stands for it: a tip, or a piece's middle. */
static void bound_group(const search *s, item *it) {
    const co_nearest *own = &s->surface[it->of];
    const co_surface_pieces *pieces = own->pieces;
    const co_box_node *node = &own->tree.node[it->group];
    co_surface_point near;
    double x[3], square = 0, tips = 0;
    if (it->piece < 0)
        memcpy(x, pieces->tip[pieces->tip_of[-1 - it->piece]].at, sizeof x);
    else
        co_bezier_point(co_pieces_bezier(pieces, it->piece), 0.5, 0.5, x);
    look_from(s, it, x, &near);
    for (int c = 0; c < 3; c++) {
        const double far = fmax(x[c] - node->box.low[c], node->box.high[c] - x[c]);
        square += far * far;
    }
    for (int32_t k = node->begin; k < node->end; k++) {
        const int32_t tip = pieces->tip_of[own->tree.order[k]];
        tips = fmax(tips, tip < 0 ? 0 : pieces->tip[tip].radius);
    }
    it->upper = fmin(it->upper, near.distance + sqrt(square) + tips);
}

/* Items that are left out when it is cancelled keep the bound of what they were cut from. */
static void bound_items(void *context, size_t begin, size_t end) {
    const search *s = context;
    for (size_t k = begin; k < end && !co_cancel_is_requested(s->cancel); k++)
        if (s->now[k].group >= 0)
            bound_group(s, &s->now[k]);
        else if (s->now[k].piece < 0)
            bound_tip(s, &s->now[k]);
        else
            bound_part(s, &s->now[k]);
}

/* Where to look first for what is nearest to a patch: a part of the patch at the same place in the other list, which is
 * the same one moved where both cages have the same faces, or one was subdivided. */
static int32_t first_hint(const co_nearest *own, const co_nearest *other, int32_t patch) {
    const int64_t n = own->pieces->patches.n_patches, n_other = other->pieces->patches.n_patches;
    return other->first[patch * n_other / n];
}

static item item_of_patch(const search *s, int32_t of, int32_t patch) {
    const co_surface_pieces *own = s->surface[of].pieces;
    return (item){.upper = INFINITY,
                  .side = 1,
                  .piece = own->tip_of[patch] < 0 ? own->first[patch] : -1 - patch,
                  .hint = first_hint(&s->surface[of], &s->surface[!of], patch),
                  .of = of,
                  .group = -1};
}

/* An item's children, of which there may be as many. */
static int32_t most_children(const search *s, const item *it) {
    const co_box_node *node = it->group < 0 ? NULL : &s->surface[it->of].tree.node[it->group];
    return node ? node->end - node->begin : 4;
}

/* Children of an item; 0: it cannot be cut. */
static int32_t cut(const search *s, const item *it, item *child) {
    const co_nearest *surface = &s->surface[it->of];
    const co_surface_pieces *own = surface->pieces;
    if (it->group >= 0) {
        const co_box_node *node = &surface->tree.node[it->group];
        for (int32_t k = node->begin; k < node->end; k++) {
            child[k - node->begin] = item_of_patch(s, it->of, surface->tree.order[k]);
            child[k - node->begin].upper = it->upper;
        }
        return node->end - node->begin;
    }
    for (int k = 0; k < 4; k++)
        child[k] = *it;
    if (it->piece >= 0) {
        for (int k = 0; k < 4; k++) {
            child[k].side = it->side / 2;
            child[k].u += k % 2 ? child[k].side : 0;
            child[k].v += k >= 2 ? child[k].side : 0;
        }
        return it->side > 1e-7 ? 4 : 0;
    }
    const int32_t patch = -1 - it->piece;
    if (it->ring == co_pieces_n_rings(own, patch))
        return 0;
    for (int k = 0; k < CO_RING_CELLS; k++)
        child[k].piece = own->first[patch] + CO_RING_CELLS * it->ring + k;
    child[CO_RING_CELLS].ring++;
    return 4;
}

static int32_t make_room(search *s, curvopt_error *error) {
    s->now =
        CO_NEW(item, (size_t)s->surface[0].pieces->patches.n_patches + (size_t)s->surface[1].pieces->patches.n_patches);
    return s->now ? CURVOPT_OK : co_status_no_memory(error);
}

/* Every stride-th patch of both surfaces. */
static int32_t start(search *s, int32_t stride, curvopt_error *error) {
    const int32_t status = make_room(s, error);
    for (int32_t of = 0; status == CURVOPT_OK && of < 2; of++)
        for (int32_t patch = 0; patch < s->surface[of].pieces->patches.n_patches; patch += stride)
            s->now[s->n_now++] = item_of_patch(s, of, patch);
    return status;
}

/* The patches of both surfaces in groups of `most`, more than a leaf of their trees, or fewer. */
static int32_t start_with_groups(search *s, int32_t most, curvopt_error *error) {
    const int32_t status = make_room(s, error);
    for (int32_t of = 0; status == CURVOPT_OK && of < 2; of++) {
        const co_box_tree *tree = &s->surface[of].tree;
        int32_t done = 0; /* nodes follow their parents */
        for (int32_t k = 0; k < tree->n_nodes; k++) {
            const co_box_node *node = &tree->node[k];
            if (node->end <= done || node->end - node->begin > most)
                continue;
            s->now[s->n_now] = item_of_patch(s, of, tree->order[node->begin + (node->end - node->begin) / 2]);
            s->now[s->n_now++].group = k;
            done = node->end;
        }
    }
    return status;
}

/* Takes over the largest distance of the present items, and whose it is; and their work. */
static void take_largest(search *s, co_deviation *out) {
    for (size_t k = 0; k < s->n_now; k++) {
        out->n_parts += s->now[k].group < 0;
        out->n_steps += (size_t)s->now[k].n_steps;
        if (s->now[k].lower > out->max) {
            out->max = s->now[k].lower;
            s->farthest = s->now[k];
        }
    }
}

/* Keeps an item that is not cut, if its bound is among the largest. */
static void keep_promising(search *s, const item *it) {
    int at = s->n_promising < CO_DEVIATION_CLIMBS ? s->n_promising++ : CO_DEVIATION_CLIMBS - 1;
    if (s->promising[at].upper >= it->upper && s->n_promising == CO_DEVIATION_CLIMBS && s->promising[at].upper > 0)
        return;
    for (; at > 0 && s->promising[at - 1].upper < it->upper; at--)
        s->promising[at] = s->promising[at - 1];
    s->promising[at] = *it;
}

/* Takes over a point of an item's piece, if it is farther than *largest; and than all, if it is. */
static int try_farther(const search *s, const item *it, double u, double v, double *largest, co_deviation *out) {
    double x[3];
    co_surface_point near;
    co_bezier_point(co_pieces_bezier(s->surface[it->of].pieces, it->piece), u, v, x);
    co_nearest_find(&s->surface[!it->of], x, it->hint, &near);
    if (near.distance < *largest)
        return 0;
    *largest = near.distance;
    if (near.distance < out->max)
        return 1;
    out->max = near.distance;
    for (int c = 0; c < 3; c++) {
        out->point[it->of][c] = x[c];
        out->point[!it->of][c] = near.at[c];
    }
    return 1;
}

/* From an item's middle uphill on its piece, by a pattern of eight points that shrinks (Hooke and Jeeves,
 * "Direct search solution of numerical and statistical problems", JACM 8(2), 1961). */
static void climb(const search *s, const item *it, co_deviation *out) {
    enum { MOST_STEPS = 40 };
    double u = it->u + it->side / 2, v = it->v + it->side / 2, side = it->side, largest = 0;
    const co_surface_pieces *own = s->surface[it->of].pieces;
    if (it->piece < 0) {
        co_surface_point near;
        const double *x = own->tip[own->tip_of[-1 - it->piece]].at;
        co_nearest_find(&s->surface[!it->of], x, it->hint, &near);
        for (int c = 0; c < 3 && near.distance >= out->max; c++) {
            out->point[it->of][c] = x[c];
            out->point[!it->of][c] = near.at[c];
        }
        return;
    }
    try_farther(s, it, u, v, &largest, out);
    for (int n = 0; n < MOST_STEPS && side > 1e-3 && !co_cancel_is_requested(s->cancel); n++) {
        double to[2] = {u, v};
        for (int k = 0; k < 9; k++) {
            const double x = fmin(fmax(u + (k % 3 - 1) * side, 0), 1);
            const double y = fmin(fmax(v + (k >= 6) * side - (k < 3) * side, 0), 1);
            if (k != 4 && try_farther(s, it, x, y, &largest, out)) {
                to[0] = x;
                to[1] = y;
            }
        }
        if (to[0] == u && to[1] == v)
            side /= 2;
        u = to[0];
        v = to[1];
    }
}

/* Cuts the items whose bound is above `enough`; the others' bounds are final. */
static int32_t next_items(search *s, double enough, co_deviation *out, curvopt_error *error) {
    size_t n = 0, room = 0;
    for (size_t k = 0; k < s->n_now; k++)
        room += s->now[k].upper > enough ? (size_t)most_children(s, &s->now[k]) : 0;
    item *next = CO_NEW(item, room);
    if (!next)
        return co_status_no_memory(error);
    for (size_t k = 0; k < s->n_now; k++) {
        const item *it = &s->now[k];
        const int32_t n_children = it->upper > enough ? cut(s, it, next + n) : 0;
        if (n_children == 0) {
            out->bound = fmax(out->bound, it->upper);
            keep_promising(s, it);
        }
        n += (size_t)n_children;
    }
    free(s->now);
    s->now = next;
    s->n_now = n;
    return CURVOPT_OK;
}

int32_t co_deviation_glimpse(const co_nearest surface[2], co_thread_pool *pool, const curvopt_cancel *cancel,
                             double *out, curvopt_error *error) {
    search s = {.surface = surface, .cancel = cancel};
    co_deviation found = {.max = 0};
    const int32_t n = surface[0].pieces->patches.n_patches + surface[1].pieces->patches.n_patches;
    const int32_t status = start(&s, 1 + n / CO_DEVIATION_GLIMPSE, error);
    if (status == CURVOPT_OK) {
        co_thread_pool_for(pool, s.n_now, bound_items, &s);
        take_largest(&s, &found);
    }
    *out = co_cancel_is_requested(cancel) ? 0 : found.max;
    free(s.now);
    return status;
}

/* Whether the present items may be looked at, if they take as many steps each as those before; the first ones always.
 */
static int is_affordable(const search *s, size_t budget, const co_deviation *out) {
    const double steps_of_part = out->n_parts ? (double)out->n_steps / (double)out->n_parts : 0;
    return (double)out->n_steps + steps_of_part * (double)s->n_now <= (double)budget &&
           !(out->n_parts && co_cancel_is_requested(s->cancel));
}

static int32_t find_largest(const co_nearest surface[2], size_t budget, co_thread_pool *pool,
                            const curvopt_cancel *cancel, co_deviation *out, curvopt_error *error) {
    search s = {.surface = surface, .cancel = cancel};
    const double floor = CO_DEVIATION_FLOOR * surface[0].pieces->size;
    const int32_t n = surface[0].pieces->patches.n_patches + surface[1].pieces->patches.n_patches;
    const int32_t most = n / CO_DEVIATION_FEW;
    int32_t status = most < CO_BOX_TREE_LEAF ? start(&s, 1, error) : start_with_groups(&s, most, error);
    while (status == CURVOPT_OK && s.n_now && is_affordable(&s, budget, out)) {
        co_thread_pool_for(pool, s.n_now, bound_items, &s);
        take_largest(&s, out);
        const double ratio = out->n_parts < CO_DEVIATION_FEW ? CO_DEVIATION_CLOSE : CO_DEVIATION_RATIO;
        status = next_items(&s, fmax(ratio * out->max, floor), out, error);
    }
    if (status == CURVOPT_OK)
        status = next_items(&s, (double)INFINITY, out, error);
    if (status == CURVOPT_OK)
        climb(&s, &s.farthest, out);
    for (int k = 0; status == CURVOPT_OK && k < s.n_promising && !co_cancel_is_requested(cancel); k++)
        if (s.promising[k].upper > CO_DEVIATION_CLOSE * out->max)
            climb(&s, &s.promising[k], out);
    free(s.now);
    out->bound = fmax(out->bound, out->max);
    return status;
}

/* ------------------------------------------------------------------------------------- root mean square -- */

typedef struct mean {
    const co_nearest *surface; /* [2] */
    double *sums;              /* [n_patches][2] integral of the squared distance, and area */
    int n_cells;               /* a side of a patch is cut into so many; 0: one point a patch */
    const curvopt_cancel *cancel;
} mean;

/* Adds a point of a piece that stands for `weight` of what its parameters cover. */
static void add_point(const mean *m, int32_t piece, double u, double v, double weight, int32_t *hint, double sum[2]) {
    co_bezier_jet jet;
    co_surface_point near;
    co_bezier_at(co_pieces_bezier(m->surface[0].pieces, piece), u, v, &jet);
    co_nearest_find(&m->surface[1], jet.s, *hint, &near);
    *hint = near.part;
    const double uu = co_dot3(jet.u, jet.u), vv = co_dot3(jet.v, jet.v), uv = co_dot3(jet.u, jet.v);
    const double area = weight * sqrt(fmax(0, uu * vv - uv * uv));
    sum[0] += area * near.distance * near.distance;
    sum[1] += area;
}

/* Adds n x n cells of a piece with 2 x 2 points of Gauss each, or one point in the middle where n is 0. */
static void add_piece(const mean *m, int32_t piece, int n, int32_t *hint, double sum[2]) {
    const int n_points = n ? 2 * n : 1;
    const double offset = n ? 0.5 - 0.5 / sqrt(3.0) : 0.5, side = 1.0 / (n ? n : 1);
    for (int j = 0; j < n_points; j++)
        for (int i = 0; i < n_points; i++) {
            const double u = side * (i / 2 + (i % 2 ? 1 - offset : offset)); /* NOLINT(bugprone-integer-division) */
            const double v = side * (j / 2 + (j % 2 ? 1 - offset : offset)); /* NOLINT(bugprone-integer-division) */
            add_point(m, piece, u, v, 1.0 / ((double)n_points * n_points), hint, sum);
        }
}

/* Adds the middle of a patch. At an extraordinary vertex it is the inner corner of its ring's cell at (1, 1), a quarter
 * of the patch. */
static void add_middle(const mean *m, int32_t patch, int32_t *hint, double sum[2]) {
    const co_surface_pieces *s = m->surface[0].pieces;
    if (s->tip_of[patch] < 0)
        add_point(m, s->first[patch], 0.5, 0.5, 1, hint, sum);
    else
        add_point(m, s->first[patch] + 1, 0, 0, 4, hint, sum);
}

static void add_patches(void *context, size_t begin, size_t end) {
    enum { RINGS = 5, FINE_RINGS = 2 }; /* of a patch 4^-RINGS of its area is left out, about */
    const mean *m = context;
    const co_surface_pieces *s = m->surface[0].pieces;
    for (size_t p = begin; p < end && !co_cancel_is_requested(m->cancel); p++) {
        int32_t hint = first_hint(&m->surface[0], &m->surface[1], (int32_t)p);
        const int32_t most = m->n_cells > 0 ? s->first[p] + CO_RING_CELLS * RINGS : s->first[p];
        const int32_t last = s->first[p + 1] < most ? s->first[p + 1] : most;
        m->sums[2 * p] = m->sums[2 * p + 1] = 0;
        if (m->n_cells == 0)
            add_middle(m, (int32_t)p, &hint, m->sums + 2 * p);
        for (int32_t k = s->first[p]; k < last; k++) {
            const int ring = s->tip_of[p] < 0 ? 0 : 1 + (k - s->first[p]) / CO_RING_CELLS;
            const int half = m->n_cells >> ring;
            add_piece(m, k, ring <= FINE_RINGS && half == 0 ? 1 : half, &hint, m->sums + 2 * p);
        }
    }
}

static int32_t find_mean(const co_nearest surface[2], co_thread_pool *pool, const curvopt_cancel *cancel,
                         co_deviation *out, curvopt_error *error) {
    enum { LEAST_CELLS = 1024, MANY_PATCHES = 8192 }; /* cells with four points each */
    const int32_t n = surface[0].pieces->patches.n_patches;
    mean m = {.surface = surface, .sums = CO_NEW(double, 2 * (size_t)n), .n_cells = 1, .cancel = cancel};
    double square = 0, area = 0;
    if (!m.sums)
        return co_status_no_memory(error);
    if (n > MANY_PATCHES)
        m.n_cells = 0;
    while (m.n_cells > 0 && (double)n * m.n_cells * m.n_cells < LEAST_CELLS)
        m.n_cells++;
    co_thread_pool_for(pool, (size_t)n, add_patches, &m);
    for (int32_t p = 0; p < n; p++) {
        square += m.sums[2 * (size_t)p];
        area += m.sums[2 * (size_t)p + 1];
    }
    free(m.sums);
    if (!co_cancel_is_requested(cancel))
        out->rms = area > 0 ? sqrt(square / area) : 0;
    return CURVOPT_OK;
}

int32_t co_deviation_measure(const co_nearest surface[2], size_t budget, co_thread_pool *pool,
                             const curvopt_cancel *cancel, co_deviation *out, curvopt_error *error) {
    *out = (co_deviation){.max = -1, .rms = (double)NAN};
    int32_t status = find_largest(surface, budget, pool, cancel, out, error);
    if (status == CURVOPT_OK && !co_cancel_is_requested(cancel))
        status = find_mean(surface, pool, cancel, out, error);
    return status;
}
