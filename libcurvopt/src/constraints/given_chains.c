/* The chains of edges whose limit curves the user wants to follow curves. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/given_chains.h"

#include "base/memory.h"
#include "constraints/freedom.h"
#include "constraints/given_curve.h"
#include "constraints/interpolation.h"
#include "mesh/similarity.h"
#include "surface/vertex_mask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Distance, in parts of the cage's radius, up to which two chains hold the same point of a vertex that both have. */
static const double SAME_PLACE = 1e-6;

enum { ENDS = 3 }; /* limit points that an open chain holds more than it has edges: a vertex, and two middles */

typedef struct reader {
    const curvopt_mesh *mesh;
    const double *xyz;
    const curvopt_chain *given; /* the present one, */
    co_chain *chain;            /* and what becomes of it */
    int32_t number, levels;
    co_constraints *constraints;
    int32_t *vertex_owner; /* [n_vertices] the chain that holds the vertex' point; -1 */
    int32_t *edge_owner;   /* [n_edges] the chain of an edge; -1 */
    int32_t *group;        /* [n_chains] one of those that the chain hangs together with by vertices */
    int32_t *n_points;     /* [n_chains] limit points that it holds on the last level, without those of others */
    double weight;         /* of the present one. Below 1 springs draw it, and it owns nothing */
    double radius;
} reader;

/* ------------------------------------------------------------------------------------------ the chain itself -- */

static int32_t check_counts(const reader *r, curvopt_error *error) {
    const curvopt_chain *c = r->given;
    const int32_t least = c->is_closed ? 3 : 2;
    if (!c->vertices || c->n_vertices < least)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, r->number,
                              "chain %d has %d vertices, which are %s; %s chain needs %d", r->number, c->n_vertices,
                              c->vertices ? "given" : "NULL", c->is_closed ? "a closed" : "an open", least);
    const int32_t n_edges = c->n_vertices - (c->is_closed ? 0 : 1), halvings = r->levels < 31 ? r->levels - 1 : 30;
    const int32_t more = c->is_closed ? 0 : ENDS, most = CO_INTERPOLATION_MOST_TOUCHING - more;
    const long long n_last = (long long)n_edges << halvings;
    if (n_last > most && r->weight == 1)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, r->number,
                              "chain %d has %d edges, which become %lld on level %d; there can be %d: use fewer "
                              "levels, a weight below 1, "
                              "or two chains that do not touch",
                              r->number, n_edges, n_last, r->levels, most);
    r->n_points[r->number] = r->weight == 1 ? (int32_t)n_last + more : 0;
    return CURVOPT_OK;
}

static int32_t check_vertex(const reader *r, int32_t i, curvopt_error *error) {
    const co_constraints *c = r->constraints;
    const int32_t v = r->given->vertices[i];
    if (v < 0 || v >= r->mesh->info.n_vertices)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, r->number, "chain %d has vertex %d; there are %d vertices",
                              r->number, v, r->mesh->info.n_vertices);
    for (int32_t k = 0; k < i; k++)
        if (r->given->vertices[k] == v)
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, r->number, "chain %d has vertex %d twice%s", r->number,
                                  v, k == 0 ? ": a closed chain says so, and names its first vertex once" : "");
    if (!co_vertex_mask_exists(r->mesh, v))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, r->number,
                              "chain %d goes through vertex %d, where a crease fades or ends, or there is no surface",
                              r->number, v);
    if (r->vertex_owner[v] >= 0 || r->weight < 1)
        return CURVOPT_OK;
    if (c->freedom[v] != CO_FREEDOM_ALL || (c->springs.stiffness && c->springs.stiffness[v] > 0))
        return co_status_fail(
            error, CURVOPT_ERROR_ARGUMENT, r->number,
            "chain %d goes through vertex %d, which has a constraint of its own: leave one of them out", r->number, v);
    return CURVOPT_OK;
}

