/* Sharp edges and vertices of a mesh: checked, stored, handed on to meshes made from it (source: crease.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/crease.h"

#include "base/memory.h"
#include "curvopt_experimental.h"

#include <math.h>

/* A half-edge of the edge between two vertices, or -1. Edges are numbered by their smaller vertex, then their larger
 * one (mesh.c). */
static int32_t find_edge(const curvopt_mesh *m, int32_t a, int32_t b) {
    int32_t low = 0, high = m->info.n_edges, smaller = a < b ? a : b, larger = a < b ? b : a;
    while (low < high) {
        int32_t middle = low + (high - low) / 2, h = m->edge_corner[middle];
        int32_t c = m->corner_vertex[h], d = co_mesh_destination(m, h), first = c < d ? c : d, second = c < d ? d : c;
        if (first == smaller && second == larger)
            return h;
        if (first < smaller || (first == smaller && second < larger))
            low = middle + 1;
        else
            high = middle;
    }
    return -1;
}

static int32_t check_sharpness(const char *what, int32_t index, double sharpness, curvopt_error *error) {
    if (sharpness >= 0 && sharpness <= CURVOPT_SHARPNESS_MAX)
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, index,
                          "%s %d has sharpness %g; it must be 0 to %g (from %g on it is infinite)", what, index,
                          sharpness, CURVOPT_SHARPNESS_MAX, CURVOPT_SHARPNESS_INFINITE);
}

static int32_t check_vertex(const curvopt_mesh *m, const char *what, int32_t index, int32_t v, curvopt_error *error) {
    if (v >= 0 && v < m->info.n_vertices)
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, index, "%s %d names vertex %d; the cage has vertices 0 to %d",
                          what, index, v, m->info.n_vertices - 1);
}

static int32_t set_edges(curvopt_mesh *m, const curvopt_creases *c, curvopt_error *error) {
    if (c->n_creases == 0)
        return CURVOPT_OK;
    m->edge_sharpness = CO_NEW(double, m->info.n_edges);
    if (!m->edge_sharpness)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < c->n_creases; i++) {
        int32_t a = c->crease_vertices[2 * i], b = c->crease_vertices[2 * i + 1];
        int32_t status = check_sharpness("crease", i, c->crease_sharpness[i], error);
        if (status == CURVOPT_OK)
            status = check_vertex(m, "crease", i, a, error);
        if (status == CURVOPT_OK)
            status = check_vertex(m, "crease", i, b, error);
        if (status != CURVOPT_OK)
            return status;
        int32_t h = find_edge(m, a, b);
        if (h < 0)
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                                  "crease %d runs from vertex %d to vertex %d, which no edge of the cage joins", i, a,
                                  b);
        m->edge_sharpness[m->edge[h]] = c->crease_sharpness[i];
    }
    return CURVOPT_OK;
}

static int32_t set_vertices(curvopt_mesh *m, const curvopt_creases *c, curvopt_error *error) {
    int corners = c->boundary_rule == CURVOPT_BOUNDARY_RULE_CORNERS && m->info.n_boundary_edges > 0;
    if (c->n_corners == 0 && !corners)
        return CURVOPT_OK;
    m->vertex_sharpness = CO_NEW(double, m->info.n_vertices);
    if (!m->vertex_sharpness)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < c->n_corners; i++) {
        int32_t status = check_sharpness("corner", i, c->corner_sharpness[i], error);
        if (status == CURVOPT_OK)
            status = check_vertex(m, "corner", i, c->corner_vertices[i], error);
        if (status != CURVOPT_OK)
            return status;
        m->vertex_sharpness[c->corner_vertices[i]] = c->corner_sharpness[i];
    }
    for (int32_t v = 0; corners && v < m->info.n_vertices; v++)
        if (co_mesh_is_boundary_vertex(m, v) && m->valence[v] == 2 && co_mesh_flaw_of(m, v) == CO_MESH_SOUND)
            m->vertex_sharpness[v] = CURVOPT_SHARPNESS_INFINITE;
    return CURVOPT_OK;
}

int32_t co_crease_set(curvopt_mesh *m, const curvopt_creases *c, curvopt_error *error) {
    if (c->boundary_rule != CURVOPT_BOUNDARY_RULE_SMOOTH && c->boundary_rule != CURVOPT_BOUNDARY_RULE_CORNERS)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "boundary_rule is %d; it must be 0 or 1",
                              c->boundary_rule);
    if (c->reserved != 0)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "reserved is %d; it must be 0", c->reserved);
    if (c->n_creases < 0 || c->n_corners < 0)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "%d creases and %d corners", c->n_creases,
                              c->n_corners);
    if ((c->n_creases > 0 && (!c->crease_vertices || !c->crease_sharpness)) ||
        (c->n_corners > 0 && (!c->corner_vertices || !c->corner_sharpness)))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "an array of the creases is NULL");
    m->boundary_rule = c->boundary_rule;
    int32_t status = set_edges(m, c, error);
    return status == CURVOPT_OK ? set_vertices(m, c, error) : status;
}

/* Room in *to for what `from` has; destroys *to on failure. */
static int32_t allocate_like(const curvopt_mesh *from, curvopt_mesh **to, curvopt_error *error) {
    curvopt_mesh *m = *to;
    m->boundary_rule = from->boundary_rule;
    if (from->edge_sharpness)
        m->edge_sharpness = CO_NEW(double, m->info.n_edges);
    if (from->vertex_sharpness)
        m->vertex_sharpness = CO_NEW(double, m->info.n_vertices);
    if ((!from->edge_sharpness || m->edge_sharpness) && (!from->vertex_sharpness || m->vertex_sharpness))
        return CURVOPT_OK;
    co_mesh_destroy(m);
    *to = NULL;
    return co_status_no_memory(error);
}

