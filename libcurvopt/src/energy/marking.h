/* Which patches get another quadrature rule: those where it brings most for its cost.
 *
 * Follows: Doerfler, "A convergent adaptive algorithm for Poisson's equation", SIAM J. Numer. Anal. 33, 1996, sec. 4.2:
 * elements are marked, those with the largest error indicators first, until the unmarked ones hold no more than a given
 * part of the whole error. Differs: elements are sorted by error per cost, not by error, for rules differ in cost by up
 * to a hundred times; errors are added up as they are, not their squares; the unmarked ones' bound is a part of the
 * tolerance, not of the error.
 *
 *     error    1   8   3   2        bound for the unmarked ones: 4
 *     cost     1   4   1   4
 *     e / c    1   2   3   .5       ascending: .5 (error 2), 1 (error 1), 2 (error 8)
 *                                   2 + 1 <= 4 < 2 + 1 + 8: the threshold is 2, and patches 1 and 2 are marked
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_MARKING_H
#define CO_ENERGY_MARKING_H

#include <stdint.h>

/* A patch whose rule could change. */
typedef struct co_marking_candidate {
    double error_per_cost;
    double error;
} co_marking_candidate;

/* The error per cost; infinite for an error that is no number. */
double co_marking_error_per_cost(double error, double cost);
/* The error per cost from which on candidates are marked: those below it have together an error of at most `unmarked`.
 * Candidates whose error per cost differs by a relative `tie` or less are treated alike. INFINITY: none is marked.
 * Sorts the candidates. */
double co_marking_threshold(co_marking_candidate *candidates, int32_t n, double unmarked, double tie);

#endif
