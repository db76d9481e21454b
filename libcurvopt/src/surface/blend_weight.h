/* Blending weights near extraordinary vertices. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BLEND_WEIGHT_H
#define CO_SURFACE_BLEND_WEIGHT_H

#include "surface/bspline.h"

/* Blending functions w(t) of one variable. Both fall from 1 at t = 0 to 0 at t = 1, flat at both ends, w(t) + w(1 - t)
 * = 1. */
typedef enum co_blend_kind {
    /* With h(t) = exp(2 exp(-1/t) / (t - 1)), w(t) = h(t) / (h(t) + h(1 - t)), all derivatives 0 at the ends: Ying,
     * Zorin, "A simple manifold-based construction of surfaces of arbitrary smoothness", SIGGRAPH 2004; the report's
     * eq. 1, whose printed form has lost the 1 - t in its denominator. */
    CO_BLEND_SMOOTH,
    /* The polynomial of least degree with three derivatives 0 at the ends, 1 - t^4 (35 - 84 t + 70 t^2 - 20 t^3): all
     * that third-order energies need, and several times less variation for them to pick up. */
    CO_BLEND_POLYNOMIAL
} co_blend_kind;

/* Jet of w(u) w(v): 1 at the extraordinary vertex (0,0), 0 on the two far edges. */
void co_blend_weight(co_blend_kind blend, double u, double v, double jet[CO_JET]);

#endif
