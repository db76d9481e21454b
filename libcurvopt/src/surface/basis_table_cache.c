/* The tables and fits made so far for a surface, found by their kind.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/basis_table_cache.h"

#include "base/memory.h"
#include "surface/blend_fit_cut.h"
#include "surface/blend_fit_half.h"

#include <stdlib.h>

struct co_cached_table {
    int32_t kind, rule; /* what the table is for */
    co_basis_table *table;
};

struct co_cached_fit {
    int32_t key, width; /* what the fit is for: kind with steps of a map, but no sector or place; width */
    co_blend_fit polynomial;
};

/* The polynomial of a kind of patch; the fit only where it is folded into rows. */
static int32_t create_polynomial(const co_stam_disc *disc, int32_t kind, co_blend_fit *out, curvopt_error *error) {
    const co_blend_fit_half_kind half = co_blend_fit_half_kind_of(kind);
    return co_fan_is_half(kind)   ? co_blend_fit_create_half_map(&half, out, error)
           : co_fan_is_wide(kind) ? co_blend_fit_create_map(disc, co_fan_wide_width(kind), out, error)
           : co_fan_is_cut(kind)  ? co_blend_fit_create_cut(disc->fan, out, error)
                                  : co_blend_fit_create(disc, 1, out, error);
}

int32_t co_basis_table_cache_fit(co_basis_table_cache *cache, int32_t kind, const co_blend_fit **out,
                                 curvopt_error *error) {
    int32_t type = co_fan_type_of(kind), width = co_fan_is_wide(kind) ? co_fan_wide_width(kind) : 1;
    const int steps = co_fan_is_half(kind) ? co_fan_half_steps(kind) : 0;
    int32_t key = co_fan_make(type, co_fan_sectors(kind), steps); /* all sectors' */
    int32_t fan = co_fan_is_wide(kind) ? co_fan_at_vertex(kind) : key;
    for (int32_t i = 0; i < cache->n_fits; i++)
        if (cache->fit[i].key == key && cache->fit[i].width == width) {
            *out = &cache->fit[i].polynomial;
            return CURVOPT_OK;
        }
    struct co_cached_fit *fit = CO_RESIZED(cache->fit, (size_t)cache->n_fits + 1);
    if (!fit)
        return co_status_no_memory(error);
    cache->fit = fit;
    fit += cache->n_fits;
    *fit = (struct co_cached_fit){.key = key, .width = width};
    co_stam_disc disc;
    int32_t status = co_stam_disc_create(fan, &disc, error);
    if (status != CURVOPT_OK)
        return status;
    status = create_polynomial(&disc, kind, &fit->polynomial, error);
    co_stam_disc_free(&disc);
    if (status == CURVOPT_OK) {
        cache->n_fits++;
        *out = &fit->polynomial;
    }
    return status;
}

/* A table of the cache's surface, with the fit that the cache has or makes. */
static int32_t create_table(co_basis_table_cache *cache, int32_t kind, int32_t rule, co_basis_table **out,
                            curvopt_error *error) {
    const int32_t surface = co_blend_fit_surface(cache->surface, kind);
    co_table_making making = {.threads = cache->threads, .cancel = cache->cancel};
    if (surface == CURVOPT_SURFACE_POLYNOMIAL) {
        const int32_t status = co_basis_table_cache_fit(cache, kind, &making.polynomial, error);
        if (status != CURVOPT_OK)
            return status;
    }
    return co_basis_table_make(surface, kind, rule, &making, out, error);
}

int32_t co_basis_table_create(int32_t surface, int32_t kind, int32_t rule, co_basis_table **out, curvopt_error *error) {
    co_basis_table_cache cache;
    co_basis_table_cache_create(surface, &cache);
    int32_t status = create_table(&cache, kind, rule, out, error);
    co_basis_table_cache_free(&cache);
    return status;
}

void co_basis_table_cache_create(int32_t surface, co_basis_table_cache *cache) {
    *cache = (co_basis_table_cache){.surface = surface};
}

void co_basis_table_cache_free(co_basis_table_cache *cache) {
    for (int32_t i = 0; i < cache->n_tables; i++)
        co_basis_table_destroy(cache->table[i].table);
    for (int32_t i = 0; i < cache->n_fits; i++)
        co_blend_fit_free(&cache->fit[i].polynomial);
    free(cache->table);
    free(cache->fit);
    *cache = (co_basis_table_cache){0};
}

int32_t co_basis_table_cache_get(co_basis_table_cache *cache, int32_t kind, int32_t rule_number,
                                 const co_basis_table **out, curvopt_error *error) {
    *out = NULL;
    for (int32_t i = 0; i < cache->n_tables; i++)
        if (cache->table[i].kind == kind && cache->table[i].rule == rule_number) {
            *out = cache->table[i].table;
            return CURVOPT_OK;
        }
    if (co_cancel_is_due(cache->cancel))
        return CO_CANCELLED;
    struct co_cached_table entry = {.kind = kind, .rule = rule_number};
    struct co_cached_table *table = CO_RESIZED(cache->table, (size_t)cache->n_tables + 1);
    if (!table)
        return co_status_no_memory(error);
    cache->table = table;
    int32_t status = create_table(cache, kind, rule_number, &entry.table, error);
    if (status == CURVOPT_OK) {
        cache->table[cache->n_tables++] = entry;
        *out = entry.table;
        if (cache->made)
            cache->made(cache->user);
    }
    return status;
}
