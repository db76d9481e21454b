/* Where pieces lie on the cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/location.h"

#include <math.h>
#include <string.h>

void co_location_uv(const co_place *place, const double st[2], double uv[2]) {
    const double scale = ldexp(1, -place->level);
    double x = st[0], y = st[1];
    for (int turn = 0; turn < place->rotation; turn++) {
        const double old_x = x;
        x = -y;
        y = old_x;
    }
    uv[0] = place->origin[0] + scale * x;
    uv[1] = place->origin[1] + scale * y;
}

co_location co_location_of(const co_place *place, const double s[2], const double t[2]) {
    const double low[2] = {s[0], t[0]}, high[2] = {s[1], t[1]};
    double a[2], b[2];
    co_location_uv(place, low, a);
    co_location_uv(place, high, b);
    return (co_location){.face = place->face,
                         .quarter = place->quarter,
                         .u = {fmin(a[0], b[0]), fmax(a[0], b[0])},
                         .v = {fmin(a[1], b[1]), fmax(a[1], b[1])}};
}

/* A segment on a line that faces or quarters share. */
typedef struct segment {
    int32_t
        line; /* an edge; n_edges + h: the line inside h's face from the middle of edge h to the middle of the face */
    double from, to;
} segment;

/* Fills in the at most four segments of a rectangle on such lines, and the vertices that it has: a vertex; n_vertices +
 * f: the middle of face f that is no quad. Returns the number of segments. */
static int touches(const curvopt_mesh *m, const co_location *a, segment out[4], int32_t vertex[4], int *n_vertices) {
    const int32_t first = m->face_start[a->face], size = co_mesh_face_size(m, a->face);
    const double end[4] = {a->v[0], 1 - a->u[1], 1 - a->v[1], a->u[0]}; /* 0 where side k is reached */
    int n = 0;
    *n_vertices = 0;
    for (int k = 0; k < 4; k++) {
        if (end[k] != 0)
            continue;
        const double *along = k % 2 ? a->v : a->u;
        double from = k < 2 ? along[0] : 1 - along[1], to = k < 2 ? along[1] : 1 - along[0];
        int32_t h = first + k; /* the half-edge along the side, counter-clockwise */
        if (size != 4) {
            const int32_t own = first + a->quarter, before = co_mesh_prev(m, own);
            h = k == 0 || k == 1 ? own : before;
            if (k == 1 || k == 2) { /* inside the face, from its edge on */
                const double x = k == 1 ? from : 1 - to;
                out[n++] = (segment){m->info.n_edges + h, x, k == 1 ? to : 1 - from};
                continue;
            }
            from = k == 0 ? from / 2 : 0.5 + from / 2;
            to = k == 0 ? to / 2 : 0.5 + to / 2;
        }
        const int against = m->edge_corner[m->edge[h]] != h;
        /* Half-edges of a flawed edge run either way: the lesser vertex tells. */
        const int backward = m->twin[h] < 0 ? m->corner_vertex[h] > co_mesh_destination(m, h) : against;
        out[n++] = (segment){m->edge[h], backward ? 1 - to : from, backward ? 1 - from : to};
    }
    for (int k = 0; k < 4; k++) /* corner k is between sides k - 1 and k */
        if (end[k] == 0 && end[(k + 3) % 4] == 0) {
            if (size == 4)
                vertex[(*n_vertices)++] = m->corner_vertex[first + k];
            else if (k == 0)
                vertex[(*n_vertices)++] = m->corner_vertex[first + a->quarter];
            else if (k == 2)
                vertex[(*n_vertices)++] = m->info.n_vertices + a->face;
        }
    return n;
}

/* Contact of two intervals, seen along a shared line. */
static co_contact meet(const double a[2], const double b[2]) {
    const double low = fmax(a[0], b[0]), high = fmin(a[1], b[1]);
    return low < high ? CO_CONTACT_EDGE : low == high ? CO_CONTACT_VERTEX : CO_CONTACT_NONE;
}

co_contact co_location_contact(const curvopt_mesh *m, const co_location *a, const co_location *b) {
    co_contact best = CO_CONTACT_NONE;
    if (a->face == b->face && a->quarter == b->quarter) {
        const co_contact u = meet(a->u, b->u), v = meet(a->v, b->v);
        return u == CO_CONTACT_NONE || v == CO_CONTACT_NONE   ? CO_CONTACT_NONE
               : u == CO_CONTACT_EDGE || v == CO_CONTACT_EDGE ? CO_CONTACT_EDGE
                                                              : CO_CONTACT_VERTEX;
    }
    segment of_a[4], of_b[4];
    int32_t at_a[4], at_b[4];
    int n_at_a, n_at_b;
    const int n_a = touches(m, a, of_a, at_a, &n_at_a), n_b = touches(m, b, of_b, at_b, &n_at_b);
    for (int i = 0; i < n_a; i++)
        for (int j = 0; j < n_b; j++)
            if (of_a[i].line == of_b[j].line) {
                const double one[2] = {of_a[i].from, of_a[i].to}, two[2] = {of_b[j].from, of_b[j].to};
                const co_contact here = meet(one, two);
                best = here > best ? here : best;
            }
    for (int i = 0; i < n_at_a && best == CO_CONTACT_NONE; i++)
        for (int j = 0; j < n_at_b; j++)
            if (at_a[i] == at_b[j])
                best = CO_CONTACT_VERTEX;
    return best;
}

int co_location_is_on_boundary(const curvopt_mesh *m, const co_place *place, const double st[2]) {
    double uv[2];
    co_location_uv(place, st, uv);
    const int32_t first = m->face_start[place->face], size = co_mesh_face_size(m, place->face);
    const double end[4] = {uv[1], 1 - uv[0], 1 - uv[1], uv[0]};
    for (int k = 0; k < 4; k++) {
        if (end[k] > 1e-9 || (size != 4 && (k == 1 || k == 2)))
            continue;
        const int32_t own = first + place->quarter;
        if (m->twin[size == 4 ? first + k : k == 0 ? own : co_mesh_prev(m, own)] < 0)
            return 1;
    }
    return 0;
}

int32_t co_location_vertex(const curvopt_mesh *m, const co_place *place, int corner) {
    static const double at[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    double uv[2];
    co_location_uv(place, at[corner], uv);
    for (int k = 0; k < 4; k++)
        if (uv[0] == at[k][0] && uv[1] == at[k][1]) {
            if (co_mesh_face_size(m, place->face) == 4)
                return m->corner_vertex[m->face_start[place->face] + k];
            return k == 0 ? m->corner_vertex[m->face_start[place->face] + place->quarter] : -1;
        }
    return -1;
}

void co_location_limits(const curvopt_mesh *m, const co_surface_pieces *s, double *point) {
    static const int of_net[4] = {0, 9, 45, 36};
    for (size_t i = 0; i < 3 * (size_t)m->info.n_vertices; i++)
        point[i] = (double)NAN;
    for (int32_t p = 0; p < s->patches.n_patches; p++)
        for (int k = 0; k < 4; k++) {
            const int32_t v = co_location_vertex(m, &s->patches.place[p], k);
            if (v < 0)
                continue;
            const double *x = co_pieces_bezier(s, s->first[p]) + of_net[k];
            if (s->tip_of[p] >= 0) /* corners but the first are those of ring 1's cells, in their order */
                x = k == 0 ? s->tip[s->tip_of[p]].at : co_pieces_bezier(s, s->first[p] + k - 1) + of_net[k];
            memcpy(point + 3 * (size_t)v, x, 3 * sizeof(double));
        }
}