int32_t co_crease_inherit(const curvopt_mesh *from, const uint8_t *keep, const int32_t *vertex_of, curvopt_mesh **to,
                          curvopt_error *error) {
    int32_t status = allocate_like(from, to, error), at = 0;
    if (status != CURVOPT_OK)
        return status;
    curvopt_mesh *m = *to;
    for (int32_t h = 0; from->edge_sharpness && h < from->info.n_corners; h++)
        if (!keep || keep[from->corner_face[h]])
            m->edge_sharpness[m->edge[at++]] = from->edge_sharpness[from->edge[h]];
    for (int32_t v = 0; from->vertex_sharpness && v < m->info.n_vertices; v++)
        m->vertex_sharpness[v] = from->vertex_sharpness[vertex_of ? vertex_of[v] : v];
    return CURVOPT_OK;
}

int32_t co_crease_soften(const curvopt_mesh *from, curvopt_mesh **fine, curvopt_error *error) {
    int32_t status = allocate_like(from, fine, error);
    if (status != CURVOPT_OK)
        return status;
    curvopt_mesh *m = *fine;
    for (int32_t h = 0; from->edge_sharpness && h < from->info.n_corners; h++) {
        double leaving = from->edge_sharpness[from->edge[h]];
        double arriving = from->edge_sharpness[from->edge[co_mesh_prev(from, h)]];
        /* child h runs: vertex, middle of the edge leaving it, face, middle of the edge arriving */
        m->edge_sharpness[m->edge[4 * h]] = co_crease_softened(leaving);
        m->edge_sharpness[m->edge[4 * h + 3]] = co_crease_softened(arriving);
    }
    for (int32_t v = 0; from->vertex_sharpness && v < from->info.n_vertices; v++)
        m->vertex_sharpness[v] = co_crease_softened(from->vertex_sharpness[v]);
    return CURVOPT_OK;
}

double co_crease_largest_fading(const curvopt_mesh *m) {
    double largest = 0;
    for (int32_t e = 0; m->edge_sharpness && e < m->info.n_edges; e++)
        if (co_crease_is_fading(m->edge_sharpness[e]))
            largest = fmax(largest, m->edge_sharpness[e]);
    for (int32_t v = 0; m->vertex_sharpness && v < m->info.n_vertices; v++)
        if (co_crease_is_fading(m->vertex_sharpness[v]))
            largest = fmax(largest, m->vertex_sharpness[v]);
    return largest;
}

/* ------------------------------------------------------------------------------------- exported functions -- */

static int32_t set_or_destroy(curvopt_mesh **mesh, const curvopt_creases *creases, curvopt_error *error) {
    int32_t status = creases ? co_crease_set(*mesh, creases, error) : CURVOPT_OK;
    if (status != CURVOPT_OK) {
        co_mesh_destroy(*mesh);
        *mesh = NULL;
    }
    return status;
}

int32_t curvopt_mesh_create_creased(int32_t n_vertices, int32_t n_faces, const int32_t *face_sizes,
                                    const int32_t *face_vertices, const curvopt_creases *creases, curvopt_mesh **out,
                                    curvopt_error *error) {
    int32_t status = co_mesh_create(n_vertices, n_faces, face_sizes, face_vertices, out, error);
    return status == CURVOPT_OK ? set_or_destroy(out, creases, error) : status;
}

int32_t curvopt_mesh_create_part(int32_t n_vertices, int32_t n_faces, const int32_t *face_sizes,
                                 const int32_t *face_vertices, const curvopt_creases *creases, curvopt_mesh **out,
                                 curvopt_error *error) {
    int32_t status = co_mesh_create(n_vertices, n_faces, face_sizes, face_vertices, out, error);
    return status == CURVOPT_OK ? set_or_destroy(out, creases, error) : status;
}

void curvopt_mesh_count_creases(const curvopt_mesh *m, int32_t *n_creases, int32_t *n_corners) {
    *n_creases = *n_corners = 0;
    for (int32_t e = 0; m->edge_sharpness && e < m->info.n_edges; e++)
        *n_creases += m->edge_sharpness[e] > 0;
    for (int32_t v = 0; m->vertex_sharpness && v < m->info.n_vertices; v++)
        *n_corners += m->vertex_sharpness[v] > 0;
}

void curvopt_mesh_get_creases(const curvopt_mesh *m, int32_t *crease_vertices, double *crease_sharpness,
                              int32_t *corner_vertices, double *corner_sharpness) {
    for (int32_t e = 0; m->edge_sharpness && e < m->info.n_edges; e++)
        if (m->edge_sharpness[e] > 0) {
            *crease_vertices++ = m->corner_vertex[m->edge_corner[e]];
            *crease_vertices++ = co_mesh_destination(m, m->edge_corner[e]);
            *crease_sharpness++ = m->edge_sharpness[e];
        }
    for (int32_t v = 0; m->vertex_sharpness && v < m->info.n_vertices; v++)
        if (m->vertex_sharpness[v] > 0) {
            *corner_vertices++ = v;
            *corner_sharpness++ = m->vertex_sharpness[v];
        }
}
