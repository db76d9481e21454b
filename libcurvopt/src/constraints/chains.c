/* Chains of edges whose limit curves follow given curves. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/chains.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "constraints/freedom.h"
#include "mesh/crease.h"
#include "surface/vertex_mask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Largest second derivative of the curve, by numbers of vertices, in parts of the edge at an open chain's end, with
 * which that edge's middle is held: a curve that bends by a radian along the edge. With more the surface beyond the end
 * would fold, on a grid that is too coarse for the curve; on finer levels it is less. */
static const double MOST_BENT = 1;

void co_chain_free(co_chain *chain) {
    free(chain->vertex);
    co_cubic_spline_free(&chain->parameter);
    co_cubic_spline_free(&chain->curve);
    *chain = (co_chain){0};
}

void co_chains_free(co_chains *chains) {
    for (int32_t i = 0; i < chains->n; i++)
        co_chain_free(&chains->item[i]);
    free(chains->item);
    *chains = (co_chains){0};
}

int co_chains_hold_any(const co_chains *chains) {
    int holds = 0;
    for (int32_t k = 0; k < chains->n; k++)
        holds |= chains->item[k].stiffness == 0;
    return holds;
}

int32_t co_chain_edges(const co_chain *chain) {
    return chain->n - (chain->is_closed ? 0 : 1);
}

int32_t co_chains_find_edge(const curvopt_mesh *m, int32_t from, int32_t to) {
    const int32_t first = m->vertex_corner[from];
    for (int32_t h = first; h >= 0;) {
        const int32_t before = co_mesh_prev(m, h);
        if (co_mesh_destination(m, h) == to)
            return h;
        if (m->corner_vertex[before] == to)
            return before;
        h = co_mesh_rotate(m, h);
        if (h == first)
            return -1;
    }
    return -1;
}

/* Half-edge of edge i. */
static int32_t edge_of(const curvopt_mesh *m, const co_chain *chain, int32_t i) {
    return co_chains_find_edge(m, chain->vertex[i], chain->vertex[(i + 1) % chain->n]);
}

int32_t co_chains_subdivide(const curvopt_mesh *m, co_chains *chains, curvopt_error *error) {
    for (int32_t k = 0; k < chains->n; k++) {
        co_chain *chain = &chains->item[k];
        const int32_t n_edges = co_chain_edges(chain);
        int32_t *fine = CO_NEW(int32_t, chain->n + n_edges);
        if (!fine)
            return co_status_no_memory(error);
        for (int32_t i = 0; i < chain->n; i++)
            fine[2 * i] = chain->vertex[i];
        for (int32_t i = 0; i < n_edges; i++)
            fine[2 * i + 1] = m->info.n_vertices + m->edge[edge_of(m, chain, i)];
        free(chain->vertex);
        chain->vertex = fine;
        chain->n += n_edges;
        chain->step /= 2;
    }
    return CURVOPT_OK;
}

void co_chain_place(const co_chain *chain, double at, double place[3]) {
    double parameter[3], jet[9];
    const double number = at * chain->step;
    co_cubic_spline_at(&chain->parameter, number, parameter);
    co_cubic_spline_at(&chain->curve, parameter[0] + chain->turn * number, jet);
    memcpy(place, jet, 3 * sizeof *place);
}

/* ---------------------------------------------------------------------------------- the middles at the ends -- */

static void count_entry(int32_t vertex, double weight, void *context) {
    (void)vertex;
    (void)weight;
    ++*(int *)context;
}

/* Whether the limit curve ends at this vertex as it ends there: at corners, and across boundaries and creases, a
 * chain's curve has no curvature, and no freedom more. h: the chain's edge. */
static int is_end_of_surface(const curvopt_mesh *m, int32_t v, int32_t h) {
    enum { CORNER = 1, CURVE = 3 }; /* entries of masks */
    int n_entries = 0;
    co_vertex_mask_visit(m, v, count_entry, &n_entries);
    return n_entries == CORNER || (n_entries == CURVE && !co_crease_is_infinite(co_crease_edge(m, h)));
}

static void add_middle(const curvopt_mesh *m, const co_chain *chain, int32_t edge, int32_t h, double stiffness,
                       co_surface_values *values) {
    static const double on_quad[4][2] = {{0.5, 0}, {1, 0.5}, {0.5, 1}, {0, 0.5}};
    co_surface_value *f = &values->item[values->n++];
    const int32_t first = m->face_start[m->corner_face[h]];
    const int is_quad = co_mesh_face_size(m, m->corner_face[h]) == 4;
    *f = (co_surface_value){.number = chain->number,
                            .vertex = -1,
                            .corner = is_quad ? first : h,
                            .uv = {is_quad ? on_quad[h - first][0] : 1, is_quad ? on_quad[h - first][1] : 0},
                            .freedom = CO_FREEDOM_NONE,
                            .pivot = -1,
                            .is_optional = 1,
                            .stiffness = stiffness};
    co_chain_place(chain, edge + 0.5, f->anchor);
}

/* Whether the curve at one end of an open chain bends by MOST_BENT at most, along the edge there. Its limit curve there
 * is a B-spline whose next control point lies beyond the end. Where the edge's middle is held, that point is the
 * curve's second derivative off the straight way on. */
