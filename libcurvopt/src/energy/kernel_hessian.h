/* The core of a Hessian: the second derivatives at a sample with respect to the derivatives of S, 27 x 27 (15 x 15
 * without third order). Included by element_kernel.c only, as kernel_gradient.h is.
 *
 * Nothing is had from differences. Derivatives are taken with respect to parameters in which S_u and S_v are the frame
 * e1, e2, and by components along e1, e2, n. While S_u and S_v are held, an integrand is a function of few components:
 * of the second derivatives, p, q, h along e1, e2, n, and of the third ones' normal components T, through C = T - h *
 * Gamma, which is linear in T and bilinear in h and (p, q). What S_u and S_v do follows from two invariances: integrals
 * depend neither on parameters nor on rotations.
 *
 * Let D be the generator of a change of parameters, S_a <- S_a + eps S_b, or of a rotation that takes e_a towards n. It
 * acts on all derivatives; it takes S_u or S_v to a unit vector, and the others to `moved`. With tr = 1 for a change
 * that stretches, a = b, and 0 for the others, the integrand F (times J) has for every S
 *
 *     dF (D S) = tr F ,      hence      H (D S) = tr g - D^T g .
 *
 * The six generators reach the six components of S_u and S_v: their columns of H are tr g - D^T g - H moved.
 *
 * In the lifted Newton method's matrix (element_kernel.c) C is C(S) + kappa, with kappa constant in the frame. S_u <-
 * S_u + eps S_v turns the frame, and not kappa; its equation has one more term (lift). The others do not turn e1.
 * libcurvopt/notes/48-second-derivatives-by-invariance.md has the digits and the costs.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KERNEL_HESSIAN_H
#define CO_ENERGY_KERNEL_HESSIAN_H

#include "energy/kernel_forms.h"

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

/* Derivatives of S are called low: S_u, S_v and, with third order, S_uu, S_uv, S_vv; and top: those of the highest
 * order, of which first derivatives see only normal components. */
enum { MOST_LOW = 5, MOST_TOP = 4 };
CO_SIMD_INLINE int n_low_of(int third) {
    return third ? 5 : 2;
}
CO_SIMD_INLINE int n_top_of(int third) {
    return third ? 4 : 3;
}

/* A vector for each derivative of S. */
typedef struct sample_jet {
    lane low[MOST_LOW][3], top[MOST_TOP][3];
} sample_jet;

/* Second derivatives with respect to component d of one derivative of S and c of another:
 *
 *     low k, low j     low[k][j][d][c]
 *     top l, low j     n_d mixed[l][j][c]; if j is S_u or S_v, less slope[l] e_j,d n_c
 *     top l, top m     n_d n_c top[l][m] */
typedef struct sample_core {
    lane low[MOST_LOW][MOST_LOW][3][3];
    lane mixed[MOST_TOP][MOST_LOW][3];
    lane top[MOST_TOP][MOST_TOP];
    lane slope[MOST_TOP]; /* first derivative by top l, along n */
} sample_core;

/* A sample while its core is made. */
typedef struct sample_hessian {
    int third;
    lane axis[3][3]; /* e1, e2, n */
    sample_jet S;    /* derivatives of S by components in the frame */
    sample_jet g;    /* first derivatives of the integrand */
    lane lift;       /* dF (D S) - tr F for the one generator that turns e1; 0 unless lifted */
    sample_jet lift_g;
} sample_hessian;

/* ------------------------------------------------------------------------------------------------ the frame -- */

/* Derivatives of S by components, with respect to parameters that make S_u, S_v the frame. */
CO_SIMD_INLINE void to_frame(lane S[CO_JET][3], const sample_state *m, sample_hessian *out) {
    const int n_top = n_top_of(out->third);
    for (int c = 0; c < 3; c++) {
        out->axis[0][c] = m->s * S[1][c];
        out->axis[2][c] = m->n[c];
    }
    lane_cross(m->n, out->axis[0], out->axis[1]);
    memset(&out->S, 0, sizeof out->S);
    out->S.low[0][0] = out->S.low[1][1] = lane_all(1);
    for (int c = 0; c < 3; c++) {
        lane raw[MOST_TOP], framed[MOST_TOP];
        for (int k = 0; k < 3; k++)
            raw[k] = lane_dot(S[3 + k], out->axis[c]);
        to_frame_second(m, raw, framed);
        for (int k = 0; k < 3; k++)
            *(out->third ? &out->S.low[2 + k][c] : &out->S.top[k][c]) = framed[k];
        if (!out->third)
            continue;
        for (int k = 0; k < n_top; k++)
            raw[k] = lane_dot(S[6 + k], out->axis[c]);
        to_frame_third(m, raw, framed);
        for (int k = 0; k < n_top; k++)
            out->S.top[k][c] = framed[k];
    }
}

