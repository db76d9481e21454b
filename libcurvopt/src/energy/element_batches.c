/* Patches grouped for the element kernels. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/element_batches.h"

#include "base/memory.h"
#include "surface/basis_table_mixed.h"
#include "surface/face_rule.h"

#include <stdlib.h>
#include <string.h>

/* Largest size of a batch's gradients: 2^17 doubles, 1 MB, which a core's own cache holds beside what else is read. The
 * gradients of all faces together would go to memory and back, 768 bytes a face. */
enum { BATCH_SIZE = 1 << 17 };
/* Least number of batches of like cost, where there are as many blocks: so many that two cores or a few get done at the
 * same time. Both: libcurvopt/notes/30-batches-of-gradients.md. */
enum { FEWEST_BATCHES = 32 };

void co_element_batches_free(co_element_batches *l) {
    free(l->block);
    free(l->patch);
    free(l->points);
    free(l->sums);
    free(l->is_known);
    for (int32_t i = 0; i < l->n_mixed; i++)
        co_basis_table_destroy(l->mixed[i]);
    free(l->mixed);
    free(l->batch_block);
    free(l->batch_touched);
    free(l->touched);
    free(l->batch_sums);
    free(l->incident);
    *l = (co_element_batches){0};
}

/* ------------------------------------------------------------------------------------------------- bins -- */

/* A bin is for patches of one kind (fan.h) and one rule: number of the kind among the patches' times CO_N_RULES + rule
 * less CO_ROUGH_RULE, the first. */
static int32_t bin_of(const co_element_batches_spec *s, int32_t p) {
    const int32_t kind = s->patches->kind[p], rule = s->rule[p] + s->step;
    const int32_t coarsest = co_element_batches_coarsest(s->cache->surface, kind, s->coarsest);
    return co_patches_kind(s->patches, kind) * CO_N_RULES + (rule > coarsest ? rule : coarsest) - CO_ROUGH_RULE;
}

static int32_t rule_of_bin(int32_t bin) {
    return bin % CO_N_RULES + CO_ROUGH_RULE;
}

static int is_in(const co_element_batches_spec *s, int32_t p) {
    return !s->only || s->only[p];
}

/* Patches sorted into bins, stably. */
typedef struct sorted_patches {
    int32_t n_bins;
    int32_t *start; /* [n_bins + 1] place in `order` of each bin's first patch */
    int32_t *order; /* [n_patches] */
    int32_t *whole; /* [n_bins] patches of a bin that fill blocks of their own; the others are mixed */
} sorted_patches;

static void sort_into_bins(const co_element_batches_spec *s, sorted_patches *d) {
    for (int32_t p = 0; p < s->patches->n_patches; p++)
        if (is_in(s, p))
            d->start[bin_of(s, p) + 1]++;
    for (int32_t k = 0; k < d->n_bins; k++)
        d->start[k + 1] += d->start[k];
    for (int32_t p = 0; p < s->patches->n_patches; p++)
        if (is_in(s, p))
            d->order[d->start[bin_of(s, p)]++] = p;
    for (int32_t k = d->n_bins; k > 0; k--)
        d->start[k] = d->start[k - 1];
    d->start[0] = 0;
}

static int32_t table_of(const co_element_batches_spec *s, int32_t bin, const co_basis_table **table,
                        curvopt_error *error) {
    return co_basis_table_cache_get(s->cache, s->patches->kinds[bin / CO_N_RULES], rule_of_bin(bin), table, error);
}

int32_t co_element_batches_make_tables(const co_element_batches_spec *s, curvopt_error *error) {
    const co_basis_table *table;
    uint8_t *is_there = CO_NEW(uint8_t, s->patches->n_kinds * CO_N_RULES);
    int32_t status = is_there ? CURVOPT_OK : co_status_no_memory(error);
    for (int32_t p = 0; status == CURVOPT_OK && p < s->patches->n_patches; p++) {
        if (!is_in(s, p))
            continue;
        int32_t bin = bin_of(s, p);
        if (!is_there[bin])
            status = table_of(s, bin, &table, error);
        is_there[bin] = 1;
    }
    free(is_there);
    return status;
}

static int32_t blocks_of(int32_t n) {
    return (n + CO_BLOCK_FACES - 1) / CO_BLOCK_FACES;
}

