/* Spontaneous curvature (Helfrich, "Elastic properties of lipid bilayers", 1973): with c0 the bending energy int H^2 dA
 * becomes int (H - c0 / 2)^2 dA. The difference is a function of two numbers of the whole surface,
 *
 *     -c0 M + c0^2 A / 4,    M = int H dA,
 *
 * in which c0 is over the unit of the cage. It is what is added to an objective, times 4 for WILLMORE.
 *
 * A surface of which nothing is held gets a size in the end: one of its numbers gets a value (held_scalars.h). Lengths
 * are measured by that number then, and what is added does not depend on the size of the positions that are integrated
 * over; so that scaling stays a motion that the objective does not see.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_SPONTANEOUS_CURVATURE_H
#define CO_ENERGY_SPONTANEOUS_CURVATURE_H

#include "energy/held_numbers.h"

typedef struct co_spontaneous_curvature {
    double curvature;   /* c0, over the unit of the cage; 0: there is none, and the rest is not read */
    double weight;      /* of int H^2 dA in the objective */
    int measure;        /* curvopt_scalar that has a value at last; -1: none, lengths are what they are */
    double length;      /* without a measure the unit of positions, in those of the cage; else the length whose power is
                           the value */
    double orientation; /* as of co_held_numbers; 0: by the sign of the volume */
    double area;        /* area that the reference goes by, in units of the cage; 0: that of the surface itself */
} co_spontaneous_curvature;

/* What is added at one surface. */
typedef struct co_spontaneous_part {
    co_held_residual added; /* its value, and derivatives by the numbers of the surface as integrals give them */
    double reference;       /* With this on top it is well above 0 and of the size of its parts, as relative figures
                               need it: with m c0^2 A instead of c0^2 A the energy is at least (2 - 4 / m) int H^2 dA by
                               Cauchy's inequality; m = 3 */
} co_spontaneous_part;

/* Of these weights (curvopt_term), lengths as they are. */
co_spontaneous_curvature co_spontaneous_curvature_of(const double weights[CURVOPT_N_TERMS], double curvature);
/* Whether a weight is of an energy that has it. */
int co_spontaneous_curvature_is_seen(const double weights[CURVOPT_N_TERMS]);
/* The reference of a surface with this area, in units of the cage. */
double co_spontaneous_curvature_reference(const co_spontaneous_curvature *spontaneous, double area);
/* integral: of positions that were divided by `radius` first. All is 0 without spontaneous curvature. */
co_spontaneous_part co_spontaneous_curvature_add(const co_spontaneous_curvature *spontaneous, double radius,
                                                 const double integral[CO_N_INTEGRALS]);
/* Adds the integrands whose gradient is that of what is added, at a surface with these integrals. Returns how much that
 * changes when the surface is scaled, per part of its size. */
double co_spontaneous_curvature_add_integrands(const co_spontaneous_curvature *spontaneous, double radius,
                                               const double integral[CO_N_INTEGRALS], co_integrand *integrand);

#endif
