/* Mirror planes that the user chose. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/mirror_planes.h"

#include "base/memory.h"
#include "mesh/crease.h"
#include "mesh/similarity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Search for the vertex or face that makes a cage unsymmetric about one plane. */
typedef struct diagnosis {
    const curvopt_mesh *mesh;
    const double *xyz;
    const co_constraints *constraints;
    int axis;
    double position;  /* coordinate of the plane along the axis */
    double tolerance; /* a length */
    int32_t *partner; /* [n_vertices] */
} diagnosis;

typedef struct ranked {
    double at;
    int32_t vertex;
} ranked;

typedef struct directed {
    int32_t from, to, corner;
} directed;

static int by_place(const void *a, const void *b) {
    const ranked *x = a, *y = b;
    if (x->at != y->at)
        return x->at > y->at ? 1 : -1;
    return (x->vertex > y->vertex) - (x->vertex < y->vertex);
}

static int by_ends(const void *a, const void *b) {
    const directed *x = a, *y = b;
    int from = (x->from > y->from) - (x->from < y->from);
    return from ? from : (x->to > y->to) - (x->to < y->to);
}

/* Distance from the mirror image of v to w. */
static double distance(const diagnosis *q, int32_t v, int32_t w) {
    const double *x = q->xyz + 3 * (size_t)v, *y = q->xyz + 3 * (size_t)w;
    double square = 0;
    for (int c = 0; c < 3; c++) {
        double off = (c == q->axis ? 2 * q->position - x[c] : x[c]) - y[c];
        square += off * off;
    }
    return sqrt(square);
}

static int32_t refuse_vertex(const diagnosis *q, int32_t v, curvopt_error *error) {
    int32_t nearest = 0;
    for (int32_t w = 1; w < q->mesh->info.n_vertices; w++)
        if (distance(q, v, w) < distance(q, v, nearest))
            nearest = w;
    return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, v,
                          "the cage is not symmetric about the plane %c = %.6g: vertex %d has no "
                          "partner, the nearest to its mirror image is vertex %d, %.3g away",
                          "xyz"[q->axis], q -> position, v, nearest, distance(q, v, nearest));
}

/* order [n_vertices]: along the axis. */
static void sort_along(const diagnosis *q, ranked *order) {
    int32_t n = q->mesh->info.n_vertices;
    for (int32_t v = 0; v < n; v++)
        order[v] = (ranked){q->xyz[3 * (size_t)v + (size_t)q->axis], v};
    qsort(order, (size_t)n, sizeof *order, by_place);
}

/* Partners, by a window in the order along the axis; how many vertices have none, *first of them. */
static int32_t find_partners(diagnosis *q, const ranked *order, int32_t *first) {
    int32_t n = q->mesh->info.n_vertices, n_alone = 0;
    for (int32_t v = 0; v < n; v++) {
        double image = 2 * q->position - q->xyz[3 * (size_t)v + (size_t)q->axis];
        int32_t low = 0, high = n;
        while (low < high) {
            int32_t middle = (low + high) / 2;
            if (order[middle].at < image - q->tolerance)
                low = middle + 1;
            else
                high = middle;
        }
        while (low < n && order[low].at <= image + q->tolerance && distance(q, v, order[low].vertex) > q->tolerance)
            low++;
        int alone = low == n || distance(q, v, order[low].vertex) > q->tolerance;
        if (alone && n_alone++ == 0)
            *first = v;
        q->partner[v] = alone ? -1 : order[low].vertex;
    }
    return n_alone;
}

/* Chooses the plane that pairs most vertices: through their mean, through the origin, or halfway between the ends. A
 * single vertex that is astray moves the mean, and all would look unpaired. Returns the first vertex without a partner,
 * or -1. */
static int32_t choose_plane(diagnosis *q, const ranked *order) {
    const double mean = fabs(q->position) > q->tolerance ? q->position : 0;
    const double candidate[3] = {mean, 0, (order[0].at + order[q->mesh->info.n_vertices - 1].at) / 2};
    int32_t fewest = INT32_MAX, first = -1, best = 0;
    for (int k = 0; k < 3; k++) {
        q->position = candidate[k];
        int32_t n_alone = find_partners(q, order, &first);
        if (n_alone < fewest) {
            fewest = n_alone;
            best = k;
        }
    }
    q->position = candidate[best];
    return find_partners(q, order, &first) ? first : -1;
}

