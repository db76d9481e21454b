/* Vertices that slide along boundaries and creases. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/sliding.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "mesh/crease.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------------------ tracing curves -- */

/* The sharp edges of a cage: infinitely sharp ones and the boundary. */
typedef struct net {
    const curvopt_mesh *mesh;
    int32_t *n_sharp;   /* [n_vertices] sharp edges at a vertex */
    int32_t *link;      /* [n_vertices][2] the last two of them */
    uint8_t *is_spoilt; /* [n_vertices] no curve through it or to it is a spline */
    uint8_t *seen;      /* [n_edges] */
} net;

static void free_net(net *s) {
    free(s->n_sharp);
    free(s->link);
    free(s->is_spoilt);
    free(s->seen);
}

static int is_sharp(const curvopt_mesh *m, int32_t e) {
    return co_crease_is_infinite(co_crease_edge(m, m->edge_corner[e]));
}

static int32_t other_end(const curvopt_mesh *m, int32_t e, int32_t v) {
    int32_t h = m->edge_corner[e], from = m->corner_vertex[h];
    return from == v ? co_mesh_destination(m, h) : from;
}

static int is_end(const net *s, int32_t v) {
    return s->n_sharp[v] != 2 || co_crease_is_infinite(co_crease_vertex(s->mesh, v));
}

static int32_t make_net(const curvopt_mesh *m, net *s, curvopt_error *error) {
    size_t n = (size_t)m->info.n_vertices;
    *s = (net){.mesh = m,
               .n_sharp = CO_NEW(int32_t, n),
               .link = CO_NEW(int32_t, 2 * n),
               .is_spoilt = CO_NEW(uint8_t, n),
               .seen = CO_NEW(uint8_t, m->info.n_edges)};
    if (!s->n_sharp || !s->link || !s->is_spoilt || !s->seen)
        return co_status_no_memory(error);
    for (int32_t e = 0; e < m->info.n_edges; e++) {
        int32_t h = m->edge_corner[e], ends[2] = {m->corner_vertex[h], co_mesh_destination(m, h)};
        for (int k = 0; k < 2; k++) {
            if (is_sharp(m, e))
                s->link[2 * ends[k] + s->n_sharp[ends[k]]++ % 2] = e;
            else if (co_crease_edge(m, h) > 0)
                s->is_spoilt[ends[k]] = 1;
        }
    }
    for (int32_t v = 0; v < m->info.n_vertices; v++) {
        double sharpness = co_crease_vertex(m, v);
        if (s->n_sharp[v] > 2 || co_crease_is_infinite(sharpness)) /* a corner, whatever else is there */
            s->is_spoilt[v] = 0;
        else if (s->n_sharp[v] == 1 || sharpness > 0 || co_mesh_flaw_of(m, v) != CO_MESH_SOUND)
            s->is_spoilt[v] = 1;
    }
    return CURVOPT_OK;
}

/* The vertices of the curve that leaves v by edge e, into vertex unless that is NULL, and whether it is a spline; their
 * number. Its edges have been seen then. */
static int32_t walk(net *s, int32_t v, int32_t e, int32_t *vertex, int *is_closed, int *is_spline) {
    const int32_t start = v;
    int32_t n = 0;
    *is_closed = !is_end(s, v);
    *is_spline = 1;
    for (;;) {
        if (vertex)
            vertex[n] = v;
        n++;
        *is_spline = *is_spline && !s->is_spoilt[v];
        if ((n > 1 && is_end(s, v)) || e < 0)
            return n;
        s->seen[e] = 1;
        v = other_end(s->mesh, e, v);
        if (*is_closed && v == start)
            return n;
        e = is_end(s, v) ? -1 : s->link[2 * v] == e ? s->link[2 * v + 1] : s->link[2 * v];
    }
}

static void free_curve(co_slide_curve *c) {
    free(c->track.control);
    free(c->vertex);
    free(c->place);
    free(c->next);
    free(c->point);
    free(c->control);
    free(c->role);
    *c = (co_slide_curve){0};
}

void co_sliding_free(co_sliding *s) {
    for (int32_t k = 0; k < s->n_curves; k++)
        free_curve(&s->curves[k]);
    free(s->curves);
    *s = (co_sliding){0};
}

