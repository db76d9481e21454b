/* Second derivatives of the integrands with respect to the second fundamental form h and to C = grad h, by components
 * in the frame. Included by element_kernel.c only, as kernel_gradient.h is. SPDX-License-Identifier: GPL-3.0-or-later
 */
#ifndef CO_ENERGY_KERNEL_FORMS_H
#define CO_ENERGY_KERNEL_FORMS_H

#include "energy/kernel_gradient.h"

#include <string.h>

/* The integrand at one sample. */
typedef struct sample_integrand {
    const co_integrand *integrand;
    double eps4;        /* functional.h's regularization: eps to the fourth */
    double weight;      /* quadrature weight of the curvature integrals */
    double area_weight; /* quadrature weight of the area */
} sample_integrand;

/* An integrand and its derivatives with respect to C = (C111, C112, C122, C222) and h = (h11, h12, h22). */
typedef struct form_derivatives {
    lane value;
    lane C[4], h[3];
    lane CC[4][4], Ch[4][3], hh[3][3];
} form_derivatives;

/* Derivatives with respect to C from those with respect to A1, B1, A3, B3. */
CO_SIMD_INLINE void from_coefficients(const lane a[4], lane C[4]) {
    C[0] = 0.75 * a[0] + 0.25 * a[2];
    C[1] = 0.75 * (a[1] + a[3]);
    C[2] = 0.75 * (a[0] - a[2]);
    C[3] = 0.75 * a[1] - 0.25 * a[3];
}

/* The second-order part: seed (a |h|^2 + b K + c H). Sets what belongs to h. */
CO_SIMD_INLINE void second_forms(const co_integrand *w, const lane h[3], lane seed, form_derivatives *out) {
    const lane square = 2 * w->h2 * seed, gauss = w->gauss * seed, none = lane_all(0);
    const lane hh[3][3] = {{square, none, gauss}, {none, 2 * (square - gauss), none}, {gauss, none, square}};
    memcpy(out->hh, hh, sizeof hh);
    out->value = lane_all(0);
    for (int k = 0; k < 3; k++) {
        out->h[k] = hh[k][0] * h[0] + hh[k][1] * h[1] + hh[k][2] * h[2];
        out->value += 0.5 * out->h[k] * h[k];
        const lane linear = (k == 1 ? 0 : -0.5) * w->mean * seed;
        out->value += linear * h[k];
        out->h[k] += linear;
    }
}

/* P + i R = q^2 sigma with q = q1 + i q2 and sigma = |q|^2 / (|q|^4 + eps^4), and derivatives by q1 and q2. */
typedef struct umbilic_factor {
    lane P, R, P_q[2], R_q[2];
    lane slope[2], curvature[2][2]; /* first and second derivatives of re P + im R, re and im held */
} umbilic_factor;

CO_SIMD_INLINE void differentiate_factor(const lane h[3], double eps4, lane re, lane im, umbilic_factor *out) {
    const lane q[2] = {0.5 * (h[0] - h[2]), h[1]};
    const lane square = q[0] * q[0] + q[1] * q[1], squares = square * square, inv = 1.0 / (squares + eps4);
    const lane sigma = square * inv, first = (eps4 - squares) * inv * inv; /* sigma and its derivatives by |q|^2 */
    const lane second = -2 * square * (3 * eps4 - squares) * inv * inv * inv;
    const lane q_re = q[0] * q[0] - q[1] * q[1], q_im = 2 * q[0] * q[1], N = re * q_re + im * q_im;
    const lane re_q[2] = {2 * q[0], -2 * q[1]}, im_q[2] = {2 * q[1], 2 * q[0]};
    const lane N_q[2] = {re * re_q[0] + im * im_q[0], re * re_q[1] + im * im_q[1]};
    const lane N_qq[2][2] = {{2 * re, 2 * im}, {2 * im, -2 * re}};
    out->P = q_re * sigma;
    out->R = q_im * sigma;
    for (int i = 0; i < 2; i++) {
        const lane sigma_i = 2 * q[i] * first;
        out->P_q[i] = re_q[i] * sigma + q_re * sigma_i;
        out->R_q[i] = im_q[i] * sigma + q_im * sigma_i;
        out->slope[i] = N_q[i] * sigma + N * sigma_i;
        for (int j = 0; j < 2; j++) {
            const lane sigma_ij = 4 * q[i] * q[j] * second + (i == j ? 2 * first : lane_all(0));
            out->curvature[i][j] = N_qq[i][j] * sigma + 2 * (N_q[i] * q[j] + N_q[j] * q[i]) * first + N * sigma_ij;
        }
    }
}

