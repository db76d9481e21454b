/* What keeps a surface from crossing itself. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/repulsion.h"

#include "base/elementary.h"
#include "base/memory.h"
#include "base/vec3.h"
#include "hessian/node_sum.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double area_of(const double piece[CO_BEZIER]) {
    co_bezier_jet jet;
    double square = 0;
    co_bezier_at(piece, 0.5, 0.5, &jet);
    for (int c = 0; c < 3; c++) {
        const int d = (c + 1) % 3, e = (c + 2) % 3;
        const double x = jet.u[d] * jet.v[e] - jet.u[e] * jet.v[d];
        square += x * x;
    }
    return sqrt(square);
}

static int32_t allocate(co_repulsion *r, curvopt_error *error) {
    const co_patches *p = &r->pieces.patches;
    int32_t largest = 0;
    for (int32_t k = 0; k < p->n_patches; k++)
        largest = co_patches_own_size(p->kind[k]) > largest ? co_patches_own_size(p->kind[k]) : largest;
    r->area = CO_NEW(double, r->pieces.n_pieces);
    r->clear = CO_NEW(double, 3 * (size_t)p->n_points);
    r->row = CO_NEW(double, largest);
    r->point_gradient = CO_NEW(double, 3 * (size_t)p->n_points);
    return r->area && r->clear && r->row && r->point_gradient ? CURVOPT_OK : co_status_no_memory(error);
}

int32_t co_repulsion_create(const curvopt_mesh *mesh, const co_substitution *substitution, const double *x,
                            double reach, co_repulsion_exceptions *exceptions, co_thread_pool *threads, co_repulsion *r,
                            curvopt_error *error) {
    double sum = 0;
    *r = (co_repulsion){.mesh = mesh, .exceptions = exceptions, .threads = threads, .reach = reach};
    int32_t status = co_pieces_prepare(mesh, substitution, CO_REPULSION_TIP, NULL, &r->pieces, error);
    if (status == CURVOPT_OK)
        status = allocate(r, error);
    if (status == CURVOPT_OK)
        status = co_patch_neighbours_create(mesh, &r->pieces.patches, &r->neighbours, error);
    if (status != CURVOPT_OK) {
        co_repulsion_free(r);
        return status;
    }
    co_pieces_place(&r->pieces, x, threads, NULL);
    for (int32_t k = 0; k < r->pieces.n_pieces; k++)
        sum += r->area[k] = area_of(co_pieces_bezier(&r->pieces, k));
    for (int32_t k = 0; k < r->pieces.n_pieces; k++)
        r->area[k] /= sum;
    return CURVOPT_OK;
}

void co_repulsion_free(co_repulsion *r) {
    co_pieces_free(&r->pieces);
    co_facings_free(&r->facings);
    co_patch_neighbours_free(&r->neighbours);
    free(r->area);
    free(r->clear);
    free(r->row);
    free(r->point_gradient);
    *r = (co_repulsion){0};
}

void co_repulsion_copy(co_repulsion *r, const co_repulsion *other) {
    r->reach = other->reach;
    r->weight = other->weight;
    memcpy(r->area, other->area, (size_t)r->pieces.n_pieces * sizeof *r->area);
}

/* ------------------------------------------------------------------------------------------------ value -- */

static int crosses_anew(co_repulsion *r, const co_near_patches *near) {
    co_crossings found;
    const int32_t status = r->is_thorough ? co_crossings_find(r->mesh, &r->pieces, r->threads, NULL, &found, NULL)
                                          : co_crossings_find_near(r->mesh, near, r->threads, &found, NULL);
    const int is_new = !co_face_pairs_allow(&r->exceptions->pairs, &found);
    co_crossings_free(&found);
    if (status != CURVOPT_OK)
        r->exceptions->failed = status;
    return is_new;
}

void co_repulsion_accept(co_repulsion *r, const double *x) {
    co_near_patches near = {0};
    if (!r->exceptions->pairs.n_crossing)
        return;
    co_pieces_place(&r->pieces, x, r->threads, NULL);
    int32_t status = co_near_patches_create(&r->pieces, &r->neighbours, r->reach, r->threads, &near, NULL);
    for (int k = 0; k < 2 && status == CURVOPT_OK; k++) {
        co_crossings found;
        status = k ? co_crossings_find_near(r->mesh, &near, r->threads, &found, NULL)
                   : co_crossings_find(r->mesh, &r->pieces, r->threads, NULL, &found, NULL);
        if (status == CURVOPT_OK)
            co_face_pairs_accept(&r->exceptions->pairs, &found);
        co_crossings_free(&found);
    }
    co_near_patches_free(&near);
    if (status != CURVOPT_OK)
        r->exceptions->failed = status;
}

/* Two surfaces that were `clearance` apart cannot meet before one of them has moved by half of it. Half of that again,
 * because it is known at points only. Surfaces move by no more than what their patches are made of, which positions
 * that limit points or tangents stand in place of are not. */
