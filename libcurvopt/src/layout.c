/* Patches dealt out to blocks. SPDX-License-Identifier: GPL-3.0-or-later */
#include "layout.h"

#include "memory.h"

#include <stdlib.h>

void co_layout_free(co_layout *l) {
    free(l->block);
    free(l->patch);
    free(l->points);
    free(l->sums);
    free(l->gradients);
    free(l->incident_start);
    free(l->incident);
    *l = (co_layout){0};
}

static int32_t kind_of(const co_patches *patches, const uint8_t *rule, int step, int32_t p) {
    int number = rule[p] + step;
    return co_patches_kind(patches, patches->valence[p]) * CO_N_RULES + (number > 0 ? number : 0);
}

/* Patches sorted by kind, stably: order [n_patches]; start [n_kinds + 1]. */
static void sort_by_kind(const co_patches *patches, const uint8_t *rule, int step, int32_t n_kinds, int32_t *start,
                         int32_t *order) {
    for (int32_t p = 0; p < patches->n_patches; p++)
        start[kind_of(patches, rule, step, p) + 1]++;
    for (int32_t k = 0; k < n_kinds; k++)
        start[k + 1] += start[k];
    for (int32_t p = 0; p < patches->n_patches; p++)
        order[start[kind_of(patches, rule, step, p)]++] = p;
    for (int32_t k = n_kinds; k > 0; k--)
        start[k] = start[k - 1];
    start[0] = 0;
}

/* Fetches the tables of the kinds that occur; counts blocks and what they hold. */
static int32_t measure(co_layout *l, const co_patches *patches, co_table_cache *cache, int32_t n_kinds,
                       const int32_t *start, int area, size_t *n_points, size_t *n_gradients, curvopt_error *error) {
    *n_points = *n_gradients = 0;
    for (int32_t k = 0; k < n_kinds; k++) {
        int32_t n = start[k + 1] - start[k];
        const co_table *table;
        if (n == 0)
            continue;
        int32_t status = co_table_cache_get(cache, patches->kinds[k / CO_N_RULES], k % CO_N_RULES, &table, error);
        if (status != CURVOPT_OK)
            return status;
        size_t blocks = (size_t)((n + l->lanes - 1) / l->lanes), points = (size_t)table->n_points * (size_t)l->lanes;
        l->n_blocks += (int32_t)blocks;
        l->n_samples += (int64_t)n * table->n_samples;
        l->max_points = table->n_points > l->max_points ? table->n_points : l->max_points;
        *n_points += blocks * points;
        *n_gradients += blocks * points * 3 * (size_t)(1 + area);
    }
    return CURVOPT_OK;
}

static void fill_block(const co_patches *patches, const int32_t *order, int32_t n_used, co_layout *l, int32_t b) {
    co_block *block = &l->block[b];
    int32_t lanes = l->lanes, *points = l->points + block->points;
    block->n_used = n_used;
    for (int32_t lane = 0; lane < lanes; lane++) {
        int32_t p = order[lane < n_used ? lane : 0];
        const int32_t *from = patches->points + patches->start[p];
        l->patch[b * lanes + lane] = p;
        for (int32_t i = 0; i < block->table->n_points; i++)
            points[i * lanes + lane] = from[block->table->support[i]];
    }
}

static int32_t fill_blocks(const co_patches *patches, co_table_cache *cache, int32_t n_kinds, const int32_t *start,
                           const int32_t *order, int area, co_layout *l, curvopt_error *error) {
    size_t points = 0, gradient = 0;
    int32_t b = 0;
    for (int32_t k = 0; k < n_kinds; k++)
        for (int32_t first = start[k]; first < start[k + 1]; first += l->lanes, b++) {
            int32_t n = start[k + 1] - first;
            co_block *block = &l->block[b];
            int32_t status =
                co_table_cache_get(cache, patches->kinds[k / CO_N_RULES], k % CO_N_RULES, &block->table, error);
            if (status != CURVOPT_OK)
                return status;
            block->points = points;
            block->gradient = gradient;
            fill_block(patches, order + first, n < l->lanes ? n : l->lanes, l, b);
            points += (size_t)block->table->n_points * (size_t)l->lanes;
            gradient += (size_t)block->table->n_points * (size_t)l->lanes * 3 * (size_t)(1 + area);
        }
    return CURVOPT_OK;
}

/* Runs over every share of every point, in the order of blocks; place == NULL only counts. */
static void visit_incidences(const co_layout *l, int area, size_t *count, size_t *place) {
    for (int32_t b = 0; b < l->n_blocks; b++) {
        const co_block *block = &l->block[b];
        for (int32_t i = 0; i < block->table->n_points; i++)
            for (int32_t lane = 0; lane < block->n_used; lane++) {
                int32_t point = l->points[block->points + (size_t)(i * l->lanes + lane)];
                if (place)
                    place[count[point]] = block->gradient + (size_t)(i * (1 + area) * 3 * l->lanes + lane);
                count[point]++;
            }
    }
}

static int32_t build_incidence(int32_t n_points, int area, size_t n_gradients, co_layout *l, curvopt_error *error) {
    l->gradients = CO_NEW_ALIGNED(double, n_gradients);
    l->incident_start = CO_NEW(size_t, (size_t)n_points + 1);
    if (!l->gradients || !l->incident_start)
        return co_status_no_memory(error);
    visit_incidences(l, area, l->incident_start + 1, NULL);
    for (int32_t p = 0; p < n_points; p++)
        l->incident_start[p + 1] += l->incident_start[p];
    l->incident = CO_NEW(size_t, l->incident_start[n_points]);
    if (!l->incident)
        return co_status_no_memory(error);
    visit_incidences(l, area, l->incident_start, l->incident);
    for (int32_t p = n_points; p > 0; p--)
        l->incident_start[p] = l->incident_start[p - 1];
    l->incident_start[0] = 0;
    return CURVOPT_OK;
}

int32_t co_layout_create(const co_patches *patches, co_table_cache *cache, int32_t lanes, const uint8_t *rule, int step,
                         int gradients, int area, co_layout *l, curvopt_error *error) {
    int32_t n_kinds = patches->n_kinds * CO_N_RULES, status = CURVOPT_ERROR_MEMORY;
    size_t n_points, n_gradients;
    int32_t *start = CO_NEW(int32_t, n_kinds + 1), *order = CO_NEW(int32_t, patches->n_patches);
    *l = (co_layout){.lanes = lanes};
    if (!start || !order) {
        co_status_no_memory(error);
        goto done;
    }
    sort_by_kind(patches, rule, step, n_kinds, start, order);
    status = measure(l, patches, cache, n_kinds, start, area, &n_points, &n_gradients, error);
    if (status != CURVOPT_OK)
        goto done;
    l->block = CO_NEW(co_block, l->n_blocks);
    l->patch = CO_NEW(int32_t, (size_t)l->n_blocks * (size_t)lanes);
    l->points = CO_NEW(int32_t, n_points);
    l->sums = CO_NEW_ALIGNED(double, (size_t)l->n_blocks *CO_N_SUMS *(size_t)lanes);
    if (!l->block || !l->patch || !l->points || !l->sums) {
        status = co_status_no_memory(error);
        goto done;
    }
    status = fill_blocks(patches, cache, n_kinds, start, order, area, l, error);
    if (status == CURVOPT_OK && gradients)
        status = build_incidence(patches->n_points, area, n_gradients, l, error);
done:
    free(start);
    free(order);
    return status;
}
