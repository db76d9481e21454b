/* Nearest points of a limit surface. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/nearest.h"

#include "base/memory.h"
#include "base/vec3.h"

#include <math.h>
#include <stdlib.h>

/* Parts are halved until they differ from a bilinear patch by less than FLAT of their diagonal, DEEPEST times at most.
 */
#define FLAT 0.08
enum { DEEPEST = 4, NEWTON_STEPS = 20 };

static double clamped(double x, const double range[2]) {
    return x < range[0] ? range[0] : x > range[1] ? range[1] : x;
}

/* Newton's step for half the squared distance, within the rectangle: of a parameter at its end that wants out, none.
 * Where the Hessian is not positive, that of Gauss and Newton. */
static void newton_step(const co_bezier_jet *j, const double r[3], const double g[2], const int fixed[2],
                        double step[2]) {
    const double uu = co_dot3(j->u, j->u), uv = co_dot3(j->u, j->v), vv = co_dot3(j->v, j->v);
    double a = uu + co_dot3(r, j->uu), b = uv + co_dot3(r, j->uv), c = vv + co_dot3(r, j->vv);
    step[0] = step[1] = 0;
    if (fixed[0] || fixed[1]) {
        const int k = fixed[0];
        const double full = k ? c : a, gauss = k ? vv : uu, curvature = full > 0.1 * gauss ? full : gauss;
        if (!(fixed[0] && fixed[1]) && curvature > 0)
            step[k] = -g[k] / curvature;
        return;
    }
    if (!(a > 0 && a * c - b * b > 1e-3 * (uu * vv - uv * uv))) {
        a = uu;
        b = uv;
        c = vv;
    }
    a += 1e-12 * (uu + vv);
    c += 1e-12 * (uu + vv);
    const double determinant = a * c - b * b;
    if (!(determinant > 0))
        return;
    step[0] = -(c * g[0] - b * g[1]) / determinant;
    step[1] = -(a * g[1] - b * g[0]) / determinant;
}

double co_nearest_on_piece(const double piece[CO_BEZIER], const double x[3], const double u[2], const double v[2],
                           double uv[2], double at[3], int32_t *n_steps) {
    co_bezier_jet jet;
    double best = INFINITY, moved = 1, from[2] = {clamped(uv[0], u), clamped(uv[1], v)}, step[2] = {0};
    uv[0] = from[0];
    uv[1] = from[1];
    int k = 0;
    for (; k < NEWTON_STEPS; k++) {
        co_bezier_at(piece, uv[0], uv[1], &jet);
        const double r[3] = {jet.s[0] - x[0], jet.s[1] - x[1], jet.s[2] - x[2]}, d = co_dot3(r, r);
        if (!(d < best)) { /* too far, or done: half the way */
            step[0] *= 0.25;
            step[1] *= 0.25;
        } else {
            const double g[2] = {co_dot3(r, jet.u), co_dot3(r, jet.v)};
            const int fixed[2] = {(uv[0] <= u[0] && g[0] > 0) || (uv[0] >= u[1] && g[0] < 0),
                                  (uv[1] <= v[0] && g[1] > 0) || (uv[1] >= v[1] && g[1] < 0)};
            best = d;
            from[0] = uv[0];
            from[1] = uv[1];
            for (int c = 0; c < 3; c++)
                at[c] = jet.s[c];
            newton_step(&jet, r, g, fixed, step);
        }
        uv[0] = clamped(from[0] + step[0], u);
        uv[1] = clamped(from[1] + step[1], v);
        if (moved < 1e-6) /* Newton's step squares the error: what is left is of rounding */
            break;
        moved = fabs(uv[0] - from[0]) + fabs(uv[1] - from[1]);
        if (moved < 1e-11)
            break;
    }
    uv[0] = from[0];
    uv[1] = from[1];
    if (n_steps)
        *n_steps += k;
    return sqrt(best);
}

