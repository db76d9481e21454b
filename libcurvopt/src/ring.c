/* Ordered neighbourhoods of faces and vertices. SPDX-License-Identifier: GPL-3.0-or-later */
#include "ring.h"

int32_t co_ring_two_ring_index(int32_t valence, int32_t sector, int x, int y) {
    static const int32_t place[3][3] = {{-1, -1, -1}, {0, 2, 4}, {1, 3, 5}}; /* [x][y] */
    if (x == 0 && y == 0)
        return 0;
    if (x == 0) { /* on the next sector's first edge */
        sector++;
        x = y;
        y = 0;
    }
    sector = (sector % valence + valence) % valence;
    return 1 + CO_RING_SECTOR * sector + place[x][y];
}

/* Interior with nothing but quads round it. */
static int has_quad_ring(const curvopt_mesh *m, int32_t v) {
    int32_t first = m->vertex_corner[v], h = first;
    if (co_mesh_is_boundary_vertex(m, v))
        return 0;
    do {
        if (co_mesh_face_size(m, m->corner_face[h]) != 4)
            return 0;
        h = co_mesh_rotate(m, h);
    } while (h != first);
    return 1;
}

/* Whether the other vertices of the faces round v are all regular. */
static int is_isolated(const curvopt_mesh *m, int32_t v, const uint8_t *kind) {
    int32_t first = m->vertex_corner[v], h = first;
    do {
        for (int32_t g = co_mesh_next(m, h); g != h; g = co_mesh_next(m, g))
            if (kind[m->corner_vertex[g]] != CO_VERTEX_REGULAR)
                return 0;
        h = co_mesh_rotate(m, h);
    } while (h != first);
    return 1;
}

void co_ring_classify(const curvopt_mesh *m, uint8_t *kind) {
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        kind[v] = !has_quad_ring(m, v) ? CO_VERTEX_UNREADY
                  : m->valence[v] == 4 ? CO_VERTEX_REGULAR
                                       : CO_VERTEX_EXTRAORDINARY;
    /* Demoting one never makes another vertex more or less isolated: neither kind is regular. */
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        if (kind[v] == CO_VERTEX_EXTRAORDINARY && !is_isolated(m, v, kind))
            kind[v] = CO_VERTEX_UNREADY;
}

void co_ring_regular(const curvopt_mesh *m, int32_t h, int32_t *points) {
    /* by corner: the corner itself, then the three points beyond it, counter-clockwise */
    static const int place[4][4] = {{5, 4, 0, 1}, {6, 2, 3, 7}, {10, 11, 15, 14}, {9, 13, 12, 8}};
    for (int corner = 0; corner < 4; corner++, h = co_mesh_next(m, h)) {
        int32_t beyond = co_mesh_rotate(m, co_mesh_rotate(m, h)); /* continues the edge that arrives from corner + 1 */
        int32_t diagonal = co_mesh_next(m, beyond);
        points[place[corner][0]] = m->corner_vertex[h];
        points[place[corner][1]] = m->corner_vertex[diagonal];
        points[place[corner][2]] = co_mesh_destination(m, diagonal);
        points[place[corner][3]] = co_mesh_destination(m, co_mesh_rotate(m, beyond));
    }
}

/* From half-edge h of a quad grid, the half-edge that goes straight on after h's destination (regular). */
static int32_t straight_on(const curvopt_mesh *m, int32_t h) {
    return co_mesh_next(m, m->twin[co_mesh_next(m, h)]);
}

void co_ring_two_ring(const curvopt_mesh *m, int32_t h, int32_t *points) {
    int32_t valence = m->valence[m->corner_vertex[h]];
    points[0] = m->corner_vertex[h];
    for (int32_t s = 0; s < valence; s++, h = co_mesh_rotate(m, h)) {
        int32_t *p = points + 1 + CO_RING_SECTOR * s;
        int32_t along_x = straight_on(m, h);                    /* (1,0) -> (2,0) */
        int32_t beside = straight_on(m, co_mesh_next(m, h));    /* (1,1) -> (1,2) */
        int32_t corner_edge = co_mesh_next(m, m->twin[beside]); /* (1,1) -> (2,1) */
        p[0] = co_mesh_destination(m, h);
        p[1] = co_mesh_destination(m, along_x);
        p[2] = m->corner_vertex[beside];
        p[3] = co_mesh_destination(m, corner_edge);
        p[4] = co_mesh_destination(m, beside);
        p[5] = co_mesh_destination(m, co_mesh_next(m, corner_edge));
    }
}
