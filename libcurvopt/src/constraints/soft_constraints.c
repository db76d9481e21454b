/* Soft constraints: vertices that springs pull back. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/soft_constraints.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Relative difference up to which stiffnesses count as equal: sums over a patch and its mirror image differ by rounding
 * (libcurvopt/notes/80-soft-constraints.md). */
static const double SAME_STIFFNESS = 1e-9;

/* To be freed whatever the status. */
static int32_t allocate(int32_t n_vertices, co_soft_constraints *s, curvopt_error *error) {
    size_t n = (size_t)n_vertices;
    *s = (co_soft_constraints){.stiffness = CO_NEW(double, n),
                               .freedom = CO_NEW(uint8_t, n),
                               .direction = CO_NEW(double, 3 * n),
                               .anchor = CO_NEW(double, 3 * n),
                               .original = CO_NEW(double, 3 * n),
                               .reach = (double)INFINITY};
    int is_complete = s->stiffness && s->freedom && s->direction && s->anchor && s->original;
    return is_complete ? CURVOPT_OK : co_status_no_memory(error);
}

void co_soft_constraints_free(co_soft_constraints *s) {
    free(s->stiffness);
    free(s->freedom);
    free(s->direction);
    free(s->anchor);
    free(s->original);
    *s = (co_soft_constraints){0};
}

int32_t co_soft_constraints_copy(const curvopt_mesh *m, const co_soft_constraints *from, co_soft_constraints *to,
                                 curvopt_error *error) {
    size_t n = (size_t)m->info.n_vertices;
    *to = (co_soft_constraints){0};
    if (!from->stiffness)
        return CURVOPT_OK;
    int32_t status = allocate(m->info.n_vertices, to, error);
    if (status != CURVOPT_OK) {
        co_soft_constraints_free(to);
        return status;
    }
    memcpy(to->stiffness, from->stiffness, n * sizeof(double));
    memcpy(to->freedom, from->freedom, n);
    memcpy(to->direction, from->direction, 3 * n * sizeof(double));
    memcpy(to->anchor, from->anchor, 3 * n * sizeof(double));
    memcpy(to->original, from->original, 3 * n * sizeof(double));
    to->reach = from->reach;
    to->weighed_by = from->weighed_by;
    return CURVOPT_OK;
}

/* ------------------------------------------------------------------------------------------------- patches -- */

/* The vertex that stands for v's patch (union-find); paths to it get shorter. */
static int32_t find(int32_t *parent, int32_t v) {
    while (parent[v] != v)
        v = parent[v] = parent[parent[v]];
    return v;
}

/* mass [n_vertices]: max w / sum w of the connected patch of vertices with a weight that a vertex is in. */
static int32_t find_masses(const curvopt_mesh *m, const double *weight, double *mass, curvopt_error *error) {
    int32_t n = m->info.n_vertices, *parent = CO_NEW(int32_t, n);
    double *sum = CO_NEW(double, n), *most = CO_NEW(double, n);
    int32_t status = parent && sum && most ? CURVOPT_OK : co_status_no_memory(error);
    for (int32_t v = 0; status == CURVOPT_OK && v < n; v++)
        parent[v] = v;
    for (int32_t h = 0; status == CURVOPT_OK && h < m->info.n_corners; h++) {
        int32_t a = m->corner_vertex[h], b = co_mesh_destination(m, h);
        if (weight[a] > 0 && weight[b] > 0)
            parent[find(parent, a)] = find(parent, b);
    }
    for (int32_t v = 0; status == CURVOPT_OK && v < n; v++) {
        int32_t patch = find(parent, v);
        sum[patch] += weight[v];
        most[patch] = fmax(most[patch], weight[v]);
    }
    for (int32_t v = 0; status == CURVOPT_OK && v < n; v++)
        mass[v] = weight[v] > 0 ? most[find(parent, v)] / sum[find(parent, v)] : 0;
    free(parent);
    free(sum);
    free(most);
    return status;
}

int32_t co_soft_constraints_create(const curvopt_mesh *m, const double *xyz, const double *weight,
                                   const uint8_t *freedom, const double *direction, co_soft_constraints *out,
                                   curvopt_error *error) {
    size_t n = (size_t)m->info.n_vertices;
    int32_t status = allocate(m->info.n_vertices, out, error);
    if (status == CURVOPT_OK)
        status = find_masses(m, weight, out->stiffness, error);
    if (status != CURVOPT_OK) {
        co_soft_constraints_free(out);
        return status;
    }
    for (size_t v = 0; v < n; v++)
        out->stiffness[v] *= weight[v] < 1 ? weight[v] / (1 - weight[v]) : 0;
    memcpy(out->freedom, freedom, n);
    memcpy(out->direction, direction, 3 * n * sizeof(double));
    memcpy(out->anchor, xyz, 3 * n * sizeof(double));
    memcpy(out->original, xyz, 3 * n * sizeof(double));
    return CURVOPT_OK;
}

int32_t co_soft_constraints_add_all(const curvopt_mesh *m, const double *xyz, const double *stiffness, double reach,
                                    co_soft_constraints *s, curvopt_error *error) {
    size_t n = (size_t)m->info.n_vertices;
    int32_t status = s->stiffness ? CURVOPT_OK : allocate(m->info.n_vertices, s, error);
    if (status != CURVOPT_OK) {
        co_soft_constraints_free(s);
        return status;
    }
    memcpy(s->anchor, xyz, 3 * n * sizeof(double));
    memcpy(s->original, xyz, 3 * n * sizeof(double));
    s->reach = reach;
    for (size_t v = 0; v < n; v++)
        if (s->stiffness[v] == 0 || s->freedom[v] == CO_FREEDOM_NONE) {
            s->stiffness[v] += stiffness[v];
            s->freedom[v] = CO_FREEDOM_NONE;
        }
    return CURVOPT_OK;
}

