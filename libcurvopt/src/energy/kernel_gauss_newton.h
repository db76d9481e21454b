/* The integrands as sums of squares, for Gauss-Newton. Included by element_kernel.c only, as kernel_gradient.h.
 *
 * a h2 + b K is (a / 2 + b / 4) (h11 + h22)^2 + (a / 2 - b / 4) (h11 - h22)^2 + (2 a - b) h12^2. A third-order
 * integrand a |F1|^2 + b |F3|^2 + c X is, with M F3 = (P A3 + R B3, R A3 - P B3), P + i R = q^2 |q|^2 / (|q|^4 + eps^4)
 * and |M|^2 = P^2 + R^2, a |F1 + c / (2 a) M F3|^2 + (b - c^2 |M|^2 / (4 a)) |F3|^2 ; here F1 = (A1, B1), F3 = (A3,
 * B3). Each square is multiplied by J: the residual carries sqrt(J).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KERNEL_GAUSS_NEWTON_H
#define CO_ENERGY_KERNEL_GAUSS_NEWTON_H

#include "energy/kernel_gradient.h"

enum { RESIDUALS_SECOND = 3, RESIDUALS_THIRD = 4 };

/* Adjoint of residual `which` (0..2 second order, 3..6 third) at one sample: S_bar [1..9]. */
CO_SIMD_INLINE void adjoint_residual_second(lane S[CO_JET][3], const sample_state *m, const co_integrand *w, int which,
                                            lane S_bar[CO_JET][3]) {
    const double weight[3] = {0.5 * w->h2 + 0.25 * w->gauss, 2 * w->h2 - w->gauss, 0.5 * w->h2 - 0.25 * w->gauss};
    const double of_h[3][3] = {{1, 0, 1}, {0, 1, 0}, {1, 0, -1}};
    lane root = lane_sqrt(m->J), h_bar[3], value = {0};
    double factor = weight[which] > 0 ? sqrt(weight[which]) : 0; /* 0 may come out a little less */
    for (int k = 0; k < 3; k++) {
        value += of_h[which][k] * m->h[k];
        h_bar[k] = factor * of_h[which][k] * root;
    }
    adjoint_forms(S, m, 0, NULL, h_bar, 0.5 * factor * value / root, S_bar);
}

CO_SIMD_INLINE void adjoint_residual_third(lane S[CO_JET][3], const sample_state *m, const co_integrand *w, double eps4,
                                           int which, lane S_bar[CO_JET][3]) {
    const lane *h = m->h;
    lane q1 = 0.5 * (h[0] - h[2]), q2 = h[1], q_re = q1 * q1 - q2 * q2, q_im = 2 * q1 * q2;
    lane square = q1 * q1 + q2 * q2, inv = 1.0 / (square * square + eps4), sigma = square * inv;
    lane P = q_re * sigma, R = q_im * sigma, root = lane_sqrt(m->J);
    lane A1 = {0}, B1 = {0}, A3 = {0}, B3 = {0}, P_bar = {0}, R_bar = {0}, value;
    double a = sqrt(w->f1), coupling = w->x / (2 * a);
    lane rest = lane_sqrt(lane_max(w->f3 - coupling * coupling * (P * P + R * R), lane_all(0)));
    switch (which) {
    case 0:
        value = a * m->A1 + coupling * (P * m->A3 + R * m->B3);
        A1 = a * root;
        A3 = coupling * P * root;
        B3 = coupling * R * root;
        P_bar = coupling * m->A3 * root;
        R_bar = coupling * m->B3 * root;
        break;
    case 1:
        value = a * m->B1 + coupling * (R * m->A3 - P * m->B3);
        B1 = a * root;
        A3 = coupling * R * root;
        B3 = -coupling * P * root;
        P_bar = -coupling * m->B3 * root;
        R_bar = coupling * m->A3 * root;
        break;
    case 2:
        value = rest * m->A3;
        A3 = rest * root;
        break;
    default:
        value = rest * m->B3;
        B3 = rest * root;
        break;
    }
    lane C_bar[4] = {0.75 * A1 + 0.25 * A3, 0.75 * (B1 + B3), 0.75 * (A1 - A3), 0.75 * B1 - 0.25 * B3};
    lane re_bar = P_bar * sigma, im_bar = R_bar * sigma;
    lane square_bar = (P_bar * q_re + R_bar * q_im) * (eps4 - square * square) * inv * inv;
    lane q1_bar = 2 * (q1 * (re_bar + square_bar) + q2 * im_bar),
         q2_bar = 2 * (q2 * (square_bar - re_bar) + q1 * im_bar);
    lane h_bar[3] = {0.5 * q1_bar, q2_bar, -0.5 * q1_bar};
    adjoint_forms(S, m, 1, C_bar, h_bar, 0.5 * value / root, S_bar);
}

#endif
