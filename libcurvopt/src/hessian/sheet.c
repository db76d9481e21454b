/* An elastic sheet through the cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/sheet.h"

#include "base/elementary.h"

#include <math.h>
#include <string.h>

/* Where a corner has less than this part of the rest square's area, f grows no more: a folded cage may unfold. */
static const double LEAST_AREA = 1e-2;

/* A corner of a face: J = (j0, j1) from the edges to the next and to the last corner. The edges' ends move J by
 * dJ_k = sum_i by[k][i] dx_vertex[i]. */
typedef struct corner {
    int32_t vertex[3]; /* its own, the next and the last */
    double by[2][3];
    double j[2][3];
} corner;

/* Cosine and sine of the angle of a regular polygon's corner. */
static void angle_of(int32_t size, double *cosine, double *sine) {
    *cosine = 0;
    *sine = 1;
    if (size != 4) {
        *cosine = co_cos_pi(1 - 2.0 / size);
        *sine = co_sin_pi(1 - 2.0 / size);
    }
}

static int can_move(const co_sheet *s, int32_t v) {
    return s->dofs->node[v] >= 0;
}

/* 0 if no vertex of half-edge h's corner can move, or its face is left out. */
static int find_corner(const co_sheet *s, const double *x, int32_t h, corner *out) {
    double cosine, sine;
    const curvopt_mesh *m = s->mesh;
    const int32_t v[3] = {m->corner_vertex[h], co_mesh_destination(m, h), m->corner_vertex[co_mesh_prev(m, h)]};
    if ((s->left_out && s->left_out[m->corner_face[h]]) ||
        (!can_move(s, v[0]) && !can_move(s, v[1]) && !can_move(s, v[2])))
        return 0;
    angle_of(co_mesh_face_size(m, m->corner_face[h]), &cosine, &sine);
    *out = (corner){.vertex = {v[0], v[1], v[2]}, .by = {{-1, 1, 0}, {(cosine - 1) / sine, -cosine / sine, 1 / sine}}};
    for (size_t k = 0; k < 2; k++)
        for (size_t i = 0; i < 3; i++)
            for (size_t c = 0; c < 3; c++)
                out->j[k][c] += out->by[k][i] * x[3 * (size_t)v[i] + c];
    return 1;
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* What f is made of: f = sum g(square), square = p^2 q^2, with two derivatives of g. */
typedef struct measures {
    double c[3]; /* J^T J: 00, 01, 11 */
    double sum, square;
    double g[3];
} measures;

static measures measure(double rest, const corner *at) {
    measures m = {.c = {dot(at->j[0], at->j[0]), dot(at->j[0], at->j[1]), dot(at->j[1], at->j[1])}};
    const double soft = LEAST_AREA * LEAST_AREA;
    m.sum = m.c[0] + m.c[2];
    m.square = fmax(0, m.c[0] * m.c[2] - m.c[1] * m.c[1]);
    const double below = m.square + soft * rest * rest, above = (1 + soft) * rest;
    m.g[0] = 1 / rest + above / below;
    m.g[1] = -above / (below * below);
    m.g[2] = 2 * above / (below * below * below);
    return m;
}

static int32_t n_corners(const co_sheet *s) {
    return s->mesh->face_start[s->mesh->info.n_faces];
}

double co_sheet_rest(const co_sheet *s, const double *x, double part) {
    double area = 0, n = 0;
    corner at;
    for (int32_t h = 0; h < n_corners(s); h++)
        if (find_corner(s, x, h, &at)) {
            area += sqrt(measure(1, &at).square);
            n++;
        }
    return area > 0 ? part * area / n : 1;
}

double co_sheet_value(const co_sheet *s, const double *x, double *gradient) {
    double sum = 0;
    corner at;
    if (gradient)
        memset(gradient, 0, 3 * sizeof *gradient * (size_t)s->mesh->info.n_vertices);
    for (int32_t h = 0; h < n_corners(s); h++) {
        if (!find_corner(s, x, h, &at))
            continue;
        const measures m = measure(s->rest, &at);
        sum += m.sum * m.g[0];
        for (size_t c = 0; gradient && c < 3; c++) {
            const double by_square = 2 * m.sum * m.g[1];
            const double force[2] = {2 * m.g[0] * at.j[0][c] + by_square * (m.c[2] * at.j[0][c] - m.c[1] * at.j[1][c]),
                                     2 * m.g[0] * at.j[1][c] + by_square * (m.c[0] * at.j[1][c] - m.c[1] * at.j[0][c])};
            for (size_t i = 0; i < 3; i++)
                gradient[3 * (size_t)at.vertex[i] + c] += s->weight * (at.by[0][i] * force[0] + at.by[1][i] * force[1]);
        }
    }
    return s->weight * sum;
}

/* ------------------------------------------------------------------------------- second derivatives -- */

/* An eigenvector of f's second derivatives, as a change of J, and its eigenvalue. */
typedef struct mode {
    double value;
    double j[2][3];
} mode;

/* (p, u, v): singular values p >= q of J, their directions in space u[0], u[1] and the normal u[2], and in the rest
 * square v[0], v[1]. Where there is no area, any directions that fit. */
typedef struct decomposition {
    double p, q, u[3][3], v[2][2];
} decomposition;

static void scale_to(const double from[3], double factor, double out[3]) {
    for (size_t c = 0; c < 3; c++)
        out[c] = factor * from[c];
}

static void cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* The unit eigenvector of the larger eigenvalue of (a, b; b, c). Returns half the difference of both. */
static double find_axis(double a, double b, double c, double axis[2]) {
    const double half = 0.5 * (a - c), root = sqrt(half * half + b * b);
    const double along[2] = {half >= 0 ? root + half : b, half >= 0 ? b : root - half};
    const double length = sqrt(along[0] * along[0] + along[1] * along[1]);
    axis[0] = length > 0 ? along[0] / length : 1;
    axis[1] = length > 0 ? along[1] / length : 0;
    return root;
}

/* A unit vector across u. */
static void find_across(const double u[3], double out[3]) {
    const size_t k = fabs(u[0]) < 0.6 ? 0 : 1;
    const double axis[3] = {k == 0, k == 1, 0};
    cross(u, axis, out);
    scale_to(out, 1 / sqrt(dot(out, out)), out);
}

static decomposition decompose(const corner *at, const measures *m) {
    decomposition d = {.u = {{1, 0, 0}}};
    const double root = find_axis(m->c[0], m->c[1], m->c[2], d.v[0]);
    d.v[1][0] = -d.v[0][1];
    d.v[1][1] = d.v[0][0];
    d.p = sqrt(0.5 * m->sum + root);
    d.q = d.p > 0 ? sqrt(m->square) / d.p : 0;
    for (size_t k = 0; k < 2; k++)
        for (size_t c = 0; c < 3 && d.p > 0; c++)
            d.u[k][c] = d.v[k][0] * at->j[0][c] + d.v[k][1] * at->j[1][c];
    if (d.p > 0)
        scale_to(d.u[0], 1 / d.p, d.u[0]);
    if (d.q > 1e-9 * d.p)
        scale_to(d.u[1], 1 / d.q, d.u[1]);
    else
        find_across(d.u[0], d.u[1]);
    cross(d.u[0], d.u[1], d.u[2]);
    return d;
}

/* out += factor times the change of J that takes v[k] to u[i] */
static void add_change(const decomposition *d, size_t i, size_t k, double factor, mode *out) {
    for (size_t c = 0; c < 3; c++) {
        out->j[0][c] += factor * d->u[i][c] * d->v[k][0];
        out->j[1][c] += factor * d->u[i][c] * d->v[k][1];
    }
}

/* The two modes that change the singular values alone: of f's second derivatives (pp, pq; pq, qq). */
static void find_stretches(const decomposition *d, const measures *m, mode out[2]) {
    const double p = d->p, q = d->q, by_p = 2 * p * q * q, by_q = 2 * p * p * q; /* of the square */
    const double pp = 2 * m->g[0] + 4 * p * by_p * m->g[1] + m->sum * (2 * q * q * m->g[1] + by_p * by_p * m->g[2]);
    const double qq = 2 * m->g[0] + 4 * q * by_q * m->g[1] + m->sum * (2 * p * p * m->g[1] + by_q * by_q * m->g[2]);
    const double pq = 2 * (p * by_q + q * by_p) * m->g[1] + m->sum * (4 * p * q * m->g[1] + by_p * by_q * m->g[2]);
    double w[2];
    const double root = find_axis(pp, pq, qq, w);
    out[0].value = 0.5 * (pp + qq) + root;
    out[1].value = 0.5 * (pp + qq) - root;
    add_change(d, 0, 0, w[0], &out[0]);
    add_change(d, 1, 1, w[1], &out[0]);
    add_change(d, 0, 0, -w[1], &out[1]);
    add_change(d, 1, 1, w[0], &out[1]);
}

/* All six (Smith, de Goes, Kim, "Analytic eigensystems for isotropic distortion energies", 2019; across the surface as
 * for membranes). */
static void find_modes(const corner *at, const measures *m, mode out[6]) {
    const decomposition d = decompose(at, m);
    const double by_square = 2 * m->sum * m->g[1], pq = d.p * d.q, part = sqrt(0.5);
    memset(out, 0, 6 * sizeof *out);
    find_stretches(&d, m, out);
    out[2].value = 2 * m->g[0] + by_square * pq;
    add_change(&d, 0, 1, part, &out[2]);
    add_change(&d, 1, 0, -part, &out[2]);
    out[3].value = 2 * m->g[0] - by_square * pq;
    add_change(&d, 0, 1, part, &out[3]);
    add_change(&d, 1, 0, part, &out[3]);
    out[4].value = 2 * m->g[0] + by_square * d.q * d.q;
    add_change(&d, 2, 0, 1, &out[4]);
    out[5].value = 2 * m->g[0] + by_square * d.p * d.p;
    add_change(&d, 2, 1, 1, &out[5]);
}

/* The derivatives' place of a node among n, which ascend; a new one where there is none. */
static co_node_derivative *find_node(co_node_derivative *d, int32_t *n, int32_t node) {
    int32_t k = *n;
    while (k > 0 && d[k - 1].node >= node)
        k--;
    if (k == *n || d[k].node != node) {
        memmove(d + k + 1, d + k, (size_t)(*n - k) * sizeof *d);
        d[k] = (co_node_derivative){.node = node};
        ++*n;
    }
    return &d[k];
}

/* What the corner's vertices move of a mode, by nodes; returns their number. */
static int32_t differentiate(const co_sheet *s, const corner *at, const mode *of, co_node_derivative d[3]) {
    int32_t n = 0;
    for (size_t i = 0; i < 3; i++) {
        const int32_t v = at->vertex[i];
        double move[3], by[3];
        if (!can_move(s, v))
            continue;
        for (size_t c = 0; c < 3; c++)
            move[c] = at->by[0][i] * of->j[0][c] + at->by[1][i] * of->j[1][c];
        co_dof_map_project(s->dofs, v, move, by);
        co_node_derivative *to = find_node(d, &n, s->dofs->node[v]);
        for (int k = 0; k < 3; k++)
            to->by[k] += by[k];
    }
    return n;
}

void co_sheet_add_hessian(const co_sheet *s, const double *x, co_sparse_hessian *hessian) {
    corner at;
    for (int32_t h = 0; h < n_corners(s); h++) {
        mode modes[6];
        co_node_derivative d[3];
        if (!find_corner(s, x, h, &at))
            continue;
        const measures m = measure(s->rest, &at);
        find_modes(&at, &m, modes);
        for (size_t k = 0; k < 6; k++)
            if (modes[k].value > 0)
                co_sparse_hessian_add_square(hessian, differentiate(s, &at, &modes[k], d), d,
                                             s->weight * modes[k].value);
    }
}
