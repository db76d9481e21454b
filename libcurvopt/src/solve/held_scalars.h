/* What a run holds of the whole surface: options.scalar_rule. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_HELD_SCALARS_H
#define CO_SOLVE_HELD_SCALARS_H

#include "energy/assembly_sums.h"
#include "solve/run_context.h"

/* The constraints and the size from the numbers of the input, whose values `start` are by its own radius; `is_framed`:
 * whether something of the cage is held. The assembly is the input's. ERROR_ARGUMENT, `element` the curvopt_scalar:
 * what cannot be held, or contradicts itself. */
int32_t co_held_scalars_create(const curvopt_options *options, const co_assembly *assembly, const co_values *start,
                               int is_framed, co_held_numbers *held, co_run_size *size, curvopt_error *error);
/* Spontaneous curvature as levels see it: with the same `held`, `size` and `is_framed`, by positions in units of
 * `radius` where something is held. area: of the input. */
co_spontaneous_curvature co_held_scalars_spontaneous(const curvopt_options *options, const co_held_numbers *held,
                                                     const co_run_size *size, int is_framed, double radius,
                                                     double area);
/* How much the least objective rises for each unit by which the size of a result does, whose numbers in the user's
 * units these are; `multiplier`: of each constraint (co_newton_held). Nothing of the cage is held. */
double co_held_scalars_multiplier_of_size(const co_run_context *run, const co_held_numbers *held,
                                          const double multiplier[CURVOPT_N_SCALARS], double area, double mean);
/* The surface whose `measure` is `number` has the size when it is enlarged so many times. */
double co_run_size_unit(const co_run_size *size, double number);
/* The measure of a surface with these numbers. */
double co_run_size_number(const co_run_size *size, double area, double volume, double mean);

#endif
