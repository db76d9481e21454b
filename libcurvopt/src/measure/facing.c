/* Where parts of a surface face each other. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/facing.h"

#include "base/constants.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "base/vec3.h"
#include "measure/nearest.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    GRID = 4,    /* intervals of the grid on a face's side */
    DEEPEST = 3, /* pieces of 2^-DEEPEST of a face are the smallest that have points */
    SMALLEST = 5 /* pieces of 2^-SMALLEST are the smallest that are faced: smaller ones are all at a few vertices */
};
/* Of the cosine between x - y and a tangent at a minimum. */
#define NORMAL 1e-6
/* Of coordinates, in sizes of the cage. */
#define ROUNDING 1e-12
/* Points closer than that, in reaches, are one. */
#define SAME 1e-6

/* Where points must be to face a piece: in the directions along it from `low` to `high`, and as far beyond as their
 * height over it lets a normal reach. */
typedef struct before {
    double along[2][3], low[2], high[2], length[2];
    double normal[3], bottom, top; /* heights of the piece */
    double most, slope;            /* a normal's part along the piece: at most, and in parts of its height */
} before;

typedef struct store {
    co_facing *pair;
    size_t n, room;
    int32_t *near; /* pieces that are near the present one */
    size_t n_near, near_room;
    int failed; /* memory is out */
} store;

typedef struct work {
    const curvopt_mesh *mesh;
    const co_surface_pieces *pieces;
    const co_face_pairs *left_out;
    double reach;
    const co_near_patches *near;
    before *before;   /* [n_pieces] of patches that are near another one */
    before *of_patch; /* [n_patches] the same of all pieces of one */
    store *of_thread; /* [n_threads] */
} work;

static int grow_near(store *s) {
    int32_t *more = s->n_near < s->near_room ? s->near : CO_RESIZED(s->near, 2 * s->near_room + 16);
    if (!more)
        return 0;
    s->near_room = s->n_near < s->near_room ? s->near_room : 2 * s->near_room + 16;
    s->near = more;
    return 1;
}

static co_facing *grow_pairs(store *s) {
    if (s->n == s->room) {
        co_facing *more = CO_RESIZED(s->pair, 2 * s->room + 64);
        if (!more)
            return NULL;
        s->pair = more;
        s->room = 2 * s->room + 64;
    }
    return &s->pair[s->n];
}

static void project(const double *net, int n_points, const double axis[3], double *low, double *high) {
    *low = *high = co_dot3(net, axis);
    for (int i = 1; i < n_points; i++) {
        const double x = co_dot3(net + 3 * (size_t)i, axis);
        *low = x < *low ? x : *low;
        *high = x > *high ? x : *high;
    }
}

/* A cone round the normals of all pieces of a patch; angle pi where there is none. */
static co_cone normals_of(const work *w, size_t p) {
    const co_directions *d = w->near->directions;
    co_cone out = {.angle = CO_PI};
    double angle = 0;
    for (int32_t k = w->pieces->first[p]; k < w->pieces->first[p + 1]; k++)
        for (int c = 0; c < 3; c++)
            out.axis[c] += d[k].normal.axis[c];
    const double length = co_length3(out.axis);
    if (!(length > 0))
        return out;
    for (int c = 0; c < 3; c++)
        out.axis[c] /= length;
    for (int32_t k = w->pieces->first[p]; k < w->pieces->first[p + 1]; k++) {
        const double cosine = co_dot3(d[k].normal.axis, out.axis);
        angle = fmax(angle, d[k].normal.angle + co_arc_cosine(fmax(-1, fmin(1, cosine))));
    }
    out.angle = fmin(angle, CO_PI);
    return out;
}

/* From a point closer than `reach` y on some pieces is along a normal. These are in a cone, so that along the pieces
 * the point is not farther from them than its height times the tangent of the cone's angle, nor than the reach times
 * the sine. */
