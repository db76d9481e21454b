/* Catmull-Clark subdivision as rows over the coarse points.
 *
 * Follows: Catmull, Clark, "Recursively generated B-spline surfaces on arbitrary topological meshes", CAD 10(6), 1978;
 * boundaries and creases as uniform cubic B-spline curves, corners kept; while a sharpness fades below 1, the rules
 * before and after are mixed as OpenSubdiv's Sdc::Scheme does: by the mean sharpness of what fades at the vertex. Where
 * a cage is no manifold, vertices stay and edges are infinitely sharp, as OpenSubdiv has it.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/subdivide.h"

#include "base/memory.h"
#include "mesh/crease.h"

#include <math.h>
#include <stdlib.h>

/* Collects one row; entries on the same column are added up. A linear search for the column would be quadratic at
 * vertices of high valence; `slot` finds it at once. */
typedef struct row_builder {
    co_sparse_rows *rows;
    size_t *slot;      /* [n_vertices] entry that last held each column; of this row if it is from begin to end - 1 */
    int32_t row;       /* number of the row being built */
    size_t begin, end; /* entries of the row so far */
    int32_t *fan;      /* [n_fans] first half-edges of the open fans at vertices of CO_MESH_CURVE, by vertex */
    int32_t n_fans;    /* number of these */
    int32_t next_fan;  /* the first that has not been used */
} row_builder;

static void row_begin(row_builder *b, int32_t row) {
    b->row = row;
    b->begin = b->end = b->rows->start[row];
}

static void row_add(row_builder *b, int32_t column, double value) {
    size_t at = b->slot[column];
    if (at < b->begin || at >= b->end || b->rows->column[at] != column) {
        at = b->slot[column] = b->end++;
        b->rows->column[at] = column;
        b->rows->value[at] = 0;
    }
    b->rows->value[at] += value;
}

static void row_end(row_builder *b) {
    b->rows->start[b->row + 1] = b->end;
}

/* `weight` times the centroid of a face. */
static void row_add_face(row_builder *b, const curvopt_mesh *m, int32_t f, double weight) {
    double part = weight / co_mesh_face_size(m, f);
    for (int32_t h = m->face_start[f]; h < m->face_start[f + 1]; h++)
        row_add(b, m->corner_vertex[h], part);
}

/* Interior vertex of valence n: (F + 2 R + (n - 3) P) / n with F the mean of face points, R of edge midpoints. */
static void add_smooth_rule(row_builder *b, const curvopt_mesh *m, int32_t v, double weight) {
    int32_t first = m->vertex_corner[v], h = first;
    double n = m->valence[v];
    row_add(b, v, weight * ((n - 3) / n + 1 / n));
    do {
        row_add(b, co_mesh_destination(m, h), weight * (1 / (n * n)));
        row_add_face(b, m, m->corner_face[h], weight * (1 / (n * n)));
        h = co_mesh_rotate(m, h);
    } while (h != first);
}

/* The sharp edges round a vertex, now or one subdivision later. */
typedef struct sharp_edges {
    int32_t count;   /* number of sharp edges */
    int32_t ends[2]; /* other ends of the first two sharp edges */
    int is_corner;   /* whether the vertex keeps its place: it is sharp itself, or has three sharp edges and more */
} sharp_edges;

/* The sharpnesses at a vertex that this subdivision takes to 0. */
typedef struct fading {
    double sum;    /* sum of these sharpnesses */
    int32_t count; /* number of these sharpnesses */
} fading;

static void count_sharp(sharp_edges *s, double sharpness, int32_t end) {
    if (sharpness > 0) {
        if (s->count < 2)
            s->ends[s->count] = end;
        s->count++;
    }
}

static void note_fading(fading *f, double sharpness) {
    if (sharpness > 0 && co_crease_softened(sharpness) == 0) {
        f->sum += sharpness;
        f->count++;
    }
}

static void note_edge(double sharpness, int32_t end, sharp_edges state[2], fading *f) {
    count_sharp(&state[0], sharpness, end);
    count_sharp(&state[1], co_crease_softened(sharpness), end);
    note_fading(f, sharpness);
}

/* Fills state[0] with what is sharp at v now, state[1] with what is one subdivision later, *f with what fades.
 *
 * Example: two edges of sharpness 0.4 and a smooth rest. Now: a crease, weights 1/8 3/4 1/8; later: smooth. Both fade,
 * with mean 0.4, so that the row is 0.4 times the crease's and 0.6 times the smooth one (vertex_row). */
static void look_round(const curvopt_mesh *m, int32_t v, sharp_edges state[2], fading *f) {
    int32_t first = m->vertex_corner[v], h = first, last;
    double sharpness = co_crease_vertex(m, v);
    state[0] = (sharp_edges){.is_corner = sharpness > 0};
    state[1] = (sharp_edges){.is_corner = co_crease_softened(sharpness) > 0};
    *f = (fading){0};
    note_fading(f, sharpness);
    do {
        note_edge(co_crease_edge(m, h), co_mesh_destination(m, h), state, f);
        last = h;
        h = co_mesh_rotate(m, h);
    } while (h >= 0 && h != first);
    if (h < 0) /* the boundary edge that arrives */
        note_edge(CURVOPT_SHARPNESS_INFINITE, m->corner_vertex[co_mesh_prev(m, last)], state, f);
    for (int i = 0; i < 2; i++)
        state[i].is_corner |= state[i].count > 2;
}

