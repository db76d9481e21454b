/* A cage moved so that values of its surface are what they are to be. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/placement.h"

#include "base/memory.h"
#include "constraints/freedom.h"
#include "constraints/held_curvatures.h"
#include "linalg/vector.h"

#include <stdlib.h>
#include <string.h>

/* Conjugate gradients end when the residual is this part of what it was, or after so many steps. */
static const double ENOUGH = 1e-10;
enum { MOST_STEPS = 200 };

static int may_move(const co_constraints *c, int32_t v) {
    return c->freedom[v] == CO_FREEDOM_ALL || c->of_limit[v] != CO_OF_VERTEX;
}

/* field [3 n_vertices] = M^T value */
static void spread(const co_interpolation *map, const co_constraints *c, const double *value, double *field) {
    const int32_t n = map->limit.n_columns;
    memset(field, 0, 3 * sizeof *field * (size_t)n);
    co_sparse_rows_add_transposed(&map->limit, value, field);
    for (int32_t v = 0; v < n; v++)
        if (!may_move(c, v))
            memset(field + 3 * (size_t)v, 0, 3 * sizeof *field);
}

/* Leaves of value [3 n_rows] what is held; H is the projector. */
static void keep_held(const co_interpolation *map, const co_constraints *c, double *value) {
    for (int32_t i = 0; i < map->limit.n_rows; i++) {
        const size_t v = (size_t)map->vertex[i];
        double free_part[9], *x = value + 3 * (size_t)i;
        co_freedom_projector(c->freedom[v], c->direction + 3 * v, free_part);
        const double was[3] = {x[0], x[1], x[2]};
        for (size_t k = 0; k < 3; k++)
            for (size_t l = 0; l < 3; l++)
                x[k] -= free_part[3 * k + l] * was[l];
    }
}

/* Solves H M M^T H x = r [3 n_rows], which is spent, by conjugate gradients; x is 0 at first. work [6 n_rows + 3
 * n_vertices]
 */
static void solve(const co_interpolation *map, const co_constraints *c, double *r, double *x, double *work) {
    const size_t n = 3 * (size_t)map->limit.n_rows;
    double *d = work, *q = work + n, *field = work + 2 * n, square = co_vector_dot(n, r, r);
    const double end = ENOUGH * ENOUGH * square;
    memcpy(d, r, n * sizeof *d);
    for (int k = 0; k < MOST_STEPS && square > end; k++) {
        spread(map, c, d, field);
        co_sparse_rows_apply(&map->limit, field, q);
        keep_held(map, c, q);
        const double length = co_vector_dot(n, d, q);
        if (!(length > 0))
            return;
        co_vector_add(n, square / length, d, x);
        co_vector_add(n, -square / length, q, r);
        const double next = co_vector_dot(n, r, r);
        for (size_t i = 0; i < n; i++)
            d[i] = r[i] + next / square * d[i];
        square = next;
    }
}

int32_t co_placement_move(const co_interpolation *map, const co_constraints *constraints, const double *wanted,
                          double *xyz, curvopt_error *error) {
    const size_t n = 3 * (size_t)map->limit.n_rows, n_cage = 3 * (size_t)map->limit.n_columns;
    double *rest = CO_NEW(double, 4 * n + n_cage);
    if (!rest)
        return co_status_no_memory(error);
    double *x = rest + n, *work = rest + 2 * n, *field = work + 2 * n;
    co_sparse_rows_apply(&map->limit, xyz, rest);
    for (size_t i = 0; i < n; i++)
        rest[i] = wanted[i] - rest[i];
    keep_held(map, constraints, rest);
    solve(map, constraints, rest, x, work);
    spread(map, constraints, x, field);
    co_vector_add(n_cage, 1, field, xyz);
    co_sparse_rows_apply(&map->limit, xyz, x);
    for (size_t i = 0; i < n; i++)
        rest[i] = wanted[i] - x[i];
    keep_held(map, constraints, rest);
    for (size_t i = 0; i < n; i++) /* what is left, by the vertices in whose place the values are */
        xyz[3 * (size_t)map->vertex[i / 3] + i % 3] = x[i] + rest[i];
    if (co_held_curvatures_exist(&constraints->values))
        co_interpolation_to_cage_exactly(map, field, xyz);
    else
        co_interpolation_to_cage(map, xyz);
    free(rest);
    return CURVOPT_OK;
}
