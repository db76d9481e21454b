/* One sample of a surface in each lane: derivatives -> fundamental forms, C = grad h, invariants; and the adjoint of
 * all this, by hand. Included by element_kernel.c only, once per instruction set.
 *
 * The frame is e1 = S_u / |S_u|, e2 = n x e1. With alpha = |S_u|, J = |S_u x S_v| and tau = S_u.S_v / alpha^2, a
 * second-order array X (uu, uv, vv) has the frame components s^2 X_uu,   s t (X_uv - tau X_uu),   t^2 (X_vv - 2 tau
 * X_uv + tau^2 X_uu),    s = 1 / alpha, t = alpha / J, and so on for third order. In a parametrization that is
 * orthonormal at the point, C_ijk = S_ijk.n - sum over the three choices of k of h_kl S_ij.e_l .
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KERNEL_GRADIENT_H
#define CO_ENERGY_KERNEL_GRADIENT_H

#include "base/simd.h"
#include "energy/functional.h"
#include "surface/bspline.h"

/* Results of the forward pass that the adjoint needs. */
typedef struct sample_state {
    lane n[3], J, inv_E, s, t, tau;
    lane L[3];               /* S_ij.n */
    lane h[3];               /* h11 h12 h22 in the frame */
    lane ga[3], gb[3];       /* S_ij.S_u, S_ij.S_v */
    lane p_raw[3], q_raw[3]; /* S_ij.e1, S_ij.e2 */
    lane p[3], q[3];         /* p_raw, q_raw in the frame */
    lane T[4];               /* S_ijk.n */
    lane A1, B1, A3, B3;     /* Fourier coefficients of the derivative of normal curvature */
} sample_state;

typedef struct sample_values {
    lane h2, gauss, f1, f3, x, mean;
} sample_values;

CO_SIMD_INLINE void to_frame_second(const sample_state *m, const lane X[3], lane out[3]) {
    lane u1 = -m->tau * X[0] + X[1], u2 = -m->tau * (X[1] + u1) + X[2];
    out[0] = m->s * m->s * X[0];
    out[1] = m->s * m->t * u1;
    out[2] = m->t * m->t * u2;
}

CO_SIMD_INLINE void to_frame_third(const sample_state *m, const lane Y[4], lane out[4]) {
    lane tau = m->tau, s = m->s, t = m->t;
    lane v1 = -tau * Y[0] + Y[1], v2 = -tau * (Y[1] + v1) + Y[2];
    lane v3 = -tau * (-tau * (2 * Y[1] + v1) + 3 * Y[2]) + Y[3];
    out[0] = s * s * s * Y[0];
    out[1] = s * s * t * v1;
    out[2] = s * t * t * v2;
    out[3] = t * t * t * v3;
}

/* First fundamental form, normal, second fundamental form. */
CO_SIMD_INLINE void forward_second(lane S[CO_JET][3], sample_state *m, sample_values *out) {
    lane normal[3], E = lane_dot(S[1], S[1]);
    lane_cross(S[1], S[2], normal);
    m->J = lane_sqrt(lane_dot(normal, normal));
    lane inv_J = 1.0 / m->J, alpha = lane_sqrt(E);
    m->inv_E = 1.0 / E;
    m->s = alpha * m->inv_E;
    m->t = alpha * inv_J;
    m->tau = lane_dot(S[1], S[2]) * m->inv_E;
    for (int c = 0; c < 3; c++)
        m->n[c] = normal[c] * inv_J;
    for (int k = 0; k < 3; k++)
        m->L[k] = lane_dot(S[3 + k], m->n);
    to_frame_second(m, m->L, m->h);
    out->h2 = m->h[0] * m->h[0] + (2 * m->h[1] * m->h[1] + m->h[2] * m->h[2]);
    out->gauss = m->h[0] * m->h[2] - m->h[1] * m->h[1];
    out->mean = -0.5 * (m->h[0] + m->h[2]);
}