/* Derivatives with respect to h from those with respect to q1 = (h11 - h22) / 2 and q2 = h12. */
CO_SIMD_INLINE void from_traceless(const lane q[2], lane h[3]) {
    h[0] = 0.5 * q[0];
    h[1] = q[1];
    h[2] = -0.5 * q[0];
}

/* Adds the third-order part, seed (a |F1|^2 + b |F3|^2 + c X), by the coefficients A1, B1, A3, B3 of C. */
CO_SIMD_INLINE void third_forms(const sample_integrand *s, const lane a[4], const lane h[3], lane seed,
                                form_derivatives *out) {
    const co_integrand *w = s->integrand;
    const lane x = w->x * seed, re = a[0] * a[2] - a[1] * a[3], im = a[0] * a[3] + a[1] * a[2];
    const lane re_a[4] = {a[2], -a[3], a[0], -a[1]}, im_a[4] = {a[3], a[2], a[1], a[0]};
    umbilic_factor f;
    differentiate_factor(h, s->eps4, re, im, &f);
    const lane P = x * f.P, R = x * f.R, one = 2 * w->f1 * seed, three = 2 * w->f3 * seed, none = lane_all(0);
    const lane aa[4][4] = {{one, none, P, R}, {none, one, R, -P}, {P, R, three, none}, {R, -P, none, three}};
    lane by_a[4], by_aC[4][4], by_ah[4][3], more[3], more_q[3];
    for (int i = 0; i < 4; i++) {
        const lane by_aq[2] = {x * (re_a[i] * f.P_q[0] + im_a[i] * f.R_q[0]),
                               x * (re_a[i] * f.P_q[1] + im_a[i] * f.R_q[1])};
        from_traceless(by_aq, by_ah[i]);
        from_coefficients(aa[i], by_aC[i]);
        by_a[i] = (i < 2 ? one : three) * a[i] + P * re_a[i] + R * im_a[i];
        out->value += 0.5 * (i < 2 ? one : three) * a[i] * a[i];
    }
    out->value += re * P + im * R;
    from_coefficients(by_a, out->C);
    for (int j = 0; j < 4; j++) {
        const lane column[4] = {by_aC[0][j], by_aC[1][j], by_aC[2][j], by_aC[3][j]};
        from_coefficients(column, out->CC[j]);
    }
    for (int k = 0; k < 3; k++) {
        const lane column[4] = {by_ah[0][k], by_ah[1][k], by_ah[2][k], by_ah[3][k]};
        lane by_C[4];
        from_coefficients(column, by_C);
        for (int i = 0; i < 4; i++)
            out->Ch[i][k] = by_C[i];
    }
    from_traceless(f.slope, more);
    for (int k = 0; k < 3; k++) {
        const lane by_qh[2] = {k == 1 ? f.curvature[0][1] : (k == 0 ? 0.5 : -0.5) * f.curvature[0][0],
                               k == 1 ? f.curvature[1][1] : (k == 0 ? 0.5 : -0.5) * f.curvature[1][0]};
        from_traceless(by_qh, more_q);
        out->h[k] += x * more[k];
        for (int l = 0; l < 3; l++)
            out->hh[k][l] += x * more_q[l];
    }
}

#endif
