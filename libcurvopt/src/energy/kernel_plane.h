/* The surface `plane` of Joshi and Sequin's report, one face in each lane: derivatives of S -> derivatives of S', and
 * the adjoint of this. Included by element_kernel.c only, once per instruction set.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KERNEL_PLANE_H
#define CO_ENERGY_KERNEL_PLANE_H

#include "base/simd.h"
#include "surface/basis_table.h"

#include <string.h>

/* The report's surface: S' = S - w ((S - V).n_V) n_V with limit position V and normal n_V. */
typedef struct plane_state {
    lane V[3], n[3], tangent[2][3], inv_length;
    lane V_bar[3], n_bar[3];
    lane phi[CO_JET], psi[CO_JET]; /* jets of (S - V).n and of w times it */
} plane_state;

CO_SIMD_INLINE void plane_begin(const co_basis_table *t, lane (*P)[3], plane_state *m) {
    lane sums[3][3], normal[3];
    memset(sums, 0, sizeof sums);
    for (int i = 0; i < 3; i++)
        for (int32_t p = 0; p < t->n_points; p++)
            lane_add_scaled(sums[i], lane_all(t->masks[i * t->n_points + p]), P[p]);
    memcpy(m->V, sums[0], sizeof m->V);
    memcpy(m->tangent, sums[1], sizeof m->tangent);
    memset(m->V_bar, 0, sizeof m->V_bar);
    memset(m->n_bar, 0, sizeof m->n_bar);
    lane_cross(m->tangent[0], m->tangent[1], normal);
    m->inv_length = 1.0 / lane_sqrt(lane_dot(normal, normal));
    for (int c = 0; c < 3; c++)
        m->n[c] = normal[c] * m->inv_length;
}

/* Adjoint of V and n_V back to the points. */
CO_SIMD_INLINE void plane_end(const co_basis_table *t, const plane_state *m, lane (*G)[3]) {
    lane normal_bar[3], bar[3][3];
    lane along = lane_dot(m->n_bar, m->n);
    for (int c = 0; c < 3; c++) {
        normal_bar[c] = (m->n_bar[c] - along * m->n[c]) * m->inv_length;
        bar[0][c] = m->V_bar[c];
    }
    lane_cross(m->tangent[1], normal_bar, bar[1]);
    lane_cross(normal_bar, m->tangent[0], bar[2]);
    for (int i = 0; i < 3; i++)
        for (int32_t p = 0; p < t->n_points; p++)
            lane_add_scaled(G[p], lane_all(t->masks[i * t->n_points + p]), bar[i]);
}

/* Binomials of Leibniz' rule. */
static const int binomial[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};

/* psi = w phi; or, transposed, phi from psi. */
CO_SIMD_INLINE void leibniz(const double w[CO_JET], int transposed, const lane in[CO_JET], lane out[CO_JET]) {
    for (int k = 0; k < CO_JET; k++)
        out[k] = lane_all(0);
    for (int k = 0; k < CO_JET; k++)
        for (int i = 0; i <= co_jet_order_u[k]; i++)
            for (int j = 0; j <= co_jet_order_v[k]; j++) {
                int from = co_jet_index(i, j), with = co_jet_index(co_jet_order_u[k] - i, co_jet_order_v[k] - j);
                double factor = binomial[co_jet_order_u[k]][i] * binomial[co_jet_order_v[k]][j] * w[with];
                if (transposed)
                    out[from] += factor * in[k];
                else
                    out[k] += factor * in[from];
            }
}

/* S -> S' in place. */
CO_SIMD_INLINE void plane_forward(plane_state *m, const double w[CO_JET], lane S[CO_JET][3]) {
    for (int k = 0; k < CO_JET; k++)
        m->phi[k] = lane_dot(S[k], m->n);
    m->phi[0] -= lane_dot(m->V, m->n);
    leibniz(w, 0, m->phi, m->psi);
    for (int k = 0; k < CO_JET; k++)
        lane_add_scaled(S[k], -m->psi[k], m->n);
}

/* S'_bar -> S_bar in place; S is S'. */
CO_SIMD_INLINE void plane_adjoint(plane_state *m, const double w[CO_JET], lane S[CO_JET][3], lane S_bar[CO_JET][3]) {
    lane psi_bar[CO_JET], phi_bar[CO_JET];
    for (int k = 0; k < CO_JET; k++) {
        psi_bar[k] = -lane_dot(S_bar[k], m->n);
        lane_add_scaled(m->n_bar, -m->psi[k], S_bar[k]);
    }
    leibniz(w, 1, psi_bar, phi_bar);
    for (int k = 0; k < CO_JET; k++) {
        lane original[3];
        for (int c = 0; c < 3; c++) {
            original[c] = S[k][c] + m->psi[k] * m->n[c] - (k == 0 ? m->V[c] : lane_all(0));
            S_bar[k][c] += phi_bar[k] * m->n[c];
        }
        lane_add_scaled(m->n_bar, phi_bar[k], original);
    }
    for (int c = 0; c < 3; c++)
        m->V_bar[c] -= phi_bar[0] * m->n[c];
}

#endif