static const double NEAR = 0.25;

static int is_near(const co_repulsion *r) {
    const double most = NEAR * r->clearance;
    for (size_t i = 0; i < 3 * (size_t)r->pieces.patches.n_points; i += 3)
        if (!(co_distance3_squared(r->pieces.points + i, r->clear + i) < most * most))
            return 0;
    return 1;
}

/* Whether a look at these very points, as thorough as the one that is due, found no crossing. Where a level's last
 * steps were none, or one was taken back, up to three looks are due at the same points. */
static int is_clear_here(const co_repulsion *r) {
    return r->clear_look >= (r->is_thorough ? CO_LOOK_THOROUGH : CO_LOOK_CURSORY) &&
           memcmp(r->clear, r->pieces.points, 3 * sizeof *r->clear * (size_t)r->pieces.patches.n_points) == 0;
}

static void remember(co_repulsion *r) {
    memcpy(r->clear, r->pieces.points, 3 * sizeof *r->clear * (size_t)r->pieces.patches.n_points);
    r->clear_look = r->is_thorough ? CO_LOOK_THOROUGH : CO_LOOK_CURSORY;
    r->clearance = r->reach;
    for (size_t k = 0; k < r->facings.n; k++)
        r->clearance = fmin(r->clearance, r->facings.pair[k].distance);
}

/* What faces what at x; and if wanted whether there is a crossing. */
static int look(co_repulsion *r, const double *x, int wants_crossings) {
    co_near_patches near;
    int crosses = 0;
    co_facings_free(&r->facings);
    co_pieces_place(&r->pieces, x, r->threads, NULL);
    const int is_wanted = wants_crossings && !is_clear_here(r) && (r->is_thorough || !is_near(r));
    int32_t status = co_near_patches_create(&r->pieces, &r->neighbours, r->reach, r->threads, &near, NULL);
    if (status == CURVOPT_OK && is_wanted)
        crosses = crosses_anew(r, &near);
    if (status == CURVOPT_OK && !crosses)
        status = co_facings_find(r->mesh, &near, r->reach, &r->exceptions->pairs, r->threads, &r->facings, NULL);
    co_near_patches_free(&near);
    if (status != CURVOPT_OK)
        r->exceptions->failed = status;
    else if (is_wanted && !crosses)
        remember(r);
    return crosses;
}

void co_repulsion_look(co_repulsion *r, const double *x) {
    look(r, x, 0);
}

/* The barrier at x = d / reach, below 1, and its first two derivatives. */
static void barrier(double x, double out[3]) {
    const double y = x - 1, log = co_log(x);
    out[0] = -y * y * log;
    out[1] = -2 * y * log - y * y / x;
    out[2] = -2 * log - 4 * y / x + y * y / (x * x);
}

/* Adds a force at a point of a piece to those at its patch's points. */
static void spread(co_repulsion *r, int32_t piece, const double uv[2], const double along[3], double factor) {
    const co_patches *p = &r->pieces.patches;
    const int32_t patch = r->pieces.patch[piece], n = co_patches_own_size(p->kind[patch]);
    const int32_t *point = p->points + p->start[patch];
    co_pieces_row(&r->pieces, piece, uv[0], uv[1], r->row);
    for (int32_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++)
            r->point_gradient[3 * (size_t)point[i] + c] += factor * r->row[i] * along[c];
}

static void collect(co_repulsion *r, double *gradient) {
    const co_patches *p = &r->pieces.patches;
    memcpy(gradient, r->point_gradient, 3 * (size_t)p->n_cage * sizeof *gradient);
    co_patches_add_derived(p, r->point_gradient, gradient);
}

double co_repulsion_value(co_repulsion *r, const double *x, double *gradient) {
    double sum = 0;
    const int crosses = look(r, x, 1);
    *r->exceptions->n_refused += crosses;
    if (crosses || r->exceptions->failed != CURVOPT_OK)
        return (double)INFINITY;
    if (gradient)
        memset(r->point_gradient, 0, 3 * (size_t)r->pieces.patches.n_points * sizeof *r->point_gradient);
    for (size_t k = 0; k < r->facings.n; k++) {
        const co_facing *f = &r->facings.pair[k];
        double b[3];
        if (!(f->distance > 0))
            return (double)INFINITY;
        barrier(f->distance / r->reach, b);
        const double area = r->weight * r->area[f->piece[0]] * f->weight;
        sum += area * b[0];
        if (!gradient)
            continue;
        spread(r, f->piece[0], f->uv[0], f->along, area * b[1] / r->reach);
        spread(r, f->piece[1], f->uv[1], f->along, -area * b[1] / r->reach);
    }
    if (gradient)
        collect(r, gradient);
    return sum;
}

/* --------------------------------------------------------------------------------------------- hessian -- */

