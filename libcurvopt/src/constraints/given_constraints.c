/* The user's constraints. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/given_constraints.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "constraints/given_through.h"
#include "constraints/interpolation.h"
#include "constraints/look_ahead.h"
#include "constraints/pivots.h"
#include "constraints/placement.h"
#include "mesh/similarity.h"
#include "surface/vertex_mask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double UNSEEN = -1; /* weight of a vertex that no constraint was seen on */

/* A constraint, checked. */
typedef struct one {
    int32_t vertex, freedom;
    int of_limit, has_place; /* a place that was given */
    double weight;
    double direction[3]; /* of length 1, or 0 */
    double place[3];
} one;

static int32_t read_direction(const curvopt_constraints *from, int32_t i, one *c, curvopt_error *error) {
    if (c->freedom == CO_FREEDOM_NONE)
        return CURVOPT_OK;
    if (!from->directions)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "constraint %d on vertex %d has no direction", i,
                              c->vertex);
    double *d = c->direction;
    memcpy(d, from->directions + 3 * (size_t)i, 3 * sizeof *d);
    const double length = co_length3(d);
    if (!(length > 0) || !isfinite(length))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "constraint %d on vertex %d has the direction %g %g %g",
                              i, c->vertex, d[0], d[1], d[2]);
    for (int k = 0; k < 3; k++)
        d[k] /= length;
    return CURVOPT_OK;
}

/* Where the constraint is: given, or where the vertex or its limit point is. */
static int32_t read_place(const curvopt_mesh *m, const double *xyz, const curvopt_constraints *from, int32_t i, one *c,
                          curvopt_error *error) {
    const double *given = from->has_places && from->places ? from->places + 3 * (size_t)i : NULL;
    if (given && !(isnan(given[0]) && isnan(given[1]) && isnan(given[2]))) {
        memcpy(c->place, given, sizeof c->place);
        c->has_place = 1;
        return isfinite(given[0]) && isfinite(given[1]) && isfinite(given[2])
                   ? CURVOPT_OK
                   : co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                                    "constraint %d on vertex %d has the place %g %g %g", i, c->vertex, given[0],
                                    given[1], given[2]);
    }
    if (c->of_limit)
        co_vertex_mask_point(m, c->vertex, xyz, c->place);
    else
        memcpy(c->place, xyz + 3 * (size_t)c->vertex, sizeof c->place);
    return CURVOPT_OK;
}

static int32_t read_one(const curvopt_mesh *m, const double *xyz, const curvopt_constraints *from, int32_t i, one *c,
                        curvopt_error *error) {
    const int32_t v = from->vertices[i], given = from->freedom ? from->freedom[i] : CO_FREEDOM_NONE;
    const int of_limit = given >= CURVOPT_FREEDOM_OF_LIMIT_POINT;
    *c = (one){.vertex = v,
               .freedom = of_limit ? given - CURVOPT_FREEDOM_OF_LIMIT_POINT : given,
               .of_limit = of_limit,
               .weight = from->weights ? co_constraint_weight(from->weights[i]) : 1};
    if (v < 0 || v >= m->info.n_vertices)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "constraint %d is on vertex %d; there are %d vertices",
                              i, v, m->info.n_vertices);
    if (c->freedom < CO_FREEDOM_NONE || c->freedom > CO_FREEDOM_PLANE)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                              "constraint %d leaves vertex %d %d dimensions; it must be 0 to 2", i, v, given);
    if (!(c->weight >= 0 && c->weight <= 1))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                              "constraint %d on vertex %d has the weight %g; it must be 0 to 1", i, v, c->weight);
    if (of_limit && c->weight < 1)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                              "constraint %d on the limit point of vertex %d has the weight %g; it must be 1", i, v,
                              c->weight);
    if (of_limit && !co_vertex_mask_exists(m, v))
        return co_status_fail(
            error, CURVOPT_ERROR_ARGUMENT, i,
            "constraint %d is on the limit point of vertex %d, where a crease fades or ends, or there "
            "is no surface; constrain the vertex itself",
            i, v);
    int32_t status = read_direction(from, i, c, error);
    return status == CURVOPT_OK ? read_place(m, xyz, from, i, c, error) : status;
}

