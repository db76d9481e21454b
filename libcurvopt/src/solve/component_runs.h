/* A run over a cage of several components, each of which is minimized as if it were alone.
 *
 * Energies say neither where components are nor how large they are beside each other, and third-order terms are
 * products of sums over all of them: in one minimization components that nothing holds drift and shrink. So each has a
 * run of its own, with its own frame, size, symmetries, steps and verdict; level by level, so that all of the surface
 * gets better while the caller looks on. Components that are images of others by a symmetry of the whole are copies.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_COMPONENT_RUNS_H
#define CO_SOLVE_COMPONENT_RUNS_H

#include "solve/run.h"

/* Minimizes the cage at xyz [3 n_vertices] of which `whole` has been started, if it has several components; else
 * *has_run is 0, and nothing is done. The result goes into whole->at.xyz and whole->result. As curvopt_minimize. */
int32_t co_component_runs_minimize(co_run *whole, const double *xyz, int *has_run, curvopt_error *error);

#endif
