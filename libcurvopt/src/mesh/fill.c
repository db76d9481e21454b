/* Vertices put between others, as a thin plate would lie. SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/fill.h"

#include "base/memory.h"
#include "linalg/vector.h"

#include <stdlib.h>

static const double ENOUGH = 1e-10; /* of the residual at the start */
enum { MOST_STEPS = 2000 };

typedef struct plate {
    const curvopt_mesh *mesh;
    const uint8_t *is_free;
    double *share; /* [n_vertices] 1 / number of neighbours */
    double *bend;  /* [3 n_vertices] x - mean of its neighbours, of what was multiplied last */
} plate;

static void add3(double s, const double *x, double *y) {
    for (int c = 0; c < 3; c++)
        y[c] += s * x[c];
}

/* y = L^T L x, at free vertices, else 0: the gradient of half of the sum. */
static void multiply(const plate *p, const double *x, double *y) {
    const curvopt_mesh *m = p->mesh;
    const size_t n = (size_t)m->info.n_vertices;
    for (size_t i = 0; i < 3 * n; i++)
        p->bend[i] = x[i];
    for (int32_t e = 0; e < m->info.n_edges; e++) {
        const size_t v = (size_t)m->corner_vertex[m->edge_corner[e]];
        const size_t w = (size_t)co_mesh_destination(m, m->edge_corner[e]);
        add3(-p->share[v], x + 3 * w, p->bend + 3 * v);
        add3(-p->share[w], x + 3 * v, p->bend + 3 * w);
    }
    for (size_t i = 0; i < 3 * n; i++)
        y[i] = p->bend[i];
    for (int32_t e = 0; e < m->info.n_edges; e++) {
        const size_t v = (size_t)m->corner_vertex[m->edge_corner[e]];
        const size_t w = (size_t)co_mesh_destination(m, m->edge_corner[e]);
        add3(-p->share[v], p->bend + 3 * v, y + 3 * w);
        add3(-p->share[w], p->bend + 3 * w, y + 3 * v);
    }
    for (size_t i = 0; i < 3 * n; i++)
        y[i] = p->is_free[i / 3] ? y[i] : 0;
}

/* xyz goes to where the gradient is 0. work [3][3 n_vertices] */
static void solve(const plate *p, double *xyz, double *work) {
    const size_t n = 3 * (size_t)p->mesh->info.n_vertices;
    double *residual = work, *along = work + n, *image = work + 2 * n;
    multiply(p, xyz, residual);
    for (size_t i = 0; i < n; i++)
        along[i] = residual[i] = -residual[i];
    double square = co_vector_dot(n, residual, residual);
    const double enough = ENOUGH * ENOUGH * square;
    for (int k = 0; k < MOST_STEPS && square > enough; k++) {
        multiply(p, along, image);
        const double step = square / co_vector_dot(n, along, image), before = square;
        co_vector_add(n, step, along, xyz);
        co_vector_add(n, -step, image, residual);
        square = co_vector_dot(n, residual, residual);
        for (size_t i = 0; i < n; i++)
            along[i] = residual[i] + square / before * along[i];
    }
}

int32_t co_mesh_fill(const curvopt_mesh *mesh, const uint8_t *is_free, double *xyz, curvopt_error *error) {
    const size_t n = (size_t)mesh->info.n_vertices;
    plate p = {.mesh = mesh, .is_free = is_free, .share = CO_NEW(double, n), .bend = CO_NEW(double, 3 * n)};
    double *work = CO_NEW(double, 9 * n);
    int32_t status = p.share && p.bend && work ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        for (int32_t e = 0; e < mesh->info.n_edges; e++) {
            p.share[mesh->corner_vertex[mesh->edge_corner[e]]]++;
            p.share[co_mesh_destination(mesh, mesh->edge_corner[e])]++;
        }
        for (size_t v = 0; v < n; v++)
            p.share[v] = p.share[v] > 0 ? 1 / p.share[v] : 0;
        solve(&p, xyz, work);
    }
    free(p.share);
    free(p.bend);
    free(work);
    return status;
}