/* weight [n_vertices]: UNSEEN where there is no constraint yet. */
static int32_t add(const one *c, int32_t i, double *weight, co_constraints *constraints, curvopt_error *error) {
    const int32_t v = c->vertex;
    double *direction = constraints->direction + 3 * (size_t)v, *place = constraints->anchor + 3 * (size_t)v;
    if (weight[v] != UNSEEN &&
        (weight[v] != c->weight || constraints->freedom[v] != c->freedom || constraints->of_limit[v] != c->of_limit ||
         (c->freedom != CO_FREEDOM_NONE && !co_freedom_same_direction(c->direction, direction)) ||
         memcmp(place, c->place, sizeof c->place) != 0))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "vertex %d has two constraints that contradict", v);
    weight[v] = c->weight;
    constraints->freedom[v] = (uint8_t)c->freedom;
    constraints->of_limit[v] = (uint8_t)c->of_limit;
    memcpy(direction, c->direction, sizeof c->direction);
    memcpy(place, c->place, sizeof c->place);
    return CURVOPT_OK;
}

/* Refuses a place that is too far for a cage with this frame. */
static int32_t check_place(const one *c, int32_t i, const double centroid[3], double radius, curvopt_error *error) {
    const double *p = c->place;
    if (!c->has_place || co_similarity_reaches(centroid, radius, p))
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                          "constraint %d on vertex %d has the place %g %g %g, which is more than %g times the cage's "
                          "size away",
                          i, c->vertex, p[0], p[1], p[2], CO_SIMILARITY_FARTHEST);
}

/* Constraints of a weight below 1 become soft ones, or none. */
static int32_t separate_soft(const curvopt_mesh *m, const double *xyz, double *weight, co_constraints *constraints,
                             curvopt_error *error) {
    int32_t status = CURVOPT_OK, n_exact = 0, n_soft = 0;
    for (int32_t v = 0; v < m->info.n_vertices; v++) {
        weight[v] = fmax(weight[v], 0);
        n_exact += weight[v] == 1;
        n_soft += weight[v] > 0 && weight[v] < 1;
    }
    double *rest = n_soft ? CO_NEW(double, 3 * (size_t)m->info.n_vertices) : NULL; /* the cage, springs at rest */
    if (n_soft && !rest)
        status = co_status_no_memory(error);
    for (size_t i = 0; rest && i < 3 * (size_t)m->info.n_vertices; i++)
        rest[i] = weight[i / 3] > 0 && weight[i / 3] < 1 ? constraints->anchor[i] : xyz[i];
    if (rest)
        status = co_soft_constraints_create(m, rest, weight, constraints->freedom, constraints->direction,
                                            &constraints->springs, error);
    free(rest);
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        if (weight[v] < 1)
            constraints->freedom[v] = CO_FREEDOM_ALL;
    if (!n_exact && !n_soft)
        co_constraints_free(constraints);
    return status;
}

