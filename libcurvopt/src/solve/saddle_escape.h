/* Away from saddles that symmetry hides. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_SADDLE_ESCAPE_H
#define CO_SOLVE_SADDLE_ESCAPE_H

#include "solve/level.h"

/* A way down from a cage that is stationary among those of its symmetry. */
typedef struct co_way_down {
    int found;
    co_symmetry symmetry; /* that is kept on it: of the largest subgroup in which there is one */
    double *xyz;          /* [3 n_vertices] some way along */
} co_way_down;

/* Looks for one at xyz [3 n_vertices], a cage of this symmetry in the user's units. As co_level_create. */
int32_t co_saddle_escape_find(const co_run_context *run, const curvopt_mesh *mesh, const co_symmetry *symmetry,
                              const co_constraints *constraints, const double *xyz, int32_t number, co_motion among,
                              co_way_down *out, curvopt_error *error);
void co_saddle_escape_free(co_way_down *way);

#endif
