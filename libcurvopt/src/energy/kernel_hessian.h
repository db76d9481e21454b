/* The core of a Hessian: the 27 x 27 second derivatives at a sample (15 x 15 without third order) with respect to the
 * derivatives of S. Included by element_kernel.c only, as kernel_gradient.h is.
 *
 * It is had from central differences of the exact gradient, for a tenth of the work of differencing the whole
 * gradient, and with none of its dependence on the mesh. The step is relative to |S_u|, |S_v|.
 *
 * C = grad h is a small difference of large numbers, and the gradient is a multiple of it. In the difference quotients
 * C is therefore replaced by its linearization, which a central difference cannot tell from C itself. The rounding
 * errors of C, divided by the step, would leave nine digits of the matrix; its eigenvalues span thirteen orders of
 * magnitude, and the least of them would be lost. With the linearization the step can be so short that those are right
 * to a tenth (libcurvopt/notes/41-difference-step-of-the-hessian.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KERNEL_HESSIAN_H
#define CO_ENERGY_KERNEL_HESSIAN_H

#include "energy/kernel_gradient.h"

/* C = grad h at one sample, by its coefficients A1, B1, A3, B3. */
typedef struct curvature_derivative {
    sample_state at;
    lane value[4];
    lane slope[4][CO_JET][3]; /* [.][1..9] with respect to derivatives of S */
} curvature_derivative;

CO_SIMD_INLINE void differentiate_curvature(lane S[CO_JET][3], curvature_derivative *out) {
    static const double of_C[4][4] = {{0.75, 0, 0.75, 0}, {0, 0.75, 0, 0.75}, {0.25, 0, -0.75, 0}, {0, 0.75, 0, -0.25}};
    sample_state *m = &out->at;
    sample_values value;
    forward_second(S, m, &value);
    forward_third(S, m);
    out->value[0] = m->A1;
    out->value[1] = m->B1;
    out->value[2] = m->A3;
    out->value[3] = m->B3;
    for (int i = 0; i < 4; i++) {
        lane C_bar[4], h_bar[3];
        for (int k = 0; k < 4; k++)
            C_bar[k] = lane_all(of_C[i][k]);
        for (int k = 0; k < 3; k++)
            h_bar[k] = lane_all(0);
        adjoint_forms(S, m, 1, C_bar, h_bar, lane_all(0), out->slope[i]);
    }
}

/* The integrand at one sample. */
typedef struct sample_integrand {
    const co_integrand *integrand;
    double eps4;        /* functional.h's regularization: eps to the fourth */
    double weight;      /* quadrature weight of the curvature integrals */
    double area_weight; /* quadrature weight of the area */
} sample_integrand;

/* S_bar [1..9] at one sample, everything included. The coefficients A1, B1, A3, B3 are taken from C. */
CO_SIMD_INLINE void sample_gradient(const sample_integrand *s, int third, const lane C[4], lane S[CO_JET][3],
                                    lane S_bar[CO_JET][3]) {
    const co_integrand *w = s->integrand;
    sample_state state;
    sample_values value;
    forward_second(S, &state, &value);
    lane density = w->h2 * value.h2 + w->gauss * value.gauss;
    if (third) {
        forward_third(S, &state);
        state.A1 = C[0];
        state.B1 = C[1];
        state.A3 = C[2];
        state.B3 = C[3];
        forward_invariants(&state, s->eps4, &value);
        density += w->f1 * value.f1 + w->f3 * value.f3 + w->x * value.x;
    }
    adjoint_sample(S, &state, w, s->eps4, third, s->weight, w->area * s->area_weight, density, S_bar);
}

/* A sample's second derivatives: core[d][k][j][c] = d^2 f / (d S_k,d  d S_j,c), for k, j = 1..9 (u, v, uu, uv, vv, uuu,
 * uuv, uvv, vvv) and coordinates c, d. Columns k = 1..5 are differences (core_column), columns k = 6..9 are analytic
 * (core_of_third), and one quarter is copied from the other half, so the order of calls matters:
 *
 *                 k = 1..5               k = 6..9
 *     j = 1..5   core_column            copied: core[d][k][j][c] = core[c][j][k][d]
 *     j = 6..9   core_column            core_of_third */
typedef lane sample_core[3][CO_JET][CO_JET][3];

/* The derivative of S that a difference is taken along: coordinate d of S_k, plus and minus `step`. */
typedef struct difference {
    int k, d;
    lane step;
} difference;

/* Difference of the gradients at S +- step along one derivative, C going with them to first order. */
CO_SIMD_INLINE void core_column(const sample_integrand *s, int third, const difference *along,
                                const curvature_derivative *C, lane S[CO_JET][3], lane column[CO_JET][3]) {
    const int last = third ? 9 : 5, k = along->k, d = along->d;
    const lane step = along->step;
    lane at = S[k][d], half = 0.5 / step, C_up[4], C_down[4], down[CO_JET][3];
    for (int i = 0; third && i < 4; i++) {
        C_up[i] = C->value[i] + step * C->slope[i][k][d];
        C_down[i] = C->value[i] - step * C->slope[i][k][d];
    }
    S[k][d] = at + step;
    sample_gradient(s, third, C_up, S, column);
    S[k][d] = at - step;
    sample_gradient(s, third, C_down, S, down);
    S[k][d] = at;
    for (int j = 1; j <= last; j++)
        for (int c = 0; c < 3; c++)
            column[j][c] = (column[j][c] - down[j][c]) * half;
}

/* Columns of third derivatives, after all calls of core_column: of third derivatives themselves the energy is a square,
 * through C; the other entries are the transpose of what core_column found. */
CO_SIMD_INLINE void core_of_third(const sample_integrand *s, const curvature_derivative *C, sample_core core) {
    const lane *n = C->at.n;
    for (int k = 0; k < 4; k++) {
        sample_state m = C->at;
        frame_adjoint f = {{0}, {0}, {0}};
        lane C_bar[4], T_bar[4], h_bar[3] = {{0}, {0}, {0}}, along[4];
        for (int i = 0; i < 4; i++)
            along[i] = lane_dot(C->slope[i][6 + k], n);
        m.A1 = along[0];
        m.B1 = along[1];
        m.A3 = along[2];
        m.B3 = along[3];
        adjoint_invariants(&m, s->integrand, s->eps4, s->weight * m.J, C_bar, h_bar);
        from_frame_third(&m, m.T, C_bar, T_bar, &f);
        for (int d = 0; d < 3; d++)
            for (int c = 0; c < 3; c++) {
                for (int j = 1; j < 6; j++)
                    core[d][6 + k][j][c] = core[c][j][6 + k][d];
                for (int l = 0; l < 4; l++)
                    core[d][6 + k][6 + l][c] = T_bar[l] * n[c] * n[d];
            }
    }
}

#endif
