/* Sums over patches that stay known when batches are made anew for other rules: a patch whose rule stays, or becomes
 * one that it was compared with, is not evaluated again.
 *
 *     rules r, and r + 1 of batches that are freed --keep--> sums by patch and rule --give--> blocks of new batches
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KNOWN_SUMS_H
#define CO_ENERGY_KNOWN_SUMS_H

#include "energy/element_batches.h"

enum { CO_KNOWN_RULES = 2 }; /* kept of each patch: its own, and the one that this was compared with */

/* All 0 at first. */
typedef struct co_known_sums {
    co_sums_of of[CO_KNOWN_RULES]; /* what the sums are of; unknown: none are kept */
    int8_t *rule[CO_KNOWN_RULES];  /* [n_patches] by which they are; CO_N_RULES: none */
    double *sums[CO_KNOWN_RULES];  /* [n_patches][CO_N_SUMS] */
} co_known_sums;

void co_known_sums_free(co_known_sums *known);
/* Keeps the sums of batches in place `which` of the known ones, if they were evaluated for `placement`. What is kept
 * there already stays otherwise. ERROR_MEMORY. */
int32_t co_known_sums_keep(co_known_sums *known, int which, int32_t n_patches, const co_element_batches *batches,
                           int64_t placement, curvopt_error *error);
/* Sets the sums of those blocks whose patches' are all known, and marks the blocks as known. */
void co_known_sums_give(const co_known_sums *known, const co_sums_of *wanted, co_element_batches *batches);

#endif
