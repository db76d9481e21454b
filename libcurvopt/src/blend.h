/* Blending weights near extraordinary vertices. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BLEND_H
#define CO_BLEND_H

#include "bspline.h"

/* Jet of w(u) w(v): 1 at the extraordinary vertex (0,0), 0 on the two far edges, all derivatives 0 at both ends.
 * With h(t) = exp(2 exp(-1/t) / (t - 1)), w(t) = h(t) / (h(t) + h(1 - t)): Ying, Zorin, "A simple manifold-based
 * construction of surfaces of arbitrary smoothness", SIGGRAPH 2004; the report's eq. 1, whose printed form has lost the
 * 1 - t in its denominator. */
void co_blend_weight(co_real u, co_real v, co_real jet[CO_JET]);

#endif