/* The edge after vertex i. */
static int32_t take_edge(const reader *r, int32_t i, curvopt_error *error) {
    const int32_t a = r->given->vertices[i], b = r->given->vertices[(i + 1) % r->given->n_vertices];
    const int32_t h = co_chains_find_edge(r->mesh, a, b);
    if (h < 0)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, r->number,
                              "chain %d goes from vertex %d to vertex %d, but no edge does", r->number, a, b);
    int32_t *owner = &r->edge_owner[r->mesh->edge[h]];
    if (r->weight < 1)
        return CURVOPT_OK;
    if (*owner >= 0)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, r->number,
                              "chain %d has the edge from vertex %d to vertex %d, as chain %d has", r->number, a, b,
                              *owner);
    *owner = r->number;
    return CURVOPT_OK;
}

static int32_t read_vertices(const reader *r, curvopt_error *error) {
    const curvopt_chain *c = r->given;
    int32_t status = check_counts(r, error);
    if (status != CURVOPT_OK)
        return status;
    *r->chain = (co_chain){.number = r->number,
                           .n = c->n_vertices,
                           .is_closed = c->is_closed != 0,
                           .vertex = CO_NEW(int32_t, c->n_vertices),
                           .step = 1,
                           .stiffness = r->weight < 1 ? r->weight / (1 - r->weight) : 0};
    if (!r->chain->vertex)
        return co_status_no_memory(error);
    memcpy(r->chain->vertex, c->vertices, (size_t)c->n_vertices * sizeof *c->vertices);
    for (int32_t i = 0; status == CURVOPT_OK && i < c->n_vertices; i++)
        status = check_vertex(r, i, error);
    for (int32_t i = 0; status == CURVOPT_OK && i < co_chain_edges(r->chain); i++)
        status = take_edge(r, i, error);
    return status;
}

/* ------------------------------------------------------------------------------------- places on its curve -- */

/* The curve's parameter for vertex i. */
static int32_t find_parameter(const reader *r, const co_given_curve *curve, int32_t i, double *t,
                              curvopt_error *error) {
    const int32_t most = curve->n_points - (curve->is_closed ? 0 : 1);
    if (!r->given->parameters) {
        double at[3];
        co_vertex_mask_point(r->mesh, r->chain->vertex[i], r->xyz, at);
        *t = co_given_curve_nearest(curve, at);
        return CURVOPT_OK;
    }
    const double at = r->given->parameters[i];
    if (!(at >= 0 && at <= most))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, r->number,
                              "chain %d: the parameter of vertex %d is %g; it must be 0 to %d", r->number,
                              r->chain->vertex[i], at, most);
    *t = co_given_curve_parameter(curve, at);
    return CURVOPT_OK;
}

/* Whether a piece of a cubic that rises by `rise` over length 1, with slopes a and b at its ends, goes forward all
 * along, where that is the direction `sign`. */
static int goes_forward(double rise, double a, double b, double sign) {
    const double square = 3 * (a + b - 2 * rise), linear = 6 * rise - 4 * a - 2 * b;
    const double turns_at = square != 0 ? -linear / (2 * square) : -1;
    const double inside = turns_at > 0 && turns_at < 1 ? a + linear * turns_at / 2 : a;
    return sign * a > 0 && sign * b > 0 && sign * inside > 0;
}

/* Parameters between vertices, by a spline through t [n + 1], of which [n] is room. */
static int32_t make_parameter(const reader *r, double *t, double turn, double *knot, curvopt_error *error) {
    co_chain *chain = r->chain;
    const int32_t n = chain->n, n_knots = n + chain->is_closed;
    chain->turn = turn / n;
    for (int32_t i = 0; i < n; i++) {
        knot[i] = i;
        t[i] -= chain->turn * i;
    }
    knot[n] = n;
    t[n] = t[0];
    int32_t status = co_cubic_spline_create(n_knots, 1, chain->is_closed, knot, t, &chain->parameter, error);
    if (status != CURVOPT_OK)
        return status;
    const double *value = chain->parameter.value, *slope = chain->parameter.slope;
    for (int32_t i = 0; i < n_knots - 1; i++) {
        const double rise = value[i + 1] - value[i] + chain->turn;
        if (!goes_forward(rise, slope[i] + chain->turn, slope[i + 1] + chain->turn, rise > 0 ? 1 : -1))
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, r->number,
                                  "chain %d: between vertex %d and vertex %d the places on its curve turn back when "
                                  "they are to follow each other smoothly: give parameters that are more even",
                                  r->number, chain->vertex[i], chain->vertex[(i + 1) % n]);
    }
    return CURVOPT_OK;
}

