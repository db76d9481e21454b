/* Sums over patches that stay known when batches are made anew. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/known_sums.h"

#include "base/memory.h"
#include "surface/face_rule.h"

#include <stdlib.h>
#include <string.h>

void co_known_sums_free(co_known_sums *known) {
    for (int k = 0; k < CO_KNOWN_RULES; k++) {
        free(known->rule[k]);
        free(known->sums[k]);
    }
    *known = (co_known_sums){0};
}

int32_t co_known_sums_keep(co_known_sums *known, int which, int32_t n_patches, const co_element_batches *l,
                           int64_t placement, curvopt_error *error) {
    if (l->sums_of.placement != placement || l->n_known != l->n_blocks)
        return CURVOPT_OK;
    if (!known->rule[which])
        known->rule[which] = CO_NEW(int8_t, n_patches);
    if (!known->sums[which])
        known->sums[which] = CO_NEW(double, CO_N_SUMS *(size_t)n_patches);
    if (!known->rule[which] || !known->sums[which])
        return co_status_no_memory(error);
    known->of[which] = l->sums_of;
    memset(known->rule[which], CO_N_RULES, (size_t)n_patches);
    for (int32_t b = 0; b < l->n_blocks; b++)
        for (int32_t k = 0; k < l->block[b].n_used; k++) {
            const int32_t p = co_element_batches_patch(l, b, k);
            known->rule[which][p] = l->block[b].rule;
            for (int i = 0; i < CO_N_SUMS; i++)
                known->sums[which][(size_t)p * CO_N_SUMS + (size_t)i] = co_element_batches_sum(l, b, k, i);
        }
    return CURVOPT_OK;
}

/* A patch's sums by a rule, or NULL. */
static const double *sums_of(const co_known_sums *known, const co_sums_of *wanted, int32_t patch, int rule) {
    for (int k = 0; k < CO_KNOWN_RULES; k++)
        if (co_sums_of_has(&known->of[k], wanted) && known->rule[k][patch] == rule)
            return known->sums[k] + (size_t)patch * CO_N_SUMS;
    return NULL;
}

void co_known_sums_give(const co_known_sums *known, const co_sums_of *wanted, co_element_batches *l) {
    if (!co_sums_of_has(&known->of[0], wanted) && !co_sums_of_has(&known->of[1], wanted))
        return;
    for (int32_t b = 0; b < l->n_blocks; b++) {
        const double *from[CO_BLOCK_FACES];
        int32_t n = 0;
        while (n < l->block[b].n_used &&
               (from[n] = sums_of(known, wanted, co_element_batches_patch(l, b, n), l->block[b].rule)))
            n++;
        if (n < l->block[b].n_used || l->is_known[b])
            continue;
        for (int32_t k = 0; k < n; k++)
            for (int i = 0; i < CO_N_SUMS; i++)
                co_element_batches_sums(l, b, k)[i * l->lanes] = from[k][i];
        l->is_known[b] = 1;
        l->n_known++;
    }
}