/* C = grad h: its Fourier coefficients. After forward_second. */
CO_SIMD_INLINE void forward_third(lane S[CO_JET][3], sample_state *m) {
    lane T[4];
    const lane *h = m->h, *p = m->p, *q = m->q;
    for (int k = 0; k < 3; k++) {
        m->ga[k] = lane_dot(S[3 + k], S[1]);
        m->gb[k] = lane_dot(S[3 + k], S[2]);
        m->p_raw[k] = m->s * m->ga[k];
        m->q_raw[k] = m->t * (-m->tau * m->ga[k] + m->gb[k]);
    }
    to_frame_second(m, m->p_raw, m->p);
    to_frame_second(m, m->q_raw, m->q);
    for (int k = 0; k < 4; k++)
        m->T[k] = lane_dot(S[6 + k], m->n);
    to_frame_third(m, m->T, T);
    const lane minus_2 = lane_all(-2), minus_3 = lane_all(-3);
    lane C111 = minus_3 * (h[0] * p[0] + h[1] * q[0]) + T[0];
    lane C112 = minus_2 * (h[0] * p[1] + h[1] * q[1]) + (T[1] - (h[1] * p[0] + h[2] * q[0]));
    lane C122 = minus_2 * (h[1] * p[1] + h[2] * q[1]) + (T[2] - (h[0] * p[2] + h[1] * q[2]));
    lane C222 = minus_3 * (h[1] * p[2] + h[2] * q[2]) + T[3];
    m->A1 = 0.75 * (C111 + C122);
    m->B1 = 0.75 * (C112 + C222);
    m->A3 = 0.25 * C111 - 0.75 * C122;
    m->B3 = 0.75 * C112 - 0.25 * C222;
}

/* Of the second fundamental form without its trace, q = q1 + i q2: q^2 and |q|^2; and F1 F3, in the same complex
 * numbers. */
typedef struct deviator {
    lane q1, q2, q_re, q_im, square, re, im;
} deviator;

CO_SIMD_INLINE deviator deviator_of(const sample_state *m) {
    deviator d;
    d.q1 = 0.5 * (m->h[0] - m->h[2]);
    d.q2 = m->h[1];
    d.q_re = d.q1 * d.q1 - d.q2 * d.q2;
    d.q_im = 2 * d.q1 * d.q2;
    d.square = d.q1 * d.q1 + d.q2 * d.q2;
    d.re = m->A1 * m->A3 - m->B1 * m->B3;
    d.im = m->A1 * m->B3 + m->B1 * m->A3;
    return d;
}

/* |F1|^2, |F3|^2 and X from C and the second fundamental form. */
CO_SIMD_INLINE void forward_invariants(const sample_state *m, double eps4, sample_values *out) {
    const deviator d = deviator_of(m);
    const lane square = d.square;
    out->f1 = m->A1 * m->A1 + m->B1 * m->B1;
    out->f3 = m->A3 * m->A3 + m->B3 * m->B3;
    out->x = (d.re * d.q_re + d.im * d.q_im) * square / (square * square + eps4);
}

/* Adjoint of the frame's s, t, tau, gathered from all arrays that were brought into the frame. */
typedef struct frame_adjoint {
    lane s, t, tau;
} frame_adjoint;

CO_SIMD_INLINE void from_frame_second(const sample_state *m, const lane X[3], const lane bar[3], lane X_bar[3],
                                      frame_adjoint *f) {
    lane s = m->s, t = m->t, tau = m->tau, u1 = -tau * X[0] + X[1], u2 = -tau * (X[1] + u1) + X[2];
    lane b1 = s * t * bar[1], b2 = t * t * bar[2];
    X_bar[0] = -tau * (-tau * b2 + b1) + s * s * bar[0];
    X_bar[1] = -2 * tau * b2 + b1;
    X_bar[2] = b2;
    f->s += 2 * s * X[0] * bar[0] + t * u1 * bar[1];
    f->t += s * u1 * bar[1] + 2 * t * u2 * bar[2];
    f->tau -= X[0] * b1 + 2 * u1 * b2;
}