/* Room for n vertices, but for the track. */
static int allocate_curve(int32_t n, co_slide_curve *c) {
    size_t count = (size_t)n;
    c->n = n;
    c->vertex = CO_NEW(int32_t, count);
    c->place = CO_NEW(double, count);
    c->next = CO_NEW(double, count);
    c->point = CO_NEW(double, 3 * count);
    c->control = CO_NEW(double, 3 * count);
    c->role = CO_NEW(uint8_t, count);
    return c->vertex && c->place && c->next && c->point && c->control && c->role;
}

/* The curve of the cage at xyz becomes the track. */
static int32_t lay_track(co_slide_curve *c, const double *xyz, curvopt_error *error) {
    double *control = CO_NEW(double, 3 * (size_t)c->n);
    if (!control)
        return co_status_no_memory(error);
    free(c->track.control);
    c->track.n = c->n;
    c->track.control = control;
    for (int32_t i = 0; i < c->n; i++) {
        memcpy(control + 3 * i, xyz + 3 * (size_t)c->vertex[i], 3 * sizeof *control);
        c->place[i] = c->next[i] = i;
    }
    return CURVOPT_OK;
}

/* Fewest vertices of a curve: on fewer a vertex would be its own neighbour's neighbour. */
enum { FEWEST_CLOSED = 4, FEWEST_OPEN = 3 };

static int32_t add_curve(net *s, int32_t v, int32_t e, const double *xyz, co_sliding *out, curvopt_error *error) {
    int is_closed, is_spline;
    int32_t n = walk(s, v, e, NULL, &is_closed, &is_spline);
    if (!is_spline || n < (is_closed ? FEWEST_CLOSED : FEWEST_OPEN))
        return CURVOPT_OK;
    co_slide_curve *more = CO_RESIZED(out->curves, (size_t)out->n_curves + 1);
    if (!more)
        return co_status_no_memory(error);
    out->curves = more;
    co_slide_curve *c = &out->curves[out->n_curves++];
    *c = (co_slide_curve){.track.closed = is_closed};
    if (!allocate_curve(n, c))
        return co_status_no_memory(error);
    walk(s, v, e, c->vertex, &is_closed, &is_spline);
    if (!is_closed && n == FEWEST_OPEN && c->vertex[0] == c->vertex[n - 1]) { /* two edges between the same two */
        free_curve(c);
        out->n_curves--;
        return CURVOPT_OK;
    }
    return lay_track(c, xyz, error);
}

int32_t co_sliding_create(const curvopt_mesh *m, const double *xyz, co_sliding *out, curvopt_error *error) {
    net s;
    *out = (co_sliding){0};
    int32_t status = make_net(m, &s, error);
    for (int closed = 0; closed < 2; closed++) /* what curves between ends leave is closed */
        for (int32_t e = 0; status == CURVOPT_OK && e < m->info.n_edges; e++) {
            int32_t a = m->corner_vertex[m->edge_corner[e]], b = other_end(m, e, a);
            if (s.seen[e] || !is_sharp(m, e) || !(closed || is_end(&s, a) || is_end(&s, b)))
                continue;
            status = add_curve(&s, closed || is_end(&s, a) ? a : b, e, xyz, out, error);
        }
    free_net(&s);
    if (status != CURVOPT_OK)
        co_sliding_free(out);
    return status;
}

/* The sharp edge between neighbours on a curve: one of them is no end. */
static int32_t edge_between(const net *s, int32_t v, int32_t w) {
    int32_t inner = is_end(s, v) ? w : v, outer = inner == v ? w : v;
    int32_t e = s->link[2 * inner];
    return other_end(s->mesh, e, inner) == outer ? e : s->link[2 * inner + 1];
}

