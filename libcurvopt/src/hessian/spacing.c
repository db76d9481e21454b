/* Vertices in the middle of their neighbours. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/spacing.h"

#include "base/memory.h"
#include "mesh/crease.h"

#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------------------------- neighbours -- */

/* Whether edge e pulls at its ends: where a curve runs through one, those of the curve do. */
static int pulls(const curvopt_mesh *m, int32_t e, int32_t v, const int32_t *n_sharp) {
    if (n_sharp[v] > 2 || co_crease_is_infinite(co_crease_vertex(m, v)))
        return 0;
    return n_sharp[v] < 2 || co_crease_is_infinite(co_crease_edge(m, m->edge_corner[e]));
}

/* Both ends of edge e; 0 if neither can move. */
static int ends_of(const curvopt_mesh *m, const co_dof_map *dofs, int32_t e, int32_t end[2]) {
    int32_t h = m->edge_corner[e];
    end[0] = m->corner_vertex[h];
    end[1] = co_mesh_destination(m, h);
    return dofs->node[end[0]] >= 0 || dofs->node[end[1]] >= 0;
}

/* n_sharp [n_vertices]: edges of boundaries and infinitely sharp creases at each; n_edges: all edges. */
static void count_edges(const curvopt_mesh *m, int32_t *n_sharp, int32_t *n_edges) {
    for (int32_t e = 0; e < m->info.n_edges; e++) {
        int32_t h = m->edge_corner[e], sharp = co_crease_is_infinite(co_crease_edge(m, h));
        const int32_t end[2] = {m->corner_vertex[h], co_mesh_destination(m, h)};
        for (int k = 0; k < 2; k++) {
            n_sharp[end[k]] += sharp;
            n_edges[end[k]]++;
        }
    }
}

static void find_neighbours(const curvopt_mesh *m, const int32_t *n_sharp, co_spacing *s) {
    int32_t end[2];
    for (int32_t e = 0; e < m->info.n_edges; e++) {
        if (!ends_of(m, s->dofs, e, end))
            continue;
        for (int k = 0; k < 2; k++)
            if (pulls(m, e, end[k], n_sharp))
                s->neighbour[s->start[end[k]] + s->count[end[k]]++] = end[1 - k];
    }
}

int32_t co_spacing_create(const curvopt_mesh *m, const co_dof_map *dofs, co_spacing *s, curvopt_error *error) {
    size_t n = (size_t)m->info.n_vertices;
    int32_t status = CURVOPT_OK, *n_sharp = CO_NEW(int32_t, n);
    *s = (co_spacing){.dofs = dofs,
                      .n_vertices = m->info.n_vertices,
                      .start = CO_NEW(int32_t, n + 1),
                      .count = CO_NEW(int32_t, n),
                      .neighbour = CO_NEW(int32_t, 2 * (size_t)m->info.n_edges),
                      .scale = CO_NEW(double, n)};
    if (n_sharp && s->start && s->count && s->neighbour && s->scale) {
        count_edges(m, n_sharp, s->start + 1);
        for (size_t v = 0; v < n; v++)
            s->start[v + 1] += s->start[v];
        find_neighbours(m, n_sharp, s);
    } else {
        status = co_status_no_memory(error);
        co_spacing_free(s);
    }
    free(n_sharp);
    return status;
}

void co_spacing_free(co_spacing *s) {
    free(s->start);
    free(s->count);
    free(s->neighbour);
    free(s->scale);
    *s = (co_spacing){0};
}

/* ----------------------------------------------------------------------------------------------- the sum -- */

static void add(double factor, const double *x, double *to) {
    for (int c = 0; c < 3; c++)
        to[c] += factor * x[c];
}

static double square(const double *d) {
    return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}

/* A vertex less the mean of its neighbours; 0 without any. */
static void find_offset(const co_spacing *s, const double *x, int32_t v, double offset[3]) {
    offset[0] = offset[1] = offset[2] = 0;
    for (int32_t i = s->start[v]; i < s->start[v] + s->count[v]; i++) {
        add(1.0 / s->count[v], x + 3 * (size_t)v, offset);
        add(-1.0 / s->count[v], x + 3 * (size_t)s->neighbour[i], offset);
    }
}

void co_spacing_weigh(co_spacing *s, const double *x, double worth) {
    for (int32_t v = 0; v < s->n_vertices; v++) {
        double sum = 0;
        for (int32_t i = s->start[v]; i < s->start[v] + s->count[v]; i++) {
            double edge[3] = {0, 0, 0};
            add(1, x + 3 * (size_t)v, edge);
            add(-1, x + 3 * (size_t)s->neighbour[i], edge);
            sum += square(edge);
        }
        s->scale[v] = sum > 0 ? s->count[v] / sum : 0;
    }
    s->weight = 1;
    double value = co_spacing_value(s, x, NULL);
    s->weight = value > 0 ? worth / value : 0;
}

double co_spacing_value(const co_spacing *s, const double *x, double *gradient) {
    double sum = 0, offset[3];
    if (gradient)
        memset(gradient, 0, 3 * sizeof *gradient * (size_t)s->n_vertices);
    for (int32_t v = 0; v < s->n_vertices; v++) {
        double pull = 2 * s->weight * s->scale[v];
        find_offset(s, x, v, offset);
        sum += s->scale[v] * square(offset);
        if (!gradient)
            continue;
        for (int32_t i = s->start[v]; i < s->start[v] + s->count[v]; i++) {
            add(pull / s->count[v], offset, gradient + 3 * (size_t)v);
            add(-pull / s->count[v], offset, gradient + 3 * (size_t)s->neighbour[i]);
        }
    }
    return s->weight * sum;
}

static void add_block(co_sparse_hessian *hessian, int32_t v, int32_t w, double stiffness) {
    const double block[9] = {stiffness, 0, 0, 0, stiffness, 0, 0, 0, stiffness};
    co_sparse_hessian_add_block(hessian, v, w, block);
}

void co_spacing_add_hessian(const co_spacing *s, co_sparse_hessian *hessian) {
    for (int32_t v = 0; s->weight > 0 && v < s->n_vertices; v++) {
        double part = -1.0 / s->count[v], stiffness = 2 * s->weight * s->scale[v];
        if (stiffness == 0)
            continue;
        add_block(hessian, v, v, stiffness);
        for (int32_t i = s->start[v]; i < s->start[v] + s->count[v]; i++) {
            add_block(hessian, v, s->neighbour[i], part * stiffness);
            for (int32_t j = s->start[v]; j <= i; j++)
                add_block(hessian, s->neighbour[i], s->neighbour[j], part * part * stiffness);
        }
    }
}
