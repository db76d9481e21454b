/* Ordered neighbourhoods of faces and vertices. SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/ring.h"

#include "mesh/crease.h"

static int is_cut(const curvopt_mesh *m, int32_t h) {
    return co_crease_is_infinite(co_crease_edge(m, h));
}

/* The sharp edges round a vertex, and whether it is sharp itself. */
typedef struct vertex_state {
    int32_t n_cuts; /* infinitely sharp edges, boundaries among them */
    int32_t cut;    /* a half-edge that leaves along an infinitely sharp edge, -1 if there is none */
    int is_fading;  /* whether anything there is sharp for some subdivisions only */
    int is_corner;  /* whether the corner rule holds: a sharp vertex, or three cuts and more */
} vertex_state;

/* The half-edge that the walk round h's vertex begins at; where several fans meet, round h's. */
static int32_t beginning(const curvopt_mesh *m, int32_t h) {
    int32_t v = m->corner_vertex[h], least = h;
    if (co_mesh_flaw_of(m, v) == CO_MESH_SOUND)
        return m->vertex_corner[v];
    for (int32_t g = h; m->twin[g] >= 0;) { /* clockwise */
        g = co_mesh_next(m, m->twin[g]);
        if (g == h)
            return least;
        least = m->twin[g] < 0 || g < least ? g : least;
    }
    return least;
}

/* first: from beginning(). */
static vertex_state look_round(const curvopt_mesh *m, int32_t first) {
    int32_t h = first;
    double sharpness = co_crease_vertex(m, m->corner_vertex[h]);
    vertex_state s = {.cut = -1, .is_fading = co_crease_is_fading(sharpness)};
    if (!m->edge_sharpness && sharpness == 0 && m->twin[first] >= 0)
        return s;
    do {
        double edge = co_crease_edge(m, h);
        s.is_fading |= co_crease_is_fading(edge);
        if (co_crease_is_infinite(edge)) {
            s.n_cuts++;
            s.cut = s.cut < 0 ? h : s.cut;
        }
        h = co_mesh_rotate(m, h);
    } while (h >= 0 && h != first);
    s.n_cuts += h < 0; /* the boundary edge that arrives */
    s.is_corner = co_crease_is_infinite(sharpness) || s.n_cuts > 2;
    return s;
}

/* The kind of fan that begins at h, the sector left open; h leaves along a cut if there is one. */
static int32_t fan_from(const curvopt_mesh *m, const vertex_state *s, int32_t h) {
    co_fan_type type = s->is_corner     ? (s->n_cuts ? CO_FAN_CORNER : CO_FAN_CONE)
                       : s->n_cuts == 2 ? CO_FAN_CREASE
                       : s->n_cuts == 1 ? CO_FAN_DART
                                        : CO_FAN_CLOSED;
    int32_t sectors = 0, g = h;
    do {
        sectors++;
        g = co_mesh_rotate(m, g);
    } while (g >= 0 && g != h && !is_cut(m, g));
    return co_fan_make(type, sectors < CO_FAN_MAX ? sectors : CO_FAN_MAX, 0);
}

/* Marks the corners of the fan that begins at h. */
static void mark_fan(const curvopt_mesh *m, const vertex_state *s, int32_t h, uint8_t *kind) {
    int32_t fan = fan_from(m, s, h), sectors = co_fan_sectors(fan), g = h;
    int quads = 1;
    for (int32_t i = 0; i < sectors; i++, g = co_mesh_rotate(m, g))
        quads &= co_mesh_face_size(m, m->corner_face[g]) == 4;
    uint8_t mark = !quads || s->is_fading || sectors == CO_FAN_MAX ? CO_CORNER_UNREADY
                   : fan == CO_FAN_REGULAR                         ? CO_CORNER_REGULAR
                   : fan == co_fan_make(CO_FAN_CREASE, 2, 0)       ? CO_CORNER_CREASE
                   : fan == co_fan_make(CO_FAN_CORNER, 1, 0)       ? CO_CORNER_SHARP
                                                                   : CO_CORNER_EXTRAORDINARY;
    g = h;
    for (int32_t i = 0; i < sectors; i++, g = co_mesh_rotate(m, g))
        kind[g] = mark;
}

/* begin: from beginning(). */
static void mark_vertex(const curvopt_mesh *m, int32_t begin, uint8_t *kind) {
    vertex_state s = look_round(m, begin);
    int32_t first = s.cut < 0 || m->twin[begin] < 0 ? begin : s.cut, h = first;
    do {
        if (h == first || is_cut(m, h))
            mark_fan(m, &s, h, kind);
        h = co_mesh_rotate(m, h);
    } while (h >= 0 && h != first);
}

