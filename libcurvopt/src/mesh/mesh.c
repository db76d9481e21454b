/* Polygons as half-edges: validation and construction in linear time. SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/mesh.h"

#include "base/memory.h"
#include "base/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Refinement needs V + E + F <= 2^31 and four children a face; this stays well inside. */
enum { MOST_ELEMENTS = INT32_MAX / 8 };

static int32_t check_polygons(int32_t n_vertices, int32_t n_faces, const int32_t *face_sizes,
                              const int32_t *face_vertices, int32_t *n_corners, curvopt_error *error) {
    if (!face_sizes || !face_vertices)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "the face arrays are NULL");
    if (n_vertices < 1 || n_faces < 1)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "the cage has %d vertices and %d faces", n_vertices,
                              n_faces);
    if (n_vertices > MOST_ELEMENTS)
        return co_status_fail(error, CURVOPT_ERROR_SIZE, -1, "more than %d vertices", MOST_ELEMENTS);
    int64_t total = 0;
    for (int32_t f = 0; f < n_faces; f++) {
        if (face_sizes[f] < 3)
            return co_status_fail(error, CURVOPT_ERROR_TOPOLOGY, f, "face %d has %d corners; at least 3 are needed", f,
                                  face_sizes[f]);
        total += face_sizes[f];
        if (total > MOST_ELEMENTS)
            return co_status_fail(error, CURVOPT_ERROR_SIZE, f, "more than %d face corners", MOST_ELEMENTS);
    }
    for (int64_t c = 0, f = 0, end = face_sizes[0]; c < total; c++) {
        if (c == end)
            end += face_sizes[++f];
        if (face_vertices[c] < 0 || face_vertices[c] >= n_vertices)
            return co_status_fail(error, CURVOPT_ERROR_TOPOLOGY, (int32_t)f,
                                  "face %d names vertex %d; the cage has vertices 0 to %d", (int32_t)f,
                                  face_vertices[c], n_vertices - 1);
    }
    *n_corners = (int32_t)total;
    return CURVOPT_OK;
}

static int32_t allocate(curvopt_mesh *m, curvopt_error *error) {
    const curvopt_mesh_info *n = &m->info;
    m->face_start = CO_NEW(int32_t, n->n_faces + 1);
    m->corner_vertex = CO_NEW(int32_t, n->n_corners);
    m->corner_face = CO_NEW(int32_t, n->n_corners);
    m->twin = CO_NEW(int32_t, n->n_corners);
    m->edge = CO_NEW(int32_t, n->n_corners);
    m->vertex_corner = CO_NEW(int32_t, n->n_vertices);
    m->valence = CO_NEW(int32_t, n->n_vertices);
    if (!m->face_start || !m->corner_vertex || !m->corner_face || !m->twin || !m->edge || !m->vertex_corner ||
        !m->valence)
        return co_status_no_memory(error);
    return CURVOPT_OK;
}

/* A vertex twice in one face; `last_face` remembers for each vertex the face that named it last. */
static int32_t check_repeated_vertices(const curvopt_mesh *m, int32_t *last_face, curvopt_error *error) {
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        last_face[v] = -1;
    for (int32_t h = 0; h < m->info.n_corners; h++) {
        int32_t v = m->corner_vertex[h], f = m->corner_face[h];
        if (last_face[v] == f)
            return co_status_fail(error, CURVOPT_ERROR_TOPOLOGY, f, "face %d names vertex %d twice", f, v);
        last_face[v] = f;
    }
    return CURVOPT_OK;
}

/* A vertex that is flawed in several ways has the flaw that comes first in co_mesh_flaw. */
static int32_t mark(curvopt_mesh *m, int32_t v, co_mesh_flaw flaw, curvopt_error *error) {
    if (!m->flaw)
        m->flaw = CO_NEW(uint8_t, m->info.n_vertices);
    if (!m->flaw)
        return co_status_no_memory(error);
    if (m->flaw[v] == CO_MESH_SOUND || flaw < m->flaw[v])
        m->flaw[v] = (uint8_t)flaw;
    return CURVOPT_OK;
}

