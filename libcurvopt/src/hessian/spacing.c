/* An evenly spaced cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/spacing.h"

#include "base/elementary.h"

#include <math.h>
#include <string.h>

/* delta, of a: bounds what a corner without area is worth, so that a folded cage may unfold. */
static const double SOFT = 1e-3;
/* Weights up to this are left out of the Hessian: where many limit points touch, those of far ones fall by a factor a
 * vertex. */
static const double NEGLIGIBLE = 1e-12;

/* An edge that can move. */
typedef struct edge {
    int32_t v, w;
    double along[3]; /* from w to v */
    double square;   /* of the length */
} edge;

/* Vertex v as a combination of positions. */
static co_point_row positions_of(const co_spacing *s, const int32_t *v) {
    static const double one = 1;
    const int32_t i = s->interpolation ? co_interpolation_find(s->interpolation, *v) : -1;
    if (i < 0)
        return (co_point_row){v, &one, 1};
    const co_sparse_rows *rows = &s->interpolation->cage;
    return (co_point_row){rows->column + rows->start[i], rows->value + rows->start[i],
                          rows->start[i + 1] - rows->start[i]};
}

/* Whether vertex v can move, as far as its own position tells: of one that interpolates it does not. */
static int can_move(const co_spacing *s, int32_t v) {
    return s->dofs->node[v] >= 0 || (s->interpolation && co_interpolation_find(s->interpolation, v) >= 0);
}

/* 0 if neither end of edge k can move. */
static int find_edge(const co_spacing *s, const double *x, int32_t k, edge *out) {
    int32_t h = s->mesh->edge_corner[k];
    *out = (edge){.v = s->mesh->corner_vertex[h], .w = co_mesh_destination(s->mesh, h)};
    if (!can_move(s, out->v) && !can_move(s, out->w))
        return 0;
    for (size_t c = 0; c < 3; c++) {
        out->along[c] = x[3 * (size_t)out->v + c] - x[3 * (size_t)out->w + c];
        out->square += out->along[c] * out->along[c];
    }
    return 1;
}

/* A corner of a face: J = (j0, j1) from the edges to the next and to the last corner. The edges' ends move J by
 * dJ_k = sum_i by[k][i] dx_vertex[i]. */