/* Rows of the table for the same parameters: [0] is free, then S_u, S_v, ... as in CO_JET. */
CO_SIMD_INLINE void rows_to_frame(const sample_state *m, int third, const lane row[CO_JET], lane out[CO_JET]) {
    out[1] = m->s * row[1];
    out[2] = m->t * (row[2] - m->tau * row[1]);
    to_frame_second(m, row + 3, out + 3);
    if (third)
        to_frame_third(m, row + 6, out + 6);
}

/* --------------------------------------------------------------------------------- while S_u and S_v are held -- */

/* C = T - h * Gamma and its derivatives by second derivatives of S: [.][uu, uv, vv][p, q, h]. */
CO_SIMD_INLINE void differentiate_codazzi(const sample_jet *S, lane C[4], lane by_second[4][3][3]) {
    /* Weights of the terms h * Gamma of C111, C112, C122, C222: of S_ij . e_l and h_kl for the pairs (ij, k). */
    static const double weight[4][3][2] = {
        {{3, 0}, {0, 0}, {0, 0}}, {{0, 1}, {2, 0}, {0, 0}}, {{0, 0}, {0, 2}, {1, 0}}, {{0, 0}, {0, 0}, {0, 3}}};
    for (int i = 0; i < 4; i++) {
        C[i] = S->top[i][2];
        memset(by_second[i], 0, sizeof by_second[i]);
        for (int ij = 0; ij < 3; ij++)
            for (int k = 0; k < 2; k++)
                for (int l = 0; weight[i][ij][k] != 0 && l < 2; l++) {
                    C[i] -= (weight[i][ij][k] * S->low[2 + k + l][2]) * S->low[2 + ij][l];
                    by_second[i][ij][l] -= weight[i][ij][k] * S->low[2 + k + l][2];
                    by_second[i][k + l][2] -= weight[i][ij][k] * S->low[2 + ij][l];
                }
    }
}

/* Adds sum of C_bar times the second derivatives of C, which is bilinear: by h_kl and S_ij . e_l. */
CO_SIMD_INLINE void add_bilinear(const lane C_bar[4], sample_core *core) {
    const lane factor[3][2] = {{-3 * C_bar[0], -C_bar[1]}, {-2 * C_bar[1], -2 * C_bar[2]}, {-C_bar[2], -3 * C_bar[3]}};
    for (int ij = 0; ij < 3; ij++)
        for (int k = 0; k < 2; k++)
            for (int l = 0; l < 2; l++) {
                core->low[2 + ij][2 + k + l][l][2] += factor[ij][k];
                core->low[2 + k + l][2 + ij][2][l] += factor[ij][k];
            }
}

/* Third order: derivatives by second and third derivatives of S, from those by C and h. */
CO_SIMD_INLINE void hold_first_third(const form_derivatives *f, lane by_second[4][3][3], sample_hessian *s,
                                     sample_core *core) {
    memcpy(core->top, f->CC, sizeof core->top);
    for (int l = 0; l < 4; l++) {
        core->slope[l] = s->g.top[l][2] = f->C[l];
        for (int k = 0; k < 3; k++)
            for (int d = 0; d < 3; d++) {
                lane sum = d == 2 ? f->Ch[l][k] : lane_all(0);
                for (int i = 0; i < 4; i++)
                    sum += f->CC[l][i] * by_second[i][k][d];
                core->mixed[l][2 + k][d] = sum;
            }
    }
    for (int k = 0; k < 3; k++)
        for (int d = 0; d < 3; d++) {
            s->g.low[2 + k][d] = d == 2 ? f->h[k] : lane_all(0);
            for (int i = 0; i < 4; i++)
                s->g.low[2 + k][d] += f->C[i] * by_second[i][k][d];
            for (int j = 0; j < 3; j++)
                for (int c = 0; c < 3; c++) {
                    lane sum = d == 2 && c == 2 ? f->hh[k][j] : lane_all(0);
                    for (int i = 0; i < 4; i++)
                        sum += by_second[i][k][d] * core->mixed[i][2 + j][c];
                    for (int i = 0; d == 2 && i < 4; i++)
                        sum += f->Ch[i][k] * by_second[i][j][c];
                    core->low[2 + k][2 + j][d][c] = sum;
                }
        }
    add_bilinear(f->C, core);
}

