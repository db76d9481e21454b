/* Normalized positions, and gradients from there. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/normalization.h"

#include "base/ordered_sum.h"
#include "mesh/similarity.h"

#include <string.h>

/* Positions on their way to normalized ones. */
typedef struct placement {
    const double *from;
    double *to;
    double centroid[3], unit;
    _Atomic int changes; /* whether any is another than before */
} placement;

static void normalize_points(void *context, size_t begin, size_t end) {
    placement *m = context;
    int changes = 0;
    for (size_t v = begin; v < end; v++)
        for (size_t c = 0; c < 3; c++)
            changes |= co_normalization_set((m->from[3 * v + c] - m->centroid[c]) * m->unit, &m->to[3 * v + c]);
    if (changes)
        m->changes = 1;
}

double co_normalization_apply(const co_normalization *c, const double *xyz, double *points, int *changes) {
    placement m = {.from = xyz, .to = points};
    const double radius = co_similarity_frame_without(c->n, xyz, c->n_skipped, c->skipped, m.centroid);
    m.unit = 1 / radius;
    co_thread_pool_for(co_thread_pool_if_worth(c->threads, c->n), c->n, normalize_points, &m);
    *changes = m.changes;
    return radius;
}

/* What co_normalization_gradient() is about. */
typedef struct gradient_parts {
    const double *points;
    double *gradient;
    size_t n;
    double part, unit, mean[3], radial;   /* `radial` drops out, per position */
    double sum[CO_ORDERED_SUM_CHUNKS][6]; /* of the gradient, and of its products with positions */
} gradient_parts;

static void sum_gradient(void *context, size_t begin, size_t end) {
    gradient_parts *g = context;
    for (int k = (int)begin; k < (int)end; k++)
        for (size_t v = co_ordered_sum_begin(g->n, k); v < co_ordered_sum_begin(g->n, k + 1); v++)
            for (size_t c = 0; c < 3; c++) {
                g->sum[k][c] += g->part * g->gradient[3 * v + c];
                g->sum[k][3 + c] += g->part * g->gradient[3 * v + c] * g->points[3 * v + c];
            }
}

static void project_gradient(void *context, size_t begin, size_t end) {
    const gradient_parts *g = context;
    for (size_t v = begin; v < end; v++)
        for (size_t c = 0; c < 3; c++)
            g->gradient[3 * v + c] = (g->gradient[3 * v + c] - g->mean[c] - g->radial * g->points[3 * v + c]) * g->unit;
}

void co_normalization_gradient(const co_normalization *c, const double *points, double radius, double stays,
                               double *gradient) {
    double along[3] = {0, 0, 0};
    gradient_parts g = {.points = points,
                        .gradient = gradient,
                        .n = c->n,
                        .part = 1 / (double)(c->n - c->n_skipped),
                        .unit = 1 / radius};
    co_ordered_sum_run(c->threads, c->n, sum_gradient, &g);
    for (int k = 0; k < CO_ORDERED_SUM_CHUNKS; k++)
        for (size_t i = 0; i < 3; i++) {
            g.mean[i] += g.sum[k][i];
            along[i] += g.sum[k][3 + i];
        }
    g.radial = along[0] + along[1] + along[2] - stays * g.part;
    co_thread_pool_for(co_thread_pool_if_worth(c->threads, c->n), c->n, project_gradient, &g);
    for (size_t i = 0; i < c->n_skipped; i++)
        memset(gradient + 3 * (size_t)c->skipped[i], 0, 3 * sizeof *gradient);
}