typedef struct corner {
    int32_t vertex[3]; /* its own, the next and the last */
    double by[2][3];
    double j[2][3];
    double tension; /* least stiffness of a change of J, by its part of both edges */
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

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double square_between(const double a[3], const double b[3]) {
    const double along[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return dot(along, along);
}

/* 0 if no vertex of half-edge h's corner can move. An edge's |e|^4 is at least as stiff as 4 |e|^2; up to four corners
 * share it. A change of J is at most 1 / sqrt(1 - |cosine|) times those of the edges. */
static int find_corner(const co_spacing *s, const double *x, int32_t h, corner *out) {
    double cosine, sine;
    const curvopt_mesh *m = s->mesh;
    const int32_t v[3] = {m->corner_vertex[h], co_mesh_destination(m, h), m->corner_vertex[co_mesh_prev(m, h)]};
    const double *at = x + 3 * (size_t)v[0];
    if (!can_move(s, v[0]) && !can_move(s, v[1]) && !can_move(s, v[2]))
        return 0;
    angle_of(co_mesh_face_size(m, m->corner_face[h]), &cosine, &sine);
    *out = (corner){.vertex = {v[0], v[1], v[2]}, .by = {{-1, 1, 0}, {(cosine - 1) / sine, -cosine / sine, 1 / sine}}};
    for (size_t k = 0; k < 2; k++)
        for (size_t i = 0; i < 3; i++)
            for (size_t c = 0; c < 3; c++)
                out->j[k][c] += out->by[k][i] * x[3 * (size_t)v[i] + c];
    out->tension =
        (1 - fabs(cosine)) * fmin(square_between(at, x + 3 * (size_t)v[1]), square_between(at, x + 3 * (size_t)v[2]));
    return 1;
}

/* J^T J: its entries 00, 01, 11, trace and determinant. */
typedef struct metric {
    double c[3], trace, det;
} metric;

static metric metric_of(const corner *at) {
    metric m = {.c = {dot(at->j[0], at->j[0]), dot(at->j[0], at->j[1]), dot(at->j[1], at->j[1])}};
    m.trace = m.c[0] + m.c[2];
    m.det = fmax(0, m.c[0] * m.c[2] - m.c[1] * m.c[1]);
    return m;
}

double co_spacing_mean_corner(const co_spacing *s, const double *x) {
    double area = 0, n = 0;
    corner at;
    for (int32_t h = 0; h < s->mesh->face_start[s->mesh->info.n_faces]; h++)
        if (find_corner(s, x, h, &at)) {
            area += sqrt(metric_of(&at).det);
            n += 1;
        }
    return n > 0 ? area / n : 0;
}

/* The sum over corners; gradient += weight times theirs. p^2 + q^2 and p^2 q^2 are the trace and the determinant. */
static double add_corner_values(const co_spacing *s, const double *x, double *gradient) {
    const double cube = s->least * s->least * s->least, soft = SOFT * s->least;
    double sum = 0;
    corner at;
    for (int32_t h = 0; h < s->mesh->face_start[s->mesh->info.n_faces]; h++) {
        if (!find_corner(s, x, h, &at))
            continue;
        const metric m = metric_of(&at);
        const double below = m.det + soft * m.trace + soft * soft, above = m.trace + 2 * soft;
        const double slope = 2 * s->weight * cube / (below * below);
        sum += cube * above / below;
        for (size_t c = 0; gradient && c < 3; c++) {
            const double a = at.j[0][c], b = at.j[1][c], own = m.det - soft * soft;
            const double force[2] = {slope * (own * a - above * (m.c[2] * a - m.c[1] * b)),
                                     slope * (own * b - above * (m.c[0] * b - m.c[1] * a))};
            for (size_t i = 0; i < 3; i++)
                gradient[3 * (size_t)at.vertex[i] + c] += at.by[0][i] * force[0] + at.by[1][i] * force[1];
        }
    }
    return sum;
}

double co_spacing_value(const co_spacing *s, const double *x, double *gradient) {
    double sum = 0;
    edge e;
    if (gradient)
        memset(gradient, 0, 3 * sizeof *gradient * (size_t)s->mesh->info.n_vertices);
    for (int32_t k = 0; k < s->mesh->info.n_edges; k++) {
        if (!find_edge(s, x, k, &e))
            continue;
        sum += e.square * e.square;
        for (size_t c = 0; gradient && c < 3; c++) {
            double force = 4 * s->weight * e.square * e.along[c];
            gradient[3 * (size_t)e.v + c] += force;
            gradient[3 * (size_t)e.w + c] -= force;
        }
    }
    if (s->least > 0)
        sum += add_corner_values(s, x, gradient);
    return s->weight * sum;
}

/* ------------------------------------------------------------------------------- second derivatives -- */

/* An eigenvector of a corner's second derivatives, as a change of J, and its eigenvalue. */
typedef struct mode {
    double value;
    double j[2][3];
} mode;

/* (p, u, v): singular values p >= q of J, their directions in space u[0], u[1] and the normal u[2], and in the
 * polygon v[0], v[1]. Where there is no area, any directions that fit. */
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

static decomposition decompose(const corner *at, const metric *m) {
    decomposition d = {.u = {{1, 0, 0}}};
    const double root = find_axis(m->c[0], m->c[1], m->c[2], d.v[0]);
    d.v[1][0] = -d.v[0][1];
    d.v[1][1] = d.v[0][0];
    d.p = sqrt(0.5 * m->trace + root);
    d.q = d.p > 0 ? sqrt(m->det) / d.p : 0;
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

/* Those of 1 / (p^2 + soft) + 1 / (q^2 + soft): each singular value, shear, rotation and both changes across the
 * surface (Smith, de Goes, Kim, "Analytic eigensystems for isotropic distortion energies", 2019). */
static void find_modes(const corner *at, const metric *m, double soft, mode out[6]) {
    const decomposition d = decompose(at, m);
    const double of_p = d.p * d.p + soft, of_q = d.q * d.q + soft, both = of_p * of_p * of_q * of_q;
    const double pq = d.p * d.q, part = sqrt(0.5);
    memset(out, 0, 6 * sizeof *out);
    out[0].value = (6 * d.p * d.p - 2 * soft) / (of_p * of_p * of_p);
    add_change(&d, 0, 0, 1, &out[0]);
    out[1].value = (6 * d.q * d.q - 2 * soft) / (of_q * of_q * of_q);
    add_change(&d, 1, 1, 1, &out[1]);
    out[2].value = 2 * (pq * (m->trace + pq) + 2 * soft * pq - soft * soft) / both;
    add_change(&d, 0, 1, part, &out[2]);
    add_change(&d, 1, 0, part, &out[2]);
    out[3].value = -2 * (pq * (m->trace - pq) + 2 * soft * pq + soft * soft) / both;
    add_change(&d, 0, 1, part, &out[3]);
    add_change(&d, 1, 0, -part, &out[3]);
    out[4].value = -2 / (of_p * of_p);
    add_change(&d, 2, 0, 1, &out[4]);
    out[5].value = -2 / (of_q * of_q);
    add_change(&d, 2, 1, 1, &out[5]);
}

/* block[i][k] += of the corner's vertices i <= k */
static void add_mode(const corner *at, const mode *of, double weight, double block[3][3][9]) {
    double move[3][3]; /* what a vertex' motion along x, y, z is of the mode */
    for (size_t i = 0; i < 3; i++)
        for (size_t c = 0; c < 3; c++)
            move[i][c] = at->by[0][i] * of->j[0][c] + at->by[1][i] * of->j[1][c];
    for (size_t i = 0; i < 3; i++)
        for (size_t k = i; k < 3; k++)
            for (size_t c = 0; c < 9; c++)
                block[i][k][c] += weight * of->value * move[i][c / 3] * move[k][c % 3];
}

/* The block of vertices v (rows) and w, which may be combinations of positions. */
static void add_pair(const co_spacing *s, const int32_t *v, const int32_t *w, const double block[9],
                     co_sparse_hessian *hessian) {
    const co_point_row rows = positions_of(s, v), columns = positions_of(s, w);
    for (size_t i = 0; i < rows.n; i++)
        for (size_t k = 0; k < (v == w ? i + 1 : columns.n); k++) {
            const double weight = rows.weight[i] * columns.weight[k];
            const int is_diagonal = v != w && rows.vertex[i] == columns.vertex[k]; /* (w, v) is added, too */
            double part[9];
            if (fabs(weight) <= NEGLIGIBLE)
                continue;
            for (int c = 0; c < 9; c++)
                part[c] = weight * (block[c] + (is_diagonal ? block[3 * (c % 3) + c / 3] : 0));
            co_sparse_hessian_add_block(hessian, rows.vertex[i], columns.vertex[k], part);
        }
}

static void add_corners(const co_spacing *s, const double *x, co_sparse_hessian *hessian) {
    const double cube = s->least * s->least * s->least;
    corner at;
    for (int32_t h = 0; h < s->mesh->face_start[s->mesh->info.n_faces]; h++) {
        mode modes[6];
        double block[3][3][9] = {{{0}}};
        if (!find_corner(s, x, h, &at))
            continue;
        const metric m = metric_of(&at);
        find_modes(&at, &m, SOFT * s->least, modes);
        for (size_t k = 0; k < 6; k++) {
            modes[k].value = fmax(cube * modes[k].value, -at.tension);
            add_mode(&at, &modes[k], s->weight, block);
        }
        for (size_t i = 0; i < 3; i++)
            for (size_t k = i; k < 3; k++)
                add_pair(s, &at.vertex[i], &at.vertex[k], block[i][k], hessian);
    }
}

static void add_edges(const co_spacing *s, const double *x, co_sparse_hessian *hessian) {
    edge e;
    for (int32_t k = 0; k < s->mesh->info.n_edges; k++) {
        double own[9], other[9];
        if (!find_edge(s, x, k, &e))
            continue;
        for (int i = 0; i < 9; i++) {
            own[i] = 4 * s->weight * ((i % 4 == 0) * e.square + 2 * e.along[i / 3] * e.along[i % 3]);
            other[i] = -own[i];
        }
        add_pair(s, &e.v, &e.v, own, hessian);
        add_pair(s, &e.w, &e.w, own, hessian);
        add_pair(s, &e.v, &e.w, other, hessian);
    }
}

void co_spacing_add_hessian(const co_spacing *s, const double *x, co_sparse_hessian *hessian) {
    if (s->weight > 0)
        add_edges(s, x, hessian);
    if (s->weight > 0 && s->least > 0)
        add_corners(s, x, hessian);
}
