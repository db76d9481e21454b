/* How much of a minimum's energy is the net's: how far the least energy of the cage with these vertices is above that
 * of finer and finer nets, by the levels of a run.
 *
 *     E_1, E_2, E_3 at the ends of three levels:   d = E_2 - E_3,   q = d / (E_1 - E_2)
 *     where a level leaves q of what the one before left, all that follow take d (q + q^2 + ...) = d q / (1 - q)
 *
 * That is Richardson's extrapolation with an order found from three levels (Roache, "Perspective: a method for uniform
 * reporting of grid refinement studies", 1994). A high order is not relied on: q is .6 at least, so that with two
 * levels, too, there is an estimate, 1.5 d (libcurvopt/notes/112-discretization-error.md). No energy is below 0, so it
 * is not more than E_3.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_DISCRETIZATION_ERROR_H
#define CO_SOLVE_DISCRETIZATION_ERROR_H

#include "curvopt.h"

/* Of the last of n levels, in the energy's unit. NAN where nothing is known: of one level, of levels that did not
 * come to their end, and where the last one took nearly as much as the one before, or more. */
double co_discretization_error(const curvopt_level_report *levels, int32_t n);

#endif
