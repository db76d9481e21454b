/* Blending weights near extraordinary vertices (sources: blend_weight.h). SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/blend_weight.h"

#include "base/elementary.h"

#include <math.h>

/* Terms of a truncated Taylor series, a[0] + a[1] s + a[2] s^2 + a[3] s^3. */
enum { TERMS = 4 };

static void series_multiply(const double *a, const double *b, double *out) {
    for (int k = 0; k < TERMS; k++) {
        out[k] = 0;
        for (int i = 0; i <= k; i++)
            out[k] += a[i] * b[k - i];
    }
}

static void series_reciprocal(const double *a, double *out) {
    out[0] = 1 / a[0];
    for (int k = 1; k < TERMS; k++) {
        double sum = 0;
        for (int i = 1; i <= k; i++)
            sum += a[i] * out[k - i];
        out[k] = -sum / a[0];
    }
}

static void series_exp(const double *a, double *out) {
    out[0] = co_exp(a[0]);
    for (int k = 1; k < TERMS; k++) {
        out[k] = 0;
        for (int i = 1; i <= k; i++)
            out[k] += i * a[i] * out[k - i] / k;
    }
}

/* 2 exp(-1/t) / (t - 1) about t, the variable running with the given sign. */
static void series_log_h(double t, double sign, double *out) {
    double about[TERMS] = {t, sign, 0, 0}, below[TERMS] = {t - 1, sign, 0, 0}, a[TERMS], b[TERMS];
    series_reciprocal(about, a);
    for (int k = 0; k < TERMS; k++)
        a[k] = -a[k];
    series_exp(a, b);
    series_reciprocal(below, a);
    series_multiply(b, a, out);
    for (int k = 0; k < TERMS; k++)
        out[k] *= 2;
}

/* w and its three derivatives at t <= 1/2: w = 1 / (1 + h(1 - t) / h(t)). */
static void weight_lower_half(double t, double w[4]) {
    double here[TERMS], mirrored[TERMS], ratio[TERMS];
    series_log_h(t, 1, here);
    series_log_h(1 - t, -1, mirrored);
    for (int k = 0; k < TERMS; k++)
        mirrored[k] -= here[k];
    series_exp(mirrored, ratio);
    ratio[0] += 1;
    series_reciprocal(ratio, w);
    w[2] *= 2;
    w[3] *= 6;
}

static void weight_smooth(double t, double w[4]) {
    const double flat = 0.005; /* closer to an end w equals its limit to the last bit */
    w[0] = t < 0.5;
    w[1] = w[2] = w[3] = 0;
    if (t <= flat || t >= 1 - flat)
        return;
    if (t <= 0.5) {
        weight_lower_half(t, w);
    } else { /* w(t) = 1 - w(1 - t) */
        weight_lower_half(1 - t, w);
        w[0] = 1 - w[0];
        w[2] = -w[2];
    }
}

static void weight_polynomial(double t, double w[4]) {
    double s = 1 - t;
    w[0] = 1 - t * t * t * t * (35 - 84 * t + 70 * t * t - 20 * t * t * t);
    w[1] = -140 * t * t * t * s * s * s;
    w[2] = -420 * t * t * s * s * (1 - 2 * t);
    w[3] = -840 * t * s * (1 - 5 * t * s);
}

void co_blend_weight(co_blend_kind blend, double u, double v, double jet[CO_JET]) {
    double along_u[4], along_v[4];
    void (*weight)(double, double *) = blend == CO_BLEND_SMOOTH ? weight_smooth : weight_polynomial;
    weight(u, along_u);
    weight(v, along_v);
    co_jet_of_product(along_u, along_v, jet);
}