/* corners_at [n_vertices] */
static int32_t list_isolated(curvopt_mesh *m, const int32_t *corners_at, curvopt_error *error) {
    int32_t n = 0, status = CURVOPT_OK;
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        n += corners_at[v] == 0;
    if (n == 0)
        return CURVOPT_OK;
    m->isolated = CO_NEW(int32_t, n);
    if (!m->isolated)
        return co_status_no_memory(error);
    for (int32_t v = 0; status == CURVOPT_OK && v < m->info.n_vertices; v++)
        if (corners_at[v] == 0) {
            m->vertex_corner[v] = -1;
            m->isolated[m->info.n_isolated++] = v;
            status = mark(m, v, CO_MESH_ISOLATED, error);
        }
    return status;
}

/* Stable counting sort of half-edges by the larger or smaller of their two vertices; start [n_vertices + 1]. */
static void sort_by_vertex(const curvopt_mesh *m, int want_larger, const int32_t *in, int32_t *out, int32_t *start) {
    int32_t n = m->info.n_corners;
    memset(start, 0, sizeof(int32_t) * ((size_t)m->info.n_vertices + 1));
    for (int32_t i = 0; i < n; i++) {
        int32_t h = in ? in[i] : i, a = m->corner_vertex[h], b = co_mesh_destination(m, h);
        start[((a > b) == want_larger ? a : b) + 1]++;
    }
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        start[v + 1] += start[v];
    for (int32_t i = 0; i < n; i++) {
        int32_t h = in ? in[i] : i, a = m->corner_vertex[h], b = co_mesh_destination(m, h);
        out[start[(a > b) == want_larger ? a : b]++] = h;
    }
}

static int same_edge(const curvopt_mesh *m, int32_t g, int32_t h) {
    int32_t a = m->corner_vertex[g], b = co_mesh_destination(m, g);
    int32_t c = m->corner_vertex[h], d = co_mesh_destination(m, h);
    return (a == c && b == d) || (a == d && b == c);
}

/* Pairs the half-edges that `sorted` has brought together and numbers the edges. */
static int32_t pair_half_edges(curvopt_mesh *m, const int32_t *sorted, curvopt_error *error) {
    int32_t n = m->info.n_corners, n_edges = 0, status = CURVOPT_OK;
    for (int32_t i = 0, count; status == CURVOPT_OK && i < n; i += count) {
        int32_t g = sorted[i], a = m->corner_vertex[g], b = co_mesh_destination(m, g);
        for (count = 0; i + count < n && same_edge(m, g, sorted[i + count]); count++) {
            m->edge[sorted[i + count]] = n_edges;
            m->twin[sorted[i + count]] = -1;
        }
        n_edges++;
        if (count == 1) {
            m->info.n_boundary_edges++;
        } else if (count == 2 && m->corner_vertex[sorted[i + 1]] == b) {
            m->twin[g] = sorted[i + 1];
            m->twin[sorted[i + 1]] = g;
        } else {
            co_mesh_flaw flaw = count == 2 ? CO_MESH_FLIPPED : CO_MESH_CROWDED;
            m->info.n_flawed_edges++;
            status = mark(m, a, flaw, error);
            if (status == CURVOPT_OK)
                status = mark(m, b, flaw, error);
        }
    }
    m->info.n_edges = n_edges;
    return status;
}

static int32_t build_edges(curvopt_mesh *m, int32_t *work, curvopt_error *error) {
    int32_t n = m->info.n_corners;
    int32_t *by_larger = work, *sorted = work + n, *start = work + 2 * (size_t)n;
    sort_by_vertex(m, 1, NULL, by_larger, start);
    sort_by_vertex(m, 0, by_larger, sorted, start);
    int32_t status = pair_half_edges(m, sorted, error);
    if (status != CURVOPT_OK)
        return status;
    m->edge_corner = CO_NEW(int32_t, m->info.n_edges);
    if (!m->edge_corner)
        return co_status_no_memory(error);
    for (int32_t h = n - 1; h >= 0; h--)
        m->edge_corner[m->edge[h]] = h;
    return CURVOPT_OK;
}

enum { NO_CURVE = 1000 }; /* a boundary edge counts for so many flawed ones, and is thus never one of two */