static int32_t read_curve(const reader *r, curvopt_error *error) {
    co_chain *chain = r->chain;
    const size_t room = (size_t)chain->n + 1;
    co_given_curve curve = {0};
    double turn = 0, *t = CO_NEW(double, 2 * room);
    int32_t status = t ? co_given_curve_create(r->given, r->number, &curve, error) : co_status_no_memory(error);
    for (int32_t i = 0; status == CURVOPT_OK && i < chain->n; i++)
        status = find_parameter(r, &curve, i, &t[i], error);
    if (status == CURVOPT_OK)
        status = co_given_curve_order(&curve, chain->vertex, chain->n, chain->is_closed, t, &turn, error);
    if (status == CURVOPT_OK)
        status = make_parameter(r, t, turn, t + room, error);
    if (status == CURVOPT_OK) {
        chain->curve = curve.spline;
        curve.spline = (co_cubic_spline){0};
    }
    co_given_curve_free(&curve);
    free(t);
    return status;
}

/* --------------------------------------------------------------------------------------- beside other things -- */

static int32_t root_of(const reader *r, int32_t k) {
    while (r->group[k] != k)
        k = r->group[k];
    return k;
}

/* Enters the present chain into the group of another one, with which it has a vertex in common. */
static void join(const reader *r, int32_t other) {
    const int32_t into = root_of(r, other), from = root_of(r, r->number);
    r->n_points[into]--; /* counted twice */
    if (into != from) {
        r->group[from] = into;
        r->n_points[into] += r->n_points[from];
    }
}

/* More limit points hang together on the last level than can be held. */
static int32_t check_group(const reader *r, curvopt_error *error) {
    const int32_t n = r->n_points[root_of(r, r->number)];
    if (n <= CO_INTERPOLATION_MOST_TOUCHING)
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, r->number,
                          "chain %d, with the chains that it hangs together with by vertices, holds %d limit points on "
                          "level %d; there can be %d: use fewer levels, weights below 1, or chains that do not touch",
                          r->number, n, r->levels, CO_INTERPOLATION_MOST_TOUCHING);
}

/* Enters what the chain holds, or compares it with what one before holds. */
static int32_t take_vertices(const reader *r, curvopt_error *error) {
    for (int32_t i = 0; r->weight == 1 && i < r->chain->n; i++) {
        const int32_t v = r->chain->vertex[i];
        double place[3], square = 0, *anchor = r->constraints->anchor + 3 * (size_t)v;
        co_chain_place(r->chain, i, place);
        for (int c = 0; r->vertex_owner[v] >= 0 && c < 3; c++)
            square += (place[c] - anchor[c]) * (place[c] - anchor[c]);
        if (!(sqrt(square) <= SAME_PLACE * r->radius))
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, r->number,
                                  "chain %d wants vertex %d %g away from where chain %d wants it: give both parameters "
                                  "at which their curves meet",
                                  r->number, v, sqrt(square), r->vertex_owner[v]);
        if (r->vertex_owner[v] >= 0) {
            join(r, r->vertex_owner[v]);
            continue;
        }
        memcpy(anchor, place, sizeof place);
        r->vertex_owner[v] = r->number;
    }
    return check_group(r, error);
}

/* Half-edges of the edges that a place inside a face is on, of which there are at most two. */
static int find_edges(const curvopt_mesh *m, const co_surface_value *f, int32_t h[2]) {
    const int is_quad = co_mesh_face_size(m, m->corner_face[f->corner]) == 4;
    int n = 0;
    if (f->uv[1] == 0)
        h[n++] = f->corner;
    if (f->uv[0] == 0)
        h[n++] = co_mesh_prev(m, f->corner);
    if (is_quad && f->uv[0] == 1)
        h[n++] = f->corner + 1;
    if (is_quad && f->uv[1] == 1)
        h[n++] = f->corner + 2;
    return n < 2 ? n : 2;
}