static void add_rule(row_builder *b, const curvopt_mesh *m, int32_t v, const sharp_edges *s, double weight) {
    if (s->is_corner) {
        row_add(b, v, weight);
    } else if (s->count == 2) {
        row_add(b, v, weight * 0.75);
        row_add(b, s->ends[0], weight * 0.125);
        row_add(b, s->ends[1], weight * 0.125);
    } else { /* a dart, where one crease ends, is smooth */
        add_smooth_rule(b, m, v, weight);
    }
}

/* The same round a vertex of CO_MESH_CURVE: over all of its open fans, each between two flawed edges, which are those
 * of the first. */
static void look_round_curve(row_builder *b, const curvopt_mesh *m, int32_t v, sharp_edges state[2], fading *f) {
    double sharpness = co_crease_vertex(m, v);
    state[0] = (sharp_edges){.is_corner = sharpness > 0};
    state[1] = (sharp_edges){.is_corner = co_crease_softened(sharpness) > 0};
    *f = (fading){0};
    note_fading(f, sharpness);
    for (int fan = 0; b->next_fan < b->n_fans && m->corner_vertex[b->fan[b->next_fan]] == v; fan++, b->next_fan++) {
        int32_t first = b->fan[b->next_fan], last = first;
        for (int32_t h = first; h >= 0; last = h, h = co_mesh_rotate(m, h))
            if (h != first || fan == 0)
                note_edge(co_crease_edge(m, h), co_mesh_destination(m, h), state, f);
        if (fan == 0)
            note_edge(CURVOPT_SHARPNESS_INFINITE, m->corner_vertex[co_mesh_prev(m, last)], state, f);
    }
    for (int i = 0; i < 2; i++)
        state[i].is_corner |= state[i].count > 2;
}

static void vertex_row(row_builder *b, const curvopt_mesh *m, int32_t v) {
    sharp_edges state[2];
    fading f;
    co_mesh_flaw flaw = co_mesh_flaw_of(m, v);
    if (flaw != CO_MESH_SOUND && flaw != CO_MESH_CURVE) {
        row_add(b, v, 1);
        return;
    }
    if (flaw == CO_MESH_SOUND && !m->edge_sharpness && !m->vertex_sharpness && !co_mesh_is_boundary_vertex(m, v)) {
        add_smooth_rule(b, m, v, 1);
        return;
    }
    if (flaw == CO_MESH_CURVE)
        look_round_curve(b, m, v, state, &f);
    else
        look_round(m, v, state, &f);
    double weight = f.count ? fmin(f.sum / f.count, 1) : 1;
    add_rule(b, m, v, &state[0], weight);
    if (weight < 1)
        add_rule(b, m, v, &state[1], 1 - weight);
}

static void edge_row(row_builder *b, const curvopt_mesh *m, int32_t h) {
    double smooth = 1 - fmin(co_crease_edge(m, h), 1), end_weight = 0.5 - 0.25 * smooth;
    row_add(b, m->corner_vertex[h], end_weight);
    row_add(b, co_mesh_destination(m, h), end_weight);
    if (smooth > 0) {
        row_add_face(b, m, m->corner_face[h], 0.25 * smooth);
        row_add_face(b, m, m->corner_face[m->twin[h]], 0.25 * smooth);
    }
}

/* No more entries than this are ever needed: every face once a vertex, twice an edge, once itself. */
static size_t entries_bound(const curvopt_mesh *m) {
    size_t n = (size_t)m->info.n_vertices + 2 * (size_t)m->info.n_edges;
    for (int32_t f = 0; f < m->info.n_faces; f++) {
        size_t size = (size_t)co_mesh_face_size(m, f);
        n += size * size + size * size + size + size;
    }
    return n;
}

typedef struct fan_start {
    int32_t vertex, h;
} fan_start;

static int by_vertex(const void *a, const void *b) {
    const fan_start *x = a, *y = b;
    return x->vertex != y->vertex ? (x->vertex > y->vertex) - (x->vertex < y->vertex) : (x->h > y->h) - (x->h < y->h);
}

/* Fills b->fan. */
static int32_t list_fans(const curvopt_mesh *m, row_builder *b, curvopt_error *error) {
    int32_t n = 0;
    for (int32_t h = 0; m->flaw && h < m->info.n_corners; h++)
        n += m->twin[h] < 0 && co_mesh_flaw_of(m, m->corner_vertex[h]) == CO_MESH_CURVE;
    if (n == 0)
        return CURVOPT_OK;
    fan_start *start = CO_NEW(fan_start, n);
    b->fan = CO_NEW(int32_t, n);
    if (!start || !b->fan) {
        free(start);
        return co_status_no_memory(error);
    }
    for (int32_t h = 0; h < m->info.n_corners; h++)
        if (m->twin[h] < 0 && co_mesh_flaw_of(m, m->corner_vertex[h]) == CO_MESH_CURVE)
            start[b->n_fans++] = (fan_start){m->corner_vertex[h], h};
    qsort(start, (size_t)n, sizeof *start, by_vertex);
    for (int32_t i = 0; i < n; i++)
        b->fan[i] = start[i].h;
    free(start);
    return CURVOPT_OK;
}