static int is_straight_enough(const co_chain *chain, int32_t edge, int32_t end) {
    double from[3], to[3], parameter[3], jet[9], square = 0;
    co_chain_place(chain, edge, from);
    co_chain_place(chain, edge + 1, to);
    co_cubic_spline_at(&chain->parameter, end * chain->step, parameter);
    co_cubic_spline_at(&chain->curve, parameter[0], jet);
    for (int c = 0; c < 3; c++) {
        const double second = jet[6 + c] * parameter[1] * parameter[1] + jet[3 + c] * parameter[2];
        square += second * second;
    }
    return sqrt(square) * chain->step * chain->step <= MOST_BENT * co_distance3(from, to);
}

/* Half-edges of the first and the last edge of a chain if their middles count on this level, else -1; of a single edge
 * that counts the second is -1. */
static void find_end_edges(const curvopt_mesh *m, const co_chain *chain, int32_t h[2]) {
    const int32_t last = co_chain_edges(chain) - 1;
    h[0] = h[1] = -1;
    if (chain->is_closed)
        return;
    const int32_t first = edge_of(m, chain, 0), end = edge_of(m, chain, last);
    if (!is_end_of_surface(m, chain->vertex[0], first) && is_straight_enough(chain, 0, 0))
        h[0] = first;
    if (!is_end_of_surface(m, chain->vertex[last + 1], end) && is_straight_enough(chain, last, last + 1) &&
        !(h[0] >= 0 && last == 0))
        h[1] = end;
}

/* Takes what is of chains off. */
static void drop(co_surface_values *values) {
    int32_t n = 0;
    for (int32_t i = 0; i < values->n; i++)
        if (!values->item[i].is_optional)
            values->item[n++] = values->item[i];
    values->n = n;
    co_sparse_rows_free(&values->rows);
}

void co_chains_hold_middles(const curvopt_mesh *m, const co_chains *chains, co_surface_values *values) {
    drop(values);
    for (int32_t k = 0; k < chains->n; k++) {
        const co_chain *chain = &chains->item[k];
        int32_t h[2];
        if (chain->stiffness > 0)
            continue;
        find_end_edges(m, chain, h);
        for (int end = 0; end < 2; end++)
            if (h[end] >= 0)
                add_middle(m, chain, end == 0 ? 0 : co_chain_edges(chain) - 1, h[end], 0, values);
    }
}

/* ------------------------------------------------------------------------------------------------- springs -- */

static void add_vertex(const curvopt_mesh *m, const co_chain *chain, int32_t i, double stiffness,
                       co_surface_values *values) {
    co_surface_value *f = &values->item[values->n++];
    *f = (co_surface_value){.number = chain->number,
                            .vertex = chain->vertex[i],
                            .corner = m->vertex_corner[chain->vertex[i]],
                            .freedom = CO_FREEDOM_NONE,
                            .pivot = -1,
                            .is_optional = 1,
                            .stiffness = stiffness};
    co_chain_place(chain, i, f->anchor);
}

/* Quadrature over the chain's parameter: by Simpson's rule on end edges whose middles count, on all others by the
 * trapezoidal rule. */
static void draw(const curvopt_mesh *m, const co_chain *chain, co_surface_values *values) {
    const double whole = chain->stiffness * chain->step; /* of an edge */
    const int32_t n_edges = co_chain_edges(chain);
    int32_t h[2];
    find_end_edges(m, chain, h);
    for (int32_t i = 0; i < chain->n; i++) {
        double stiffness = 0;
        for (int32_t edge = i - 1; edge <= i; edge++) { /* a closed chain's have no middles */
            const int has_middle = (edge == 0 && h[0] >= 0) || (edge == n_edges - 1 && h[1] >= 0);
            const int exists = chain->is_closed || (edge >= 0 && edge < n_edges);
            stiffness += exists ? whole / (has_middle ? 6 : 2) : 0;
        }
        add_vertex(m, chain, i, stiffness, values);
    }
    for (int end = 0; end < 2; end++)
        if (h[end] >= 0)
            add_middle(m, chain, end == 0 ? 0 : n_edges - 1, h[end], whole * 2 / 3, values);
}

int32_t co_chains_draw(const curvopt_mesh *m, const co_chains *chains, co_surface_values *values,
                       curvopt_error *error) {
    size_t n = 0;
    drop(values);
    for (int32_t k = 0; k < chains->n; k++)
        n += chains->item[k].stiffness > 0 ? (size_t)chains->item[k].n + 2 : 0;
    if (!n)
        return CURVOPT_OK;
    co_surface_value *item = CO_NEW(co_surface_value, (size_t)values->n + n);
    if (!item)
        return co_status_no_memory(error);
    if (values->n)
        memcpy(item, values->item, (size_t)values->n * sizeof *item);
    free(values->item);
    values->item = item;
    for (int32_t k = 0; k < chains->n; k++)
        if (chains->item[k].stiffness > 0)
            draw(m, &chains->item[k], values);
    return CURVOPT_OK;
}
