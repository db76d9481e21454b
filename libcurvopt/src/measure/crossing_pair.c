/* Whether two pieces of a limit surface cross (crossing_pair.h). SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/crossing_pair.h"

#include "base/constants.h"
#include "base/elementary.h"
#include "base/vec3.h"
#include "measure/quadric.h"

#include <math.h>
#include <string.h>

enum {
    DEEPEST = 8,       /* parts of 1 / 256 of a piece are not cut */
    ENOUGH_PAIRS = 60, /* where common points were found, but no crossing: surfaces that lie on each other */
    NEWTON_STEPS = 12
};
/* Common points: distance, in sizes of the cage; least angle of tangent planes; least area of a part's parallelogram of
 * derivatives, in products of their lengths. */
#define COMMON      1e-10
#define TRANSVERSAL 1e-3
#define DEGENERATE  1e-6
#define NORMALS     (75 * CO_PI / 180)
/* A cone of normals by the cones of both derivatives: if it is wider, another one is tried, which costs more. */
#define WIDE 0.3

typedef struct part {
    double bezier[CO_BEZIER];
    double u[2], v[2];
    co_location where;
} part;

/* Two rectangles of 2^-level of a piece each; corners counted in units of that. */
typedef struct task {
    int32_t u[2], v[2];
    int level;
} task;

co_directions co_directions_of(const double *pieces, int n) {
    co_directions out;
    co_bezier_cones(pieces, n, &out.u, &out.v);
    out.normal = co_cone_product(&out.u, &out.v);
    out.are_apart = out.normal.angle < CO_PI;
    if (n == 1 && out.normal.angle > WIDE) {
        const co_cone normals = co_bezier_normals(pieces);
        if (normals.angle < out.normal.angle)
            out.normal = normals;
    }
    return out;
}

static void take_part(const co_crossing_search *s, int32_t piece, int32_t u, int32_t v, int level, part *out) {
    const double side = ldexp(1, -level);
    out->u[0] = u * side;
    out->u[1] = (u + 1) * side;
    out->v[0] = v * side;
    out->v[1] = (v + 1) * side;
    co_bezier_part(co_pieces_bezier(s->pieces, piece), out->u, out->v, out->bezier);
    out->where = co_location_of(&s->pieces->place[piece], out->u, out->v);
}

/* Whether the control nets' projections on a direction are apart. */
static int are_apart_along(const double a[CO_BEZIER], const double b[CO_BEZIER], const double axis[3]) {
    double low[2], high[2];
    for (int k = 0; k < 2; k++) {
        const double *net = k ? b : a;
        low[k] = high[k] = co_dot3(net, axis);
        for (int i = 1; i < 16; i++) {
            const double x = co_dot3(net + 3 * (size_t)i, axis);
            low[k] = x < low[k] ? x : low[k]; /* fmin and fmax are calls */
            high[k] = x > high[k] ? x : high[k];
        }
    }
    return low[0] > high[1] || low[1] > high[0];
}

/* Along the line between the middles. */
static int are_apart(const double a[CO_BEZIER], const double b[CO_BEZIER]) {
    double between[3];
    for (int c = 0; c < 3; c++)
        between[c] = b[15 + c] + b[30 + c] - a[15 + c] - a[30 + c];
    return are_apart_along(a, b, between);
}

/* Along a normal of either part, to the mean directions by u and v of its corners. */
static int are_apart_along_normals(const double a[CO_BEZIER], const double b[CO_BEZIER]) {
    for (int k = 0; k < 2; k++) {
        const double *net = k ? b : a, *const corner[4] = {net, net + 9, net + 36, net + 45};
        double u[3], v[3], normal[3];
        co_bezier_mean_directions(corner, u, v, normal);
        if (are_apart_along(a, b, normal))
            return 1;
    }
    return 0;
}

/* Whether heights over a paraboloid that osculates one of them are apart: sheets that lie along each other. */
static int are_apart_as_sheets(const double a[CO_BEZIER], const double b[CO_BEZIER]) {
    for (int k = 0; k < 2; k++) {
        co_quadric quadric = {.origin = {0}};
        double of_a[2], of_b[2];
        if (!co_quadric_at_middle(k ? b : a, &quadric))
            continue;
        co_quadric_heights(&quadric, a, of_a);
        co_quadric_heights(&quadric, b, of_b);
        if (of_a[0] > of_b[1] || of_b[0] > of_a[1])
            return 1;
    }
    return 0;
}

static double angle_between(const double a[3], const double b[3]) {
    return co_arc_cosine(fmax(-1, fmin(1, co_dot3(a, b))));
}