/* Second order: of second derivatives only h counts. */
CO_SIMD_INLINE void hold_first_second(const form_derivatives *f, sample_hessian *s, sample_core *core) {
    for (int k = 0; k < 3; k++) {
        core->slope[k] = s->g.top[k][2] = f->h[k];
        for (int l = 0; l < 3; l++)
            core->top[k][l] = f->hh[k][l];
    }
}

/* The lifted matrix: what the generator that turns e1 has more, - dF / dC . (kappa turned), and its derivatives while
 * S_u and S_v are held. kappa by its coefficients A1, B1, A3, B3. Returns its derivative as the frame turns under C and
 * h. */
CO_SIMD_INLINE lane lift_equation(const form_derivatives *f, const lane kappa[4], const lane C[4], const lane h[3],
                                  lane by_second[4][3][3], sample_hessian *s) {
    const double third = 1.0 / 3;
    const lane turned[4] = {kappa[1] + 3 * kappa[3], -third * kappa[0] - 3 * kappa[2], third * kappa[1] - 3 * kappa[3],
                            3 * kappa[2] - kappa[0]};
    for (int i = 0; i < 4; i++) {
        s->lift -= f->C[i] * turned[i];
        for (int l = 0; l < 4; l++)
            s->lift_g.top[l][2] -= f->CC[l][i] * turned[i];
        for (int k = 0; k < 3; k++)
            s->lift_g.low[2 + k][2] -= f->Ch[i][k] * turned[i];
    }
    const lane *by_h[3] = {s->lift_g.low[2] + 2, s->lift_g.low[3] + 2, s->lift_g.low[4] + 2};
    const lane C_turned[4] = {3 * C[1], 2 * C[2] - C[0], C[3] - 2 * C[1], -3 * C[2]};
    lane sum = 2 * h[1] * (*by_h[0] - *by_h[2]) + (h[2] - h[0]) * *by_h[1];
    for (int i = 0; i < 4; i++)
        sum += s->lift_g.top[i][2] * C_turned[i];
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            for (int d = 0; d < 3; d++)
                s->lift_g.low[2 + k][d] += s->lift_g.top[i][2] * by_second[i][k][d];
    return sum;
}

/* ---------------------------------------------------------------------------------------- by invariance -- */

/* Generators: b = 0, 1: S_a <- S_a + eps S_b; b = 2: a rotation that takes e_a towards n. */
enum { N_GENERATORS = 6 };

/* Derivatives of one order, 0 .. order: out = D in, or D^T in. A derivative with l times v has order - l times u. */
CO_SIMD_INLINE void generate_order(int order, int a, int b, int transposed, lane (*in)[3], lane (*out)[3]) {
    for (int l = 0; b == 2 && l <= order; l++) {
        out[l][1 - a] = lane_all(0);
        out[l][a] = transposed ? in[l][2] : -in[l][2];
        out[l][2] = transposed ? -in[l][a] : in[l][a];
    }
    if (b == 2)
        return;
    memset(out, 0, sizeof *out * (size_t)(order + 1));
    for (int l = a; l < order + a; l++) { /* those that have any u (a = 0) or v */
        const int other = l + b - a;
        const double times = a ? l : order - l;
        for (int c = 0; c < 3; c++)
            out[transposed ? other : l][c] = times * in[transposed ? l : other][c];
    }
}