/* A chain says where all points of its edges are. */
static int32_t check_entry(const reader *r, const co_surface_value *f, curvopt_error *error) {
    int32_t h[2], owner = f->vertex >= 0 ? r->vertex_owner[f->vertex] : -1;
    for (int k = f->vertex >= 0 ? 0 : find_edges(r->mesh, f, h); k > 0; k--)
        owner = r->edge_owner[r->mesh->edge[h[k - 1]]] >= 0 ? r->edge_owner[r->mesh->edge[h[k - 1]]] : owner;
    if (owner < 0 || f->order)
        return CURVOPT_OK;
    return co_status_fail(
        error, CURVOPT_ERROR_ARGUMENT, owner,
        "chain %d holds the point of entry %d: leave the entry out; where on its curve a chain has its "
        "vertices its parameters say",
        owner, f->number);
}

static int32_t read_weight(reader *r, const curvopt_through *t, curvopt_error *error) {
    r->weight = t->chain_weights ? co_constraint_weight(t->chain_weights[r->number]) : 1;
    if (r->weight >= 0 && r->weight <= 1)
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, r->number, "chain %d has the weight %g; it must be 0 to 1",
                          r->number, r->weight);
}

/* Reads the present chain, which does not count if its weight is 0. */
static int32_t read_chain(reader *r, const curvopt_through *t, curvopt_error *error) {
    co_chains *chains = &r->constraints->chains;
    r->chain = &chains->item[chains->n++];
    r->group[r->number] = r->number;
    int32_t status = read_weight(r, t, error);
    if (status == CURVOPT_OK)
        status = read_vertices(r, error);
    if (status == CURVOPT_OK)
        status = read_curve(r, error);
    if (status == CURVOPT_OK)
        status = take_vertices(r, error);
    if (status == CURVOPT_OK && r->weight == 0) {
        co_chain_free(r->chain);
        chains->n--;
    }
    return status;
}

static int32_t read_chains(reader *r, const curvopt_through *t, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    for (int32_t k = 0; status == CURVOPT_OK && k < t->n_chains; k++) {
        r->number = k;
        r->given = &t->chains[k];
        status = read_chain(r, t, error);
    }
    for (int32_t i = 0; status == CURVOPT_OK && i < r->constraints->values.n; i++)
        status = check_entry(r, &r->constraints->values.item[i], error);
    return status;
}

int32_t co_given_chains_create(const curvopt_mesh *m, const double *xyz, const curvopt_through *t, int32_t levels,
                               co_constraints *constraints, curvopt_error *error) {
    double centroid[3];
    reader r = {.mesh = m,
                .xyz = xyz,
                .levels = levels,
                .constraints = constraints,
                .vertex_owner = CO_NEW(int32_t, m->info.n_vertices),
                .edge_owner = CO_NEW(int32_t, m->info.n_edges),
                .group = CO_NEW(int32_t, t->n_chains),
                .n_points = CO_NEW(int32_t, t->n_chains),
                .radius = co_similarity_mesh_frame(m, xyz, centroid)};
    constraints->chains.item = CO_NEW(co_chain, t->n_chains);
    const int has_room = r.vertex_owner && r.edge_owner && r.group && r.n_points && constraints->chains.item;
    int32_t status = has_room ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        memset(r.vertex_owner, 0xff, (size_t)m->info.n_vertices * sizeof *r.vertex_owner);
        memset(r.edge_owner, 0xff, (size_t)m->info.n_edges * sizeof *r.edge_owner);
        status = read_chains(&r, t, error);
    }
    if (status == CURVOPT_OK)
        status = co_constraints_hold_chains(m, constraints, error);
    free(r.vertex_owner);
    free(r.edge_owner);
    free(r.group);
    free(r.n_points);
    return status;
}