/* Whether half-edge h and its image k have the same creases and constraints. */
static int alike(const diagnosis *q, int32_t h, int32_t k) {
    const curvopt_mesh *m = q->mesh;
    int32_t v = m->corner_vertex[h], w = q->partner[v];
    return co_crease_alike(co_crease_edge(m, h), co_crease_edge(m, k)) &&
           co_crease_alike(co_crease_vertex(m, v), co_crease_vertex(m, w)) &&
           (!q->constraints->freedom || q->constraints->freedom[v] == q->constraints->freedom[w]) &&
           co_soft_constraints_alike(&q->constraints->springs, v, w);
}

/* Vertices have partners; names the first face that has none, or the first vertex that differs from its partner. */
static int32_t refuse_connection(const diagnosis *q, curvopt_error *error) {
    const curvopt_mesh *m = q->mesh;
    size_t n = (size_t)m->info.n_corners;
    int32_t face = -1, vertex = -1;
    directed *edges = CO_NEW(directed, n);
    if (!edges)
        return co_status_no_memory(error);
    for (int32_t h = 0; h < m->info.n_corners; h++)
        edges[h] = (directed){m->corner_vertex[h], co_mesh_destination(m, h), h};
    qsort(edges, n, sizeof *edges, by_ends);
    for (int32_t h = 0; face < 0 && vertex < 0 && h < m->info.n_corners; h++) {
        directed image = {q->partner[co_mesh_destination(m, h)], q->partner[m->corner_vertex[h]], 0};
        const directed *found = bsearch(&image, edges, n, sizeof *edges, by_ends);
        if (!found)
            face = m->corner_face[h];
        else if (!alike(q, h, found->corner))
            vertex = m->corner_vertex[h];
    }
    free(edges);
    if (face >= 0)
        return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, face,
                              "the cage is not symmetric about the plane %c = %.6g: its vertices are, "
                              "but face %d has no partner",
                              "xyz"[q->axis], q -> position, face);
    if (vertex >= 0)
        return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, vertex,
                              "the cage is not symmetric about the plane %c = %.6g: vertex %d and its "
                              "partner %d differ in creases or in how they are held",
                              "xyz"[q->axis], q -> position, vertex, q -> partner[vertex]);
    return co_status_fail(
        error, CURVOPT_ERROR_GEOMETRY, -1,
        "the cage is not symmetric about the plane %c = %.6g: its vertices and faces are, but not the "
        "directions in which vertices may move, or what the surface goes through",
        "xyz"[q->axis], q -> position);
}

int32_t co_mirror_planes_create(const curvopt_mesh *m, const double *xyz, const co_constraints *constraints,
                                int32_t planes, co_symmetry *out, curvopt_error *error) {
    double centroid[3], radius = co_similarity_mesh_frame(m, xyz, centroid);
    int missing;
    int32_t status = co_symmetry_of_planes(m, xyz, constraints, planes, out, &missing, error);
    if (status != CURVOPT_OK || missing < 0)
        return status;
    diagnosis q = {m,
                   xyz,
                   constraints,
                   missing,
                   centroid[missing],
                   CO_SYMMETRY_TOLERANCE * radius,
                   CO_NEW(int32_t, m->info.n_vertices)};
    ranked *order = CO_NEW(ranked, m->info.n_vertices);
    status = q.partner && order ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        sort_along(&q, order);
        int32_t alone = choose_plane(&q, order);
        status = alone >= 0 ? refuse_vertex(&q, alone, error) : refuse_connection(&q, error);
    }
    free(q.partner);
    free(order);
    return status;
}

int32_t co_mirror_planes_symmetrize(const curvopt_mesh *m, const co_symmetry *s, double *xyz, curvopt_error *error) {
    size_t n = (size_t)m->info.n_vertices;
    double centroid[3], *mean = CO_NEW(double, 3 * n);
    if (!mean)
        return co_status_no_memory(error);
    co_similarity_mesh_frame(m, xyz, centroid);
    for (int32_t g = 0; g < s->order; g++) /* the matrices are diagonal */
        for (int32_t v = 0; v < m->info.n_vertices; v++)
            for (size_t c = 0; c < 3; c++)
                mean[3 * (size_t)co_symmetry_vertex(s, m, g, v) + c] +=
                    s->matrix[9 * (size_t)g + 4 * c] * (xyz[3 * (size_t)v + c] - centroid[c]) / s->order;
    for (size_t i = 0; i < 3 * n; i++)
        xyz[i] = centroid[i % 3] + mean[i];
    free(mean);
    return CURVOPT_OK;
}