static int32_t subdivide_curve(const net *s, co_slide_curve *c, curvopt_error *error) {
    const int closed = c->track.closed;
    co_slide_curve fine = {.track = c->track, .deviation = c->deviation, .deviation_before = c->deviation_before};
    if (!allocate_curve(closed ? 2 * c->n : 2 * c->n - 1, &fine)) {
        fine.track.control = NULL;
        free_curve(&fine);
        return co_status_no_memory(error);
    }
    for (int32_t i = 0; i < c->n; i++) {
        int32_t j = (i + 1) % c->n;
        fine.vertex[2 * i] = c->vertex[i];
        fine.place[2 * i] = c->place[i];
        if (2 * i + 1 == fine.n)
            break;
        fine.vertex[2 * i + 1] = s->mesh->info.n_vertices + edge_between(s, c->vertex[i], c->vertex[j]);
        fine.place[2 * i + 1] = (c->place[i] + c->place[j] + (j == 0 ? c->track.n : 0)) / 2;
    }
    c->track.control = NULL;
    free_curve(c);
    *c = fine;
    return CURVOPT_OK;
}

int32_t co_sliding_subdivide(const curvopt_mesh *m, co_sliding *sliding, curvopt_error *error) {
    net s;
    if (sliding->n_curves == 0)
        return CURVOPT_OK;
    int32_t status = make_net(m, &s, error);
    for (int32_t k = 0; status == CURVOPT_OK && k < sliding->n_curves; k++)
        status = subdivide_curve(&s, &sliding->curves[k], error);
    free_net(&s);
    return status;
}

/* --------------------------------------------------------------------------------- places on the curves -- */

/* Index of the vertex that is k further; -1 beyond an end. */
static int32_t further(const co_slide_curve *c, int32_t i, int32_t k) {
    int32_t j = i + k;
    if (c->track.closed)
        return (j % c->n + c->n) % c->n;
    return j < 0 || j >= c->n ? -1 : j;
}

/* Distance of places from vertex i to the next one, which there is. */
static double gap(const co_slide_curve *c, const double *place, int32_t i) {
    int32_t j = (i + 1) % c->n;
    return place[j] - place[i] + (j == 0 ? c->track.n : 0);
}

/* Distance to the nearer neighbour. */
static double least_gap(const co_slide_curve *c, int32_t i) {
    int32_t before = further(c, i, -1), after = further(c, i, 1);
    double left = before < 0 ? (double)INFINITY : gap(c, c->place, before);
    return fmin(left, after < 0 ? (double)INFINITY : gap(c, c->place, i));
}

/* The curve of the cage at xyz, its control points in c->control. */
static co_spline_curve present_curve(const co_slide_curve *c, const double *xyz) {
    for (int32_t i = 0; i < c->n; i++)
        memcpy(c->control + 3 * i, xyz + 3 * (size_t)c->vertex[i], 3 * sizeof *xyz);
    return (co_spline_curve){.n = c->n, .closed = c->track.closed, .control = c->control};
}

/* The places where the limit points at xyz are closest to the track. */
static void find_places(co_slide_curve *c, const double *xyz) {
    const co_spline_curve now = present_curve(c, xyz);
    for (int32_t i = 0; i < c->n; i++) {
        double point[3];
        co_spline_curve_limit(&now, i, point);
        c->next[i] = c->role[i] == CO_SLIDE_SLIDES
                         ? co_spline_curve_closest(&c->track, point, c->place[i], least_gap(c, i))
                         : c->place[i];
    }
}

/* By how much the vertex beside one that stays follows the others: 2 q s_2 - 3 q^2 s_3 + ... */
static double slide_of_follower(const co_slide_curve *c, int32_t i, int32_t direction) {
    enum { FARTHEST = 8 }; /* q^7 is 1e-4 */
    const double q = 2 - sqrt(3);
    double sum = 0, factor = q;
    for (int32_t k = 2; k <= FARTHEST; k++, factor *= -q) {
        int32_t j = further(c, i, direction * (k - 1));
        if (j < 0 || c->role[j] == CO_SLIDE_STAYS || j == i)
            break;
        sum += k * factor * (c->next[j] - c->place[j]);
    }
    return sum;
}

static int stays(const co_slide_curve *c, int32_t i, int32_t k) {
    int32_t j = further(c, i, k);
    return j >= 0 && c->role[j] == CO_SLIDE_STAYS && (c->track.closed || (j > 0 && j < c->n - 1));
}

