/* The core of a Hessian: 27 x 27 second derivatives at a sample (15 x 15 without third order) with respect to the
 * derivatives of S. Included by sweep.c only, as kernel_gradient.h.
 *
 * It is had from central differences of the exact gradient, for a tenth of the work of differencing the whole
 * gradient, and with none of its dependence on the mesh. The step is relative to |S_u|, |S_v|. C = grad h is a small
 * difference of large numbers, of which the gradient is a multiple; so in the differences it is not computed again,
 * but is what it is to first order, and more of it central differences do not see. Its rounding, divided by the step,
 * would leave nine digits of the whole, and of a matrix whose eigenvalues go over thirteen orders that is more than
 * the least ones. As it is, the step can be so short that those are right to a tenth (tests/bench, "Digits").
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KERNEL_HESSIAN_H
#define CO_ENERGY_KERNEL_HESSIAN_H

#include "energy/element_kernel.h"
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

/* S_bar [1..9] at one sample, everything included. C: A1, B1, A3, B3 are taken for these. */
CO_SIMD_INLINE void sample_gradient(const co_element_hessian *s, int32_t sample, int third, const lane C[4],
                                    lane S[CO_JET][3], lane S_bar[CO_JET][3]) {
    const co_basis_table *t = s->table;
    sample_state state;
    sample_values value;
    forward_second(S, &state, &value);
    lane density = s->integrand.h2 * value.h2 + s->integrand.gauss * value.gauss;
    if (third) {
        forward_third(S, &state);
        state.A1 = C[0];
        state.B1 = C[1];
        state.A3 = C[2];
        state.B3 = C[3];
        forward_invariants(&state, s->eps4, &value);
        density += s->integrand.f1 * value.f1 + s->integrand.f3 * value.f3 + s->integrand.x * value.x;
    }
    adjoint_sample(S, &state, &s->integrand, s->eps4, third, t->weight[sample],
                   s->integrand.area * t->area_weight[sample], density, S_bar);
}

/* A sample's second derivatives: [d][k] is what component d of the k-th derivative of S does to a gradient. */
typedef lane sample_core[3][CO_JET][CO_JET][3];

/* Difference of the gradients at S +- step along derivative (k, d), C going with them to first order. */
CO_SIMD_INLINE void core_column(const co_element_hessian *s, int32_t sample, int third, lane step, int k, int d,
                                const curvature_derivative *C, lane S[CO_JET][3], lane column[CO_JET][3]) {
    const int last = third ? 9 : 5;
    lane at = S[k][d], half = 0.5 / step, C_up[4], C_down[4], down[CO_JET][3];
    for (int i = 0; third && i < 4; i++) {
        C_up[i] = C->value[i] + step * C->slope[i][k][d];
        C_down[i] = C->value[i] - step * C->slope[i][k][d];
    }
    S[k][d] = at + step;
    sample_gradient(s, sample, third, C_up, S, column);
    S[k][d] = at - step;
    sample_gradient(s, sample, third, C_down, S, down);
    S[k][d] = at;
    for (int j = 1; j <= last; j++)
        for (int c = 0; c < 3; c++)
            column[j][c] = (column[j][c] - down[j][c]) * half;
}

/* Columns of third derivatives: of these themselves the energy is a square, through C; the rest is there already, by
 * symmetry. */
CO_SIMD_INLINE void core_of_third(const co_element_hessian *s, int32_t sample, const curvature_derivative *C,
                                  sample_core core) {
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
        adjoint_invariants(&m, &s->integrand, s->eps4, s->table->weight[sample] * m.J, C_bar, h_bar);
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
