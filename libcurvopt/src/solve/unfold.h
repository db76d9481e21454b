/* A cage that a run may begin with in place of one whose surface is folded.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_UNFOLD_H
#define CO_SOLVE_UNFOLD_H

#include "base/cancel.h"
#include "constraints/constraints.h"

/* What was found, and done. */
typedef struct co_unfolding {
    int32_t n_folded; /* faces of the limit surface, folds.h */
    int32_t n_moved;  /* vertices; 0: the cage is as it was, for there are no folds, or they cannot be undone */
} co_unfolding;

/* Puts the vertices of folded faces between their neighbours (mesh/fill.h), and more of these round them, until no face
 * is folded. Where too little of the cage is left to say where they belong, all are smoothed. What `constraints` and
 * `boundary` hold stays. Where folds are left then, xyz [3 n_vertices] stays what it was. ERROR_TOPOLOGY, ERROR_MEMORY,
 * CO_CANCELLED.
 */
int32_t co_unfold(const curvopt_mesh *mesh, const co_constraints *constraints, int32_t boundary, co_cancel *cancel,
                  double *xyz, co_unfolding *out, curvopt_error *error);

#endif