CO_SIMD_INLINE void generate(int third, int a, int b, int transposed, sample_jet *in, sample_jet *out) {
    generate_order(1, a, b, transposed, in->low, out->low);
    if (third)
        generate_order(2, a, b, transposed, in->low + 2, out->low + 2);
    generate_order(third ? 3 : 2, a, b, transposed, in->top, out->top);
}

/* Sum over the derivatives that are held: all but S_u and S_v, of the top ones the normal components. */
CO_SIMD_INLINE lane held_dot(int third, lane (*low)[3], lane (*top)[3], const sample_jet *moved) {
    lane sum = lane_all(0);
    for (int j = 2; j < n_low_of(third); j++)
        sum += lane_dot(low[j], moved->low[j]);
    for (int l = 0; l < n_top_of(third); l++)
        sum += top[l][2] * moved->top[l][2];
    return sum;
}

/* First derivatives by S_u and S_v: of the integrand, whose value is F, and of the lifted equation's. */
CO_SIMD_INLINE void complete_gradient(lane F, lane turned, const sample_jet moved[N_GENERATORS], sample_hessian *s) {
    for (int a = 0; a < 2; a++)
        for (int b = 0; b < 3; b++) {
            const sample_jet *m = &moved[3 * a + b];
            const int turns = a == 0 && b == 1;
            lane trace = a == b ? F : turns ? s->lift : lane_all(0);
            s->g.low[a][b] = trace - held_dot(s->third, s->g.low, s->g.top, m);
            s->lift_g.low[a][b] = (turns ? turned : lane_all(0)) - held_dot(s->third, s->lift_g.low, s->lift_g.top, m);
        }
    s->lift_g.low[1][1] += 2 * s->lift; /* J^2 / |S_u|^2, by which the frame turns, times J, has this derivative */
}

/* Columns of S_a (component b), of which `rest` is tr g - D^T g, in the rows of what is held. */
CO_SIMD_INLINE void complete_held(int third, int a, int b, const sample_jet *rest, const sample_jet *moved,
                                  sample_core *core) {
    for (int k = 2; k < n_low_of(third); k++)
        for (int d = 0; d < 3; d++) {
            lane sum = rest->low[k][d];
            for (int j = 2; j < n_low_of(third); j++)
                sum -= lane_dot(core->low[k][j][d], moved->low[j]);
            for (int l = 0; l < n_top_of(third); l++)
                sum -= core->mixed[l][k][d] * moved->top[l][2];
            core->low[k][a][d][b] = core->low[a][k][b][d] = sum;
        }
    for (int l = 0; l < n_top_of(third); l++) {
        lane sum = rest->top[l][2];
        for (int j = 2; j < n_low_of(third); j++)
            sum -= lane_dot(core->mixed[l][j], moved->low[j]);
        for (int m = 0; m < n_top_of(third); m++)
            sum -= core->top[l][m] * moved->top[m][2];
        core->mixed[l][a][b] = sum;
    }
}

/* The entry of S_e (component f) in the same column, after complete_held() of all columns. */
CO_SIMD_INLINE void complete_first(int third, const int row[2], const int column[2], const sample_jet *rest,
                                   const sample_jet *moved, sample_core *core) {
    const int e = row[0], f = row[1];
    lane sum = rest->low[e][f];
    for (int j = 2; j < n_low_of(third); j++)
        sum -= lane_dot(core->low[e][j][f], moved->low[j]);
    for (int l = 0; l < n_top_of(third); l++) {
        sum -= core->mixed[l][e][f] * moved->top[l][2];
        if (f == 2)
            sum += core->slope[l] * moved->top[l][e];
    }
    core->low[e][column[0]][f][column[1]] = core->low[column[0]][e][column[1]][f] = sum;
}

