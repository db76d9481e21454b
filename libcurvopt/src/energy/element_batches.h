/* Patches grouped for the element kernels.
 *
 *     patch    a piece of the surface, of a kind (fan.h), with a quadrature rule
 *     block    CO_BLOCK_FACES patches: of one kind and rule, or of kinds that can be mixed (basis_table_mixed.h); the
 *              last of them may have fewer
 *     batch    blocks that one thread works on one after the other, and whose gradients stay in its cache until they
 *              have been added up for every point that the batch touches (libcurvopt/notes/30-batches-of-gradients.md)
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ELEMENT_BATCHES_H
#define CO_ENERGY_ELEMENT_BATCHES_H

#include "energy/element_kernel.h"
#include "surface/basis_table_cache.h"
#include "surface/blend_fit.h"
#include "surface/face_rule.h"
#include "surface/patches.h"

typedef struct co_block {
    const co_basis_table *table;
    size_t points;   /* place in co_element_batches.points of its [parts][table->n_points][lanes] (element_kernel.h) */
    size_t gradient; /* place among its batch's gradients of its [parts][table->n_points][1 + area][3][lanes] */
    int32_t n_used;  /* patches */
    int8_t rule;     /* of all of them */
} co_block;

/* A point that a batch contributes to. */
typedef struct co_touched {
    int32_t point;
    int32_t is_first; /* no earlier batch contributes to it */
    size_t next;      /* place in co_element_batches.touched of the same point in a later batch; 0: there is none */
    size_t incident;  /* place in co_element_batches.incident of its first contribution; the next one's ends them */
} co_touched;

/* What sums over patches were evaluated for; another evaluation for the same would find the same. */
typedef struct co_sums_of {
    int64_t placement;       /* positions: co_assembly.placement; 0: unknown */
    int third, volume, jump; /* third-order integrals, the volume, and CO_SUM_JUMP are among the sums */
} co_sums_of;

/* Whether such sums have all that is wanted. Those of third order are not taken for those of second order. */
static inline int co_sums_of_has(const co_sums_of *have, const co_sums_of *wanted) {
    return have->placement == wanted->placement && have->third == wanted->third && have->volume >= wanted->volume &&
           have->jump >= wanted->jump;
}

typedef struct co_element_batches {
    int32_t lanes; /* the kernel's */
    int32_t n_blocks;
    int32_t max_points;     /* most points of any table */
    int64_t n_samples;      /* samples of all patches */
    co_block *block;        /* [n_blocks] */
    int32_t *patch;         /* [n_blocks][CO_BLOCK_FACES]; after a block's last patch its first again */
    int32_t *points;        /* points of all blocks' patches, co_block.points says where */
    co_basis_table **mixed; /* [n_mixed] tables of blocks of several kinds */
    int32_t n_mixed;
    double *sums;       /* [n_blocks][parts][CO_N_SUMS][lanes] what was summed over each patch, evaluated last */
    co_sums_of sums_of; /* what for */
    int32_t n_known;    /* blocks whose sums these are */
    uint8_t *is_known;  /* [n_blocks] which */

    /* The rest is for gradients only, else NULL. */
    size_t batch_size;     /* doubles that the gradients of the largest batch take */
    int32_t n_batches;     /* number of batches */
    int32_t *batch_block;  /* [n_batches + 1] first block of each batch */
    size_t *batch_touched; /* [n_batches + 1] first entry in `touched` of each batch */
    co_touched *touched;   /* points that batches contribute to, batch by batch */
    double *batch_sums;    /* [number touched][1 + area][3] contribution of a batch to a point */
    uint32_t *incident;    /* place among the batch's gradients of each summand of a touched point, in the order of
                              blocks, which makes sums the same for any number of threads */
} co_element_batches;

/* Input of co_element_batches_create(). */
typedef struct co_element_batches_spec {
    const co_patches *patches;
    co_basis_table_cache *cache; /* tables are taken from here, and made here */
    int32_t lanes;               /* lanes of the kernel */
    const int8_t *rule;          /* [n_patches] */
    const uint8_t *only;         /* [n_patches] whether a patch is in a block; NULL: all are */
    int step;                    /* added to every patch's rule */
    int coarsest;                /* the result is at least this rule, and the coarsest that the patch's kind has */
    int gradients;               /* gradients by every point: 0 none, 1 the integrand's, 2 the area's as well */
} co_element_batches_spec;

/* The coarsest rule from `coarsest` on that a kind of patch has on a surface. */
static inline int32_t co_element_batches_coarsest(int32_t surface, int32_t kind, int32_t coarsest) {
    const int32_t of_kind = co_face_rule_coarsest(co_blend_fit_surface(surface, kind), kind);
    return coarsest > of_kind ? coarsest : of_kind;
}

/* Makes the tables that co_element_batches_create() would have to make. ERROR_MEMORY, CO_CANCELLED. */
int32_t co_element_batches_make_tables(const co_element_batches_spec *spec, curvopt_error *error);
/* Free after failure as well. ERROR_MEMORY, CO_CANCELLED. */
int32_t co_element_batches_create(const co_element_batches_spec *spec, co_element_batches *out, curvopt_error *error);
void co_element_batches_free(co_element_batches *batches);

/* Cost of an evaluation of one of a block's patches, in samples times points. Regular faces take less time for it
 * (kernel_strip.h), which is not counted. */
static inline double co_block_cost(const co_block *block) {
    return (double)block->table->n_samples * block->table->n_points;
}

/* Doubles that one thread's kernel needs for any of the blocks. */
static inline size_t co_element_batches_kernel_work(const co_element_batches *l) {
    return 9 * (size_t)l->max_points * (size_t)l->lanes;
}

/* A block's k-th patch. */
static inline int32_t co_element_batches_patch(const co_element_batches *l, int32_t block, int32_t k) {
    return l->patch[block * CO_BLOCK_FACES + k];
}
/* The sums of a block's k-th patch, [CO_N_SUMS] at a distance of l->lanes. */
static inline double *co_element_batches_sums(const co_element_batches *l, int32_t block, int32_t k) {
    const size_t lanes = (size_t)l->lanes;
    return l->sums + (size_t)block * CO_N_SUMS * CO_BLOCK_FACES + co_lane_place((size_t)k, CO_N_SUMS, lanes);
}
/* One of them: one of CO_N_INTEGRALS, or of element_kernel.h's sums. */
static inline double co_element_batches_sum(const co_element_batches *l, int32_t block, int32_t k, int which) {
    return co_element_batches_sums(l, block, k)[which * l->lanes];
}
/* Place of a point of a block's k-th patch in l->points. */
static inline size_t co_element_batches_point(const co_element_batches *l, int32_t block, int32_t k, int32_t point) {
    const co_block *b = &l->block[block];
    const size_t lanes = (size_t)l->lanes;
    return b->points + co_lane_place((size_t)k, (size_t)b->table->n_points, lanes) + (size_t)point * lanes;
}

#endif
