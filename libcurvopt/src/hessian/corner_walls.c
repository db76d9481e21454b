/* Walls against corners of faces that become thin or turn over. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/corner_walls.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "hessian/node_sum.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of what a corner has at first it may lose what is above this part; one that has less than THIN has no wall. */
static const double PART = 0.6, THIN = 0.05;
/* Of its least share: a thinner corner loses its wall where walls are weighed. */
static const double GONE = 0.02;

/* A face, and its area vectors at some positions. */
typedef struct face {
    const int32_t *vertex; /* [n] */
    int32_t first;         /* its first corner */
    int32_t n;
    double area[3]; /* A */
    double square;  /* A.A */
} face;

/* The edge from corner c of the face to the k-th after it. */
static void edge_of(const face *f, const double *x, int32_t c, int32_t k, double out[3]) {
    const double *from = x + 3 * (size_t)f->vertex[c], *to = x + 3 * (size_t)f->vertex[(c + k) % f->n];
    for (int i = 0; i < 3; i++)
        out[i] = to[i] - from[i];
}

/* Face k at x; its corners' area vectors go into walls->area. */
static face face_at(const co_corner_walls *w, const double *x, int32_t k) {
    const curvopt_mesh *m = w->cage.mesh;
    face f = {.first = m->face_start[k], .n = m->face_start[k + 1] - m->face_start[k]};
    f.vertex = m->corner_vertex + f.first;
    for (int32_t c = 0; c < f.n; c++) {
        double next[3], previous[3], *a = w->area + 3 * (size_t)c;
        edge_of(&f, x, c, 1, next);
        edge_of(&f, x, c, f.n - 1, previous);
        co_cross3(next, previous, a);
        for (int i = 0; i < 3; i++)
            f.area[i] += a[i];
    }
    f.square = co_dot3(f.area, f.area);
    return f;
}

/* Of corner c; 0 in a face without area. */
static double share_of(const co_corner_walls *w, const face *f, int32_t c) {
    return f->square > 0 ? f->n * co_dot3(w->area + 3 * (size_t)c, f->area) / f->square : 0;
}

