/* The tangents by which curvatures are held (held_curvatures.h), chosen at the beginning of levels.
 *
 * Tangents are numbers of the parameters: those of the minimum without curvatures take next to nothing from it. With
 * those of the cage that is given a torus is nine times as far from the exact one.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_TANGENT_CHOICE_H
#define CO_SOLVE_TANGENT_CHOICE_H

#include "solve/run.h"

/* Solves the level without curvatures, and fixes tangents there, if the cage that has the curvatures with them,
 * run->at.start then, has less of the objective than with the tangents before. The first level's before are those at
 * run->at.start, where points and normals are what they are to be. Without curvatures nothing. A run that was cancelled
 * meanwhile has its figures. As curvopt_minimize. */
int32_t co_tangent_choice_make(co_run *run, int32_t number, curvopt_error *error);

#endif