static before bound_along(const work *w, const double *net, int n_points, const co_cone *normal,
                          const co_directions *d) {
    before out = {.low = {-INFINITY, -INFINITY}, .high = {INFINITY, INFINITY}};
    if (!(normal->angle < CO_PI / 2))
        return out;
    const double sine = co_sin_pi(normal->angle / CO_PI), cosine = co_sin_pi(0.5 - normal->angle / CO_PI);
    memcpy(out.normal, normal->axis, sizeof out.normal);
    project(net, n_points, out.normal, &out.bottom, &out.top);
    out.most = w->reach * sine;
    out.slope = sine / cosine;
    for (int k = 0; k < 2; k++) { /* derivatives, less what is along the normal */
        const co_cone *along = k ? &d->v : &d->u;
        const double part = co_dot3(along->axis, normal->axis);
        for (int c = 0; c < 3; c++)
            out.along[k][c] = along->axis[c] - part * normal->axis[c];
        out.length[k] = co_length3(out.along[k]);
        project(net, n_points, out.along[k], &out.low[k], &out.high[k]);
        out.low[k] -= ROUNDING * w->pieces->size;
        out.high[k] += ROUNDING * w->pieces->size;
    }
    return out;
}

static void bound_patches(void *context, size_t begin, size_t end) {
    const work *w = context;
    for (size_t p = begin; p < end; p++) {
        const int32_t first = w->pieces->first[p], n = w->pieces->first[p + 1] - first;
        const co_directions *d = w->near->directions + first;
        if (w->near->start[p + 1] == w->near->start[p])
            continue;
        const co_cone normals = normals_of(w, p);
        w->of_patch[p] = bound_along(w, co_pieces_bezier(w->pieces, first), 16 * n, &normals, d);
        for (int32_t k = 0; k < n; k++)
            w->before[first + k] = bound_along(w, co_pieces_bezier(w->pieces, first + k), 16, &d[k].normal, &d[k]);
    }
}

/* What a normal from points of heights from `low` to `high` may have along the piece. */
static double most_along(const before *b, double low, double high) {
    const double above = high - b->bottom, below = b->top - low, height = above > below ? above : below;
    return b->slope * height < b->most ? b->slope * height : b->most;
}

static int is_before(const before *b, const double x[3]) {
    const double height = co_dot3(x, b->normal), most = most_along(b, height, height);
    for (int k = 0; k < 2; k++) {
        const double at = co_dot3(x, b->along[k]), beyond = most * b->length[k];
        if (at < b->low[k] - beyond || at > b->high[k] + beyond)
            return 0;
    }
    return 1;
}

static void project_box(const co_box *box, const double axis[3], double *low, double *high) {
    double middle = 0, half = 0;
    for (int c = 0; c < 3; c++) {
        middle += 0.5 * (box->low[c] + box->high[c]) * axis[c];
        half += 0.5 * (box->high[c] - box->low[c]) * fabs(axis[c]);
    }
    *low = middle - half;
    *high = middle + half;
}

/* Whether all of piece a is beside what b is of: by its box, and by its control points, which takes longer. */
static int is_beside(const work *w, int32_t a, const before *b) {
    const double *net = co_pieces_bezier(w->pieces, a);
    for (int closely = 0; closely < 2; closely++) {
        double range[3][2];
        for (int k = 0; k < 3; k++) {
            const double *axis = k < 2 ? b->along[k] : b->normal;
            if (closely)
                project(net, 16, axis, &range[k][0], &range[k][1]);
            else
                project_box(&w->near->box[a], axis, &range[k][0], &range[k][1]);
        }
        const double most = most_along(b, range[2][0], range[2][1]);
        for (int k = 0; k < 2; k++)
            if (range[k][0] > b->high[k] + most * b->length[k] || range[k][1] < b->low[k] - most * b->length[k])
                return 1;
    }
    return 0;
}

/* The pieces near piece a that it could face. */
static void find_near(const work *w, int32_t a, store *s) {
    const int32_t p = w->pieces->patch[a];
    co_box box = w->near->box[a];
    for (int c = 0; c < 3; c++) {
        box.low[c] -= w->reach;
        box.high[c] += w->reach;
    }
    s->n_near = 0;
    for (size_t k = w->near->start[p]; k < w->near->start[p + 1]; k++) {
        const int32_t q = w->near->patch[k];
        if (is_beside(w, a, &w->of_patch[q]) ||
            co_face_pairs_have(w->left_out, w->pieces->patches.place[p].face, w->pieces->patches.place[q].face))
            continue;
        for (int32_t b = w->pieces->first[q]; b < w->pieces->first[q + 1] && !s->failed; b++) {
            if (w->pieces->place[b].level > SMALLEST || !co_box_overlap(&box, &w->near->box[b]) ||
                is_beside(w, a, &w->before[b]))
                continue;
            s->failed = !grow_near(s);
            if (!s->failed)
                s->near[s->n_near++] = b;
        }
    }
}