/* Of the distance of a pair, by nodes, which ascend. */
static void differentiate(co_repulsion *r, const co_facing *f, const co_dof_map *dofs, co_node_sum *d) {
    const co_patches *p = &r->pieces.patches;
    co_node_sum_clear(d);
    for (int side = 0; side < 2; side++) {
        const int32_t patch = r->pieces.patch[f->piece[side]];
        co_pieces_row(&r->pieces, f->piece[side], f->uv[side][0], f->uv[side][1], r->row);
        for (int32_t i = 0; i < co_patches_own_size(p->kind[patch]); i++) {
            const co_point_row row = co_patches_row(p, &p->points[p->start[patch] + (size_t)i]);
            for (size_t e = 0; e < row.n; e++)
                co_node_sum_add(d, dofs, row.vertex[e], f->along, (side ? -1 : 1) * r->row[i] * row.weight[e]);
        }
    }
    co_node_sum_sort(d);
}

void co_repulsion_add_hessian(co_repulsion *r, co_sparse_hessian *h) {
    co_node_sum d;
    int32_t status = co_node_sum_create(h->dofs->n_nodes, &d, NULL);
    for (size_t k = 0; status == CURVOPT_OK && k < r->facings.n; k++) {
        const co_facing *f = &r->facings.pair[k];
        double b[3];
        if (!(f->distance > 0))
            continue;
        barrier(f->distance / r->reach, b);
        differentiate(r, f, h->dofs, &d);
        co_sparse_hessian_add_square(h, d.n, d.part,
                                     r->weight * r->area[f->piece[0]] * f->weight * b[2] / (r->reach * r->reach));
    }
    if (status != CURVOPT_OK)
        r->exceptions->failed = status;
    co_node_sum_free(&d);
}

/* Vertices of a patch, each perhaps several times, into `out`; NULL: they are only counted. Returns their number. */
static size_t vertices_of(const co_patches *p, int32_t patch, int32_t *out) {
    size_t n = 0;
    for (int32_t i = 0; i < co_patches_own_size(p->kind[patch]); i++) {
        const co_point_row row = co_patches_row(p, &p->points[p->start[patch] + (size_t)i]);
        for (size_t e = 0; e < row.n; e++) {
            if (out)
                out[n] = row.vertex[e];
            n++;
        }
    }
    return n;
}

/* From facing *k on the next pair of patches that is another than patch[2], into that; 0: there is none. */
static int next_patches(const co_repulsion *r, size_t *k, int32_t patch[2]) {
    while (*k < r->facings.n) {
        const int32_t *piece = r->facings.pair[(*k)++].piece;
        const int32_t next[2] = {r->pieces.patch[piece[0]], r->pieces.patch[piece[1]]};
        if (next[0] != patch[0] || next[1] != patch[1]) {
            memcpy(patch, next, sizeof next);
            return 1;
        }
    }
    return 0;
}

int co_repulsion_is_covered(const co_repulsion *r, const co_sparsity *pattern, const co_dof_map *dofs) {
    const co_patches *p = &r->pieces.patches;
    int32_t patch[2] = {-1, -1};
    for (size_t k = 0; next_patches(r, &k, patch);) {
        for (size_t i = p->start[patch[0]]; i < p->start[patch[0]] + (size_t)co_patches_own_size(p->kind[patch[0]]);
             i++)
            for (size_t j = p->start[patch[1]]; j < p->start[patch[1]] + (size_t)co_patches_own_size(p->kind[patch[1]]);
                 j++) {
                const co_point_row one = co_patches_row(p, &p->points[i]), two = co_patches_row(p, &p->points[j]);
                for (size_t e = 0; e < one.n; e++)
                    for (size_t f = 0; f < two.n; f++)
                        if (!co_sparsity_has(pattern, dofs->node[one.vertex[e]], dofs->node[two.vertex[f]]))
                            return 0;
            }
    }
    return 1;
}

int32_t co_repulsion_couplings(const co_repulsion *r, co_couplings *out, curvopt_error *error) {
    const co_patches *p = &r->pieces.patches;
    size_t n_vertices = 0;
    *out = (co_couplings){.start = CO_NEW(size_t, r->facings.n + 1)};
    if (!out->start)
        return co_status_no_memory(error);
    for (int pass = 0; pass < 2; pass++) {
        int32_t patch[2] = {-1, -1};
        out->n = 0;
        n_vertices = 0;
        for (size_t k = 0; next_patches(r, &k, patch);) {
            for (int side = 0; side < 2; side++)
                n_vertices += vertices_of(p, patch[side], pass ? out->vertex + n_vertices : NULL);
            out->start[++out->n] = n_vertices;
        }
        if (pass == 0 && !(out->vertex = CO_NEW(int32_t, n_vertices))) {
            co_couplings_free(out);
            return co_status_no_memory(error);
        }
    }
    return CURVOPT_OK;
}