/* Whether a part is nearly bilinear, with cones that do not turn much. */
static int is_flat(const double bezier[CO_BEZIER]) {
    double second[3];
    co_bezier_second(bezier, second);
    const double diagonal = co_distance3_squared(bezier, bezier + 45),
                 other = co_distance3_squared(bezier + 9, bezier + 36);
    return (second[0] + second[2]) / 8 <= FLAT * sqrt(fmin(diagonal, other));
}

/* What is being made, and boxes of its patches along the axes, for the tree. */
typedef struct builder {
    co_nearest *nearest;
    co_box *box;  /* [n_patches] */
    int32_t room; /* for parts */
} builder;

/* Room for one more part. */
static int grow(builder *b) {
    if (b->nearest->n_parts < b->room)
        return 1;
    const size_t more = 2 * (size_t)b->room;
    co_part *part = more < INT32_MAX / 4 ? CO_RESIZED(b->nearest->part, more) : NULL;
    if (!part)
        return 0;
    b->nearest->part = part;
    b->room = (int32_t)more;
    return 1;
}

/* Adds the parts of a piece; 0: memory is out. */
static int cut_piece(builder *b, int32_t piece) {
    co_nearest *s = b->nearest;
    struct {
        double u, v, side;
    } stack[4 * DEEPEST + 4];
    int depth = 1;
    stack[0].u = stack[0].v = 0;
    stack[0].side = 1;
    while (depth) {
        const double u0 = stack[--depth].u, v0 = stack[depth].v, side = stack[depth].side;
        const double u[2] = {u0, u0 + side}, v[2] = {v0, v0 + side};
        double bezier[CO_BEZIER];
        co_bezier_part(co_pieces_bezier(s->pieces, piece), u, v, bezier);
        if (side * (1 << DEEPEST) <= 1 || is_flat(bezier)) {
            if (!grow(b))
                return 0;
            s->part[s->n_parts++] = (co_part){
                .piece = piece, .side = (float)side, .u = (float)u0, .v = (float)v0, .box = co_oriented_box_of(bezier)};
            continue;
        }
        for (int k = 0; k < 4; k++) {
            stack[depth].u = u0 + (k % 2 ? side / 2 : 0);
            stack[depth].v = v0 + (k >= 2 ? side / 2 : 0);
            stack[depth++].side = side / 2;
        }
    }
    return 1;
}

/* A tip is a point of the surface: the rest is within its radius. */
static int add_tip(builder *b, int32_t tip) {
    co_nearest *s = b->nearest;
    if (!grow(b))
        return 0;
    const double *at = s->pieces->tip[tip].at;
    s->part[s->n_parts++] = (co_part){.piece = -1 - tip, .box = {.centre = {at[0], at[1], at[2]}}};
    return 1;
}

/* Boxes of a patch: of its tip and all of its pieces. */
static void enclose(builder *b, int32_t patch) {
    const co_surface_pieces *s = b->nearest->pieces;
    const int32_t first = s->first[patch], tip = s->tip_of[patch], n_points = 16 * (s->first[patch + 1] - first);
    const double *net = co_pieces_bezier(s, first), *corner[4] = {net, net + 9, net + 36, net + 45};
    if (tip >= 0) { /* of the outermost ring, whose cells are at (1, 0), (1, 1) and (0, 1) */
        corner[0] = s->tip[tip].at;
        corner[3] = net + CO_BEZIER + 45;
        corner[2] = net + 2 * (size_t)CO_BEZIER + 36;
    }
    b->box[patch] = co_box_of(net, n_points);
    co_box_add(&b->box[patch], corner[0], corner[0]);
    b->nearest->box[patch] = co_oriented_box_round(corner, net, n_points);
}

/* Adds a patch; 0: memory is out. */
static int add_patch(builder *b, int32_t patch) {
    const co_surface_pieces *s = b->nearest->pieces;
    b->nearest->first[patch] = b->nearest->n_parts;
    int fits = 1;
    for (int32_t k = s->first[patch]; fits && k < s->first[patch + 1]; k++)
        fits = cut_piece(b, k);
    if (fits && s->tip_of[patch] >= 0)
        fits = add_tip(b, s->tip_of[patch]);
    enclose(b, patch);
    b->nearest->first[patch + 1] = b->nearest->n_parts;
    return fits;
}

