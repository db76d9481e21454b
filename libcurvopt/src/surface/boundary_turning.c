/* Turning of boundaries and creases, for Gauss-Bonnet: do Carmo, "Differential geometry of curves and surfaces", 1976,
 * section 4-5. SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/boundary_turning.h"

#include "base/constants.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "base/vec3.h"
#include "mesh/crease.h"
#include "surface/blend_fit_cut.h"
#include "surface/blend_fit_half.h"
#include "surface/gauss_legendre.h"
#include "surface/ring_cell.h"

#include <math.h>
#include <stdlib.h>

enum {
    SIDE_GAUSS = 24, /* Gauss points of a regular patch's side */
    CELL_GAUSS = 8,  /* Gauss points of a cell's side on an extraordinary patch */
    CELL_RINGS = 40  /* rings of cells, each half as large as the one before; the rest, 2^-40 of the side, is dropped */
};

/* Samples along one side of one kind of patch: first and second derivative along it, first derivative across. */
enum { ALONG, ALONG_TWICE, ACROSS, N_ROWS };
typedef struct co_boundary_turning_table {
    int32_t kind, side; /* kind of patch (fan.h), and side of it */
    int32_t n_points, n_samples;
    double *weight; /* [n_samples] Gauss weights, in the parameter along */
    double *rows;   /* [n_samples][N_ROWS][n_points] */
} co_boundary_turning_table;

/* ------------------------------------------------------------------------------------------------- tables -- */

/* Side k starts at corner k: along u for even k, v for odd ones; jets there at (u, v). */
static void side_place(int side, double t, double *u, double *v) {
    *u = side == 1 ? 1 : side == 3 ? 0 : t;
    *v = side == 2 ? 1 : side == 0 ? 0 : t;
}

/* On a blend sides run along y = 0 of its map. Inwards is y > 0, but at a dart, where the last sector's side lies
 * below. */
static void store(co_boundary_turning_table *t, int32_t sample, int32_t point, const double jet[CO_JET],
                  int is_blended) {
    const int along_second = !is_blended && t->side % 2;
    const int is_below = is_blended && t->side && !co_fan_is_open(co_fan_at_vertex(t->kind));
    double *rows = t->rows + (size_t)(sample * N_ROWS) * (size_t)t->n_points + point;
    rows[ALONG * t->n_points] = jet[along_second ? 2 : 1];
    rows[ALONG_TWICE * t->n_points] = jet[along_second ? 5 : 3];
    rows[ACROSS * t->n_points] = (is_below ? -1 : 1) * jet[along_second ? 1 : 2];
}

