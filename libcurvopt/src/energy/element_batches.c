/* Patches dealt out to blocks. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/element_batches.h"

#include "base/memory.h"
#include "surface/basis_table_mixed.h"

#include <stdlib.h>
#include <string.h>

/* Of a batch's gradients, in doubles: 1 MB, which a core's own cache holds beside what else is read. All
 * faces' together would go to memory and back, 768 bytes a face. And into how many batches of like cost there are at
 * least, where there are as many blocks: for two cores or a few to get done at the same time. */
enum { BATCH = 1 << 17, FEWEST_BATCHES = 32 };

void co_element_batches_free(co_element_batches *l) {
    free(l->block);
    free(l->patch);
    free(l->points);
    free(l->sums);
    for (int32_t i = 0; i < l->n_mixed; i++)
        co_basis_table_destroy(l->mixed[i]);
    free(l->mixed);
    free(l->batch_block);
    free(l->batch_touched);
    free(l->touched);
    free(l->shares);
    free(l->incident);
    *l = (co_element_batches){0};
}

static int32_t kind_of(const co_patches *patches, const uint8_t *rule, int step, int32_t p) {
    int number = rule[p] + step;
    return co_patches_kind(patches, patches->kind[p]) * CO_N_RULES + (number > 0 ? number : 0);
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

/* Patches that blocks are cut from, one after the other: of one kind, or of one rule and kinds that can be mixed. */
typedef struct deal {
    int32_t n_kinds;
    int32_t *start; /* [n_kinds + 1] where a kind's patches begin, */
    int32_t *order; /* [n_patches] in this */
    int32_t *whole; /* [n_kinds] how many of them fill blocks of their own; the others are mixed */
} deal;

static int32_t table_of(const co_patches *patches, co_basis_table_cache *cache, int32_t kind,
                        const co_basis_table **table, curvopt_error *error) {
    return co_basis_table_cache_get(cache, patches->kinds[kind / CO_N_RULES], kind % CO_N_RULES, table, error);
}

static int32_t blocks_of(int32_t n, int32_t lanes) {
    return (n + lanes - 1) / lanes;
}

/* What is left of kinds that can be mixed, beside whole blocks, where that makes fewer blocks; fetches all tables. */
static int32_t choose_mixed(deal *d, const co_patches *patches, co_basis_table_cache *cache, int32_t lanes,
                            curvopt_error *error) {
    int32_t rest[CO_N_RULES] = {0}, blocks[CO_N_RULES] = {0};
    for (int pass = 0; pass < 2; pass++)
        for (int32_t k = 0; k < d->n_kinds; k++) {
            int32_t n = d->start[k + 1] - d->start[k], left = n % lanes, rule = k % CO_N_RULES;
            const co_basis_table *table;
            d->whole[k] = n;
            if (n == 0)
                continue;
            int32_t status = table_of(patches, cache, k, &table, error);
            if (status != CURVOPT_OK)
                return status;
            if (left == 0 || !co_basis_table_is_mixable(table))
                continue;
            if (pass == 0) {
                rest[rule] += left;
                blocks[rule]++;
            } else if (blocks_of(rest[rule], lanes) < blocks[rule]) {
                d->whole[k] = n - left;
            }
        }
    return CURVOPT_OK;
}

static void count_blocks(co_element_batches *l, int32_t n, const co_basis_table *table, size_t *n_points) {
    int32_t blocks = blocks_of(n, l->lanes);
    l->n_blocks += blocks;
    l->n_samples += (int64_t)n * table->n_samples;
    l->max_points = table->n_points > l->max_points ? table->n_points : l->max_points;
    *n_points += (size_t)blocks * (size_t)table->n_points * (size_t)l->lanes;
}

/* Counts blocks and what they hold. */
static int32_t measure(co_element_batches *l, const deal *d, const co_patches *patches, co_basis_table_cache *cache,
                       size_t *n_points, curvopt_error *error) {
    const co_basis_table *table, *any[CO_N_RULES];
    int32_t rest[CO_N_RULES] = {0};
    *n_points = 0;
    for (int32_t k = 0; k < d->n_kinds; k++) {
        int32_t n = d->start[k + 1] - d->start[k];
        if (n == 0)
            continue;
        int32_t status = table_of(patches, cache, k, &table, error);
        if (status != CURVOPT_OK)
            return status;
        count_blocks(l, d->whole[k], table, n_points);
        if (n > d->whole[k]) {
            rest[k % CO_N_RULES] += n - d->whole[k];
            any[k % CO_N_RULES] = table;
        }
    }
    for (int rule = 0; rule < CO_N_RULES; rule++)
        if (rest[rule]) {
            count_blocks(l, rest[rule], any[rule], n_points);
            l->n_mixed += blocks_of(rest[rule], l->lanes);
        }
    return CURVOPT_OK;
}

static void fill_block(const co_patches *patches, const int32_t *order, int32_t n_used, co_element_batches *l,
                       int32_t b) {
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

/* Where the next block goes. */
typedef struct place {
    int32_t block, mixed;
    size_t points;
} place;

static void add_block(const co_patches *patches, const co_basis_table *table, const int32_t *order, int32_t n_used,
                      co_element_batches *l, place *at) {
    l->block[at->block].table = table;
    l->block[at->block].points = at->points;
    fill_block(patches, order, n_used < l->lanes ? n_used : l->lanes, l, at->block);
    at->points += (size_t)table->n_points * (size_t)l->lanes;
    at->block++;
}

static int32_t add_mixed(const co_patches *patches, const co_basis_table **tables, const int32_t *order, int32_t n_used,
                         co_element_batches *l, place *at, curvopt_error *error) {
    for (int32_t lane = n_used; lane < l->lanes; lane++)
        tables[lane] = tables[0];
    int32_t status = co_basis_table_mix(tables, l->lanes, &l->mixed[at->mixed], error);
    if (status == CURVOPT_OK)
        add_block(patches, l->mixed[at->mixed++], order, n_used, l, at);
    return status;
}

/* The blocks of one rule's mixed patches. */
static int32_t fill_mixed(const deal *d, int32_t rule, const co_patches *patches, co_basis_table_cache *cache,
                          co_element_batches *l, place *at, curvopt_error *error) {
    const co_basis_table *tables[CO_MAX_LANES];
    int32_t order[CO_MAX_LANES], n = 0, status = CURVOPT_OK;
    for (int32_t k = rule; k < d->n_kinds; k += CO_N_RULES)
        for (int32_t i = d->start[k] + d->whole[k]; status == CURVOPT_OK && i < d->start[k + 1]; i++) {
            order[n] = d->order[i];
            status = table_of(patches, cache, k, &tables[n++], error);
            if (status == CURVOPT_OK && n == l->lanes) {
                status = add_mixed(patches, tables, order, n, l, at, error);
                n = 0;
            }
        }
    return status == CURVOPT_OK && n ? add_mixed(patches, tables, order, n, l, at, error) : status;
}

static int32_t fill_blocks(const deal *d, const co_patches *patches, co_basis_table_cache *cache, co_element_batches *l,
                           curvopt_error *error) {
    place at = {0};
    int32_t status = CURVOPT_OK;
    for (int32_t k = 0; k < d->n_kinds && status == CURVOPT_OK; k++) {
        const co_basis_table *table = NULL;
        if (d->whole[k])
            status = table_of(patches, cache, k, &table, error);
        for (int32_t i = 0; status == CURVOPT_OK && i < d->whole[k]; i += l->lanes)
            add_block(patches, table, d->order + d->start[k] + i, d->whole[k] - i, l, &at);
    }
    for (int32_t rule = 0; rule < CO_N_RULES && status == CURVOPT_OK; rule++)
        status = fill_mixed(d, rule, patches, cache, l, &at, error);
    return status;
}

/* -------------------------------------------------------------------------------------------------- batches -- */

/* Deals blocks out to batches, and gives each its place among the batch's gradients. */
static int32_t split_batches(int area, co_element_batches *l, curvopt_error *error) {
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
static size_t count_touched(const co_element_batches *l, size_t *mark) {
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

/* The points that one batch touches, from number `first` of co_element_batches.touched on, and where their shares are;
 * the next free number. slot [n_points]: 1 + the number of a point when it was last touched, 0 before. */
static size_t fill_batch(co_element_batches *l, int area, int32_t batch, size_t first, size_t *slot) {
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

static int32_t build_batches(int32_t n_points, int area, co_element_batches *l, curvopt_error *error) {
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

static int32_t allocate(co_element_batches *l, size_t n_points, curvopt_error *error) {
    l->block = CO_NEW(co_block, l->n_blocks);
    l->patch = CO_NEW(int32_t, (size_t)l->n_blocks * (size_t)l->lanes);
    l->points = CO_NEW(int32_t, n_points);
    l->sums = CO_NEW_ALIGNED(double, (size_t)l->n_blocks *CO_N_SUMS *(size_t)l->lanes);
    l->mixed = CO_NEW(co_basis_table *, l->n_mixed);
    if (l->block && l->patch && l->points && l->sums && l->mixed)
        return CURVOPT_OK;
    l->n_mixed = l->mixed ? l->n_mixed : 0;
    return co_status_no_memory(error);
}

int32_t co_element_batches_create(const co_patches *patches, co_basis_table_cache *cache, int32_t lanes,
                                  const uint8_t *rule, int step, int gradients, int area, co_element_batches *l,
                                  curvopt_error *error) {
    int32_t n_kinds = patches->n_kinds * CO_N_RULES;
    size_t n_points;
    deal d = {.n_kinds = n_kinds,
              .start = CO_NEW(int32_t, n_kinds + 1),
              .order = CO_NEW(int32_t, patches->n_patches),
              .whole = CO_NEW(int32_t, n_kinds)};
    *l = (co_element_batches){.lanes = lanes};
    int32_t status = d.start && d.order && d.whole ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        sort_by_kind(patches, rule, step, n_kinds, d.start, d.order);
        status = choose_mixed(&d, patches, cache, lanes, error);
    }
    if (status == CURVOPT_OK)
        status = measure(l, &d, patches, cache, &n_points, error);
    if (status == CURVOPT_OK)
        status = allocate(l, n_points, error);
    if (status == CURVOPT_OK)
        status = fill_blocks(&d, patches, cache, l, error);
    if (status == CURVOPT_OK && gradients)
        status = build_batches(patches->n_points, area, l, error);
    free(d.start);
    free(d.order);
    free(d.whole);
    return status;
}