int32_t co_given_constraints_create(const curvopt_mesh *m, const double *xyz, const curvopt_constraints *from,
                                    co_constraints *out, curvopt_error *error) {
    *out = (co_constraints){0};
    if (!from || from->n == 0)
        return CURVOPT_OK;
    if (from->n < 0 || !from->vertices)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "constraints: %d of them, vertices %s", from->n,
                              from->vertices ? "given" : "is NULL");
    if (from->has_places < 0 || from->has_places > 1)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "constraints.has_places is %d; it must be 0 or 1",
                              from->has_places);
    const size_t n = (size_t)m->info.n_vertices;
    double *weight = CO_NEW(double, n), centroid[3], radius = co_similarity_mesh_frame(m, xyz, centroid);
    int32_t status = weight ? co_constraints_allocate(m->info.n_vertices, out, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        memcpy(out->anchor, xyz, 3 * n * sizeof *xyz);
    for (size_t v = 0; status == CURVOPT_OK && v < n; v++)
        weight[v] = UNSEEN;
    for (int32_t i = 0; status == CURVOPT_OK && i < from->n; i++) {
        one c;
        status = read_one(m, xyz, from, i, &c, error);
        if (status == CURVOPT_OK)
            status = check_place(&c, i, centroid, radius, error);
        if (status == CURVOPT_OK)
            status = add(&c, i, weight, out, error);
    }
    if (status == CURVOPT_OK)
        status = separate_soft(m, xyz, weight, out, error);
    free(weight);
    if (status != CURVOPT_OK)
        co_constraints_free(out);
    return status;
}

static int32_t freedom_of(const curvopt_constraints *given, int32_t i) {
    return given->freedom ? given->freedom[i] % CURVOPT_FREEDOM_OF_LIMIT_POINT : CO_FREEDOM_NONE;
}

static double weight_of(const curvopt_constraints *given, int32_t i) {
    return given->weights ? co_constraint_weight(given->weights[i]) : 1;
}

static int has_place(const curvopt_constraints *given, int32_t i) {
    return given->has_places && given->places && !isnan(given->places[3 * (size_t)i]);
}

int co_given_constraints_have_places(const curvopt_constraints *given) {
    for (int32_t i = 0; given && i < given->n; i++)
        if (has_place(given, i))
            return 1;
    return 0;
}

/* What constraint i has that a run within a distance cannot promise; NULL if nothing. */
static const char *against_within(const curvopt_constraints *given, int32_t i) {
    const int32_t freedom = freedom_of(given, i);
    const double weight = weight_of(given, i);
    if (has_place(given, i))
        return "has a place where the vertex is to be";
    return weight > 0 && weight < 1 && freedom != CO_FREEDOM_NONE ? "is soft and leaves directions free" : NULL;
}

static int32_t check_within(const curvopt_constraints *given, curvopt_error *error) {
    for (int32_t i = 0; given && i < given->n; i++) {
        const char *what = against_within(given, i);
        if (what)
            return co_status_fail(
                error, CURVOPT_ERROR_ARGUMENT, i,
                "constraint %d, of vertex %d, %s, and the surface is to stay within a distance of the "
                "input; leave one of them out",
                i, given->vertices[i], what);
    }
    return CURVOPT_OK;
}

int32_t co_given_constraints_check_strength(const curvopt_constraints *given, const curvopt_options *options,
                                            curvopt_error *error) {
    if (options->within > 0)
        return check_within(given, error);
    for (int32_t i = 0; given && options->strength < 1 && i < given->n; i++) {
        const int32_t freedom = freedom_of(given, i);
        const double weight = weight_of(given, i);
        if (has_place(given, i) && weight > 0 && (weight < 1 || freedom != CO_FREEDOM_NONE))
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                                  "constraint %d has a place for vertex %d and does not hold it exactly there, where a "
                                  "strength below 1 pulls it back to the input; hold it exactly, or use strength 1",
                                  i, given->vertices[i]);
    }
    return CURVOPT_OK;
}

/* Positions in xyz [3 n_vertices] (interpolation.h) become what is held exactly. */
static int32_t put_positions(const curvopt_mesh *m, const co_constraints *given, const co_constraints *all,
                             const co_interpolation *map, double *xyz, curvopt_error *error) {
    for (int32_t v = 0; given->freedom && v < m->info.n_vertices; v++)
        if (!given->of_limit[v])
            co_constraints_put_back(given, v, xyz + 3 * (size_t)v);
    co_interpolation_from_cage(map, xyz);
    for (int32_t i = 0; i < map->limit.n_rows; i++)
        if (all->of_limit[map->vertex[i]] == CO_OF_OWN_POINT)
            co_constraints_put_back(given, map->vertex[i], xyz + 3 * (size_t)map->vertex[i]);
    return co_given_through_place(all, xyz, error);
}