/* Vertices between two that stay do not move. */
static void let_follow(co_slide_curve *c) {
    for (int32_t i = 0; i < c->n; i++) {
        int before = stays(c, i, -1), after = stays(c, i, 1);
        if (c->role[i] == CO_SLIDE_FOLLOWS)
            c->next[i] = c->place[i] + (before == after ? 0 : slide_of_follower(c, i, before ? 1 : -1));
    }
}

/* Part of the distance between neighbours that a turn leaves at least. */
static const double LEAST_LEFT = 0.25;

/* The part of the way to the next places for which that holds. */
static double part_of_way(const co_slide_curve *c) {
    double part = 1;
    for (int32_t i = 0; i + !c->track.closed < c->n; i++) {
        double before = gap(c, c->place, i), lost = before - gap(c, c->next, i);
        if (lost > (1 - LEAST_LEFT) * before)
            part = fmin(part, (1 - LEAST_LEFT) * before / lost);
    }
    return part;
}

/* Vertices that do not stay become the control points of the spline through the points of the next places. Jacobi's
 * method: each step halves the error at least, and does not depend on the order. */
static void interpolate(co_slide_curve *c, double *xyz) {
    enum { STEPS = 60 };
    for (int32_t i = 0; i < c->n; i++) {
        double jet[3][3];
        co_spline_curve_at(&c->track, c->next[i], jet);
        memcpy(c->point + 3 * i, jet[0], sizeof jet[0]);
    }
    for (int step = 0; step < STEPS; step++) {
        present_curve(c, xyz);
        for (int32_t i = 0; i < c->n; i++) {
            int32_t before = further(c, i, -1), after = further(c, i, 1);
            if (c->role[i] == CO_SLIDE_STAYS)
                continue;
            for (int k = 0; k < 3; k++)
                xyz[3 * (size_t)c->vertex[i] + (size_t)k] =
                    (6 * c->point[3 * i + k] - (c->control[3 * before + k] + c->control[3 * after + k])) / 4;
        }
    }
}

double co_sliding_put_back(co_sliding *s, double *xyz) {
    double part = 1, longest = 0;
    for (int32_t k = 0; k < s->n_curves; k++) {
        co_slide_curve *c = &s->curves[k];
        if (!c->slides)
            continue;
        find_places(c, xyz);
        let_follow(c);
        part = fmin(part, part_of_way(c));
        for (int32_t i = 0; i < c->n; i++)
            longest = fmax(longest, fabs(c->next[i] - c->place[i]) / least_gap(c, i));
    }
    for (int32_t k = 0; k < s->n_curves; k++) {
        co_slide_curve *c = &s->curves[k];
        for (int32_t i = 0; c->slides && i < c->n; i++)
            c->next[i] = c->place[i] + part * (c->next[i] - c->place[i]);
        if (c->slides)
            interpolate(c, xyz);
    }
    return longest;
}

void co_sliding_accept(co_sliding *s) {
    for (int32_t k = 0; k < s->n_curves; k++)
        memcpy(s->curves[k].place, s->curves[k].next, (size_t)s->curves[k].n * sizeof(double));
}

void co_sliding_tangents(const co_sliding *s, int32_t n_vertices, double *tangent) {
    memset(tangent, 0, 3 * (size_t)n_vertices * sizeof *tangent);
    for (int32_t k = 0; k < s->n_curves; k++) {
        const co_slide_curve *c = &s->curves[k];
        for (int32_t i = 0; c->slides && i < c->n; i++) {
            double jet[3][3];
            co_spline_curve_at(&c->track, c->place[i], jet);
            const double *d = jet[1];
            double length = co_length3(d);
            for (int a = 0; a < 3 && c->role[i] == CO_SLIDE_SLIDES && length > 0; a++)
                tangent[3 * (size_t)c->vertex[i] + (size_t)a] = d[a] / length;
        }
    }
}

/* ------------------------------------------------------------------------------------------- levels -- */

