/* Whether a cage stands already: a minimum that is minimized again stays where it is.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_STANDING_START_H
#define CO_SOLVE_STANDING_START_H

#include "solve/run.h"

/* Whether run->at.start stands, with which `level` over everything has begun: a step over everything by the matrix of
 * its first stage, which it keeps, brings no more than tuning.standing_gain of the energy, and one of Gauss and
 * Newton's method along normals moves no vertex farther than tuning.standing_step mean edges. *stands is 0 where cages
 * have no even spacing, where numbers of the surface are held or vertices slide along curves, on levels after the
 * first, and where another start is tried (run->prospect). As co_level_create. */
int32_t co_standing_start_look(const co_run *run, co_level *level, int *stands, curvopt_error *error);

#endif
