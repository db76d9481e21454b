/* An evenly spaced cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/spacing.h"

#include <math.h>
#include <string.h>

/* Of what an edge is worth in the middle. */
static const double WALL = 0.1;
/* Of what all edges are worth, in what is short at first: a cage may begin with edges that have no length. */
static const double MOST = 100;

/* What an edge costs because it is short, and the derivatives by its length's square. */
typedef struct cost {
    double value, first, second;
} cost;

static cost cost_of(const co_spacing *s, double square) {
    const double part = s->shortest * s->shortest / square, t = part - 1;
    if (!(t > 0 && s->wall > 0))
        return (cost){0};
    return (cost){.value = s->wall * t * t * t,
                  .first = -3 * s->wall * t * t * part / square,
                  .second = 6 * s->wall * t * part * (part + t) / (square * square)};
}

double co_spacing_value(const co_spacing *s, const double *x, double *gradient) {
    const curvopt_mesh *mesh = s->edges.mesh;
    double sum = 0, walls = 0;
    co_cage_edge e;
    if (gradient)
        memset(gradient, 0, 3 * sizeof *gradient * (size_t)mesh->info.n_vertices);
    for (int32_t k = 0; k < mesh->info.n_edges; k++) {
        if (!co_cage_edges_find(&s->edges, x, k, &e))
            continue;
        const cost wall = cost_of(s, e.square);
        sum += e.square * e.square;
        walls += wall.value;
        for (size_t c = 0; gradient && c < 3; c++) {
            double force = (4 * s->weight * e.square + 2 * wall.first) * e.along[c];
            gradient[3 * (size_t)e.v + c] += force;
            gradient[3 * (size_t)e.w + c] -= force;
        }
    }
    return s->weight * sum + walls;
}

void co_spacing_weigh(co_spacing *s, const double *x, double worth, double shortest) {
    double sum = 0, walls = 0;
    int32_t n = 0;
    co_cage_edge e;
    s->shortest = shortest;
    s->wall = 1;
    for (int32_t k = 0; k < s->edges.mesh->info.n_edges; k++) {
        if (!co_cage_edges_find(&s->edges, x, k, &e))
            continue;
        sum += e.square * e.square;
        walls += cost_of(s, e.square).value;
        n++;
    }
    s->weight = sum > 0 ? worth / sum : 0;
    s->wall = n > 0 ? fmin(WALL * worth / n, MOST * worth / walls) : 0;
}

static void second_derivatives(const void *context, const co_cage_edge *e, double block[9]) {
    const co_spacing *s = context;
    const cost wall = cost_of(s, e->square);
    const double along = wall.value > 0 ? 2 * wall.first / e->square + 4 * wall.second : 0;
    for (int i = 0; i < 9; i++)
        block[i] = 4 * s->weight * ((i % 4 == 0) * e->square + 2 * e->along[i / 3] * e->along[i % 3]) +
                   along * e->along[i / 3] * e->along[i % 3];
}

int32_t co_spacing_add_hessian(const co_spacing *s, const double *x, co_sparse_hessian *hessian, curvopt_error *error) {
    return co_cage_edges_add_hessian(&s->edges, x, second_derivatives, s, hessian, error);
}
