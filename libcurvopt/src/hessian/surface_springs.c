/* Springs of points and tangents of the surface. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/surface_springs.h"

#include "base/memory.h"
#include "constraints/freedom.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void co_surface_springs_free(co_surface_springs *s) {
    free(s->start);
    free(s->vertex);
    free(s->by);
    free(s->rest);
    *s = (co_surface_springs){0};
}

/* A node that a row depends on. */
typedef struct part {
    int32_t node, vertex;
    double by[9]; /* derivative of the row's value by its variables: rows x, y, z */
} part;

/* A row that is being made over the variables. */
typedef struct making {
    const co_interpolation *map;
    const co_dof_map *dofs;
    int32_t *at; /* [n_nodes] place of a node in `part`; -1 */
    part *part;  /* [..] */
    int32_t n;
    double rest[3]; /* what no variable moves */
} making;

/* Adds `weight` times position v. */
static void add_position(making *m, int32_t v, double weight) {
    const co_dof_map *r = m->dofs;
    const int32_t node = r->node[v];
    for (size_t c = 0; c < 3 && r->offset; c++)
        m->rest[c] += weight * r->offset[3 * (size_t)v + c];
    if (node < 0)
        return;
    if (m->at[node] < 0) {
        m->at[node] = m->n;
        m->part[m->n++] = (part){.node = node, .vertex = v};
    }
    for (int c = 0; c < 3; c++)
        for (int j = 0; j < co_dof_map_dimension(r, node); j++)
            m->part[m->at[node]].by[3 * c + j] += weight * r->basis[9 * (size_t)v + (size_t)(3 * c + j)];
}

/* Adds `weight` times vertex v of the cage. */
static void add_vertex(making *m, int32_t v, double weight) {
    const co_sparse_rows *cage = &m->map->cage;
    const int32_t i = co_interpolation_find(m->map, v);
    if (i < 0) {
        add_position(m, v, weight);
        return;
    }
    for (size_t e = cage->start[i]; e < cage->start[i + 1]; e++)
        add_position(m, cage->column[e], weight * cage->value[e]);
}

static int by_node(const void *a, const void *b) {
    const int32_t p = ((const part *)a)->node, q = ((const part *)b)->node;
    return (p > q) - (p < q);
}

/* How many positions a row can depend on at most. */
static size_t most_parts(const co_sparse_rows *rows, const co_interpolation *map, int32_t row) {
    size_t most = 0;
    for (size_t e = rows->start[row]; e < rows->start[row + 1]; e++) {
        const int32_t i = co_interpolation_find(map, rows->column[e]);
        most += i < 0 ? 1 : map->cage.start[i + 1] - map->cage.start[i];
    }
    return most;
}

/* Row k of `rows`, whose parts ascend. */
static void make_row(const co_sparse_rows *rows, int32_t k, making *m) {
    m->n = 0;
    memset(m->rest, 0, sizeof m->rest);
    for (size_t e = rows->start[k]; e < rows->start[k + 1]; e++)
        add_vertex(m, rows->column[e], rows->value[e]);
    for (int32_t i = 0; i < m->n; i++)
        m->at[m->part[i].node] = -1;
    if (m->n)
        qsort(m->part, (size_t)m->n, sizeof *m->part, by_node);
}

/* x = factor Q x */
static void take(const double free_part[9], double factor, double x[3]) {
    const double was[3] = {x[0], x[1], x[2]};
    for (int c = 0; c < 3; c++) {
        x[c] = factor * was[c];
        for (int d = 0; d < 3; d++)
            x[c] -= factor * free_part[3 * c + d] * was[d];
    }
}

/* Spring k of value f, whose row has been made, at the end of `out`. */
static void add_spring(const co_surface_value *f, const making *m, const double centroid[3], double radius,
                       double scale, int32_t k, co_surface_springs *out) {
    const size_t n = (size_t)m->n, first = out->start[k];
    const double factor = sqrt(scale * f->stiffness) * (f->order ? radius : 1);
    double free_part[9], *rest = out->rest + 3 * (size_t)k;
    co_freedom_projector(f->freedom, f->direction, free_part);
    for (int c = 0; c < 3; c++)
        rest[c] = m->rest[c] - (f->order ? 0 : (f->anchor[c] - centroid[c]) / radius);
    take(free_part, factor, rest);
    for (size_t i = 0; i < n; i++) {
        const part *p = &m->part[i];
        out->vertex[first + i] = p->vertex;
        for (int j = 0; j < 3; j++) {
            double column[3] = {p->by[j], p->by[3 + j], p->by[6 + j]};
            take(free_part, factor, column);
            for (size_t c = 0; c < 3; c++) {
                co_node_derivative *d = &out->by[3 * first + c * n + i];
                d->node = p->node;
                d->by[j] = column[c];
            }
        }
    }
    out->start[k + 1] = first + n;
}

