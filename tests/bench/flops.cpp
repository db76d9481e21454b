/* Floating-point operations of the pointwise formulas, counted by running the library's own code on numbers that count.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <cmath>

static long counted = 0;

/* A number that counts what is done to it; a division or a root is one operation, like a product. */
struct lane {
    double v;
    lane() : v(0) {}
    lane(double x) : v(x) {}
};
static inline lane operator+(lane a, lane b) { return counted++, lane(a.v + b.v); }
static inline lane operator-(lane a, lane b) { return counted++, lane(a.v - b.v); }
static inline lane operator*(lane a, lane b) { return counted++, lane(a.v * b.v); }
static inline lane operator/(lane a, lane b) { return counted++, lane(a.v / b.v); }
static inline lane operator-(lane a) { return lane(-a.v); }
static inline lane &operator+=(lane &a, lane b) { return a = a + b; }
static inline lane &operator-=(lane &a, lane b) { return a = a - b; }
static inline lane &operator*=(lane &a, lane b) { return a = a * b; }

/* In place of simd.h. */
#define CO_BASE_SIMD_H
#define CO_SIMD_INLINE static inline
CO_SIMD_INLINE lane lane_all(double x) { return lane(x); }
CO_SIMD_INLINE lane lane_sqrt(lane x) { return counted++, lane(std::sqrt(x.v)); }
CO_SIMD_INLINE lane lane_dot(const lane a[3], const lane b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
CO_SIMD_INLINE void lane_cross(const lane a[3], const lane b[3], lane out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}
CO_SIMD_INLINE void lane_add_scaled(lane y[3], lane s, const lane x[3]) {
    for (int c = 0; c < 3; c++)
        y[c] += s * x[c];
}

extern "C" {
#include "energy/kernel_gradient.h"

int flops_forward(int third);
int flops_adjoint(int third);
}

static void forward(lane S[CO_JET][3], int third, sample_state *state, sample_values *values) {
    for (int k = 0; k < CO_JET; k++)
        for (int c = 0; c < 3; c++)
            S[k][c] = 0.3 + std::sin(1.7 * k + 2.9 * c);
    counted = 0;
    forward_second(S, state, values);
    if (third) {
        forward_third(S, state);
        forward_invariants(state, 1e-8, values);
    }
}

int flops_forward(int third) {
    lane S[CO_JET][3];
    sample_state state;
    sample_values values;
    forward(S, third, &state, &values);
    return (int)counted;
}

int flops_adjoint(int third) {
    lane S[CO_JET][3], S_bar[CO_JET][3];
    sample_state state;
    sample_values values;
    co_integrand w = {};
    w.h2 = w.f1 = w.f3 = w.x = 1;
    forward(S, third, &state, &values);
    counted = 0;
    adjoint_sample(S, &state, &w, 1e-8, third, 0.1, 0.1, values.h2, S_bar);
    return (int)counted;
}
