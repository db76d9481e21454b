/* Patches dealt out to blocks: as many of one kind (valence and quadrature rule) at once as there are vector lanes, or
 * of kinds that can be mixed (basis_table_mixed.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ELEMENT_BATCHES_H
#define CO_ENERGY_ELEMENT_BATCHES_H

#include "energy/element_kernel.h"
#include "surface/patches.h"

typedef struct co_block {
    const co_basis_table *table;
    size_t points;   /* of co_element_batches.points: [table->n_points][lanes] */
    size_t gradient; /* among its batch's: [table->n_points][1 + area][3][lanes] */
    int32_t n_used;  /* lanes in use */
} co_block;

/* A point that a batch has shares of. */
typedef struct co_touched {
    int32_t point;
    int32_t is_first; /* no batch before has any */
    size_t next;      /* of co_element_batches.touched, the same point in a later batch; 0: there is none */
    size_t incident;  /* of co_element_batches.incident, its first; they end at the next one's */
} co_touched;

typedef struct co_element_batches {
    int32_t lanes;
    int32_t n_blocks;
    int32_t max_points; /* of any table */
    int64_t n_samples;
    co_block *block;
    int32_t *patch; /* [n_blocks][lanes] */
    int32_t *points;
    co_basis_table **mixed; /* [n_mixed] tables of blocks of several kinds */
    int32_t n_mixed;
    double *sums; /* [n_blocks][CO_N_SUMS][lanes] */
    /* For gradients only, else NULL. Blocks are worked on in batches, each by one thread, in whose cache gradients stay
     * until they have been added up for every point that the batch touches: */
    size_t batch_size; /* doubles that the largest one's gradients take */
    int32_t n_batches;
    int32_t *batch_block;  /* [n_batches + 1] where each one's blocks begin, */
    size_t *batch_touched; /* [n_batches + 1] and the points that it touches: */
    co_touched *touched;
    double *shares;     /* [number touched][1 + area][3] what a batch adds to each */
    uint32_t *incident; /* where among its batch's gradients each summand of a touched point begins; they stand in the
                         order of blocks, which makes sums the same for any number of threads */
} co_element_batches;

/* rule [n_patches]; `step` finer for every patch, or coarser, down to the coarsest. With `gradients`, room and
 * incidence for those too, two gradients a point if `area`. Free after failure as well. */
int32_t co_element_batches_create(const co_patches *patches, co_basis_table_cache *cache, int32_t lanes,
                                  const uint8_t *rule, int step, int gradients, int area, co_element_batches *out,
                                  curvopt_error *error);
void co_element_batches_free(co_element_batches *layout);

/* Time of an evaluation of one of a block's faces, in samples times points. */
static inline double co_block_cost(const co_block *block) {
    return (double)block->table->n_samples * block->table->n_points;
}

/* What was summed over one patch: one of CO_N_INTEGRALS, or of element_kernel.h's. */
static inline double co_element_batches_sum(const co_element_batches *l, int32_t block, int32_t lane, int which) {
    return l->sums[((size_t)block * CO_N_SUMS + (size_t)which) * (size_t)l->lanes + (size_t)lane];
}

#endif
