/* Basis rows at any point of a patch.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/basis_point.h"

#include "base/elementary.h"
#include "base/memory.h"
#include "surface/patches.h"
#include "surface/ring_cell.h"

#include <math.h>
#include <stdlib.h>

/* Rows of the vertex itself: its position, and NAN for derivatives, which do not exist there. */
static int32_t vertex_rows(co_stam_disc *disc, const co_blend_fit *polynomial, int is_disc, double *rows,
                           curvopt_error *error) {
    int32_t n = disc->n_points, n_all = n + (is_disc ? CO_BLEND_DISC_TERMS : 0);
    double *masks = CO_NEW(double, 3 * (size_t)n);
    if (!masks)
        return co_status_no_memory(error);
    if (co_fan_is_smooth(disc->fan))
        co_stam_limit_masks(disc->valence, masks);
    else
        co_stam_disc_limit_mask(disc, masks);
    const int is_half = polynomial->is_half; /* the vertex stays where the curve has it */
    for (int32_t i = 0; i < n_all * CO_JET; i++)
        rows[i] = i % CO_JET ? (double)NAN
                  : is_half  ? (i < n * CO_JET ? masks[i / CO_JET] : 0)
                  : i >= n * CO_JET || (is_disc && polynomial->width)
                      ? polynomial->width && i == n * CO_JET /* the first of the polynomial's points lies there */
                  : polynomial->width ? polynomial->fit[i / CO_JET]
                                      : masks[i / CO_JET];
    free(masks);
    return CURVOPT_OK;
}

/* Rows at (u, v) of a cell of the right ring, (u, v) not both 0; derivatives with respect to u, v. */
static int32_t ring_rows(co_stam_disc *disc, const co_blend_fit *polynomial, double u, double v, int32_t n_all,
                         const int32_t *all, double *rows, curvopt_error *error) {
    co_ring_cell cell;
    co_chart chart;
    int32_t status = co_ring_cell_create(disc, polynomial->width ? polynomial : NULL, NULL, &cell, error);
    if (status != CURVOPT_OK)
        return status;
    double side = 0.5;
    for (; u < side && v < side; side /= 2)
        co_stam_disc_advance(disc);
    co_ring_cell_set(&cell, disc, v < side ? 0 : u < side ? 2 : 1);
    co_ring_cell_rows(&cell, (u - cell.origin[0]) / side, (v - cell.origin[1]) / side, n_all, all, rows, &chart);
    for (int32_t i = 0; i < n_all * CO_JET; i++)
        rows[i] /= co_power(side, co_jet_order_u[i % CO_JET] + co_jet_order_v[i % CO_JET]);
    co_ring_cell_free(&cell);
    return CURVOPT_OK;
}

/* Rows of a face of a wide disc, not of that at the vertex. */
static int32_t wide_rows(const co_blend_fit *polynomial, int32_t kind, double u, double v, const int32_t *all,
                         double *rows, curvopt_error *error) {
    co_ring_cell cell;
    co_chart chart;
    int32_t status = co_ring_cell_create_face(polynomial, co_fan_wide_sector(kind), co_fan_wide_i(kind),
                                              co_fan_wide_j(kind), &cell, error);
    if (status == CURVOPT_OK)
        co_ring_cell_rows(&cell, u, v, co_patches_size(kind), all, rows, &chart);
    co_ring_cell_free(&cell);
    return status;
}

/* Rows of a face at an extraordinary vertex. */
static int32_t vertex_face_rows(const co_blend_fit *polynomial, int32_t kind, double u, double v, const int32_t *all,
                                double *rows, curvopt_error *error) {
    co_stam_disc disc;
    int32_t status = co_stam_disc_create(co_fan_at_vertex(kind), &disc, error);
    if (status == CURVOPT_OK)
        status = u == 0 && v == 0 ? vertex_rows(&disc, polynomial, co_fan_is_wide(kind), rows, error)
                                  : ring_rows(&disc, polynomial, u, v, co_patches_size(kind), all, rows, error);
    co_stam_disc_free(&disc);
    return status;
}

static int32_t irregular_point(co_basis_table_cache *cache, int32_t surface, int32_t kind, double u, double v,
                               double *rows, curvopt_error *error) {
    static const co_blend_fit none = {0};
    const co_blend_fit *polynomial = &none;
    int32_t n_all = co_patches_size(kind), *all = CO_NEW(int32_t, n_all);
    int32_t status = all ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK && surface == CURVOPT_SURFACE_POLYNOMIAL)
        status = co_basis_table_cache_fit(cache, kind, &polynomial, error);
    for (int32_t i = 0; status == CURVOPT_OK && i < n_all; i++)
        all[i] = i;
    if (status == CURVOPT_OK)
        status =
            (co_patches_is_one_piece(kind) ? wide_rows : vertex_face_rows)(polynomial, kind, u, v, all, rows, error);
    free(all);
    return status;
}

int32_t co_basis_point(co_basis_table_cache *cache, int32_t kind, double u, double v, double *rows, double *weight,
                       curvopt_error *error) {
    if (kind == CO_FAN_REGULAR) {
        co_bspline_bicubic(u, v, (double(*)[CO_JET])rows);
        return CURVOPT_OK;
    }
    const int is_limit = cache->surface == CURVOPT_SURFACE_LIMIT; /* points exist where integrals do not */
    int32_t surface = is_limit ? cache->surface : co_blend_fit_surface(cache->surface, kind);
    if (surface == CURVOPT_SURFACE_PLANE) {
        co_blend_weight(CO_BLEND_SMOOTH, u, v, weight);
    }
    return irregular_point(cache, surface, kind, u, v, rows, error);
}