int co_soft_constraints_alike(const co_soft_constraints *s, int32_t v, int32_t w) {
    if (!s->stiffness)
        return 1;
    return fabs(s->stiffness[v] - s->stiffness[w]) <= SAME_STIFFNESS * s->stiffness[v] &&
           (s->stiffness[v] == 0 || s->freedom[v] == s->freedom[w]);
}

void co_soft_constraints_drop_beyond(co_soft_constraints *s, int32_t v, const double x[3]) {
    double square = 0;
    if (!s->stiffness || !co_soft_constraints_has_end(s, v))
        return;
    for (int c = 0; c < 3; c++)
        square += (x[c] - s->anchor[3 * (size_t)v + (size_t)c]) * (x[c] - s->anchor[3 * (size_t)v + (size_t)c]);
    if (4 * square > s->reach * s->reach)
        s->stiffness[v] = 0;
}

/* ------------------------------------------------------------------------------------------- subdivision -- */

/* Whether all vertices of a face have springs of one kind. */
static int is_constrained_face(const curvopt_mesh *m, const co_soft_constraints *s, int32_t f) {
    int32_t first = m->corner_vertex[m->face_start[f]];
    for (int32_t h = m->face_start[f]; h < m->face_start[f + 1]; h++) {
        int32_t v = m->corner_vertex[h];
        if (s->stiffness[v] == 0 || s->freedom[v] != s->freedom[first])
            return 0;
        if (s->freedom[v] != CO_FREEDOM_NONE &&
            !co_freedom_same_direction(s->direction + 3 * (size_t)v, s->direction + 3 * (size_t)first))
            return 0;
    }
    return 1;
}

/* Vertex `to` of the finer cage gets a part of the stiffness of vertex `from`, and its freedom. */
static void inherit(const co_soft_constraints *coarse, int32_t from, double stiffness, const double *anchor,
                    co_soft_constraints *fine, int32_t to) {
    fine->stiffness[to] += stiffness;
    fine->freedom[to] = coarse->freedom[from];
    memcpy(fine->direction + 3 * (size_t)to, coarse->direction + 3 * (size_t)from, 3 * sizeof(double));
    memcpy(fine->anchor + 3 * (size_t)to, anchor + 3 * (size_t)to, 3 * sizeof(double));
}

/* A vertex gives each of its constrained faces an equal part of its stiffness, and of that a quarter to each of the
 * four corners of the child at the vertex:
 *
 *     v---e---.      4 constrained faces at v of stiffness k: each of them gives k / 16 to v, e, f, d; in the end v
 *     |   |          has k / 4 from its own four faces, the edge points e and d have k / 8 from v and as much from the
 *     d---f          edge's other end, and the face point f has k / 16 from each of the face's corners: inside a patch
 *     |              all have k / 4
 *
 * n_faces_of [n_vertices]: number of constrained faces at each. */
static void distribute(const curvopt_mesh *m, const co_soft_constraints *s, const int32_t *n_faces_of,
                       co_soft_constraints *out) {
    int32_t n = m->info.n_vertices, n_edges = m->info.n_edges;
    for (int32_t h = 0; h < m->info.n_corners; h++) {
        int32_t v = m->corner_vertex[h], f = m->corner_face[h];
        if (!n_faces_of[v] || !is_constrained_face(m, s, f))
            continue;
        int32_t child[4] = {v, n + m->edge[h], n + n_edges + f, n + m->edge[co_mesh_prev(m, h)]};
        for (int k = 0; k < 4; k++)
            inherit(s, v, s->stiffness[v] / (4 * n_faces_of[v]), out->original, out, child[k]);
    }
    for (int32_t v = 0; v < n; v++)
        if (!n_faces_of[v] && s->stiffness[v] > 0)
            inherit(s, v, s->stiffness[v], co_soft_constraints_has_end(s, v) ? out->original : s->anchor, out, v);
}

int32_t co_soft_constraints_subdivide(const curvopt_mesh *m, const curvopt_mesh *fine, const co_sparse_rows *rows,
                                      co_soft_constraints *springs, curvopt_error *error) {
    co_soft_constraints out = {0};
    if (!springs->stiffness)
        return CURVOPT_OK;
    int32_t *n_faces_of = CO_NEW(int32_t, m->info.n_vertices);
    int32_t status = n_faces_of ? allocate(fine->info.n_vertices, &out, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        for (int32_t f = 0; f < m->info.n_faces; f++)
            for (int32_t h = m->face_start[f]; is_constrained_face(m, springs, f) && h < m->face_start[f + 1]; h++)
                n_faces_of[m->corner_vertex[h]]++;
        co_sparse_rows_apply(rows, springs->original, out.original);
        out.reach = springs->reach;
        out.weighed_by = springs->weighed_by;
        distribute(m, springs, n_faces_of, &out);
        co_soft_constraints_free(springs);
        *springs = out;
    } else {
        co_soft_constraints_free(&out);
    }
    free(n_faces_of);
    return status;
}
