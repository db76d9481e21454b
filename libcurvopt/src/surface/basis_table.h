/* Quadrature points and basis rows of a kind of face: built once, shared by all faces of that kind.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BASIS_TABLE_H
#define CO_SURFACE_BASIS_TABLE_H

#include "surface/stam.h"

/* Rules grow finer with their number; which face gets which is decided by assembly.h. */
enum { CO_N_RULES = 8 };

/* Derivatives are with respect to the face's parameters; round a smooth extraordinary vertex to the characteristic map
 * (chart.h); at other fans to the cell's own parameters, which range over 0..1. Energies do not care. */
typedef struct co_basis_table {
    int32_t surface; /* curvopt_surface; regular faces, and those at sharp edges, are the same on all: LIMIT there */
    int32_t valence; /* fan (fan.h); 4: regular */
    int32_t n_points;
    int32_t n_samples;
    int32_t *support;       /* [n_points] which of a patch's points (ring.h) the rows stand on */
    double *area_weight;    /* [n_samples] for integrals of smooth functions */
    double *weight;         /* [n_samples] for integrals of squared curvature, which behave differently in the limit */
    double *jacobian_scale; /* [n_samples] undoes the shrinking of the rings in |S_u x S_v| */
    double *rows;           /* [n_samples][n_points][CO_JET]; if it is mixed, [CO_JET][lanes] */
    int is_mixed;           /* each vector lane has a kind of its own (basis_table_mixed.h) */
    double *blend;          /* plane: [n_samples][CO_JET], the weight w(u) w(v); else NULL */
    double *masks;          /* plane: [3][n_points] limit position and tangents at the vertex; else NULL */
} co_basis_table;

/* `valence` is a fan, here and below. */
int32_t co_basis_table_create(int32_t surface, int32_t valence, int32_t rule, co_basis_table **out,
                              curvopt_error *error);
void co_basis_table_destroy(co_basis_table *table);

/* Tables made so far, and polynomials fitted for single points, in no order: a cage has few kinds of fans. */
typedef struct co_basis_table_cache {
    int32_t surface;
    int32_t n_tables;
    struct co_cached_table *table; /* [n_tables] */
    int32_t n_fits;
    struct co_cached_fit *fit; /* [n_fits] */
} co_basis_table_cache;

void co_basis_table_cache_create(int32_t surface, co_basis_table_cache *cache);
void co_basis_table_cache_free(co_basis_table_cache *cache);
/* Builds what is not there yet. */
int32_t co_basis_table_cache_get(co_basis_table_cache *cache, int32_t valence, int32_t rule, const co_basis_table **out,
                                 curvopt_error *error);

/* Rows of one point of a patch, at (u, v) of the patch: rows [n_points][CO_JET] over the patch's points (16 or the
 * two-ring), derivatives with respect to the patch's parameters, weight [CO_JET] the blend's on the irregular patches
 * of `plane`. (u, v) = (0, 0) of an irregular patch gives NAN derivatives. */
int32_t co_basis_table_point(co_basis_table_cache *cache, int32_t valence, double u, double v, double *rows,
                             double *weight, curvopt_error *error);

#endif
