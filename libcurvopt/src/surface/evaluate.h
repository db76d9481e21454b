/* Points of a cage's surface and their derivatives, anywhere on it. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_EVALUATE_H
#define CO_SURFACE_EVALUATE_H

#include "surface/patches.h"

/* Implements curvopt_surface_jets, which describes arguments and errors; pointers and `surface` have been checked.
 * Makes the patches anew at each call: linear in the cage, then a search among a face's patches for each point. */
int32_t co_evaluate_jets(const curvopt_mesh *mesh, const double *xyz, int32_t surface, int32_t n, const int32_t *face,
                         const int32_t *corner, const double *uv, double *jets, curvopt_error *error);

#endif