/* A cone round two, the second turned round where `sign` is -1. */
static co_cone join(const co_cone *a, const co_cone *b, double sign) {
    co_cone out = {.angle = CO_PI};
    double turned[3], length;
    for (int c = 0; c < 3; c++) {
        turned[c] = sign * b->axis[c];
        out.axis[c] = a->axis[c] + turned[c];
    }
    length = co_length3(out.axis);
    if (!(length > 1e-3))
        return out;
    for (int c = 0; c < 3; c++)
        out.axis[c] /= length;
    out.angle = fmax(a->angle + angle_between(a->axis, out.axis), b->angle + angle_between(turned, out.axis));
    return out;
}

/* Parts with a common edge: the second one's parameters are turned to where they agree best with the first one's. */
int co_directions_edge_is_clear(const co_directions *a, const co_directions *b) {
    static const int swaps[4] = {0, 1, 0, 1}, sign_u[4] = {1, 1, -1, -1}, sign_v[4] = {1, -1, -1, 1};
    double best = -3;
    int at = 0;
    if (!a->are_apart || !b->are_apart)
        return 0;
    for (int r = 0; r < 4; r++) {
        const co_cone *u = swaps[r] ? &b->v : &b->u, *v = swaps[r] ? &b->u : &b->v;
        const double fit = sign_u[r] * co_dot3(a->u.axis, u->axis) + sign_v[r] * co_dot3(a->v.axis, v->axis);
        if (fit > best) {
            best = fit;
            at = r;
        }
    }
    const co_cone u = join(&a->u, swaps[at] ? &b->v : &b->u, sign_u[at]);
    const co_cone v = join(&a->v, swaps[at] ? &b->u : &b->v, sign_v[at]);
    const double between = angle_between(u.axis, v.axis);
    return u.angle + v.angle < fmin(between, CO_PI - between);
}

static int neighbours_are_clear(co_contact contact, const co_directions *a, const co_directions *b) {
    if (contact == CO_CONTACT_EDGE && co_directions_edge_is_clear(a, b))
        return 1;
    return join(&a->normal, &b->normal, 1).angle < NORMALS;
}

/* Least-norm step of Newton's method for a(p0, p1) = b(p2, p3) from the jets; 0 where it is singular. */
static int common_step(const co_bezier_jet *a, const co_bezier_jet *b, const double r[3], double step[4]) {
    const double *const column[4] = {a->u, a->v, b->u, b->v};
    double m[3][3], x[3], trace = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            m[i][j] = 0;
            for (int k = 0; k < 4; k++)
                m[i][j] += column[k][i] * column[k][j];
            trace += i == j ? m[i][j] : 0;
        }
    for (int i = 0; i < 3; i++)
        m[i][i] += 1e-12 * trace;
    const double d = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                     m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                     m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    if (!(d > 0))
        return 0;
    for (int i = 0; i < 3; i++) { /* Cramer's rule; m is symmetric */
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        x[i] = 0;
        for (int c = 0; c < 3; c++) {
            const int e = (c + 1) % 3, f = (c + 2) % 3;
            x[i] += (m[j][e] * m[k][f] - m[j][f] * m[k][e]) * r[c] / d;
        }
    }
    for (int k = 0; k < 4; k++)
        step[k] = (k < 2 ? -1 : 1) * co_dot3(column[k], x);
    return 1;
}

/* Sine of the angle between two tangent planes; 0 where a part has none. */
static double sine_between(const co_bezier_jet *a, const co_bezier_jet *b) {
    double n[2][3], length[2], product = 0;
    for (int k = 0; k < 2; k++) {
        const co_bezier_jet *j = k ? b : a;
        for (int c = 0; c < 3; c++) {
            const int d = (c + 1) % 3, e = (c + 2) % 3;
            n[k][c] = j->u[d] * j->v[e] - j->u[e] * j->v[d];
        }
        length[k] = co_length3(n[k]);
        if (!(length[k] > DEGENERATE * (co_dot3(j->u, j->u) + co_dot3(j->v, j->v))))
            return 0;
    }
    for (int c = 0; c < 3; c++) {
        const int d = (c + 1) % 3, e = (c + 2) % 3;
        const double x = (n[0][d] * n[1][e] - n[0][e] * n[1][d]) / (length[0] * length[1]);
        product += x * x;
    }
    return sqrt(product);
}