CO_SIMD_INLINE void from_frame_third(const sample_state *m, const lane Y[4], const lane bar[4], lane Y_bar[4],
                                     frame_adjoint *f) {
    lane s = m->s, t = m->t, tau = m->tau;
    lane v1 = -tau * Y[0] + Y[1], v2 = -tau * (Y[1] + v1) + Y[2];
    lane v3 = -tau * (-tau * (2 * Y[1] + v1) + 3 * Y[2]) + Y[3];
    lane b1 = s * s * t * bar[1], b2 = s * t * t * bar[2], b3 = t * t * t * bar[3];
    Y_bar[0] = -tau * (-tau * (-tau * b3 + b2) + b1) + s * s * s * bar[0];
    Y_bar[1] = -tau * (-3 * tau * b3 + 2 * b2) + b1;
    Y_bar[2] = -3 * tau * b3 + b2;
    Y_bar[3] = b3;
    f->s += 3 * s * s * Y[0] * bar[0] + (2 * s * t * v1 * bar[1] + t * t * v2 * bar[2]);
    f->t += s * s * v1 * bar[1] + (2 * s * t * v2 * bar[2] + 3 * t * t * v3 * bar[3]);
    f->tau -= Y[0] * b1 + (2 * v1 * b2 + 3 * v2 * b3);
}

/* Adjoint of the invariants with respect to C (C_bar) and the second fundamental form (added to h_bar). */
CO_SIMD_INLINE void adjoint_invariants(const sample_state *m, const co_integrand *w, double eps4, lane seed,
                                       lane C_bar[4], lane h_bar[3]) {
    const deviator d = deviator_of(m);
    const lane square = d.square, inv = 1.0 / (square * square + eps4), x_weight = w->x * seed;
    const lane x_seed = x_weight * inv * square, re_bar = d.q_re * x_seed, im_bar = d.q_im * x_seed;
    const lane f1_seed = 2 * w->f1 * seed, f3_seed = 2 * w->f3 * seed;
    lane A1 = f1_seed * m->A1 + (re_bar * m->A3 + im_bar * m->B3);
    lane B1 = f1_seed * m->B1 + (im_bar * m->A3 - re_bar * m->B3);
    lane A3 = f3_seed * m->A3 + (re_bar * m->A1 + im_bar * m->B1);
    lane B3 = f3_seed * m->B3 + (im_bar * m->A1 - re_bar * m->B1);
    C_bar[0] = 0.75 * A1 + 0.25 * A3;
    C_bar[1] = 0.75 * (B1 + B3);
    C_bar[2] = 0.75 * (A1 - A3);
    C_bar[3] = 0.75 * B1 - 0.25 * B3;
    lane square_bar = x_weight * (d.re * d.q_re + d.im * d.q_im) * (eps4 - square * square) * inv * inv;
    const lane re_seed = d.re * x_seed, im_seed = d.im * x_seed;
    lane q1_bar = 2 * (d.q1 * (re_seed + square_bar) + d.q2 * im_seed);
    lane q2_bar = 2 * (d.q2 * (square_bar - re_seed) + d.q1 * im_seed);
    h_bar[0] += 0.5 * q1_bar;
    h_bar[1] += q2_bar;
    h_bar[2] -= 0.5 * q1_bar;
}

/* Adjoint of C = T - h * Gamma. */
CO_SIMD_INLINE void adjoint_codazzi(const sample_state *m, const lane C[4], lane h_bar[3], lane p_bar[3],
                                    lane q_bar[3]) {
    const lane *h = m->h, *p = m->p, *q = m->q;
    const lane C0 = 3 * C[0], C3 = 3 * C[3], D1 = 2 * C[1], D2 = 2 * C[2];
    h_bar[0] -= C0 * p[0] + (D1 * p[1] + C[2] * p[2]);
    h_bar[1] -= (C0 * q[0] + (C[1] * p[0] + D1 * q[1])) + (C3 * p[2] + (C[2] * q[2] + D2 * p[1]));
    h_bar[2] -= C3 * q[2] + (C[1] * q[0] + D2 * q[1]);
    p_bar[0] = -(C0 * h[0] + C[1] * h[1]);
    p_bar[1] = -(D1 * h[0] + D2 * h[1]);
    p_bar[2] = -(C[2] * h[0] + C3 * h[1]);
    q_bar[0] = -(C0 * h[1] + C[1] * h[2]);
    q_bar[1] = -(D1 * h[1] + D2 * h[2]);
    q_bar[2] = -(C[2] * h[1] + C3 * h[2]);
}

