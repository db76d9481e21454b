/* The tangents by which curvatures are held (held_curvatures.h), chosen at the beginning of levels.
 *
 * Tangents are numbers of the parameters: such as the minimum would have without curvatures take least from it. Where
 * they come from a cage as it was given, minima are up to twice as far from exact surfaces.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_TANGENT_CHOICE_H
#define CO_SOLVE_TANGENT_CHOICE_H

#include "solve/run.h"

/* On the first level, and on all but the last: solves it without curvatures, and fixes tangents there, if the cage that
 * has the curvatures with them, run->at.start then, has less of the objective than with tangents that it had before.
 * The first level's are those at run->at.start, where points and normals are what they are to be. Without curvatures
 * nothing. A run that was cancelled meanwhile has its figures. As curvopt_minimize. */
int32_t co_tangent_choice_make(co_run *run, int32_t number, curvopt_error *error);

#endif
