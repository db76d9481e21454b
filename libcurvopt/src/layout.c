/* Patches dealt out to blocks. SPDX-License-Identifier: GPL-3.0-or-later */
#include "layout.h"

#include "memory.h"

#include <stdlib.h>
#include <string.h>

/* Of a batch's gradients, in doubles: 1 MB, which a core's own cache of today holds beside what else is read. All
 * faces' together would go to memory and back, 768 bytes a face. And into how many batches of like cost there are at
 * least, where there are as many blocks: for two cores or a few to get done at the same time. */
enum { BATCH = 1 << 17, FEWEST_BATCHES = 32 };

void co_layout_free(co_layout *l) {
    free(l->block);
    free(l->patch);
    free(l->points);
    free(l->sums);
    free(l->batch_block);
    free(l->batch_touched);
    free(l->touched);
    free(l->shares);
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
                       const int32_t *start, size_t *n_points, curvopt_error *error) {
    *n_points = 0;
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
                           const int32_t *order, co_layout *l, curvopt_error *error) {
    size_t points = 0;
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
            fill_block(patches, order + first, n < l->lanes ? n : l->lanes, l, b);
            points += (size_t)block->table->n_points * (size_t)l->lanes;
        }
    return CURVOPT_OK;
}

/* -------------------------------------------------------------------------------------------------- batches -- */

/* Deals blocks out to batches, and gives each its place among the batch's gradients. */
static int32_t split_batches(int area, co_layout *l, curvopt_error *error) {
    size_t at = 0;
    double cost = 0, whole = 0;
    l->batch_block = CO_NEW(int32_t, (size_t)l->n_blocks + 1);
    if (!l->batch_block)
        return co_status_no_memory(error);
    for (int32_t b = 0; b < l->n_blocks; b++)
        whole += co_block_cost(&l->block[b]);
    for (int32_t b = 0; b < l->n_blocks; b++) {
        size_t size = (size_t)l->block[b].table->n_points * (size_t)l->lanes * 3 * (size_t)(1 + area);
        cost += co_block_cost(&l->block[b]);
        if (at == 0 || at + size > BATCH || cost > whole / FEWEST_BATCHES) {
            l->batch_block[l->n_batches++] = b;
            at = 0;
            cost = co_block_cost(&l->block[b]);
        }
        l->block[b].gradient = at;
        at += size;
        l->batch_size = at > l->batch_size ? at : l->batch_size;
    }
    l->batch_block[l->n_batches] = l->n_blocks;
    l->batch_touched = CO_NEW(size_t, (size_t)l->n_batches + 1);
    return l->batch_touched ? CURVOPT_OK : co_status_no_memory(error);
}

/* Points that batches touch, each counted once a batch. mark [n_points] is 0, and is spoilt. */
static size_t count_touched(const co_layout *l, size_t *mark) {
    size_t n = 0;
    for (int32_t batch = 0; batch < l->n_batches; batch++)
        for (int32_t b = l->batch_block[batch]; b < l->batch_block[batch + 1]; b++)
            for (int32_t e = 0; e < l->block[b].table->n_points * l->lanes; e++) {
                size_t *m = &mark[l->points[l->block[b].points + (size_t)e]];
                n += *m <= (size_t)batch;
                *m = (size_t)batch + 1;
            }
    return n;
}

/* The points that one batch touches, from number `first` of co_layout.touched on, and where their shares are; the next
 * free number. slot [n_points]: 1 + the number of a point when it was last touched, 0 before. */
static size_t fill_batch(co_layout *l, int area, int32_t batch, size_t first, size_t *slot) {
    int32_t begin = l->batch_block[batch], end = l->batch_block[batch + 1], lanes = l->lanes;
    const size_t start = l->touched[first].incident; /* of the shares; left there by the batch before */
    size_t n = first, at = start;
    for (int32_t b = begin; b < end; b++)
        for (int32_t e = 0; e < l->block[b].table->n_points * lanes; e++) {
            int32_t point = l->points[l->block[b].points + (size_t)e];
            if (slot[point] <= first) {
                l->touched[n] = (co_touched){.point = point, .is_first = slot[point] == 0};
                if (slot[point])
                    l->touched[slot[point] - 1].next = n;
                slot[point] = ++n;
            }
            l->touched[slot[point] - 1].incident += e % lanes < l->block[b].n_used;
        }
    for (size_t k = first; k < n; k++) { /* from counts to places */
        size_t count = l->touched[k].incident;
        l->touched[k].incident = at;
        at += count;
    }
    for (int32_t b = begin; b < end; b++)
        for (int32_t e = 0; e < l->block[b].table->n_points * lanes; e++)
            if (e % lanes < l->block[b].n_used)
                l->incident[l->touched[slot[l->points[l->block[b].points + (size_t)e]] - 1].incident++] =
                    (uint32_t)(l->block[b].gradient + (size_t)(e / lanes * (1 + area) * 3 * lanes + e % lanes));
    for (size_t k = n; k > first; k--) /* places were moved on to the next one's */
        l->touched[k].incident = l->touched[k - 1].incident;
    l->touched[first].incident = start;
    return n;
}

static int32_t build_batches(int32_t n_points, int area, co_layout *l, curvopt_error *error) {
    size_t n_shares = 0, n = 0, n_touched;
    size_t *slot = CO_NEW(size_t, n_points);
    int32_t status = slot ? split_batches(area, l, error) : co_status_no_memory(error);
    if (status != CURVOPT_OK)
        goto done;
    for (int32_t b = 0; b < l->n_blocks; b++)
        n_shares += (size_t)l->block[b].table->n_points * (size_t)l->block[b].n_used;
    n_touched = count_touched(l, slot);
    l->touched = CO_NEW(co_touched, n_touched + 1);
    l->shares = CO_NEW(double, n_touched * 3 * (size_t)(1 + area));
    l->incident = CO_NEW(uint32_t, n_shares);
    if (!l->touched || !l->shares || !l->incident) {
        status = co_status_no_memory(error);
        goto done;
    }
    memset(slot, 0, sizeof *slot * (size_t)n_points);
    for (int32_t batch = 0; batch < l->n_batches; batch++) {
        l->batch_touched[batch] = n;
        n = fill_batch(l, area, batch, n, slot);
    }
    l->batch_touched[l->n_batches] = n;
done:
    free(slot);
    return status;
}

int32_t co_layout_create(const co_patches *patches, co_table_cache *cache, int32_t lanes, const uint8_t *rule, int step,
                         int gradients, int area, co_layout *l, curvopt_error *error) {
    int32_t n_kinds = patches->n_kinds * CO_N_RULES, status = CURVOPT_ERROR_MEMORY;
    size_t n_points;
    int32_t *start = CO_NEW(int32_t, n_kinds + 1), *order = CO_NEW(int32_t, patches->n_patches);
    *l = (co_layout){.lanes = lanes};
    if (!start || !order) {
        co_status_no_memory(error);
        goto done;
    }
    sort_by_kind(patches, rule, step, n_kinds, start, order);
    status = measure(l, patches, cache, n_kinds, start, &n_points, error);
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
    status = fill_blocks(patches, cache, n_kinds, start, order, l, error);
    if (status == CURVOPT_OK && gradients)
        status = build_batches(patches->n_points, area, l, error);
done:
    free(start);
    free(order);
    return status;
}
