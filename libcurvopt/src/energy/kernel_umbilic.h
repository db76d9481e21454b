/* Where X jumps. At an umbilic q = 0, and round it X takes all values from -|F1 F3| to |F1 F3| however near: a
 * quadrature rule misses a part of |F1 F3| times the area of the cell in which the umbilic lies, with a sign that
 * depends on where it lies there. Finer rules do not tell: their errors are as random, and two may agree
 * (libcurvopt/notes/23-claimed-quadrature-error.md). Included by element_kernel.c only, as kernel_gradient.h is.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KERNEL_UMBILIC_H
#define CO_ENERGY_KERNEL_UMBILIC_H

#include "energy/kernel_gradient.h"

/* |F1 F3| times the area of a sample's cell, which is its weight; less where no umbilic lies within some side of the
 * cell:
 *
 *     weight |F1 F3| / (1 + (|q|^4 + eps^4) / (g weight)^2) / (1 + (d^2 / weight)^2)
 *
 * In the frame's complex coordinate z dq = a dz + b dz*, a = F1* / 3, b = F3*. So g = |a|^2 + |b|^2 is the mean of
 * |dq|^2 over directions, |q|^2 / g about the square of the distance to q = 0, and eps^2 / g that of the size of the
 * spot where X is smoothed. d is the length of Newton's step from q to 0: d^2 = |b q* - a* q|^2 / (|a|^2 - |b|^2)^2.
 * Where the surface bends like a cylinder whose curvature varies, q is small beside its derivative, but does not turn:
 * |a| = |b|, and d is infinite. */
CO_SIMD_INLINE lane umbilic_jump(const sample_state *m, const sample_values *v, double eps4, lane weight) {
    const lane tiny = lane_all(1e-300); /* zero over zero: of a plane, where |F1 F3| is 0 */
    const deviator d = deviator_of(m);
    const lane a = v->f1 * (1.0 / 9), cell = (a + v->f3) * weight, n = (a - v->f3) * (a - v->f3) * weight + tiny;
    const lane turned = (d.re * d.q_re + d.im * d.q_im) * (2.0 / 3); /* 2 Re(a b q*^2) */
    const lane near = (d.square * d.square + eps4) / (cell * cell + tiny);
    const lane step = ((a + v->f3) * d.square - turned) / n;
    const lane size = lane_sqrt(v->f1) * lane_sqrt(v->f3); /* their product could be too large */
    return weight * size / ((1.0 + near) * (1.0 + step * step));
}

#endif