/* Where two flawed edges, of three faces or more at least one, and no boundary meet, OpenSubdiv has a crease
 * (Vtr::Level): a closed fan has as many edges as faces, and each edge of k faces takes off k / 2 - 1 of that. */
static int32_t mark_curves(curvopt_mesh *m, const int32_t *corners_at, curvopt_error *error) {
    size_t n = (size_t)m->info.n_vertices;
    int32_t status = CURVOPT_OK;
    if (!m->info.n_flawed_edges)
        return CURVOPT_OK;
    int32_t *n_edges = CO_NEW(int32_t, 2 * n + (size_t)m->info.n_edges), *n_flawed;
    if (!n_edges)
        return co_status_no_memory(error);
    n_flawed = n_edges + n;
    for (int32_t h = 0; h < m->info.n_corners; h++)
        n_flawed[n + (size_t)m->edge[h]]++; /* faces of each edge, behind */
    for (int32_t e = 0; e < m->info.n_edges; e++) {
        int32_t h = m->edge_corner[e], ends[2] = {m->corner_vertex[h], co_mesh_destination(m, h)};
        for (int k = 0; k < 2; k++) {
            n_edges[ends[k]]++;
            n_flawed[ends[k]] += m->twin[h] >= 0 ? 0 : n_flawed[n + (size_t)e] > 1 ? 1 : NO_CURVE;
        }
    }
    for (size_t v = 0; status == CURVOPT_OK && v < n; v++)
        if (n_flawed[v] == 2 && corners_at[v] > n_edges[v])
            status = mark(m, (int32_t)v, CO_MESH_CURVE, error);
    free(n_edges);
    return status;
}

/* One walk round a vertex: a sound one's meets all of its corners. */
static int32_t walk_round(curvopt_mesh *m, int32_t v, int32_t n_corners, curvopt_error *error) {
    int32_t first = m->vertex_corner[v], h = first, met = 0, status = CURVOPT_OK;
    if (n_corners == 0)
        return CURVOPT_OK;
    do {
        met++;
        h = co_mesh_rotate(m, h);
    } while (h >= 0 && h != first);
    if (met != n_corners)
        status = mark(m, v, CO_MESH_PINCHED, error);
    int is_sound = status == CURVOPT_OK && co_mesh_flaw_of(m, v) == CO_MESH_SOUND;
    m->valence[v] = is_sound ? met + (h < 0) : n_corners;
    if (m->valence[v] > m->info.max_valence)
        m->info.max_valence = m->valence[v];
    if (is_sound && h >= 0 && m->valence[v] != 4)
        m->info.n_extraordinary++;
    return status;
}

/* corners_at [n_vertices] is work space. */
static int32_t build_fans(curvopt_mesh *m, int32_t *corners_at, curvopt_error *error) {
    memset(corners_at, 0, sizeof(int32_t) * (size_t)m->info.n_vertices);
    for (int32_t h = m->info.n_corners - 1; h >= 0; h--) {
        corners_at[m->corner_vertex[h]]++;
        m->vertex_corner[m->corner_vertex[h]] = h;
    }
    for (int32_t h = 0; h < m->info.n_corners; h++)
        if (m->twin[h] < 0)
            m->vertex_corner[m->corner_vertex[h]] = h;
    int32_t status = list_isolated(m, corners_at, error);
    if (status == CURVOPT_OK)
        status = mark_curves(m, corners_at, error);
    for (int32_t v = 0; status == CURVOPT_OK && v < m->info.n_vertices; v++)
        status = walk_round(m, v, corners_at[v], error);
    return status;
}

/* Connected components by flooding faces; `stack` has room for every face, `seen` too. */
static void count_components(curvopt_mesh *m, int32_t *stack, int32_t *seen) {
    memset(seen, 0, sizeof(int32_t) * (size_t)m->info.n_faces);
    for (int32_t seed = 0; seed < m->info.n_faces; seed++) {
        if (seen[seed])
            continue;
        int32_t depth = 0;
        m->info.n_components++;
        seen[seed] = 1;
        stack[depth++] = seed;
        while (depth > 0) {
            int32_t f = stack[--depth];
            for (int32_t h = m->face_start[f]; h < m->face_start[f + 1]; h++) {
                int32_t g = m->twin[h] < 0 ? f : m->corner_face[m->twin[h]];
                if (!seen[g]) {
                    seen[g] = 1;
                    stack[depth++] = g;
                }
            }
        }
    }
}