/* Whether the two-ring of the fan at h is there: quads across its outer edges, and no cut but those that bound it. */
static int is_isolated(const curvopt_mesh *m, int32_t h, const uint8_t *kind) {
    int32_t g, fan = co_ring_fan(m, h, &g);
    for (int32_t i = 0; i < co_fan_sectors(fan); i++, g = co_mesh_rotate(m, g)) {
        int32_t right = co_mesh_next(m, g), across = co_mesh_next(m, right), left = co_mesh_next(m, across);
        if (kind[across] != CO_CORNER_REGULAR || kind[right] != (is_cut(m, g) ? CO_CORNER_CREASE : CO_CORNER_REGULAR) ||
            kind[left] != (is_cut(m, left) ? CO_CORNER_CREASE : CO_CORNER_REGULAR))
            return 0;
    }
    return 1;
}

void co_ring_classify(const curvopt_mesh *m, uint8_t *kind) {
    for (int32_t h = 0; h < m->info.n_corners; h++)
        if (beginning(m, h) == h)
            mark_vertex(m, h, kind);
    /* Demoting one never makes another more or less isolated: neither kind is regular. */
    for (int32_t h = 0; h < m->info.n_corners; h++)
        if (kind[h] == CO_CORNER_EXTRAORDINARY && !is_isolated(m, h, kind))
            kind[h] = CO_CORNER_UNREADY;
}

int32_t co_ring_fan(const curvopt_mesh *m, int32_t h, int32_t *first) {
    vertex_state s = look_round(m, beginning(m, h));
    int32_t sector = 0, g = h;
    while (s.n_cuts > 0 && !is_cut(m, g)) { /* clockwise */
        g = co_mesh_next(m, m->twin[g]);
        sector++;
    }
    *first = g;
    return fan_from(m, &s, g) | co_fan_make(CO_FAN_CLOSED, 0, sector);
}

void co_ring_fans(const curvopt_mesh *m, int32_t *fan) {
    for (int32_t begin = 0; begin < m->info.n_corners; begin++) {
        if (beginning(m, begin) != begin)
            continue;
        vertex_state s = look_round(m, begin);
        int32_t first = s.cut < 0 || m->twin[begin] < 0 ? begin : s.cut, h = first, at = 0;
        do {
            at = h == first || is_cut(m, h) ? fan_from(m, &s, h) : at;
            fan[h] = at;
            h = co_mesh_rotate(m, h);
        } while (h >= 0 && h != first);
    }
}

/* ----------------------------------------------------------------------------------------------- phantoms -- */

int co_ring_has_phantoms(const curvopt_mesh *m) {
    return m->info.n_boundary_edges > 0 || m->edge_sharpness || m->vertex_sharpness || m->flaw;
}

int32_t co_ring_n_numbers(const curvopt_mesh *m) {
    return co_ring_has_phantoms(m) ? m->info.n_vertices + 2 * m->info.n_edges + m->info.n_corners : m->info.n_vertices;
}

/* Number of the phantom beyond the vertex that h leaves, in line with h's edge. */
static int32_t beyond_origin(const curvopt_mesh *m, int32_t h) {
    int32_t e = m->edge[h], from_start = m->corner_vertex[m->edge_corner[e]] == m->corner_vertex[h];
    return m->info.n_vertices + 2 * e + !from_start;
}
/* Number of the phantom beyond the vertex that h arrives at. */
static int32_t beyond_destination(const curvopt_mesh *m, int32_t h) {
    return m->info.n_vertices + ((beyond_origin(m, h) - m->info.n_vertices) ^ 1);
}

int co_ring_resolve(const curvopt_mesh *m, int32_t number, int32_t *vertex, double *weight) {
    int32_t i = number - m->info.n_vertices;
    vertex[0] = number;
    weight[0] = 1;
    if (i < 0)
        return 1;
    if (i < 2 * m->info.n_edges) {
        int32_t h = m->edge_corner[i / 2], a = m->corner_vertex[h], b = co_mesh_destination(m, h);
        vertex[0] = i % 2 ? b : a;
        vertex[1] = i % 2 ? a : b;
        weight[0] = 2;
        weight[1] = -1;
        return 2;
    }
    int32_t h = i - 2 * m->info.n_edges;
    static const double corner[4] = {4, -2, 1, -2};
    for (int k = 0; k < 4; k++, h = co_mesh_next(m, h)) {
        vertex[k] = m->corner_vertex[h];
        weight[k] = corner[k];
    }
    return 4;
}

