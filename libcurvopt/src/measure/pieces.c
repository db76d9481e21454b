/* A cage's limit surface as bicubic Bezier pieces. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/pieces.h"

#include "base/elementary.h"
#include "base/memory.h"
#include "base/vec3.h"
#include "mesh/similarity.h"
#include "surface/stam.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PIECES = 2000000, LEAST_RINGS = 3, MOST_RINGS = 40 };

/* Rows of all rings of one kind of fan. */
typedef struct co_ring_table {
    int32_t n_rings, n_points, n_rows;
    double *rows; /* [n_rings][n_points][n_rows], as co_stam_disc.rows */
    double *mask; /* [n_points] limit position of the vertex */
    int32_t cell[CO_RING_CELLS][16], mirrored[CO_RING_CELLS][16];
} ring_table;

typedef struct build {
    co_surface_pieces *out;
    const curvopt_cancel *cancel;
} build;

static void table_free(ring_table *t) {
    free(t->rows);
    free(t->mask);
}

static int32_t table_create(int32_t fan, double ratio, int32_t most_rings, const curvopt_cancel *cancel, ring_table *t,
                            curvopt_error *error) {
    co_stam_disc disc;
    int32_t status = co_stam_disc_create(fan, &disc, error);
    if (status != CURVOPT_OK)
        return status;
    int32_t n_rings = (int32_t)ceil(co_log(ratio) / co_log(fmin(disc.lambda, 0.9)));
    n_rings = n_rings < LEAST_RINGS ? LEAST_RINGS : n_rings > most_rings ? most_rings : n_rings;
    const size_t n = (size_t)disc.n_points * (size_t)disc.n_rows;
    *t = (ring_table){.n_rings = n_rings, .n_points = disc.n_points, .n_rows = disc.n_rows};
    t->rows = CO_NEW(double, n *(size_t)n_rings);
    t->mask = CO_NEW(double, disc.n_points);
    if (!t->rows || !t->mask) {
        table_free(t);
        *t = (ring_table){0};
        co_stam_disc_free(&disc);
        return co_status_no_memory(error);
    }
    memcpy(t->cell, disc.cell, sizeof t->cell);
    memcpy(t->mirrored, disc.mirrored, sizeof t->mirrored);
    for (int32_t ring = 0; ring < n_rings && !co_cancel_is_requested(cancel); ring++) {
        memcpy(t->rows + n * (size_t)ring, disc.rows, n * sizeof(double));
        co_stam_disc_advance(&disc);
    }
    co_stam_disc_limit_mask(&disc, t->mask);
    co_stam_disc_free(&disc);
    return CURVOPT_OK;
}

/* The place of a cell of a ring, from its patch's. */
static co_place place_of_cell(const co_place *patch, int32_t ring, int cell) {
    co_place out = *patch;
    const double scale = ldexp(1, -(patch->level + ring));
    double x = scale * co_stam_cell_place[cell][0], y = scale * co_stam_cell_place[cell][1];
    for (int turn = 0; turn < patch->rotation; turn++) {
        const double old_x = x;
        x = -y;
        y = old_x;
    }
    out.origin[0] += x;
    out.origin[1] += y;
    out.level += ring;
    return out;
}

static void regular_patch(const co_surface_pieces *s, int32_t p) {
    const int32_t *index = s->patches.points + s->patches.start[p];
    double spline[CO_BEZIER];
    for (size_t i = 0; i < 16; i++)
        memcpy(spline + 3 * i, s->points + 3 * (size_t)index[i], 3 * sizeof(double));
    co_bezier_from_bspline(spline, s->bezier + CO_BEZIER * (size_t)s->first[p]);
}

/* The points that one ring's cells are made of, relative to the vertex, which is the first: point [3][n_rows]. */
static void ring_points(const co_surface_pieces *s, int32_t p, const ring_table *t, int32_t ring, double *point) {
    const int32_t *index = s->patches.points + s->patches.start[p];
    const size_t n_rows = (size_t)t->n_rows;
    const double *rows = t->rows + (size_t)t->n_points * n_rows * (size_t)ring;
    const double *origin = s->points + 3 * (size_t)index[0];
    memset(point, 0, sizeof(double) * 3 * n_rows);
    for (size_t i = 1; i < (size_t)t->n_points; i++)
        for (size_t c = 0; c < 3; c++) {
            const double x = s->points[3 * (size_t)index[i] + c] - origin[c];
            for (size_t k = 0; k < n_rows; k++)
                point[c * n_rows + k] += rows[i * n_rows + k] * x;
        }
}

/* A cell's 16 points of a B-spline from those of its ring. */
static void cell_spline(const ring_table *t, int cell, const double *point, const double origin[3],
                        double spline[CO_BEZIER]) {
    for (size_t k = 0; k < 16; k++) {
        const int32_t at = t->cell[cell][k], mirrored = t->mirrored[cell][k];
        for (size_t c = 0; c < 3; c++) {
            const double *of_ring = point + c * (size_t)t->n_rows, vertex = origin[c] + of_ring[0];
            double x = (mirrored < 0 ? 1 : 2) * (at ? of_ring[at] : 0);
            if (mirrored > 0)
                x -= of_ring[mirrored];
            spline[3 * k + c] = vertex + x;
        }
    }
}