static int32_t build(curvopt_mesh *m, const int32_t *face_sizes, const int32_t *face_vertices, curvopt_error *error) {
    int32_t status = allocate(m, error), *work = NULL;
    if (status != CURVOPT_OK)
        return status;
    m->info.all_quads = 1;
    for (int32_t f = 0, c = 0; f < m->info.n_faces; f++) {
        m->info.all_quads &= face_sizes[f] == 4;
        for (int32_t k = 0; k < face_sizes[f]; k++, c++)
            m->corner_face[c] = f;
        m->face_start[f + 1] = c;
    }
    memcpy(m->corner_vertex, face_vertices, sizeof(int32_t) * (size_t)m->info.n_corners);

    work = CO_NEW(int32_t, 2 * (size_t)m->info.n_corners + (size_t)m->info.n_vertices + 1);
    if (!work)
        return co_status_no_memory(error);
    status = check_repeated_vertices(m, work + 2 * (size_t)m->info.n_corners, error);
    if (status == CURVOPT_OK)
        status = build_edges(m, work, error);
    if (status == CURVOPT_OK)
        status = build_fans(m, work + 2 * (size_t)m->info.n_corners, error);
    if (status == CURVOPT_OK) {
        count_components(m, work, work + m->info.n_corners);
        m->info.euler = m->info.n_vertices - m->info.n_isolated - m->info.n_edges + m->info.n_faces;
    }
    free(work);
    return status;
}

int32_t co_mesh_create(int32_t n_vertices, int32_t n_faces, const int32_t *face_sizes, const int32_t *face_vertices,
                       curvopt_mesh **out, curvopt_error *error) {
    if (!out)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "out is NULL");
    *out = NULL;
    int32_t n_corners = 0;
    int32_t status = check_polygons(n_vertices, n_faces, face_sizes, face_vertices, &n_corners, error);
    if (status != CURVOPT_OK)
        return status;
    curvopt_mesh *m = CO_NEW(curvopt_mesh, 1);
    if (!m)
        return co_status_no_memory(error);
    m->info.n_vertices = n_vertices;
    m->info.n_faces = n_faces;
    m->info.n_corners = n_corners;
    status = build(m, face_sizes, face_vertices, error);
    if (status != CURVOPT_OK) {
        co_mesh_destroy(m);
        return status;
    }
    *out = m;
    return CURVOPT_OK;
}

void co_mesh_destroy(curvopt_mesh *m) {
    if (!m)
        return;
    free(m->face_start);
    free(m->corner_vertex);
    free(m->corner_face);
    free(m->twin);
    free(m->edge);
    free(m->vertex_corner);
    free(m->valence);
    free(m->flaw);
    free(m->isolated);
    free(m->edge_corner);
    free(m->edge_sharpness);
    free(m->vertex_sharpness);
    free(m);
}

/* Of the triangle a, b, c. */
static double triangle_area(const double *a, const double *b, const double *c) {
    double normal[3];
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        normal[i] = (b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j]);
    }
    return co_length3(normal) / 2;
}

/* The area of a face; to area [n_vertices], if it is not NULL, its vertices' parts of it are added. */
static double face_area(const curvopt_mesh *m, const double *x, int32_t f, double *area) {
    int32_t first = m->face_start[f], end = m->face_start[f + 1];
    double whole = 0, middle[3] = {0, 0, 0};
    for (int32_t h = first; h < end; h++)
        for (size_t c = 0; c < 3; c++)
            middle[c] += x[3 * (size_t)m->corner_vertex[h] + c] / (end - first);
    for (int32_t h = first; h < end; h++) {
        int32_t v = m->corner_vertex[h], w = co_mesh_destination(m, h);
        double half = triangle_area(x + 3 * (size_t)v, x + 3 * (size_t)w, middle) / 2;
        whole += 2 * half;
        if (area) {
            area[v] += half;
            area[w] += half;
        }
    }
    return whole;
}