int32_t co_corner_walls_create(const curvopt_mesh *mesh, const double *x, co_corner_walls *w, curvopt_error *error) {
    int32_t most = 0;
    for (int32_t k = 0; k < mesh->info.n_faces; k++)
        most =
            mesh->face_start[k + 1] - mesh->face_start[k] > most ? mesh->face_start[k + 1] - mesh->face_start[k] : most;
    *w = (co_corner_walls){.cage = {.mesh = mesh},
                           .least = CO_NEW(double, mesh->face_start[mesh->info.n_faces]),
                           .area = CO_NEW(double, 3 * (size_t)most)};
    if (!w->least || !w->area) {
        co_corner_walls_free(w);
        return co_status_no_memory(error);
    }
    for (int32_t k = 0; k < mesh->info.n_faces; k++) {
        const face f = face_at(w, x, k);
        for (int32_t c = 0; c < f.n; c++) {
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

void co_corner_walls_weigh(co_corner_walls *w, const double *x, double worth) {
    const curvopt_mesh *m = w->cage.mesh;
    for (int32_t k = 0; k < m->info.n_faces; k++) {
        const face f = face_at(w, x, k);
        for (int32_t c = 0; c < f.n; c++)
            if (!(share_of(w, &f, c) > GONE * w->least[f.first + c]))
                w->least[f.first + c] = 0;
    }
    w->weight = worth / m->face_start[m->info.n_faces];
}

/* What corner c costs, and by its share; 0 where that is enough. */
static double cost_of(const co_corner_walls *w, const face *f, int32_t c, double *first, double *second) {
    const double least = w->least[f->first + c], share = least > 0 ? share_of(w, f, c) : 1, t = least / share - 1;
    *first = *second = 0;
    if (share <= 0)
        return (double)INFINITY;
    if (t <= 0)
        return 0;
    *first = -3 * w->weight * t * t * least / (share * share);
    *second = 6 * w->weight * t * least * (least / share + t) / (share * share * share);
    return w->weight * t * t * t;
}

/* Gradients of u.a_c, by the vertices after and before corner c; by its own it is less their sum. */
static void differentiate(const face *f, const double *x, int32_t c, const double u[3], double after[3],
                          double before[3]) {
    double next[3], previous[3];
    edge_of(f, x, c, 1, next);
    edge_of(f, x, c, f->n - 1, previous);
    co_cross3(previous, u, after);
    co_cross3(u, next, before);
}

/* gradient += that of the face's costs. With p = n A / A.A the share changes by da.p + dA.q. */
static void add_slopes(const co_corner_walls *w, const face *f, const double *x, double *gradient) {
    double q[3] = {0}, first, second;
    for (int32_t c = 0; c < f->n; c++) {
        cost_of(w, f, c, &first, &second);
        for (int i = 0; i < 3; i++)
            q[i] +=
                first * (f->n * w->area[3 * (size_t)c + (size_t)i] - 2 * share_of(w, f, c) * f->area[i]) / f->square;
    }
    for (int32_t c = 0; c < f->n; c++) {
        double u[3], after[3], before[3];
        cost_of(w, f, c, &first, &second);
        for (int i = 0; i < 3; i++)
            u[i] = first * f->n * f->area[i] / f->square + q[i];
        differentiate(f, x, c, u, after, before);
        for (size_t i = 0; i < 3; i++) {
            gradient[3 * (size_t)f->vertex[(c + 1) % f->n] + i] += after[i];
            gradient[3 * (size_t)f->vertex[(c + f->n - 1) % f->n] + i] += before[i];
            gradient[3 * (size_t)f->vertex[c] + i] -= after[i] + before[i];
        }
    }
}

double co_corner_walls_value(const co_corner_walls *w, const double *x, double *gradient) {
    double sum = 0, first, second;
    if (!(w->weight > 0))
        return 0;
    for (int32_t k = 0; k < w->cage.mesh->info.n_faces; k++) {
        const face f = face_at(w, x, k);
        double of_face = 0;
        for (int32_t c = 0; c < f.n; c++)
            of_face += cost_of(w, &f, c, &first, &second);
        sum += of_face;
        if (isinf(sum))
            return sum;
        if (gradient && of_face > 0)
            add_slopes(w, &f, x, gradient);
    }
    return sum;
}

/* Where a vertex interpolates, its position is none of the variables'. */
static void add_vertex(const co_corner_walls *w, int32_t v, const double by[3], double factor, co_node_sum *sum) {
    if (!w->cage.interpolation || co_interpolation_find(w->cage.interpolation, v) < 0)
        co_node_sum_add(sum, w->cage.dofs, v, by, factor);
}

int32_t co_corner_walls_add_hessian(const co_corner_walls *w, const double *x, co_sparse_hessian *hessian,
                                    curvopt_error *error) {
    co_node_sum sum = {0};
    int32_t status = w->weight > 0 ? co_node_sum_create(w->cage.dofs->n_nodes, &sum, error) : CURVOPT_OK;
    for (int32_t k = 0; w->weight > 0 && status == CURVOPT_OK && k < w->cage.mesh->info.n_faces; k++) {
        const face f = face_at(w, x, k);
        for (int32_t c = 0; c < f.n; c++) {
            double first, second, u[3], after[3], before[3];
            cost_of(w, &f, c, &first, &second);
            if (!(second > 0))
                continue;
            for (int i = 0; i < 3; i++)
                u[i] = f.n * f.area[i] / f.square;
            differentiate(&f, x, c, u, after, before);
            co_node_sum_clear(&sum);
            add_vertex(w, f.vertex[(c + 1) % f.n], after, 1, &sum);
            add_vertex(w, f.vertex[(c + f.n - 1) % f.n], before, 1, &sum);
            add_vertex(w, f.vertex[c], after, -1, &sum);
            add_vertex(w, f.vertex[c], before, -1, &sum);
            co_node_sum_sort(&sum);
            co_sparse_hessian_add_square(hessian, sum.n, sum.part, second);
        }
    }
    co_node_sum_free(&sum);
    return status;
}
