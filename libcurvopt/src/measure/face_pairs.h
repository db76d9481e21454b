/* Pairs of faces of a first cage that cross or touch each other, as its subdivisions see them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_FACE_PAIRS_H
#define CO_MEASURE_FACE_PAIRS_H

#include "measure/crossings.h"

typedef struct co_face_pairs {
    size_t n;
    int32_t (*pair)[2]; /* [n] ascending, and each pair as well: those that touch or cross */
    size_t n_crossing;  /* of these */
    uint8_t *is_near;   /* [n_faces] whether a face crosses another one, or is one of the two rings round such faces */
    const int32_t *origin; /* face of the first cage that each present face is in, the caller's; NULL: itself */
} co_face_pairs;

/* Of the first cage's crossings. ERROR_MEMORY. */
int32_t co_face_pairs_create(const curvopt_mesh *mesh, const co_crossings *crossings, co_face_pairs *out,
                             curvopt_error *error);
void co_face_pairs_free(co_face_pairs *pairs);
/* Whether the present faces one and other touch or cross, or are both near a crossing. */
int co_face_pairs_have(const co_face_pairs *pairs, int32_t one, int32_t other);
/* Whether crossings of the present cage, which this puts into another order, are no worse than the first cage's: only
 * of faces near those that cross there, and in no more pairs of faces of the first cage. */
int co_face_pairs_allow(const co_face_pairs *pairs, co_crossings *crossings);
/* From now on these crossings of the present cage are no worse either; puts them into another order. */
void co_face_pairs_accept(co_face_pairs *pairs, co_crossings *crossings);

#endif
