/* The basis tables of a surface, and the polynomials fitted for them, each made once.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BASIS_TABLE_CACHE_H
#define CO_SURFACE_BASIS_TABLE_CACHE_H

#include "surface/basis_table.h"

/* What has been made so far for a surface. Tables and fits are searched one by one: a cage has few kinds of faces. */
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

/* The polynomial fitted at a kind's vertex, likewise, for kinds whose surface has one (co_blend_fit_surface).
 * ERROR_MEMORY. */
int32_t co_basis_table_cache_fit(co_basis_table_cache *cache, int32_t kind, const co_blend_fit **out,
                                 curvopt_error *error);
/* One table alone, of a kind of face on a surface. ERROR_MEMORY. */
int32_t co_basis_table_create(int32_t surface, int32_t kind, int32_t rule, co_basis_table **out, curvopt_error *error);

#endif