int32_t co_nearest_create(const co_surface_pieces *s, const curvopt_cancel *cancel, co_nearest *out,
                          curvopt_error *error) {
    const int32_t n = s->patches.n_patches;
    *out = (co_nearest){.pieces = s};
    builder b = {.nearest = out, .room = s->n_tips + s->n_pieces + 16};
    out->part = CO_NEW(co_part, b.room);
    out->first = CO_NEW(int32_t, (size_t)n + 1);
    out->box = CO_NEW(co_oriented_box, n);
    b.box = CO_NEW(co_box, n);
    int fits = out->part && out->first && out->box && b.box;
    for (int32_t p = 0; fits && p < n && !co_cancel_is_requested(cancel); p++)
        fits = add_patch(&b, p);
    int32_t status = !fits                            ? co_status_no_memory(error)
                     : co_cancel_is_requested(cancel) ? CO_CANCELLED
                                                      : co_box_tree_create(n, b.box, cancel, &out->tree, error);
    free(b.box);
    if (status != CURVOPT_OK)
        co_nearest_free(out);
    return status;
}

void co_nearest_free(co_nearest *nearest) {
    free(nearest->part);
    free(nearest->first);
    free(nearest->box);
    co_box_tree_free(&nearest->tree);
    *nearest = (co_nearest){0};
}

static void try_part(const co_nearest *s, const double x[3], int32_t k, co_surface_point *best) {
    const co_part *part = &s->part[k];
    co_surface_point found = {.piece = part->piece, .part = k};
    if (part->piece < 0) {
        const co_tip *tip = &s->pieces->tip[-1 - part->piece];
        found.distance = co_distance3(x, tip->at);
        for (int c = 0; c < 3; c++)
            found.at[c] = tip->at[c];
    } else {
        const double u[2] = {part->u, (double)part->u + part->side}, v[2] = {part->v, (double)part->v + part->side};
        found.uv[0] = (u[0] + u[1]) / 2;
        found.uv[1] = (v[0] + v[1]) / 2;
        found.distance =
            co_nearest_on_piece(co_pieces_bezier(s->pieces, part->piece), x, u, v, found.uv, found.at, &best->n_steps);
    }
    found.n_steps = best->n_steps;
    if (found.distance < best->distance)
        *best = found;
}

/* All parts of a patch but `hint`. */
static void try_patch(const co_nearest *s, const double x[3], int32_t patch, int32_t hint, co_surface_point *best) {
    if (!(co_oriented_box_distance_squared(&s->box[patch], x) < best->distance * best->distance))
        return;
    for (int32_t k = s->first[patch]; k < s->first[patch + 1]; k++)
        if (k != hint && co_oriented_box_distance_squared(&s->part[k].box, x) < best->distance * best->distance)
            try_part(s, x, k, best);
}

void co_nearest_find(const co_nearest *s, const double x[3], int32_t hint, co_surface_point *out) {
    struct {
        int32_t node;
        double square;
    } stack[CO_BOX_TREE_DEPTH];
    int depth = 0;
    out->distance = INFINITY;
    out->n_steps = 0;
    if (hint >= 0)
        try_part(s, x, hint, out);
    stack[depth].node = 0;
    stack[depth++].square = 0;
    while (depth) {
        const co_box_node *node = &s->tree.node[stack[--depth].node];
        if (!(stack[depth].square < out->distance * out->distance))
            continue;
        if (!node->second) {
            for (int32_t k = node->begin; k < node->end; k++)
                try_patch(s, x, s->tree.order[k], hint, out);
            continue;
        }
        const int32_t child[2] = {(int32_t)(node - s->tree.node) + 1, node->second};
        const double square[2] = {co_box_distance_squared(&s->tree.node[child[0]].box, x),
                                  co_box_distance_squared(&s->tree.node[child[1]].box, x)};
        const int far = square[0] < square[1];
        for (int k = 0; k < 2; k++) {
            const int which = k ? !far : far; /* the near one last: it comes first */
            stack[depth].node = child[which];
            stack[depth++].square = square[which];
        }
    }
}
