/* A set of pairs of faces. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_FACE_PAIRS_H
#define CO_MEASURE_FACE_PAIRS_H

#include "measure/crossings.h"

/* Pairs of faces of a first cage; faces of a cage that was made of it by subdivision stand for those that they are in.
 */
typedef struct co_face_pairs {
    size_t n;
    int32_t (*pair)[2];    /* [n] ascending, and each pair as well */
    const int32_t *origin; /* face of the first cage that each present face is in, the caller's; NULL: itself */
} co_face_pairs;

/* The pairs of crossings of the first cage that are `least` at least. ERROR_MEMORY. */
int32_t co_face_pairs_create(const co_crossings *crossings, co_crossing least, co_face_pairs *out,
                             curvopt_error *error);
void co_face_pairs_free(co_face_pairs *pairs);
/* Whether the present faces one and other are in a pair. */
int co_face_pairs_have(const co_face_pairs *pairs, int32_t one, int32_t other);

#endif