/* ------------------------------------------------------------------------------------------------- points -- */

/* The three points beyond the corner that h leaves: out[0] in line with h's edge, out[1] diagonally, out[2] in line
 * with the edge before it. In the numbering of ring.h, at corner 0 of the face (point 5, h from 5 to 6):
 *
 *     4 = out[0] --- 5 ---h--> 6        CO_CORNER_REGULAR: all three are vertices
 *     |              |                  CO_CORNER_CREASE, cut along h: 4 is a vertex, 0 and 1 are phantoms below the
 *     0 = out[1] --- 1 = out[2]           crease; cut along the edge before: 1 is a vertex, 0 and 4 are phantoms
 *                                       CO_CORNER_SHARP: all three are phantoms */
static void points_beyond(const curvopt_mesh *m, int32_t h, uint8_t kind, int32_t out[3]) {
    int32_t before = co_mesh_prev(m, h);
    if (kind == CO_CORNER_SHARP) {
        out[0] = beyond_origin(m, h);
        out[1] = m->info.n_vertices + 2 * m->info.n_edges + h;
        out[2] = beyond_destination(m, before);
    } else if (kind == CO_CORNER_CREASE && is_cut(m, h)) { /* the other quad lies across `before` */
        int32_t arriving = co_mesh_prev(m, co_mesh_rotate(m, h));
        out[0] = m->corner_vertex[arriving];
        out[1] = beyond_destination(m, co_mesh_prev(m, arriving));
        out[2] = beyond_destination(m, before);
    } else if (kind == CO_CORNER_CREASE) { /* across h */
        int32_t leaving = co_mesh_next(m, m->twin[h]);
        out[0] = beyond_origin(m, h);
        out[1] = beyond_origin(m, co_mesh_next(m, leaving));
        out[2] = co_mesh_destination(m, leaving);
    } else {
        int32_t beyond = co_mesh_rotate(m, co_mesh_rotate(m, h)), diagonal = co_mesh_next(m, beyond);
        out[0] = m->corner_vertex[diagonal];
        out[1] = co_mesh_destination(m, diagonal);
        out[2] = co_mesh_destination(m, co_mesh_rotate(m, beyond));
    }
}

void co_ring_regular(const curvopt_mesh *m, int32_t h, const uint8_t *kind, int32_t *points) {
    /* by corner: the corner itself, then the three points beyond it, counter-clockwise */
    static const int place[4][4] = {{5, 4, 0, 1}, {6, 2, 3, 7}, {10, 11, 15, 14}, {9, 13, 12, 8}};
    for (int corner = 0; corner < 4; corner++, h = co_mesh_next(m, h)) {
        int32_t beyond[3];
        points_beyond(m, h, kind[h], beyond);
        points[place[corner][0]] = m->corner_vertex[h];
        for (int k = 0; k < 3; k++)
            points[place[corner][k + 1]] = beyond[k];
    }
}

/* From half-edge h of a quad grid, the half-edge that goes straight on after h's destination (regular). */
static int32_t straight_on(const curvopt_mesh *m, int32_t h) {
    return co_mesh_next(m, m->twin[co_mesh_next(m, h)]);
}

void co_ring_two_ring(const curvopt_mesh *m, int32_t fan, int32_t h, int32_t *points) {
    int32_t last = h, *p = points;
    *p++ = m->corner_vertex[h];
    for (int32_t s = 0; s < co_fan_sectors(fan); s++, p += CO_RING_SECTOR, h = co_mesh_rotate(m, h)) {
        int32_t along_x = straight_on(m, h);                    /* (1,0) -> (2,0) */
        int32_t beside = straight_on(m, co_mesh_next(m, h));    /* (1,1) -> (1,2) */
        int32_t corner_edge = co_mesh_next(m, m->twin[beside]); /* (1,1) -> (2,1) */
        p[0] = co_mesh_destination(m, h);
        p[1] = co_mesh_destination(m, along_x);
        p[2] = m->corner_vertex[beside];
        p[3] = co_mesh_destination(m, corner_edge);
        p[4] = co_mesh_destination(m, beside);
        p[5] = co_mesh_destination(m, co_mesh_next(m, corner_edge));
        last = h;
    }
    if (co_fan_is_open(fan)) {                                  /* (0,1) and (0,2) of the last sector */
        int32_t outer = co_mesh_prev(m, co_mesh_prev(m, last)); /* (1,1) -> (0,1) */
        p[0] = co_mesh_destination(m, outer);
        p[1] = m->corner_vertex[co_mesh_prev(m, m->twin[outer])];
    }
}
