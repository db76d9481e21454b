/* Points of a cage's surface and their derivatives, anywhere on it. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_EVALUATE_H
#define CO_SURFACE_EVALUATE_H

#include "surface/patches.h"

/* As curvopt_surface_jets; pointers and `surface` have been checked. */
int32_t co_evaluate_jets(const curvopt_mesh *mesh, const double *xyz, int32_t surface, int32_t n, const int32_t *face,
                         const int32_t *corner, const double *uv, double *jets, curvopt_error *error);

#endif