/* Newton's method from the middles of both parts, which its points do not leave. */
static co_crossing common_point(const co_crossing_search *s, int32_t a, int32_t b, const part *of_a, const part *of_b) {
    const double *const range[4] = {of_a->u, of_a->v, of_b->u, of_b->v};
    const double enough = COMMON * s->pieces->size;
    double p[4], step[4], last = (double)INFINITY;
    for (int k = 0; k < 4; k++)
        p[k] = (range[k][0] + range[k][1]) / 2;
    for (int n = 0; n < NEWTON_STEPS; n++) {
        co_bezier_jet ja, jb;
        co_bezier_at(co_pieces_bezier(s->pieces, a), p[0], p[1], &ja);
        co_bezier_at(co_pieces_bezier(s->pieces, b), p[2], p[3], &jb);
        const double r[3] = {ja.s[0] - jb.s[0], ja.s[1] - jb.s[1], ja.s[2] - jb.s[2]}, square = co_dot3(r, r);
        if (square <= enough * enough) {
            const int inside = !co_location_is_on_boundary(s->mesh, &s->pieces->place[a], p) &&
                               !co_location_is_on_boundary(s->mesh, &s->pieces->place[b], p + 2);
            return inside && sine_between(&ja, &jb) > TRANSVERSAL ? CO_CROSSING_PROVEN : CO_CROSSING_CONTACT;
        }
        if ((n >= 2 && square > 0.25 * last) || !common_step(&ja, &jb, r, step))
            break;
        last = square;
        double moved = 0;
        for (int k = 0; k < 4; k++) {
            const double old = p[k];
            p[k] = fmin(fmax(p[k] + step[k], range[k][0]), range[k][1]);
            moved += fabs(p[k] - old);
        }
        if (!(moved > 1e-14))
            break;
    }
    return CO_CROSSING_NONE;
}

/* The boxes of a part's children. */
static void child_boxes(const double part[CO_BEZIER], co_box out[4]) {
    static const double half[2][2] = {{0, 0.5}, {0.5, 1}};
    for (int i = 0; i < 4; i++) {
        double child[CO_BEZIER];
        co_bezier_part(part, half[i % 2], half[i / 2], child);
        out[i] = co_box_of(child, 16);
    }
}

/* Adds the pairs of children of both parts whose boxes overlap, of a part with itself each once. */
static int push_children(const task *t, const part *a, const part *b, task *stack, int depth) {
    co_box of_a[4], of_b[4];
    const int same = a == b;
    child_boxes(a->bezier, of_a);
    child_boxes(b->bezier, of_b);
    for (int i = 0; i < 4; i++)
        for (int j = same ? i : 0; j < 4; j++)
            if (co_box_overlap(&of_a[i], &of_b[j]))
                stack[depth++] = (task){.u = {2 * t->u[0] + i % 2, 2 * t->u[1] + j % 2},
                                        .v = {2 * t->v[0] + i / 2, 2 * t->v[1] + j / 2},
                                        .level = t->level + 1};
    return depth;
}

static co_directions directions_of(const co_crossing_search *s, int32_t piece, int level, const part *p) {
    return s->directions && level == 0 ? s->directions[piece] : co_directions_of(p->bezier, 1);
}

co_crossing co_crossing_of(const co_crossing_search *s, int32_t a, int32_t b, int most_parts) {
    task stack[16 * (DEEPEST + 1)];
    part of_a = {.bezier = {0}}, of_b = {.bezier = {0}};
    int depth = 1, n_pairs = 0;
    co_crossing worst = CO_CROSSING_NONE, now = CO_CROSSING_NONE;
    stack[0] = (task){.level = 0};
    while (depth && n_pairs++ < (worst == CO_CROSSING_CONTACT ? ENOUGH_PAIRS : most_parts)) {
        const task t = stack[--depth];
        const int same = a == b && t.u[0] == t.u[1] && t.v[0] == t.v[1];
        take_part(s, a, t.u[0], t.v[0], t.level, &of_a);
        take_part(s, b, t.u[1], t.v[1], t.level, &of_b);
        const co_contact contact = same ? CO_CONTACT_EDGE : co_location_contact(s->mesh, &of_a.where, &of_b.where);
        if (contact == CO_CONTACT_NONE && are_apart(of_a.bezier, of_b.bezier))
            continue;
        if (same) {
            const co_directions directions = directions_of(s, a, t.level, &of_a);
            if (!directions.are_apart && t.level < DEEPEST)
                depth = push_children(&t, &of_a, &of_a, stack, depth);
            continue;
        }
        if (contact != CO_CONTACT_NONE) {
            const co_directions one = directions_of(s, a, t.level, &of_a), two = directions_of(s, b, t.level, &of_b);
            if (neighbours_are_clear(contact, &one, &two))
                continue;
        } else if (are_apart_along_normals(of_a.bezier, of_b.bezier) || are_apart_as_sheets(of_a.bezier, of_b.bezier)) {
            continue;
        }
        if (contact == CO_CONTACT_NONE) {
            now = common_point(s, a, b, &of_a, &of_b);
            if (now == CO_CROSSING_PROVEN)
                return now;
            if (now == CO_CROSSING_NONE && t.level == DEEPEST)
                now = CO_CROSSING_UNRESOLVED;
            worst = now > worst ? now : worst;
        }
        if (t.level < DEEPEST)
            depth = push_children(&t, &of_a, &of_b, stack, depth);
    }
    return depth && worst == CO_CROSSING_NONE ? CO_CROSSING_UNRESOLVED : worst;
}
