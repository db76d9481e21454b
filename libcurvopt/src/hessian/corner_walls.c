/* Walls against corners of faces that become thin or turn over. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/corner_walls.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "hessian/node_sum.h"

#include <math.h>
#include <stdlib.h>

/* Of what a corner has at first it may lose what is above this part; one that has less than THIN has no wall. */
static const double PART = 0.6, THIN = 0.05;
/* Of the least share: below this the cost goes on by its tangent, so that a corner may turn over on the way. */
static const double TANGENT = 0.1;
/* Of `worth`, at most, in what is thin at first. */
static const double MOST = 100;

/* ------------------------------------------------------------------------------------------- corners -- */

/* A face at a cage x. */
typedef struct face {
    const double *x;
    const int32_t *vertex; /* [n] */
    int32_t first;         /* its first corner */
    int32_t n;
    double area[3]; /* A */
    double square;  /* A.A */
} face;

/* The edge from corner c of the face to the k-th after it. */
static void edge_of(const face *f, int32_t c, int32_t k, double out[3]) {
    const double *from = f->x + 3 * (size_t)f->vertex[c], *to = f->x + 3 * (size_t)f->vertex[(c + k) % f->n];
    for (int i = 0; i < 3; i++)
        out[i] = to[i] - from[i];
}

/* Its corners' area vectors go into walls->area. */
static face face_of(const co_corner_walls *w, const double *x, int32_t k) {
    const curvopt_mesh *m = w->cage.mesh;
    face f = {.x = x, .first = m->face_start[k], .n = m->face_start[k + 1] - m->face_start[k]};
    f.vertex = m->corner_vertex + f.first;
    for (int32_t c = 0; c < f.n; c++) {
        double next[3], previous[3], *a = w->area + 3 * (size_t)c;
        edge_of(&f, c, 1, next);
        edge_of(&f, c, f.n - 1, previous);
        co_cross3(next, previous, a);
        for (int i = 0; i < 3; i++)
            f.area[i] += a[i];
    }
    f.square = co_dot3(f.area, f.area);
    return f;
}

/* Of corner c. */
static double share_of(const co_corner_walls *w, const face *f, int32_t c) {
    return f->n * co_dot3(w->area + 3 * (size_t)c, f->area) / f->square;
}

/* ------------------------------------------------------------------------------------------ creation -- */

static int32_t most_corners(const curvopt_mesh *m) {
    int32_t most = 0;
    for (int32_t k = 0; k < m->info.n_faces; k++) {
        const int32_t n = m->face_start[k + 1] - m->face_start[k];
        most = n > most ? n : most;
    }
    return most;
}

int32_t co_corner_walls_create(const curvopt_mesh *mesh, const uint8_t *left_out, const double *x, co_corner_walls *w,
                               curvopt_error *error) {
    *w = (co_corner_walls){.cage = {.mesh = mesh},
                           .least = CO_NEW(double, mesh->face_start[mesh->info.n_faces]),
                           .area = CO_NEW(double, 3 * (size_t)most_corners(mesh))};
    if (!w->least || !w->area)
        return co_status_no_memory(error);
    for (int32_t k = 0; k < mesh->info.n_faces; k++) {
        const face f = face_of(w, x, k);
        for (int32_t c = 0; f.square > 0 && !(left_out && left_out[k]) && c < f.n; c++) {
            const double share = share_of(w, &f, c);
            w->least[f.first + c] = share > THIN ? PART * fmin(share, 1) : 0;
        }
    }
    return CURVOPT_OK;
}

void co_corner_walls_free(co_corner_walls *w) {
    free(w->least);
    free(w->area);
    *w = (co_corner_walls){0};
}

/* --------------------------------------------------------------------------------- value and gradient -- */

/* What a corner costs, and the derivatives by its share. */
typedef struct cost {
    double value, first, second;
} cost;

/* t^3 of a corner, with `least` > 0. */
static cost cost_of(double least, double share) {
    const double at = fmax(share, TANGENT * least), past = share - at; /* past <= 0 */
    const double slope = -least / (at * at), bend = past < 0 ? 0 : 2 * least / (at * at * at),
                 t = least / at - 1 + slope * past;
    if (!(t > 0))
        return (cost){0};
    return (cost){t * t * t, 3 * t * t * slope, 6 * t * slope * slope + 3 * t * t * bend};
}

/* Of corner c, times the weight. */
static cost cost_at(const co_corner_walls *w, const face *f, int32_t c) {
    const double least = w->least[f->first + c];
    if (!(least > 0 && f->square > 0))
        return (cost){0};
    const cost one = cost_of(least, share_of(w, f, c));
    return (cost){w->weight * one.value, w->weight * one.first, w->weight * one.second};
}