static void extraordinary_patch(const co_surface_pieces *s, int32_t p, const ring_table *t,
                                const curvopt_cancel *cancel) {
    const int32_t *index = s->patches.points + s->patches.start[p];
    double point[3 * CO_STAM_MOST_ROWS], spline[CO_BEZIER];
    co_tip *tip = &s->tip[s->tip_of[p]];
    *tip = (co_tip){.patch = p};
    for (int32_t i = 0; i < t->n_points; i++)
        for (size_t c = 0; c < 3; c++)
            tip->at[c] += t->mask[i] * s->points[3 * (size_t)index[i] + c];
    for (int32_t ring = 0; ring < t->n_rings && !co_cancel_is_requested(cancel); ring++) {
        ring_points(s, p, t, ring, point);
        for (int cell = 0; cell < CO_RING_CELLS; cell++) {
            double *bezier = s->bezier + CO_BEZIER * (size_t)(s->first[p] + CO_RING_CELLS * ring + cell);
            cell_spline(t, cell, point, s->points + 3 * (size_t)index[0], spline);
            co_bezier_from_bspline(spline, bezier);
            for (size_t k = 0; k < 16 && ring + 1 == t->n_rings; k++)
                tip->radius = fmax(tip->radius, 2 * co_distance3(bezier + 3 * k, tip->at));
        }
    }
}

static const ring_table *table_of(const co_surface_pieces *s, int32_t patch) {
    return &s->tables[co_patches_kind(&s->patches, s->patches.kind[patch])];
}

static void build_patches(void *context, size_t begin, size_t end) {
    const build *b = context;
    for (size_t p = begin; p < end; p++) {
        const int32_t kind = b->out->patches.kind[p];
        if (kind == CO_FAN_REGULAR)
            regular_patch(b->out, (int32_t)p);
        else
            extraordinary_patch(b->out, (int32_t)p, table_of(b->out, (int32_t)p), b->cancel);
    }
}

/* Made to their end, unless it is cancelled. */
static int32_t make_tables(const co_patches *p, double ratio, const curvopt_cancel *cancel, ring_table *tables,
                           curvopt_error *error) {
    int32_t n_fans = 1, status = CURVOPT_OK;
    for (int32_t i = 0; i < p->n_patches; i++)
        n_fans += p->kind[i] != CO_FAN_REGULAR;
    int32_t most = MOST_PIECES / CO_RING_CELLS / n_fans;
    most = most < LEAST_RINGS ? LEAST_RINGS : most > MOST_RINGS ? MOST_RINGS : most;
    for (int32_t k = 0; status == CURVOPT_OK && k < p->n_kinds; k++) {
        if (p->kinds[k] != CO_FAN_REGULAR)
            status = table_create(p->kinds[k], ratio, most, cancel, &tables[k], error);
        if (status == CURVOPT_OK && co_cancel_is_requested(cancel))
            status = CO_CANCELLED;
    }
    return status;
}

/* Counts pieces and tips, and makes room for them. */
static int32_t allocate(co_surface_pieces *s, curvopt_error *error) {
    const co_patches *p = &s->patches;
    size_t n = 0;
    s->first = CO_NEW(int32_t, (size_t)p->n_patches + 1);
    s->tip_of = CO_NEW(int32_t, p->n_patches);
    if (!s->first || !s->tip_of)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < p->n_patches; i++) {
        const int regular = p->kind[i] == CO_FAN_REGULAR;
        s->first[i] = (int32_t)n;
        s->tip_of[i] = regular ? -1 : s->n_tips++;
        n += regular ? 1 : CO_RING_CELLS * (size_t)table_of(s, i)->n_rings;
        if (n > INT32_MAX / 4)
            return co_status_no_memory(error);
    }
    s->first[p->n_patches] = s->n_pieces = (int32_t)n;
    s->bezier = CO_NEW_ALIGNED(double, CO_BEZIER *n);
    s->place = CO_NEW(co_place, n);
    s->patch = CO_NEW(int32_t, n);
    s->tip = CO_NEW(co_tip, s->n_tips);
    return s->bezier && s->place && s->patch && s->tip ? CURVOPT_OK : co_status_no_memory(error);
}

static void locate(co_surface_pieces *s) {
    for (int32_t p = 0; p < s->patches.n_patches; p++)
        for (int32_t k = s->first[p]; k < s->first[p + 1]; k++) {
            const int32_t at = k - s->first[p];
            s->patch[k] = p;
            s->place[k] = s->tip_of[p] < 0
                              ? s->patches.place[p]
                              : place_of_cell(&s->patches.place[p], at / CO_RING_CELLS + 1, at % CO_RING_CELLS);
        }
}