CO_SIMD_INLINE void complete(lane F, lane turned, sample_hessian *s, sample_core *core) {
    sample_jet moved[N_GENERATORS], rest[N_GENERATORS];
    const int n_low = n_low_of(s->third), n_top = n_top_of(s->third);
    for (int i = 0; i < N_GENERATORS; i++)
        generate(s->third, i / 3, i % 3, 0, &s->S, &moved[i]);
    complete_gradient(F, turned, moved, s);
    for (int i = 0; i < N_GENERATORS; i++) {
        const double trace = i / 3 == i % 3, lifted = i == 1;
        generate(s->third, i / 3, i % 3, 1, &s->g, &rest[i]);
        for (int c = 0; c < 3; c++) {
            for (int k = 0; k < n_low; k++)
                rest[i].low[k][c] = trace * s->g.low[k][c] - rest[i].low[k][c] + lifted * s->lift_g.low[k][c];
            for (int l = 0; l < n_top; l++)
                rest[i].top[l][c] = trace * s->g.top[l][c] - rest[i].top[l][c] + lifted * s->lift_g.top[l][c];
        }
        complete_held(s->third, i / 3, i % 3, &rest[i], &moved[i], core);
    }
    for (int i = 0; i < N_GENERATORS; i++)
        for (int k = 0; k <= i; k++)
            complete_first(s->third, (const int[2]){k / 3, k % 3}, (const int[2]){i / 3, i % 3}, &rest[i], &moved[i],
                           core);
}

/* ------------------------------------------------------------------------------------------------ the core -- */

/* Components along e1, e2, n -> x, y, z. */
CO_SIMD_INLINE void to_axes(lane axis[3][3], const lane in[3], lane out[3]) {
    for (int c = 0; c < 3; c++)
        out[c] = in[0] * axis[0][c] + in[1] * axis[1][c] + in[2] * axis[2][c];
}

CO_SIMD_INLINE void core_to_axes(sample_hessian *s, sample_core *core) {
    for (int k = 0; k < n_low_of(s->third); k++)
        for (int j = 0; j <= k; j++) {
            lane half[3][3], column[3];
            for (int d = 0; d < 3; d++)
                to_axes(s->axis, core->low[k][j][d], half[d]);
            for (int c = 0; c < 3; c++) {
                const lane from[3] = {half[0][c], half[1][c], half[2][c]};
                to_axes(s->axis, from, column);
                for (int d = 0; d < 3; d++)
                    core->low[k][j][d][c] = core->low[j][k][c][d] = column[d];
            }
        }
    for (int l = 0; l < n_top_of(s->third); l++)
        for (int j = 0; j < n_low_of(s->third); j++) {
            const lane from[3] = {core->mixed[l][j][0], core->mixed[l][j][1], core->mixed[l][j][2]};
            to_axes(s->axis, from, core->mixed[l][j]);
        }
}

/* The core at a sample, by components along x, y, z, after forward_second(). lifted [4]: coefficients of C that are
 * taken for those at S; NULL: those at S. `third` is a constant where this is called. */
CO_SIMD_INLINE void differentiate_twice(const sample_integrand *at, int third, lane S[CO_JET][3], const sample_state *m,
                                        const lane *lifted, sample_hessian *s, sample_core *core) {
    const lane seed = at->weight * m->J;
    form_derivatives f;
    lane turned = lane_all(0);
    s->third = third;
    to_frame(S, m, s);
    memset(&s->g, 0, sizeof s->g);
    memset(&s->lift_g, 0, sizeof s->lift_g);
    s->lift = lane_all(0);
    second_forms(at->integrand, m->h, seed, &f);
    if (third) {
        lane C[4], by_second[4][3][3];
        differentiate_codazzi(&s->S, C, by_second);
        const lane own[4] = {0.75 * (C[0] + C[2]), 0.75 * (C[1] + C[3]), 0.25 * C[0] - 0.75 * C[2],
                             0.75 * C[1] - 0.25 * C[3]};
        third_forms(at, lifted ? lifted : own, m->h, seed, &f);
        hold_first_third(&f, by_second, s, core);
        if (lifted) {
            const lane kappa[4] = {lifted[0] - own[0], lifted[1] - own[1], lifted[2] - own[2], lifted[3] - own[3]};
            turned = lift_equation(&f, kappa, C, m->h, by_second, s);
        }
    } else {
        hold_first_second(&f, s, core);
    }
    complete(f.value + at->integrand->area * at->area_weight * m->J, turned, s, core);
    core_to_axes(s, core);
}

#endif