int32_t co_surface_springs_create(const co_surface_values *values, const co_interpolation *interpolation,
                                  const co_dof_map *dofs, const double centroid[3], double radius, double scale,
                                  co_surface_springs *out, curvopt_error *error) {
    making m = {.map = interpolation, .dofs = dofs};
    size_t all = 0, most = 0;
    for (int32_t k = 0; k < values->n; k++) {
        const size_t n = most_parts(&values->rows, interpolation, k);
        all += n;
        most = n > most ? n : most;
    }
    *out = (co_surface_springs){.n = values->n,
                                .dofs = dofs,
                                .start = CO_NEW(size_t, (size_t)values->n + 1),
                                .vertex = CO_NEW(int32_t, all),
                                .by = CO_NEW(co_node_derivative, 3 * all),
                                .rest = CO_NEW(double, 3 * (size_t)values->n)};
    m.at = CO_NEW(int32_t, dofs->n_nodes);
    m.part = CO_NEW(part, most);
    const int has_room = out->start && out->vertex && out->by && out->rest && m.at && m.part;
    for (int32_t i = 0; has_room && i < dofs->n_nodes; i++)
        m.at[i] = -1;
    for (int32_t k = 0; has_room && k < values->n; k++) {
        make_row(&values->rows, k, &m);
        add_spring(&values->item[k], &m, centroid, radius, scale, k, out);
    }
    free(m.at);
    free(m.part);
    if (has_room)
        return CURVOPT_OK;
    co_surface_springs_free(out);
    return co_status_no_memory(error);
}

static int32_t n_nodes(const co_surface_springs *s, int32_t k) {
    return (int32_t)(s->start[k + 1] - s->start[k]);
}

static const co_node_derivative *derivatives(const co_surface_springs *s, int32_t k, int c) {
    return s->by + 3 * s->start[k] + (size_t)c * (size_t)n_nodes(s, k);
}

double co_surface_springs_value(const co_surface_springs *s, const double *z, double weight, double *gradient) {
    const co_dof_map *dofs = s->dofs;
    double value = 0;
    for (int32_t k = 0; k < s->n; k++)
        for (int c = 0; c < 3; c++) {
            const co_node_derivative *d = derivatives(s, k, c);
            double r = s->rest[3 * (size_t)k + (size_t)c];
            for (int32_t i = 0; i < n_nodes(s, k); i++)
                for (int j = 0; j < co_dof_map_dimension(dofs, d[i].node); j++)
                    r += d[i].by[j] * z[dofs->first[d[i].node] + j];
            value += r * r / 2;
            for (int32_t i = 0; gradient && i < n_nodes(s, k); i++)
                for (int j = 0; j < co_dof_map_dimension(dofs, d[i].node); j++)
                    gradient[dofs->first[d[i].node] + j] += weight * r * d[i].by[j];
        }
    return value;
}

void co_surface_springs_add_hessian(const co_surface_springs *s, double weight, co_sparse_hessian *hessian) {
    for (int32_t k = 0; k < s->n; k++)
        for (int c = 0; c < 3; c++)
            co_sparse_hessian_add_square(hessian, n_nodes(s, k), derivatives(s, k, c), weight);
}

int32_t co_surface_springs_couple(const co_surface_springs *s, co_couplings *couplings, curvopt_error *error) {
    const int32_t before = couplings->n;
    const size_t end = couplings->start ? couplings->start[before] : 0;
    co_couplings more = {.n = before + s->n,
                         .start = CO_NEW(size_t, (size_t)before + (size_t)s->n + 1),
                         .vertex = CO_NEW(int32_t, end + s->start[s->n])};
    if (!more.start || !more.vertex) {
        co_couplings_free(&more);
        co_couplings_free(couplings);
        return co_status_no_memory(error);
    }
    if (couplings->start)
        memcpy(more.start, couplings->start, ((size_t)before + 1) * sizeof *more.start);
    if (end)
        memcpy(more.vertex, couplings->vertex, end * sizeof *more.vertex);
    for (int32_t k = 0; k < s->n; k++)
        more.start[before + k + 1] = end + s->start[k + 1];
    memcpy(more.vertex + end, s->vertex, s->start[s->n] * sizeof *more.vertex);
    co_couplings_free(couplings);
    *couplings = more;
    return CURVOPT_OK;
}
