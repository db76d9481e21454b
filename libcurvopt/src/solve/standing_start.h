/* Whether a cage stands already: a minimum that is minimized again stays where it is.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_STANDING_START_H
#define CO_SOLVE_STANDING_START_H

#include "solve/level.h"

/* Whether the cage start [3 n_vertices], in the user's units, stands, with which the level `all` over everything has
 * begun, with this symmetry and these constraints: a step by the matrix of its first stage, which it keeps, brings no
 * more than tuning.standing_gain of the energy, or, where a touch raises the energy by no more than that in the mean,
 * than tuning.standing_touches times that mean; and one of Gauss and Newton's method along normals moves no vertex
 * farther than tuning.standing_step mean edges. As co_level_create. */
int32_t co_standing_start_look(co_level *all, const co_symmetry *symmetry, const co_constraints *constraints,
                               const double *start, int *stands, curvopt_error *error);

#endif