int32_t co_pieces_prepare(const curvopt_mesh *mesh, const co_substitution *substitution, double ratio,
                          const curvopt_cancel *cancel, co_surface_pieces *s, curvopt_error *error) {
    co_cancel once;
    *s = (co_surface_pieces){.size = 1};
    /* This surface's patches have no wide blends (patches.h): they are the limit surface's own. */
    co_cancel_start_at_once(&once, cancel);
    int32_t status = co_patches_create(mesh, NULL, NULL, CURVOPT_SURFACE_PLANE, 1, &once, &s->patches, error);
    if (status != CURVOPT_OK)
        return status;
    if (substitution)
        status = co_patches_substitute(&s->patches, substitution, error);
    s->points = CO_NEW(double, 3 * (size_t)s->patches.n_points);
    s->tables = CO_NEW(ring_table, s->patches.n_kinds);
    if (status == CURVOPT_OK)
        status = s->points && s->tables ? make_tables(&s->patches, ratio, cancel, s->tables, error)
                                        : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = allocate(s, error);
    if (status == CURVOPT_OK)
        locate(s);
    else
        co_pieces_free(s);
    return status;
}

int32_t co_pieces_place(co_surface_pieces *s, const double *x, co_thread_pool *pool, const curvopt_cancel *cancel) {
    build b = {.out = s, .cancel = cancel};
    memcpy(s->points, x, sizeof(double) * 3 * (size_t)s->patches.n_cage);
    co_patches_derive(&s->patches, s->points);
    co_thread_pool_for(pool, (size_t)s->patches.n_patches, build_patches, &b);
    return co_cancel_is_requested(cancel) ? CO_CANCELLED : CURVOPT_OK;
}

int32_t co_pieces_create(const curvopt_mesh *mesh, const double *xyz, double ratio, co_thread_pool *pool,
                         const curvopt_cancel *cancel, co_surface_pieces *out, curvopt_error *error) {
    double centroid[3];
    *out = (co_surface_pieces){0};
    int32_t status = co_similarity_check(mesh->info.n_vertices, xyz, error);
    if (status == CURVOPT_OK && co_cancel_is_requested(cancel))
        status = CO_CANCELLED;
    if (status == CURVOPT_OK)
        status = co_pieces_prepare(mesh, NULL, ratio, cancel, out, error);
    if (status != CURVOPT_OK)
        return status;
    out->size = co_similarity_mesh_frame(mesh, xyz, centroid);
    status = co_pieces_place(out, xyz, pool, cancel);
    if (status != CURVOPT_OK)
        co_pieces_free(out);
    return status;
}

co_box co_pieces_bound(const co_surface_pieces *s, int32_t patch, co_box *box) {
    const int32_t first = s->first[patch];
    co_box all = co_box_of(co_pieces_bezier(s, first), 16);
    for (int32_t k = first; k < s->first[patch + 1]; k++) {
        box[k] = co_box_of(co_pieces_bezier(s, k), 16);
        co_box_add(&all, box[k].low, box[k].high);
    }
    return all;
}

/* Weights of the uniform cubic B-spline's four points at t. */
static void spline_weights(double t, double w[4]) {
    const double s = 1 - t;
    w[0] = s * s * s / 6;
    w[1] = (3 * t * t * t - 6 * t * t + 4) / 6;
    w[2] = (3 * s * s * s - 6 * s * s + 4) / 6;
    w[3] = t * t * t / 6;
}

/* From weights of a cell's 16 points to those of its fan's. */
static void fan_row(const ring_table *t, int32_t ring, int cell, const double w[16], double *row) {
    const size_t n_rows = (size_t)t->n_rows;
    const double *rows = t->rows + (size_t)t->n_points * n_rows * (size_t)ring;
    double of_point[CO_STAM_MOST_ROWS] = {1}; /* the vertex in full: it is in all */
    for (size_t k = 0; k < 16; k++) {
        const int32_t at = t->cell[cell][k], mirrored = t->mirrored[cell][k];
        if (at)
            of_point[at] += (mirrored < 0 ? 1 : 2) * w[k];
        if (mirrored > 0)
            of_point[mirrored] -= w[k];
    }
    row[0] = 1;
    for (size_t i = 1; i < (size_t)t->n_points; i++) {
        row[i] = 0;
        for (size_t k = 0; k < n_rows; k++)
            row[i] += rows[i * n_rows + k] * of_point[k];
        row[0] -= row[i];
    }
}

void co_pieces_row(const co_surface_pieces *s, int32_t piece, double u, double v, double *row) {
    const int32_t p = s->patch[piece], at = piece - s->first[p];
    double of_u[4], of_v[4], w[16];
    spline_weights(u, of_u);
    spline_weights(v, of_v);
    for (int k = 0; k < 16; k++)
        w[k] = of_u[k % 4] * of_v[k / 4];
    if (s->tip_of[p] < 0)
        memcpy(row, w, sizeof w);
    else
        fan_row(table_of(s, p), at / CO_RING_CELLS, at % CO_RING_CELLS, w, row);
}

void co_pieces_free(co_surface_pieces *s) {
    for (int32_t k = 0; s->tables && k < s->patches.n_kinds; k++)
        table_free(&s->tables[k]);
    free(s->tables);
    co_patches_free(&s->patches);
    free(s->points);
    free(s->bezier);
    free(s->place);
    free(s->patch);
    free(s->first);
    free(s->tip_of);
    free(s->tip);
    *s = (co_surface_pieces){0};
}