/* The same by vertices near them; xyz is the cage, where vertices that are held themselves are put first. */
static int32_t move_cage(const curvopt_mesh *m, const co_constraints *given, const co_constraints *all,
                         const co_interpolation *map, double *xyz, curvopt_error *error) {
    const size_t n_rows = (size_t)map->limit.n_rows, n = (size_t)m->info.n_vertices;
    double *positions = CO_NEW(double, 3 * (n + n_rows)), *wanted = positions ? positions + 3 * n : NULL;
    if (!positions)
        return co_status_no_memory(error);
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        if (!given->of_limit[v])
            co_constraints_put_back(given, v, xyz + 3 * (size_t)v);
    memcpy(positions, xyz, 3 * n * sizeof *xyz);
    int32_t status = put_positions(m, given, all, map, positions, error);
    for (size_t i = 0; i < n_rows; i++)
        memcpy(wanted + 3 * i, positions + 3 * (size_t)map->vertex[i], 3 * sizeof *wanted);
    if (status == CURVOPT_OK)
        status = co_placement_move(map, all, wanted, xyz, error);
    free(positions);
    return status;
}

int co_given_constraints_move_cage(const curvopt_mesh *m, const co_constraints *constraints) {
    return constraints->values.n > 0 || co_chains_hold_any(&constraints->chains) || co_looks_ahead(m, constraints);
}

/* Boundaries and creases that are held keep their vertices; of each chain others must be left. */
static int32_t check_chains(const co_constraints *given, const co_constraints *all, curvopt_error *error) {
    for (int32_t k = 0; k < given->chains.n; k++) {
        const co_chain *chain = &given->chains.item[k];
        int32_t i = 0;
        while (i < chain->n && all->of_limit[chain->vertex[i]] != CO_OF_OWN_POINT)
            i++;
        if (chain->stiffness == 0 && i == chain->n)
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, chain->number,
                                  "chain %d: the boundary, a crease or left-out faces hold all of its vertices, vertex "
                                  "%d first",
                                  chain->number, chain->vertex[0]);
    }
    return CURVOPT_OK;
}

/* Vertices that look ahead move to where they will be as wanted, also where the boundary or something else holds them
 * from then on. */
static void free_those_ahead(const curvopt_mesh *m, const co_constraints *given, co_constraints *all) {
    for (int32_t v = 0; given->freedom && v < m->info.n_vertices; v++)
        if (co_looks_ahead_at(given, v)) {
            all->freedom[v] = given->freedom[v];
            all->of_limit[v] = given->of_limit[v];
        }
}

int32_t co_given_constraints_place(const curvopt_mesh *m, const co_constraints *constraints, int32_t boundary,
                                   double *xyz, curvopt_error *error) {
    co_interpolation map = {0};
    co_constraints all = {0};
    const int moves_cage = co_given_constraints_move_cage(m, constraints);
    int32_t status = moves_cage ? co_constraints_all(m, constraints, boundary, &all, error)
                                : co_constraints_copy(m, constraints, &all, error);
    if (status == CURVOPT_OK) {
        free_those_ahead(m, constraints, &all);
        status = check_chains(constraints, &all, error);
    }
    if (status == CURVOPT_OK)
        status = co_pivots_choose(m, NULL, &all, error);
    if (status == CURVOPT_OK)
        status = co_interpolation_of_all(m, &all, &map, error);
    if (status == CURVOPT_OK && moves_cage) {
        status = move_cage(m, constraints, &all, &map, xyz, error);
    } else if (status == CURVOPT_OK) {
        status = put_positions(m, constraints, &all, &map, xyz, error);
        co_interpolation_to_cage(&map, xyz);
    }
    co_interpolation_free(&map);
    co_constraints_free(&all);
    return status;
}
