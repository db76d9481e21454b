/* Quadrature points, weights and basis rows of a kind of face (fan.h): built once, shared by all faces of that kind.
 * What finite elements call tabulated shape functions. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BASIS_TABLE_H
#define CO_SURFACE_BASIS_TABLE_H

#include "base/cancel.h"
#include "base/thread_pool.h"
#include "surface/stam.h"

/* Rules grow finer with their number; which face gets which is decided by assembly.h. */
enum { CO_N_RULES = 8 };

/* Derivatives are with respect to the face's parameters; round a smooth extraordinary vertex and where there is a blend
 * to its map (chart.h); at other fans to the cell's own parameters, which range over 0..1. Energies do not care. */
typedef struct co_basis_table {
    int32_t surface;        /* curvopt_surface of this kind (co_blend_fit_surface) */
    int32_t kind;           /* kind of face (fan.h) */
    int32_t n_points;       /* points of a patch on which the surface depends */
    int32_t n_own;          /* of which no coefficients of a disc; they stand first */
    int32_t n_samples;      /* quadrature points */
    int32_t *support;       /* [n_points] numbers of these points among the patch's (ring.h) */
    double *area_weight;    /* [n_samples] for integrals of smooth functions */
    double *weight;         /* [n_samples] for integrals of squared curvature, which behave differently in the limit */
    double *jacobian_scale; /* [n_samples] undoes the shrinking of the rings in |S_u x S_v| */
    double *rows;           /* [n_samples][n_points][CO_JET], of a mixed table
                               [parts][n_samples][n_points][CO_JET][lanes] (basis_table_mixed.h) */
    int is_mixed;           /* whether each vector lane has a kind of its own (basis_table_mixed.h) */
    double *blend;          /* [n_samples][CO_JET] the weight w(u) w(v) of `plane`; NULL on other surfaces */
    double *masks;          /* [3][n_points] limit position and tangents at the vertex, for `plane`; else NULL */
} co_basis_table;

/* Builds the table of a surface, a kind of face and a rule 0 .. CO_N_RULES - 1. Time and memory grow like samples times
 * points. ERROR_MEMORY. */
int32_t co_basis_table_create(int32_t surface, int32_t kind, int32_t rule, co_basis_table **out, curvopt_error *error);
void co_basis_table_destroy(co_basis_table *table);

/* The tables and fits made so far for a surface. They are searched one by one: a cage has few kinds of faces. */
typedef struct co_basis_table_cache {
    int32_t surface;         /* curvopt_surface */
    co_thread_pool *threads; /* fill tables; NULL until replaced: the calling thread alone */
    co_cancel *cancel;       /* ends the making of tables; NULL until replaced */
    void (*made)(void *); /* told, with `user`, of each table that was made; may raise the flag. NULL until replaced */
    void *user;
    int32_t n_tables;
    struct co_cached_table *table; /* [n_tables] in the order in which they were made */
    int32_t n_fits;
    struct co_cached_fit *fit; /* [n_fits] polynomials, in the order in which they were fitted */
} co_basis_table_cache;

void co_basis_table_cache_create(int32_t surface, co_basis_table_cache *cache);
void co_basis_table_cache_free(co_basis_table_cache *cache);
/* The table of a kind and rule, built if it is not there yet. It stays the cache's and lives as long. ERROR_MEMORY,
 * and CO_CANCELLED where it would have to be built. */
int32_t co_basis_table_cache_get(co_basis_table_cache *cache, int32_t kind, int32_t rule, const co_basis_table **out,
                                 curvopt_error *error);

/* Rows at any point (u, v) of a patch: rows [co_patches_size(kind)][CO_JET] over all of its points, derivatives with
 * respect to u and v. weight [CO_JET] is filled on the extraordinary patches of `plane`, with the blend's jet. At (0,
 * 0) of an extraordinary patch derivatives are NAN. On `limit` they are the limit's, also where a table has a blend.
 * ERROR_MEMORY. */
int32_t co_basis_table_point(co_basis_table_cache *cache, int32_t kind, double u, double v, double *rows,
                             double *weight, curvopt_error *error);

#endif