static int32_t build_rows(const curvopt_mesh *m, co_sparse_rows *rows, curvopt_error *error) {
    const curvopt_mesh_info *n = &m->info;
    size_t *slot = CO_NEW(size_t, n->n_vertices);
    if (!slot)
        return co_status_no_memory(error);
    row_builder b = {.rows = rows, .slot = slot};
    int32_t status =
        co_sparse_rows_allocate(rows, n->n_vertices + n->n_edges + n->n_faces, n->n_vertices, entries_bound(m), error);
    if (status == CURVOPT_OK)
        status = list_fans(m, &b, error);
    if (status == CURVOPT_OK) {
        for (int32_t v = 0; v < n->n_vertices; v++) {
            row_begin(&b, v);
            vertex_row(&b, m, v);
            row_end(&b);
        }
        for (int32_t e = 0; e < n->n_edges; e++) {
            row_begin(&b, n->n_vertices + e);
            edge_row(&b, m, m->edge_corner[e]);
            row_end(&b);
        }
        for (int32_t f = 0; f < n->n_faces; f++) {
            row_begin(&b, n->n_vertices + n->n_edges + f);
            row_add_face(&b, m, f, 1);
            row_end(&b);
        }
    }
    free(slot);
    free(b.fan);
    return status;
}

static int32_t build_faces(const curvopt_mesh *m, curvopt_mesh **fine, curvopt_error *error) {
    const curvopt_mesh_info *n = &m->info;
    int32_t status, *sizes = CO_NEW(int32_t, n->n_corners), *vertices = CO_NEW(int32_t, 4 * (size_t)n->n_corners);
    if (!sizes || !vertices) {
        status = co_status_no_memory(error);
        goto done;
    }
    for (int32_t h = 0; h < n->n_corners; h++) {
        sizes[h] = 4;
        vertices[4 * h] = m->corner_vertex[h];
        vertices[4 * h + 1] = n->n_vertices + m->edge[h];
        vertices[4 * h + 2] = n->n_vertices + n->n_edges + m->corner_face[h];
        vertices[4 * h + 3] = n->n_vertices + m->edge[co_mesh_prev(m, h)];
    }
    status = co_mesh_create(n->n_vertices + n->n_edges + n->n_faces, n->n_corners, sizes, vertices, fine, error);
done:
    free(sizes);
    free(vertices);
    return status;
}

/* A curve runs smoothly through the middle of every flawed edge, also of flipped faces: as the two halves are in line,
 * it stays where it is whatever the rule, but the patches beside it are regular. */
static void mark_middles(const curvopt_mesh *m, curvopt_mesh *fine) {
    for (int32_t e = 0; fine->flaw && e < m->info.n_edges; e++) {
        uint8_t *flaw = &fine->flaw[m->info.n_vertices + e];
        if (m->twin[m->edge_corner[e]] < 0 && *flaw != CO_MESH_SOUND)
            *flaw = CO_MESH_CURVE;
    }
}

int32_t co_subdivide(const curvopt_mesh *mesh, curvopt_mesh **fine, co_sparse_rows *rows, curvopt_error *error) {
    *fine = NULL;
    if (mesh->info.n_corners > INT32_MAX / 32)
        return co_status_fail(error, CURVOPT_ERROR_SIZE, -1, "a cage of %d face corners is too large to subdivide",
                              mesh->info.n_corners);
    int32_t status = build_faces(mesh, fine, error);
    if (status == CURVOPT_OK)
        mark_middles(mesh, *fine);
    if (status == CURVOPT_OK)
        status = co_crease_soften(mesh, fine, error);
    if (status == CURVOPT_OK && rows) {
        status = build_rows(mesh, rows, error);
        if (status != CURVOPT_OK) {
            co_mesh_destroy(*fine);
            *fine = NULL;
        }
    }
    return status;
}

int32_t co_subdivide_cage(const curvopt_mesh *m, const double *xyz, curvopt_mesh **fine, co_sparse_rows *rows,
                          double **fine_xyz, curvopt_error *error) {
    *fine_xyz = NULL;
    int32_t status = co_subdivide(m, fine, rows, error);
    if (status != CURVOPT_OK)
        return status;
    *fine_xyz = CO_NEW(double, 3 * (size_t)rows->n_rows);
    if (*fine_xyz) {
        co_sparse_rows_apply(rows, xyz, *fine_xyz);
        return CURVOPT_OK;
    }
    co_mesh_destroy(*fine);
    *fine = NULL;
    co_sparse_rows_free(rows);
    return co_status_no_memory(error);
}