/* Fills d->whole: the rest of a bin beside whole blocks is mixed with others of the same rule where that makes fewer
 * blocks. Fetches all tables. */
static int32_t choose_mixed(const co_element_batches_spec *s, sorted_patches *d, curvopt_error *error) {
    int32_t rest[CO_N_RULES] = {0}, blocks[CO_N_RULES] = {0};
    for (int pass = 0; pass < 2; pass++)
        for (int32_t k = 0; k < d->n_bins; k++) {
            int32_t n = d->start[k + 1] - d->start[k], left = n % CO_BLOCK_FACES, rule = k % CO_N_RULES;
            const co_basis_table *table;
            d->whole[k] = n;
            if (n == 0)
                continue;
            int32_t status = table_of(s, k, &table, error);
            if (status != CURVOPT_OK)
                return status;
            if (left == 0 || !co_basis_table_is_mixable(table))
                continue;
            if (pass == 0) {
                rest[rule] += left;
                blocks[rule]++;
            } else if (blocks_of(rest[rule]) < blocks[rule]) {
                d->whole[k] = n - left;
            }
        }
    return CURVOPT_OK;
}

/* ------------------------------------------------------------------------------------------------- blocks -- */

static void count_blocks(co_element_batches *l, int32_t n, const co_basis_table *table, size_t *n_points) {
    int32_t blocks = blocks_of(n);
    l->n_blocks += blocks;
    l->n_samples += (int64_t)n * table->n_samples;
    l->max_points = table->n_points > l->max_points ? table->n_points : l->max_points;
    *n_points += (size_t)blocks * (size_t)table->n_points * CO_BLOCK_FACES;
}

/* Counts blocks and their points. */
static int32_t measure(const co_element_batches_spec *s, const sorted_patches *d, co_element_batches *l,
                       size_t *n_points, curvopt_error *error) {
    const co_basis_table *table, *any[CO_N_RULES];
    int32_t rest[CO_N_RULES] = {0};
    *n_points = 0;
    for (int32_t k = 0; k < d->n_bins; k++) {
        int32_t n = d->start[k + 1] - d->start[k];
        if (n == 0)
            continue;
        int32_t status = table_of(s, k, &table, error);
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
            l->n_mixed += blocks_of(rest[rule]);
        }
    return CURVOPT_OK;
}

static void fill_block(const co_patches *patches, const int32_t *order, int32_t n_used, co_element_batches *l,
                       int32_t b) {
    co_block *block = &l->block[b];
    block->n_used = n_used;
    for (int32_t k = 0; k < CO_BLOCK_FACES; k++) {
        int32_t p = order[k < n_used ? k : 0];
        const int32_t *from = patches->points + patches->start[p];
        l->patch[b * CO_BLOCK_FACES + k] = p;
        for (int32_t i = 0; i < block->table->n_points; i++)
            l->points[co_element_batches_point(l, b, k, i)] = from[block->table->support[i]];
    }
}

/* Where the next block, table of mixed kinds and points go. */
typedef struct place {
    int32_t block, mixed;
    size_t points;
} place;

static void add_block(const co_patches *patches, const co_basis_table *table, int32_t rule, const int32_t *order,
                      int32_t n_used, co_element_batches *l, place *at) {
    l->block[at->block].table = table;
    l->block[at->block].rule = (int8_t)rule;
    l->block[at->block].points = at->points;
    fill_block(patches, order, n_used < CO_BLOCK_FACES ? n_used : CO_BLOCK_FACES, l, at->block);
    at->points += (size_t)table->n_points * CO_BLOCK_FACES;
    at->block++;
}

static int32_t add_mixed(const co_patches *patches, const co_basis_table **tables, int32_t rule, const int32_t *order,
                         int32_t n_used, co_element_batches *l, place *at, curvopt_error *error) {
    for (int32_t k = n_used; k < CO_BLOCK_FACES; k++)
        tables[k] = tables[0];
    int32_t status = co_basis_table_mix(tables, CO_BLOCK_FACES, l->lanes, &l->mixed[at->mixed], error);
    if (status == CURVOPT_OK)
        add_block(patches, l->mixed[at->mixed++], rule, order, n_used, l, at);
    return status;
}