/* The best of some points of a piece to begin at. */
static void begin_at(const double piece[CO_BEZIER], const double x[3], double uv[2]) {
    double best = INFINITY, at[3];
    for (int k = 0; k < 9; k++) {
        const double u = 1.0 / 6 + k % 3 / 3.0, v = 1.0 / 6 + k / 3 / 3.0;
        co_bezier_point(piece, u, v, at);
        const double square = co_distance3_squared(at, x);
        if (square < best) {
            best = square;
            uv[0] = u;
            uv[1] = v;
        }
    }
}

/* What the nearest point of a piece is to the surface. */
typedef enum minimum { NO_MINIMUM, MINIMUM, MINIMUM_OF_TWO /* if the piece beyond its side has it, too */ } minimum;

/* Side of a place, counted as a quad's, on which a parameter is at its end; -1: on none or two. */
static int side_of(const double uv[2]) {
    const int on[4] = {uv[1] == 0, uv[0] == 1, uv[1] == 1, uv[0] == 0};
    int side = -1;
    for (int k = 0; k < 4; k++)
        if (on[k]) {
            if (side >= 0)
                return -1;
            side = k;
        }
    return side;
}

static minimum kind_of(const work *w, int32_t b, const double uv[2], const double x[3]) {
    co_bezier_jet jet;
    co_bezier_at(co_pieces_bezier(w->pieces, b), uv[0], uv[1], &jet);
    const double r[3] = {jet.s[0] - x[0], jet.s[1] - x[1], jet.s[2] - x[2]}, length = co_length3(r);
    const double along[2] = {fabs(co_dot3(r, jet.u)) - NORMAL * length * co_length3(jet.u),
                             fabs(co_dot3(r, jet.v)) - NORMAL * length * co_length3(jet.v)};
    if (along[0] <= 0 && along[1] <= 0)
        return MINIMUM;
    const int side = side_of(uv);
    if (side < 0 || along[side % 2 == 0 ? 0 : 1] > 0)
        return NO_MINIMUM;
    if (co_location_is_on_boundary(w->mesh, &w->pieces->place[b], uv))
        return MINIMUM;
    return w->pieces->patches.cuts[w->pieces->patch[b]] >> side & 1 ? MINIMUM_OF_TWO : NO_MINIMUM;
}

/* Points of pieces that were found for x already, from `first` on, at the same place as y. */
static int is_known(const co_facing *pair, size_t first, size_t n, const double x[3], const double y[3],
                    double tolerance) {
    for (size_t k = first; k < n; k++) {
        double square = 0;
        for (int c = 0; c < 3; c++) {
            const double d = x[c] - pair[k].distance * pair[k].along[c] - y[c];
            square += d * d;
        }
        if (square <= tolerance * tolerance)
            return 1;
    }
    return 0;
}

/* Adds what the point x of piece a faces. */
static void look_from(const work *w, int32_t a, const double uv[2], double weight, store *s) {
    const size_t first = s->n;
    double x[3], halves[8][3]; /* minima on creases that one side has */
    int n_halves = 0;
    co_bezier_point(co_pieces_bezier(w->pieces, a), uv[0], uv[1], x);
    for (size_t k = 0; k < s->n_near; k++) {
        const int32_t b = s->near[k];
        static const double whole[2] = {0, 1};
        double y[3], at[2];
        if (!is_before(&w->before[b], x) || !(co_box_distance_squared(&w->near->box[b], x) < w->reach * w->reach))
            continue;
        begin_at(co_pieces_bezier(w->pieces, b), x, at);
        const double distance = co_nearest_on_piece(co_pieces_bezier(w->pieces, b), x, whole, whole, at, y, NULL);
        minimum kind = distance < w->reach ? kind_of(w, b, at, x) : NO_MINIMUM;
        for (int h = 0; h < n_halves && kind == MINIMUM_OF_TWO; h++)
            if (co_distance3_squared(halves[h], y) <= SAME * SAME * w->reach * w->reach)
                kind = MINIMUM;
        if (kind == MINIMUM_OF_TWO && n_halves < 8)
            memcpy(halves[n_halves++], y, sizeof y);
        if (kind != MINIMUM || is_known(s->pair, first, s->n, x, y, SAME * w->reach))
            continue;
        co_facing *f = grow_pairs(s);
        if (!f) {
            s->failed = 1;
            return;
        }
        *f = (co_facing){
            .piece = {a, b}, .uv = {{uv[0], uv[1]}, {at[0], at[1]}}, .distance = distance, .weight = weight};
        for (int c = 0; c < 3 && distance > 0; c++)
            f->along[c] = (x[c] - y[c]) / distance;
        s->n++;
    }
}