/* S_bar [1..9] from the adjoints of C, of the second fundamental form and of J; third order only if asked. */
CO_SIMD_INLINE void adjoint_forms(lane S[CO_JET][3], const sample_state *m, int third, const lane C_bar[4],
                                  lane h_bar[3], lane J_bar, lane S_bar[CO_JET][3]) {
    lane L_bar[3], n_bar[3] = {{0}, {0}, {0}}, E_bar, F_bar;
    frame_adjoint f = {{0}, {0}, {0}};
    for (int k = 1; k < CO_JET; k++)
        for (int c = 0; c < 3; c++)
            S_bar[k][c] = lane_all(0);
    if (third) {
        lane T_bar[4], p_bar[3], q_bar[3], p_raw_bar[3], q_raw_bar[3];
        adjoint_codazzi(m, C_bar, h_bar, p_bar, q_bar);
        from_frame_third(m, m->T, C_bar, T_bar, &f);
        from_frame_second(m, m->p_raw, p_bar, p_raw_bar, &f);
        from_frame_second(m, m->q_raw, q_bar, q_raw_bar, &f);
        for (int k = 0; k < 4; k++) {
            lane_add_scaled(n_bar, T_bar[k], S[6 + k]);
            lane_add_scaled(S_bar[6 + k], T_bar[k], m->n);
        }
        for (int k = 0; k < 3; k++) {
            lane tq = m->t * q_raw_bar[k], ga_bar = -m->tau * tq + m->s * p_raw_bar[k];
            f.s += m->ga[k] * p_raw_bar[k];
            f.t += (m->gb[k] - m->tau * m->ga[k]) * q_raw_bar[k];
            f.tau -= m->ga[k] * tq;
            lane_add_scaled(S_bar[3 + k], ga_bar, S[1]);
            lane_add_scaled(S_bar[3 + k], tq, S[2]);
            lane_add_scaled(S_bar[1], ga_bar, S[3 + k]);
            lane_add_scaled(S_bar[2], tq, S[3 + k]);
        }
    }
    from_frame_second(m, m->L, h_bar, L_bar, &f);
    for (int k = 0; k < 3; k++) {
        lane_add_scaled(n_bar, L_bar[k], S[3 + k]);
        lane_add_scaled(S_bar[3 + k], L_bar[k], m->n);
    }
    lane inv_J = 1.0 / m->J;
    F_bar = f.tau * m->inv_E;
    E_bar = 0.5 * m->s * (f.t * inv_J - f.s * m->inv_E) - m->tau * F_bar;
    J_bar -= (m->t * inv_J) * f.t;
    lane along = -lane_dot(n_bar, m->n) * inv_J + J_bar, normal_bar[3], turned[3];
    for (int c = 0; c < 3; c++)
        normal_bar[c] = n_bar[c] * inv_J + along * m->n[c];
    lane_cross(S[2], normal_bar, turned);
    for (int c = 0; c < 3; c++)
        S_bar[1][c] = 2 * E_bar * S[1][c] + (F_bar * S[2][c] + (S_bar[1][c] + turned[c]));
    lane_cross(normal_bar, S[1], turned);
    for (int c = 0; c < 3; c++)
        S_bar[2][c] = F_bar * S[1][c] + (S_bar[2][c] + turned[c]);
}

/* S_bar [1..9]: adjoint of weight * J * integrand + area_weight * J; `density` is the integrand's value. */
CO_SIMD_INLINE void adjoint_sample(lane S[CO_JET][3], const sample_state *m, const co_integrand *w, double eps4,
                                   int third, double weight, double area_weight, lane density, lane S_bar[CO_JET][3]) {
    const lane seed = weight * m->J, h2 = 2 * w->h2 * seed, gauss = w->gauss * seed, mean = 0.5 * w->mean * seed;
    lane C_bar[4];
    lane h_bar[3] = {h2 * m->h[0] + (gauss * m->h[2] - mean), /* of h2, of K = h11 h22 - h12^2, of H */
                     2 * (h2 - gauss) * m->h[1], h2 * m->h[2] + (gauss * m->h[0] - mean)};
    if (third)
        adjoint_invariants(m, w, eps4, seed, C_bar, h_bar);
    adjoint_forms(S, m, third, C_bar, h_bar, weight * density + area_weight, S_bar);
}

#endif