double co_mesh_vertex_areas(const curvopt_mesh *m, const double *x, double *area) {
    double whole = 0;
    memset(area, 0, sizeof *area * (size_t)m->info.n_vertices);
    for (int32_t f = 0; f < m->info.n_faces; f++)
        whole += face_area(m, x, f, area);
    return whole;
}

double co_mesh_area(const curvopt_mesh *m, const uint8_t *left_out, const double *x) {
    double sum = 0;
    for (int32_t f = 0; f < m->info.n_faces; f++)
        if (!left_out || !left_out[f])
            sum += face_area(m, x, f, NULL);
    return sum;
}

/* ------------------------------------------------------------------------------------------------- checks -- */

/* The faces of a flawed edge, as far as a sentence names them: half-edges in their order; how many there are. */
static int32_t half_edges_of(const curvopt_mesh *m, int32_t edge, int32_t first[3]) {
    int32_t n = 0;
    for (int32_t h = 0; h < m->info.n_corners; h++)
        if (m->edge[h] == edge) {
            if (n < 3)
                first[n] = h;
            n++;
        }
    return n;
}

static int32_t check_edges(const curvopt_mesh *m, curvopt_error *error) {
    int32_t h[3];
    for (int32_t e = 0; e < m->info.n_edges && m->info.n_flawed_edges; e++) {
        int32_t a = m->corner_vertex[m->edge_corner[e]], b = co_mesh_destination(m, m->edge_corner[e]);
        if (m->twin[m->edge_corner[e]] >= 0 || !co_mesh_flaw_of(m, a) || !co_mesh_flaw_of(m, b))
            continue;
        int32_t n = half_edges_of(m, e, h);
        if (n > 2)
            return co_status_fail(error, CURVOPT_ERROR_TOPOLOGY, m->corner_face[h[2]],
                                  "the edge between vertices %d and %d is not manifold: %d faces meet there", a, b, n);
        if (n == 2)
            return co_status_fail(error, CURVOPT_ERROR_TOPOLOGY, m->corner_face[h[1]],
                                  "faces %d and %d both run from vertex %d to %d: one of them is flipped",
                                  m->corner_face[h[0]], m->corner_face[h[1]], a, b);
    }
    return CURVOPT_OK;
}

static int32_t check_vertex(const curvopt_mesh *m, int32_t v, curvopt_error *error) {
    int32_t first = m->vertex_corner[v], h = first, met = 0;
    if (co_mesh_flaw_of(m, v) != CO_MESH_PINCHED)
        return CURVOPT_OK;
    do {
        met++;
        h = co_mesh_rotate(m, h);
    } while (h >= 0 && h != first);
    return co_status_fail(error, CURVOPT_ERROR_TOPOLOGY, v,
                          "vertex %d joins separate fans of faces: %d of its %d faces are connected round it", v, met,
                          m->valence[v]);
}

int32_t co_mesh_check_manifold(const curvopt_mesh *m, curvopt_error *error) {
    if (m->info.n_isolated)
        return co_status_fail(error, CURVOPT_ERROR_TOPOLOGY, m->isolated[0], "vertex %d is isolated: no face uses it",
                              m->isolated[0]);
    int32_t status = check_edges(m, error);
    for (int32_t v = 0; status == CURVOPT_OK && v < m->info.n_vertices; v++)
        status = check_vertex(m, v, error);
    return status;
}

/* Whether edge e belongs to a face that is not left out. */
static int counts(const curvopt_mesh *m, const uint8_t *left_out, int32_t e) {
    int32_t h = m->edge_corner[e];
    return !left_out || !left_out[m->corner_face[h]] || (m->twin[h] >= 0 && !left_out[m->corner_face[m->twin[h]]]);
}

double co_mesh_mean_edge(const curvopt_mesh *m, const uint8_t *left_out, const double *x) {
    double sum = 0;
    int32_t n = 0;
    for (int32_t e = 0; e < m->info.n_edges; e++) {
        const double *a = x + 3 * (size_t)m->corner_vertex[m->edge_corner[e]];
        const double *b = x + 3 * (size_t)co_mesh_destination(m, m->edge_corner[e]);
        if (!counts(m, left_out, e))
            continue;
        sum += sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
        n++;
    }
    return sum / n;
}