/* A face of a half disc, not the one at the vertex. */
static int32_t fill_face(co_boundary_turning_table *t, curvopt_error *error) {
    co_blend_fit map = {0};
    co_ring_cell cell = {0};
    co_chart chart;
    double node[SIDE_GAUSS], weight[SIDE_GAUSS], u, v;
    int32_t *all = CO_NEW(int32_t, t->n_points);
    double *rows = CO_NEW(double, (size_t)t->n_points *CO_JET);
    const co_blend_fit_half_kind half = co_blend_fit_half_kind_of(t->kind);
    int32_t status = all && rows ? co_blend_fit_create_half_map(&half, &map, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = co_ring_cell_create_face(&map, co_fan_wide_sector(t->kind), co_fan_wide_i(t->kind),
                                          co_fan_wide_j(t->kind), &cell, error);
    co_gauss_legendre(SIDE_GAUSS, node, weight);
    for (int32_t p = 0; status == CURVOPT_OK && p < t->n_points; p++)
        all[p] = p;
    for (int32_t i = 0; status == CURVOPT_OK && i < SIDE_GAUSS; i++) {
        side_place(t->side, node[i], &u, &v);
        co_ring_cell_rows(&cell, u, v, t->n_points, all, rows, &chart);
        t->weight[i] = weight[i];
        for (int32_t p = 0; p < t->n_points; p++)
            store(t, i, p, rows + (size_t)p * CO_JET, 0);
    }
    co_ring_cell_free(&cell);
    co_blend_fit_free(&map);
    free(all);
    free(rows);
    return status;
}

static void fill_regular(co_boundary_turning_table *t) {
    double node[SIDE_GAUSS], weight[SIDE_GAUSS], basis[16][CO_JET], u, v;
    co_gauss_legendre(SIDE_GAUSS, node, weight);
    for (int32_t i = 0; i < SIDE_GAUSS; i++) {
        side_place(t->side, node[i], &u, &v);
        co_bspline_bicubic(u, v, basis);
        t->weight[i] = weight[i];
        for (int32_t p = 0; p < 16; p++) {
            double jet[CO_JET];
            for (int k = 0; k < CO_JET; k++)
                jet[k] = basis[p][k];
            store(t, i, p, jet, 0);
        }
    }
}

/* Sides 0 and 3 of an extraordinary patch run to the vertex; ring by ring, in each cell's own parameters or in the
 * blend's map, where angles do not vanish towards the vertex. */
static int32_t fill_extraordinary(co_boundary_turning_table *t, int32_t surface, curvopt_error *error) {
    const int is_blended = co_blend_fit_surface(surface, t->kind) == CURVOPT_SURFACE_POLYNOMIAL;
    const co_blend_fit_half_kind half = co_blend_fit_half_kind_of(t->kind);
    co_blend_fit blend = {0};
    co_stam_disc disc = {0};
    co_ring_cell cell = {0};
    co_chart chart;
    double node[CELL_GAUSS], weight[CELL_GAUSS], u, v;
    int32_t *all = CO_NEW(int32_t, t->n_points), sample = 0;
    double *rows = CO_NEW(double, (size_t)t->n_points *CO_JET);
    int32_t status =
        all && rows ? co_stam_disc_create(co_fan_at_vertex(t->kind), &disc, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK && is_blended)
        status = co_fan_is_half(t->kind) ? co_blend_fit_create_half_map(&half, &blend, error)
                                         : co_blend_fit_create_cut(t->kind, &blend, error);
    if (status == CURVOPT_OK)
        status = co_ring_cell_create(&disc, is_blended ? &blend : NULL, blend.map, &cell, error);
    co_gauss_legendre(CELL_GAUSS, node, weight);
    for (int32_t p = 0; status == CURVOPT_OK && p < t->n_points; p++)
        all[p] = p;
    for (int ring = 1; status == CURVOPT_OK && ring <= CELL_RINGS; ring++) {
        co_ring_cell_set(&cell, &disc, t->side == 0 ? 0 : 2);
        for (int i = 0; i < CELL_GAUSS; i++, sample++) {
            side_place(t->side, node[i], &u, &v);
            co_ring_cell_rows(&cell, u, v, t->n_points, all, rows, &chart);
            t->weight[sample] = weight[i] * (is_blended ? fabs(chart.monomial[1][t->side ? 2 : 1]) : 1);
            for (int32_t p = 0; p < t->n_points; p++)
                store(t, sample, p, rows + (size_t)p * CO_JET, is_blended);
        }
        co_stam_disc_advance(&disc);
    }
    co_ring_cell_free(&cell);
    co_stam_disc_free(&disc);
    co_blend_fit_free(&blend);
    free(all);
    free(rows);
    return status;
}

static int32_t add_table(co_boundary_turning *turning, int32_t surface, int32_t kind, int side, int32_t *index,
                         curvopt_error *error) {
    for (*index = 0; *index < turning->n_tables; ++*index)
        if (turning->table[*index].kind == kind && turning->table[*index].side == side)
            return CURVOPT_OK;
    co_boundary_turning_table *table = CO_RESIZED(turning->table, (size_t)turning->n_tables + 1);
    if (!table)
        return co_status_no_memory(error);
    turning->table = table;
    co_boundary_turning_table *t = &table[turning->n_tables++];
    *t = (co_boundary_turning_table){.kind = kind, .side = side, .n_points = co_patches_size(kind)};
    const int is_one_piece = co_patches_own_size(kind) == CO_RING_REGULAR;
    t->n_samples = is_one_piece ? SIDE_GAUSS : CELL_GAUSS * CELL_RINGS;
    t->weight = CO_NEW(double, t->n_samples);
    t->rows = CO_NEW(double, (size_t)(t->n_samples * N_ROWS) * (size_t)t->n_points);
    if (!t->weight || !t->rows)
        return co_status_no_memory(error);
    if (kind != CO_FAN_REGULAR)
        return is_one_piece ? fill_face(t, error) : fill_extraordinary(t, surface, error);
    fill_regular(t);
    return CURVOPT_OK;
}

/* ----------------------------------------------------------------------------------------------- topology -- */

/* Fans at a vertex once the surface is cut, and whether a cut ends there. */
static int32_t count_fans(const curvopt_mesh *m, int32_t v, int *is_dart) {
    int32_t first = m->vertex_corner[v], h = first, cuts = 0;
    *is_dart = 0;
    if (first < 0) /* isolated */
        return 0;
    do {
        cuts += co_crease_is_infinite(co_crease_edge(m, h));
        h = co_mesh_rotate(m, h);
    } while (h >= 0 && h != first);
    *is_dart = h >= 0 && cuts == 1 && !co_crease_is_infinite(co_crease_vertex(m, v));
    return cuts ? cuts : 1; /* each begins at one */
}

static double cut_target(const curvopt_mesh *m) {
    int32_t euler = m->info.n_faces, darts = 0;
    for (int32_t v = 0; v < m->info.n_vertices; v++) {
        int is_dart;
        euler += count_fans(m, v, &is_dart);
        darts += is_dart;
    }
    for (int32_t e = 0; e < m->info.n_edges; e++) {
        int32_t h = m->edge_corner[e];
        euler -= 1 + (m->twin[h] >= 0 && co_crease_is_infinite(co_crease_edge(m, h)));
    }
    return 2 * CO_PI * euler + CO_PI * darts;
}

int32_t co_boundary_turning_create(const curvopt_mesh *mesh, const co_patches *patches, int32_t surface,
                                   co_boundary_turning *turning, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    *turning = (co_boundary_turning){.target = cut_target(mesh)};
    for (int32_t p = 0; p < patches->n_patches; p++)
        for (int k = 0; k < 4; k++)
            turning->n_sides += patches->cuts[p] >> k & 1;
    turning->patch = CO_NEW(int32_t, turning->n_sides);
    turning->side = CO_NEW(uint8_t, turning->n_sides);
    turning->table_of = CO_NEW(int32_t, turning->n_sides);
    if (!turning->patch || !turning->side || !turning->table_of)
        status = co_status_no_memory(error);
    for (int32_t p = 0, i = 0; status == CURVOPT_OK && p < patches->n_patches; p++)
        for (int k = 0; status == CURVOPT_OK && k < 4; k++)
            if (patches->cuts[p] >> k & 1) {
                turning->patch[i] = p;
                turning->side[i] = (uint8_t)k;
                status = add_table(turning, surface, patches->kind[p], k, &turning->table_of[i], error);
                i++;
            }
    if (status != CURVOPT_OK)
        co_boundary_turning_free(turning);
    return status;
}

void co_boundary_turning_free(co_boundary_turning *turning) {
    for (int32_t i = 0; i < turning->n_tables; i++) {
        free(turning->table[i].weight);
        free(turning->table[i].rows);
    }
    free(turning->table);
    free(turning->table_of);
    free(turning->patch);
    free(turning->side);
    *turning = (co_boundary_turning){0};
}

/* ------------------------------------------------------------------------------------------------ turning -- */

/* int kappa_g ds = int c''.m / |c'| dt with m the unit normal to the curve in the surface, inwards; with e the
 * derivative across, m = +- (|c'|^2 e - (c'.e) c') / (|c'| |c' x e|). The direction of t does not matter. */
static double side_turning(const co_boundary_turning_table *t, const int32_t *index, const double *points) {
    double sum = 0, inward = t->side == 0 || t->side == 3 ? 1 : -1;
    for (int32_t s = 0; s < t->n_samples; s++) {
        double d[N_ROWS][3] = {{0}};
        for (int r = 0; r < N_ROWS; r++) {
            const double *row = t->rows + (size_t)(s * N_ROWS + r) * (size_t)t->n_points;
            for (int32_t p = 0; p < t->n_points; p++)
                for (int c = 0; c < 3; c++)
                    d[r][c] +=
                        row[p] * (points[3 * (size_t)index[p] + (size_t)c] - points[3 * (size_t)index[0] + (size_t)c]);
        }
        double along = co_dot3(d[ALONG], d[ALONG]), skew = co_dot3(d[ALONG], d[ACROSS]);
        double area = sqrt(along * co_dot3(d[ACROSS], d[ACROSS]) - skew * skew);
        double bend = along * co_dot3(d[ALONG_TWICE], d[ACROSS]) - co_dot3(d[ALONG], d[ALONG_TWICE]) * skew;
        sum += inward * t->weight[s] * bend / (along * area);
    }
    return sum;
}

/* Interior angle at corner k of a regular patch. */
static double corner_angle(int k, const int32_t *index, const double *points) {
    double basis[16][CO_JET];
    double d[2][3] = {{0}};
    co_bspline_bicubic(k == 1 || k == 2, k >= 2, basis);
    for (int32_t p = 0; p < 16; p++)
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < 2; i++)
                d[i][c] += basis[p][1 + i] * points[3 * (size_t)index[p] + (size_t)c];
    double cosine = co_dot3(d[0], d[1]) / sqrt(co_dot3(d[0], d[0]) * co_dot3(d[1], d[1]));
    return co_arc_cosine(fmax(-1, fmin(1, k % 2 ? -cosine : cosine)));
}

double co_boundary_turning_total(const co_boundary_turning *turning, const co_patches *patches, const double *weight,
                                 const double *points) {
    double sum = 0;
    for (int32_t i = 0; i < turning->n_sides; i++) {
        const int32_t *index = patches->points + patches->start[turning->patch[i]];
        double total = side_turning(&turning->table[turning->table_of[i]], index, points);
        if (patches->cuts[turning->patch[i]] >> (4 + turning->side[i]) & 1)
            total += CO_PI - corner_angle(turning->side[i], index, points);
        sum += (weight ? weight[turning->patch[i]] : 1) * total;
    }
    return sum;
}