/* The grid of a piece, by the trapezoidal rule. */
static void look_round(const work *w, int32_t a, store *s) {
    const int level = w->pieces->place[a].level, n = level < 2 ? GRID >> level : 1;
    if (level > DEEPEST)
        return;
    find_near(w, a, s);
    for (int k = 0; k < (n + 1) * (n + 1) && s->n_near && !s->failed; k++) {
        const int i = k % (n + 1), j = k / (n + 1);
        const double uv[2] = {(double)i / n, (double)j / n};
        look_from(w, a, uv, (i % n ? 1 : 0.5) * (j % n ? 1 : 0.5) / (n * n), s);
    }
}

/* Every n_threads-th patch. */
static void look(void *context, int32_t thread, int32_t n_threads) {
    const work *w = context;
    store *s = &w->of_thread[thread];
    for (int32_t p = thread; p < w->pieces->patches.n_patches && !s->failed; p += n_threads)
        for (int32_t a = w->pieces->first[p]; a < w->pieces->first[p + 1] && w->near->start[p] < w->near->start[p + 1];
             a++)
            look_round(w, a, s);
}

/* A piece's pairs stand together, in order, with one thread. */
static int compare(const void *a, const void *b) {
    const co_facing *x = a, *y = b;
    for (int k = 0; k < 4; k++) {
        const double p = k == 0 ? x->piece[0] : k == 3 ? x->piece[1] : x->uv[0][k - 1];
        const double q = k == 0 ? y->piece[0] : k == 3 ? y->piece[1] : y->uv[0][k - 1];
        if (p != q)
            return p < q ? -1 : 1;
    }
    return 0;
}

static int32_t gather(const work *w, int32_t n_threads, co_facings *out, curvopt_error *error) {
    size_t n = 0;
    for (int32_t t = 0; t < n_threads; t++) {
        if (w->of_thread[t].failed)
            return co_status_no_memory(error);
        n += w->of_thread[t].n;
    }
    out->pair = CO_NEW(co_facing, n);
    if (!out->pair)
        return co_status_no_memory(error);
    for (int32_t t = 0; t < n_threads; t++) {
        const store *s = &w->of_thread[t];
        if (s->n)
            memcpy(out->pair + out->n, s->pair, s->n * sizeof *s->pair);
        out->n += s->n;
    }
    qsort(out->pair, out->n, sizeof *out->pair, compare);
    return CURVOPT_OK;
}

int32_t co_facings_find(const curvopt_mesh *mesh, const co_near_patches *near, double reach,
                        const co_face_pairs *left_out, co_thread_pool *pool, co_facings *out, curvopt_error *error) {
    const int32_t n_threads = co_thread_pool_size(pool);
    work w = {.mesh = mesh,
              .pieces = near->pieces,
              .left_out = left_out,
              .reach = reach,
              .near = near,
              .before = CO_NEW(before, near->pieces->n_pieces),
              .of_patch = CO_NEW(before, near->pieces->patches.n_patches),
              .of_thread = CO_NEW(store, n_threads)};
    *out = (co_facings){0};
    int32_t status = w.before && w.of_patch && w.of_thread ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        co_thread_pool_for(pool, (size_t)w.pieces->patches.n_patches, bound_patches, &w);
        co_thread_pool_run(pool, look, &w);
        status = gather(&w, n_threads, out, error);
    }
    for (int32_t t = 0; w.of_thread && t < n_threads; t++) {
        free(w.of_thread[t].pair);
        free(w.of_thread[t].near);
    }
    free(w.before);
    free(w.of_patch);
    free(w.of_thread);
    if (status != CURVOPT_OK)
        co_facings_free(out);
    return status;
}

void co_facings_free(co_facings *facings) {
    free(facings->pair);
    *facings = (co_facings){0};
}