/* The blocks of one rule's mixed patches; `first`: the rule's first bin. */
static int32_t fill_mixed(const co_element_batches_spec *s, const sorted_patches *d, int32_t first,
                          co_element_batches *l, place *at, curvopt_error *error) {
    const int32_t rule = rule_of_bin(first);
    const co_basis_table *tables[CO_BLOCK_FACES];
    int32_t order[CO_BLOCK_FACES], n = 0, status = CURVOPT_OK;
    for (int32_t k = first; k < d->n_bins; k += CO_N_RULES)
        for (int32_t i = d->start[k] + d->whole[k]; status == CURVOPT_OK && i < d->start[k + 1]; i++) {
            order[n] = d->order[i];
            status = table_of(s, k, &tables[n++], error);
            if (status == CURVOPT_OK && n == CO_BLOCK_FACES) {
                status = add_mixed(s->patches, tables, rule, order, n, l, at, error);
                n = 0;
            }
        }
    return status == CURVOPT_OK && n ? add_mixed(s->patches, tables, rule, order, n, l, at, error) : status;
}

static int32_t fill_blocks(const co_element_batches_spec *s, const sorted_patches *d, co_element_batches *l,
                           curvopt_error *error) {
    place at = {0};
    int32_t status = CURVOPT_OK;
    for (int32_t k = 0; k < d->n_bins && status == CURVOPT_OK; k++) {
        const co_basis_table *table = NULL;
        if (d->whole[k])
            status = table_of(s, k, &table, error);
        for (int32_t i = 0; status == CURVOPT_OK && i < d->whole[k]; i += CO_BLOCK_FACES)
            add_block(s->patches, table, rule_of_bin(k), d->order + d->start[k] + i, d->whole[k] - i, l, &at);
    }
    for (int32_t first = 0; first < CO_N_RULES && status == CURVOPT_OK; first++)
        status = fill_mixed(s, d, first, l, &at, error);
    return status;
}

/* -------------------------------------------------------------------------------------------------- batches -- */