/* The share of corner c changes by da_c.p + dA.q. */
static void share_slopes(const co_corner_walls *w, const face *f, int32_t c, double p[3], double q[3]) {
    const double share = share_of(w, f, c), *a = w->area + 3 * (size_t)c;
    for (int i = 0; i < 3; i++) {
        p[i] = f->n * f->area[i] / f->square;
        q[i] = (f->n * a[i] - 2 * share * f->area[i]) / f->square;
    }
}

/* Gradients of u.a_c, by the vertices after and before corner c; by its own it is less their sum. */
static void differentiate(const face *f, int32_t c, const double u[3], double after[3], double before[3]) {
    double next[3], previous[3];
    edge_of(f, c, 1, next);
    edge_of(f, c, f->n - 1, previous);
    co_cross3(previous, u, after);
    co_cross3(u, next, before);
}

/* gradient += that of the face's costs. */
static void add_slopes(const co_corner_walls *w, const face *f, double *gradient) {
    double whole[3] = {0}, p[3], q[3];
    for (int32_t c = 0; c < f->n; c++) {
        const double first = cost_at(w, f, c).first;
        share_slopes(w, f, c, p, q);
        for (int i = 0; i < 3; i++)
            whole[i] += first * q[i];
    }
    for (int32_t c = 0; c < f->n; c++) {
        double u[3], after[3], before[3];
        const double first = cost_at(w, f, c).first;
        share_slopes(w, f, c, p, q);
        for (int i = 0; i < 3; i++)
            u[i] = first * p[i] + whole[i];
        differentiate(f, c, u, after, before);
        for (size_t i = 0; i < 3; i++) {
            gradient[3 * (size_t)f->vertex[(c + 1) % f->n] + i] += after[i];
            gradient[3 * (size_t)f->vertex[(c + f->n - 1) % f->n] + i] += before[i];
            gradient[3 * (size_t)f->vertex[c] + i] -= after[i] + before[i];
        }
    }
}

double co_corner_walls_value(const co_corner_walls *w, const double *x, double *gradient) {
    double sum = 0;
    for (int32_t k = 0; w->weight > 0 && k < w->cage.mesh->info.n_faces; k++) {
        const face f = face_of(w, x, k);
        double of_face = 0;
        for (int32_t c = 0; c < f.n; c++)
            of_face += cost_at(w, &f, c).value;
        if (gradient && of_face > 0)
            add_slopes(w, &f, gradient);
        sum += of_face;
    }
    return sum;
}

void co_corner_walls_weigh(co_corner_walls *w, const double *x, double worth) {
    const curvopt_mesh *m = w->cage.mesh;
    w->weight = 1;
    const double sum = co_corner_walls_value(w, x, NULL);
    w->weight = fmin(worth / m->face_start[m->info.n_faces], MOST * worth / sum);
}

/* -------------------------------------------------------------------------------------------- hessian -- */

/* Adds `by`, a derivative by vertex v. Where a vertex interpolates, its position is none of the variables'. */
static void add_vertex(const co_corner_walls *w, int32_t v, const double by[3], double factor, co_node_sum *sum) {
    if (!w->cage.interpolation || co_interpolation_find(w->cage.interpolation, v) < 0)
        co_node_sum_add(sum, w->cage.dofs, v, by, factor);
}

/* The derivative of corner c's share, by nodes. */
static void differentiate_share(const co_corner_walls *w, const face *f, int32_t c, co_node_sum *sum) {
    double p[3], q[3];
    share_slopes(w, f, c, p, q);
    co_node_sum_clear(sum);
    for (int32_t k = 0; k < f->n; k++) {
        double u[3], after[3], before[3];
        for (int i = 0; i < 3; i++)
            u[i] = q[i] + (k == c ? p[i] : 0);
        differentiate(f, k, u, after, before);
        add_vertex(w, f->vertex[(k + 1) % f->n], after, 1, sum);
        add_vertex(w, f->vertex[(k + f->n - 1) % f->n], before, 1, sum);
        add_vertex(w, f->vertex[k], after, -1, sum);
        add_vertex(w, f->vertex[k], before, -1, sum);
    }
    co_node_sum_sort(sum);
}

int32_t co_corner_walls_add_hessian(const co_corner_walls *w, const double *x, co_sparse_hessian *hessian,
                                    curvopt_error *error) {
    co_node_sum sum = {0};
    if (!(w->weight > 0))
        return CURVOPT_OK;
    const int32_t status = co_node_sum_create(w->cage.dofs->n_nodes, &sum, error);
    for (int32_t k = 0; status == CURVOPT_OK && k < w->cage.mesh->info.n_faces; k++) {
        const face f = face_of(w, x, k);
        for (int32_t c = 0; c < f.n; c++) {
            const double second = cost_at(w, &f, c).second;
            if (!(second > 0))
                continue;
            differentiate_share(w, &f, c, &sum);
            co_sparse_hessian_add_square(hessian, sum.n, sum.part, second);
        }
    }
    co_node_sum_free(&sum);
    return status;
}