/* held [n_vertices]: vertices that are held for more than the curve's sake. */
static int32_t find_held(const curvopt_mesh *m, const co_constraints *constraints, int32_t boundary, uint8_t *held,
                         curvopt_error *error) {
    for (int32_t v = 0; constraints->freedom && v < m->info.n_vertices; v++)
        held[v] = constraints->freedom[v] != CO_FREEDOM_ALL;
    for (int32_t h = 0; constraints->left_out && h < m->info.n_corners; h++)
        held[m->corner_vertex[h]] |= constraints->left_out[m->corner_face[h]];
    if (boundary == CURVOPT_BOUNDARY_POSITION)
        return CURVOPT_OK;
    return co_constraints_mark_rows(m, boundary, held, error);
}

/* What each vertex of a curve does; whether one of them stays that is no end. */
static int find_roles(co_slide_curve *c, const uint8_t *held) {
    int any = 0;
    for (int32_t i = 0; i < c->n; i++) {
        int end = !c->track.closed && (i == 0 || i == c->n - 1);
        c->role[i] = end || held[c->vertex[i]] ? CO_SLIDE_STAYS : CO_SLIDE_SLIDES;
        any |= !end && held[c->vertex[i]];
    }
    for (int32_t i = 0; i < c->n; i++)
        if (c->role[i] == CO_SLIDE_SLIDES && (stays(c, i, -1) || stays(c, i, 1)))
            c->role[i] = CO_SLIDE_FOLLOWS;
    c->slides = 0;
    for (int32_t i = 0; i < c->n; i++)
        c->slides |= c->role[i] == CO_SLIDE_SLIDES;
    return any;
}

int32_t co_sliding_begin_level(const curvopt_mesh *m, const co_constraints *constraints, int32_t boundary,
                               co_sliding *s, double *xyz, curvopt_error *error) {
    uint8_t *held = CO_NEW(uint8_t, m->info.n_vertices);
    int32_t status = held ? find_held(m, constraints, boundary, held, error) : co_status_no_memory(error);
    s->n_sliding = 0;
    for (int32_t k = 0; status == CURVOPT_OK && k < s->n_curves; k++) {
        co_slide_curve *c = &s->curves[k];
        int holds = find_roles(c, held);
        c->slides = c->slides && boundary != CURVOPT_BOUNDARY_FREE;
        for (int32_t i = 0; c->slides && i < c->n; i++)
            s->n_sliding += c->role[i] != CO_SLIDE_STAYS;
        if (!holds && c->slides) {
            find_places(c, xyz);
            interpolate(c, xyz);
            memcpy(c->place, c->next, (size_t)c->n * sizeof *c->place);
        } else {
            c->deviation_before = c->deviation;
            status = lay_track(c, xyz, error);
        }
    }
    free(held);
    return status;
}

void co_sliding_measure(co_sliding *s, const double *xyz) {
    enum { POINTS = 8 }; /* of each span */
    for (int32_t k = 0; k < s->n_curves; k++) {
        co_slide_curve *c = &s->curves[k];
        const co_spline_curve now = present_curve(c, xyz);
        double longest = 0;
        for (int32_t i = 0; c->slides && i + !now.closed < c->n; i++)
            for (int p = 0; p < POINTS; p++) {
                double jet[3][3], on[3][3], part = (double)p / POINTS, width = gap(c, c->place, i);
                co_spline_curve_at(&now, i + part, jet);
                double t = co_spline_curve_closest(&c->track, jet[0], c->place[i] + part * width, width);
                co_spline_curve_at(&c->track, t, on);
                for (int a = 0; a < 3; a++)
                    on[0][a] -= jet[0][a];
                longest = fmax(longest, co_length3(on[0]));
            }
        c->deviation = c->deviation_before + longest;
    }
}

double co_sliding_deviation(const co_sliding *s) {
    double longest = 0;
    for (int32_t k = 0; k < s->n_curves; k++)
        longest = fmax(longest, s->curves[k].deviation);
    return longest;
}

void co_sliding_free_along(int32_t n_vertices, const double *tangent, co_constraints *all) {
    for (int32_t v = 0; v < n_vertices; v++) {
        const double *t = tangent + 3 * (size_t)v;
        if (t[0] == 0 && t[1] == 0 && t[2] == 0)
            continue;
        all->freedom[v] = CO_FREEDOM_LINE;
        memcpy(all->direction + 3 * (size_t)v, t, 3 * sizeof *t);
    }
}