/* Cuts the list of blocks into batches, and gives each block its place among its batch's gradients. */
static int32_t split_batches(int area, co_element_batches *l, curvopt_error *error) {
    size_t at = 0;
    double cost = 0, whole = 0;
    l->batch_block = CO_NEW(int32_t, (size_t)l->n_blocks + 1);
    if (!l->batch_block)
        return co_status_no_memory(error);
    for (int32_t b = 0; b < l->n_blocks; b++)
        whole += co_block_cost(&l->block[b]);
    for (int32_t b = 0; b < l->n_blocks; b++) {
        size_t size = (size_t)l->block[b].table->n_points * CO_BLOCK_FACES * 3 * (size_t)(1 + area);
        cost += co_block_cost(&l->block[b]);
        if (at == 0 || at + size > BATCH_SIZE || cost > whole / FEWEST_BATCHES) {
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
            for (int32_t e = 0; e < l->block[b].table->n_points * CO_BLOCK_FACES; e++) {
                size_t *m = &mark[l->points[l->block[b].points + (size_t)e]];
                n += *m <= (size_t)batch;
                *m = (size_t)batch + 1;
            }
    return n;
}

/* The e-th contribution of a block: points one after the other, and all of the block's patches to each. */
static int32_t point_of(const co_element_batches *l, int32_t b, int32_t e) {
    const int32_t n_used = l->block[b].n_used;
    return l->points[co_element_batches_point(l, b, e % n_used, e / n_used)];
}
static uint32_t gradient_of(const co_element_batches *l, int32_t b, int32_t e, int area) {
    const co_block *block = &l->block[b];
    const size_t lanes = (size_t)l->lanes, n = 3 * (size_t)(1 + area), k = (size_t)(e % block->n_used);
    return (uint32_t)(block->gradient + co_lane_place(k, n * (size_t)block->table->n_points, lanes) +
                      (size_t)(e / block->n_used) * n * lanes);
}

/* Lists the points that one batch touches, from entry `first` of `touched` on, and where their contributions are;
 * returns the next free entry. slot [n_points]: 1 + the entry of a point where it was touched last, 0 before.
 *
 * For example the second batch, first = 2, has one block of two patches, both with the points 7 and 5, and the first
 * batch touched point 5 as its entry 1:
 *
 *     1. count       touched[2] = {point 7, is_first}, touched[3] = {point 5}, touched[1].next = 3; slot[7] = 3,
 *                    slot[5] = 4; `incident` counts the contributions: 2, 2
 *     2. places      with 9 contributions in the first batch `incident` becomes 9, 11
 *     3. fill        each contribution is written to its point's place, which is moved on: 11, 13
 *     4. move back   each point's place is the one that the point before was moved on to: 9, 11 */
static size_t fill_batch(co_element_batches *l, int area, int32_t batch, size_t first, size_t *slot) {
    int32_t begin = l->batch_block[batch], end = l->batch_block[batch + 1];
    const size_t start = l->touched[first].incident; /* place of the batch's first; left there by the batch before */
    size_t n = first, at = start;
    for (int32_t b = begin; b < end; b++)
        for (int32_t e = 0; e < l->block[b].table->n_points * l->block[b].n_used; e++) {
            int32_t point = point_of(l, b, e);
            if (slot[point] <= first) {
                l->touched[n] = (co_touched){.point = point, .is_first = slot[point] == 0};
                if (slot[point])
                    l->touched[slot[point] - 1].next = n;
                slot[point] = ++n;
            }
            l->touched[slot[point] - 1].incident++;
        }
    for (size_t k = first; k < n; k++) { /* from counts to places */
        size_t count = l->touched[k].incident;
        l->touched[k].incident = at;
        at += count;
    }
    for (int32_t b = begin; b < end; b++)
        for (int32_t e = 0; e < l->block[b].table->n_points * l->block[b].n_used; e++)
            l->incident[l->touched[slot[point_of(l, b, e)] - 1].incident++] = gradient_of(l, b, e, area);
    for (size_t k = n; k > first; k--) /* places were moved on to the next one's */
        l->touched[k].incident = l->touched[k - 1].incident;
    l->touched[first].incident = start;
    return n;
}

static int32_t build_batches(int32_t n_points, int area, co_element_batches *l, curvopt_error *error) {
    size_t n_incident = 0, n = 0, n_touched;
    size_t *slot = CO_NEW(size_t, n_points);
    int32_t status = slot ? split_batches(area, l, error) : co_status_no_memory(error);
    if (status != CURVOPT_OK)
        goto done;
    for (int32_t b = 0; b < l->n_blocks; b++)
        n_incident += (size_t)l->block[b].table->n_points * (size_t)l->block[b].n_used;
    n_touched = count_touched(l, slot);
    l->touched = CO_NEW(co_touched, n_touched + 1);
    l->batch_sums = CO_NEW(double, n_touched * 3 * (size_t)(1 + area));
    l->incident = CO_NEW(uint32_t, n_incident);
    if (!l->touched || !l->batch_sums || !l->incident) {
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
    l->patch = CO_NEW(int32_t, (size_t)l->n_blocks * CO_BLOCK_FACES);
    l->points = CO_NEW(int32_t, n_points);
    l->sums = CO_NEW_ALIGNED(double, (size_t)l->n_blocks *CO_N_SUMS *CO_BLOCK_FACES);
    l->is_known = CO_NEW(uint8_t, l->n_blocks);
    l->mixed = CO_NEW(co_basis_table *, l->n_mixed);
    if (l->block && l->patch && l->points && l->sums && l->is_known && l->mixed)
        return CURVOPT_OK;
    l->n_mixed = l->mixed ? l->n_mixed : 0;
    return co_status_no_memory(error);
}

int32_t co_element_batches_create(const co_element_batches_spec *spec, co_element_batches *l, curvopt_error *error) {
    int32_t n_bins = spec->patches->n_kinds * CO_N_RULES;
    size_t n_points;
    sorted_patches d = {.n_bins = n_bins,
                        .start = CO_NEW(int32_t, n_bins + 1),
                        .order = CO_NEW(int32_t, spec->patches->n_patches),
                        .whole = CO_NEW(int32_t, n_bins)};
    *l = (co_element_batches){.lanes = spec->lanes};
    int32_t status = d.start && d.order && d.whole ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        sort_into_bins(spec, &d);
        status = choose_mixed(spec, &d, error);
    }
    if (status == CURVOPT_OK)
        status = measure(spec, &d, l, &n_points, error);
    if (status == CURVOPT_OK)
        status = allocate(l, n_points, error);
    if (status == CURVOPT_OK)
        status = fill_blocks(spec, &d, l, error);
    if (status == CURVOPT_OK && spec->gradients)
        status = build_batches(spec->patches->n_points, spec->gradients > 1, l, error);
    free(d.start);
    free(d.order);
    free(d.whole);
    return status;
}
