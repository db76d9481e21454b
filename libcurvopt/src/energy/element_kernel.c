/* Energies, gradients and second derivatives of a block of faces of one kind, one face per vector lane. Compiled once
 * per instruction set, with CO_DOUBLES and CO_INSTRUCTION_SET set. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/element_kernel.h"

#include "base/instruction_set.h"
#include "energy/kernel_gauss_newton.h"
#include "energy/kernel_products.h"
#include "energy/kernel_samples.h"

#include <string.h>

/* matrix += V^T V for the lower triangle, V [n_columns][size]. Tiles of 4 x 4 keep their sums in registers. */
CO_SIMD_INLINE void add_squares(const lane *V, int n_columns, int size, lane *matrix) {
    for (int i = 0; i < size; i += 4)
        for (int j = 0; j <= i; j += 4) {
            lane sum[4][4];
            int rows = size - i < 4 ? size - i : 4, columns = size - j < 4 ? size - j : 4;
            memset(sum, 0, sizeof sum);
            if (rows == 4 && columns == 4) {
                for (int k = 0; k < n_columns; k++)
                    for (int r = 0; r < 4; r++)
                        for (int c = 0; c < 4; c++)
                            sum[r][c] += V[k * size + i + r] * V[k * size + j + c];
            } else {
                for (int k = 0; k < n_columns; k++)
                    for (int r = 0; r < rows; r++)
                        for (int c = 0; c < columns; c++)
                            sum[r][c] += V[k * size + i + r] * V[k * size + j + c];
            }
            for (int r = 0; r < rows; r++)
                for (int c = 0; c < columns && j + c <= i + r; c++)
                    matrix[(i + r) * (i + r + 1) / 2 + j + c] += sum[r][c];
        }
}

/* Gradient of one residual with respect to the face's points: out [3 n]. */
CO_SIMD_INLINE void residual_gradient(const co_basis_table *t, int32_t sample, lane S_bar[CO_JET][3], int first,
                                      int last, lane *out) {
    const double *rows = rows_of(t, sample);
    double weight = sqrt(t->weight[sample]);
    transpose_jets(rows, t->is_mixed, t->n_points, S_bar, first, last, 0, (lane(*)[3])(void *)out);
    for (int32_t i = 0; i < 3 * t->n_points; i++)
        out[i] *= weight;
}

/* On `plane`, the vertex's normal taken for constant: its contribution is small, and this matrix only preconditions. */
CO_SIMD_INLINE void plane_residual(plane_state *m, const co_basis_table *t, int32_t sample, lane S[CO_JET][3],
                                   lane S_bar[CO_JET][3], lane *out) {
    memset(S_bar[0], 0, sizeof S_bar[0]);
    memset(m->V_bar, 0, sizeof m->V_bar);
    plane_adjoint(m, t->blend + (size_t)sample * CO_JET, S, S_bar);
    residual_gradient(t, sample, S_bar, 0, 9, out);
    for (int32_t p = 0; p < t->n_points; p++)
        lane_add_scaled(out + 3 * p, lane_all(t->masks[p] * sqrt(t->weight[sample])), m->V_bar);
}

/* `third` and `plane` are constants where this is called. */
CO_SIMD_INLINE void add_gauss_newton(const co_element_hessian *s, lane (*P)[3], lane *V, int third, int plane) {
    const co_basis_table *t = s->table;
    const int size = 3 * t->n_points, first = plane ? 0 : 1, last = third || plane ? 9 : 5;
    int n_columns = 0;
    lane *matrix = (lane *)(void *)s->matrix;
    plane_state vertex;
    if (plane)
        plane_begin(t, P, &vertex);
    for (int32_t i = 0; i < t->n_samples && !co_cancel_is_due(s->cancel); i++) {
        lane S[CO_JET][3], S_bar[CO_JET][3];
        sample_state state;
        sample_values value;
        jets(rows_of(t, i), t->is_mixed, t->n_points, P, first, last, S);
        if (plane)
            plane_forward(&vertex, t->blend + (size_t)i * CO_JET, S);
        forward_second(S, &state, &value);
        if (third)
            forward_third(S, &state);
        for (int which = s->integrand.h2 > 0 ? 0 : RESIDUALS_SECOND;
             which < RESIDUALS_SECOND + (third ? RESIDUALS_THIRD : 0); which++) {
            if (which < RESIDUALS_SECOND)
                adjoint_residual_second(S, &state, &s->integrand, which, S_bar);
            else if (third)
                adjoint_residual_third(S, &state, &s->integrand, s->eps4, which - RESIDUALS_SECOND, S_bar);
            if (plane)
                plane_residual(&vertex, t, i, S, S_bar, V + n_columns * size);
            else
                residual_gradient(t, i, S_bar, first, last, V + n_columns * size);
            if (++n_columns == CO_SECOND_COLUMNS) {
                add_squares(V, n_columns, size, matrix);
                n_columns = 0;
            }
        }
    }
    add_squares(V, n_columns, size, matrix);
}

/* C becomes its linear extrapolation from `before` along the step. */
CO_SIMD_INLINE void lift_curvature(const double *rows, int mixed, int32_t n_points, lane (*before)[3],
                                   lane S[CO_JET][3], lane C[4]) {
    lane from[CO_JET][3];
    curvature_derivative at;
    jets(rows, mixed, n_points, before, 1, 9, from);
    differentiate_curvature(from, &at);
    for (int i = 0; i < 4; i++) {
        C[i] = at.value[i];
        for (int k = 1; k < CO_JET; k++)
            for (int c = 0; c < 3; c++)
                C[i] += at.slope[i][k][c] * (S[k][c] - from[k][c]);
    }
}

/* The Hessian (kernel_hessian.h).
 *
 * After a step it can be the lifted Newton method's matrix instead (Albersmeyer, Diehl, "The lifted Newton method and
 * its application in optimization", SIAM J. Optim. 20, 2010; for thin shells Magisano, Leonetti, Garcea, "Advantages of
 * the mixed format in geometrically nonlinear analysis of beams and shells using solid finite elements", Int. J. Numer.
 * Meth. Engng 109, 2017). After a step that slides vertices by a hundredth of an edge, C differs from its linear
 * extrapolation by a second-order remainder that is as large as C. In the Hessian C multiplies curvatures; with that
 * remainder it is indefinite, and no model of the rest of the way. So C is taken for a variable of its own: in the
 * matrix, not in the gradient, it is its linear extrapolation (libcurvopt/notes/54-lifted-newton-method.md).
 *
 * At each sample, with S the 9 derivatives (27 numbers) and x the points (S = R x, R the rows of the table), matrix +=
 * R^T core R. The core is in kernel_hessian.h, the products are in kernel_products.h. V: rows in the frame's
 * parameters, [n][CO_JET], then `before`. */
CO_SIMD_INLINE void add_hessian(const co_element_hessian *s, lane (*P)[3], lane *V, int third) {
    const co_basis_table *t = s->table;
    const int n = t->n_points, mixed = t->is_mixed, last = third ? 9 : 5, n_low = n_low_of(third),
              n_top = n_top_of(third);
    lane(*before)[3] = (lane(*)[3])(void *)(V + CO_JET * n);
    if (third && s->before)
        gather(n, s->points, s->before, before);
    for (int32_t i = 0; i < t->n_samples && !co_cancel_is_due(s->cancel); i++) {
        const double *rows = rows_of(t, i);
        const sample_integrand at = {&s->integrand, s->eps4, t->weight[i], t->area_weight[i]};
        lane S[CO_JET][3], C[4];
        sample_state state;
        sample_values value;
        sample_hessian sample;
        sample_core core;
        left_factor left[2];
        jets(rows, mixed, n, P, 1, last, S);
        forward_second(S, &state, &value);
        if (third && s->before)
            lift_curvature(rows, mixed, n, before, S, C);
        differentiate_twice(&at, third, S, &state, third && s->before ? C : NULL, &sample, &core);
        for (int p = 0; p < n; p++) {
            lane row[CO_JET], *framed = V + p * CO_JET;
            for (int k = 1; k <= last; k++)
                row[k] = entry(rows, mixed, p * CO_JET + k);
            rows_to_frame(&state, third, row, framed);
            framed[0] = lane_all(0);
            for (int l = 0; l < n_top; l++)
                framed[0] += core.slope[l] * framed[1 + n_low + l];
        }
        for (int p = 0; p < n; p += 2) {
            const lane *framed = V + p * CO_JET;
            if (p + 1 < n)
                make_left_factors(&core, sample.axis, third, framed, 2, left);
            else
                make_left_factors(&core, sample.axis, third, framed, 1, left);
            for (int k = 0; k < 2 && p + k < n; k++)
                add_blocks(&left[k], sample.axis[2], third, V, p + k, (lane *)(void *)s->matrix);
        }
    }
}

/* Adds the volume's second derivatives. */
static void add_volume_hessian(const co_element_hessian *s, lane (*P)[3]) {
    const co_basis_table *t = s->table;
    const int mixed = t->is_mixed;
    lane offset[3], *matrix = (lane *)(void *)s->matrix;
    volume_offset(s->points, s->xyz, offset);
    for (int32_t i = 0; i < t->n_samples && !co_cancel_is_due(s->cancel); i++) {
        const double *rows = rows_of(t, i), weight = s->integrand.volume * t->area_weight[i];
        lane S[CO_JET][3];
        jets(rows, mixed, t->n_points, P, 0, 2, S);
        lane_add_scaled(S[0], lane_all(1), offset);
        for (int p = 1; p < t->n_points; p++) {
            const lane r_p[3] = {entry(rows, mixed, p * CO_JET), entry(rows, mixed, p * CO_JET + 1),
                                 entry(rows, mixed, p * CO_JET + 2)};
            for (int q = 0; q < p; q++) {
                const lane r_q[3] = {entry(rows, mixed, q * CO_JET), entry(rows, mixed, q * CO_JET + 1),
                                     entry(rows, mixed, q * CO_JET + 2)};
                volume_add_block(S, weight, r_p, r_q, p, q, matrix);
            }
        }
    }
}

/* The energies' Hessian, or their Gauss-Newton matrix. */
static void add_energies(const co_element_hessian *s, lane (*P)[3], lane *V) {
    if (s->exact && !s->table->blend) {
        if (s->third)
            add_hessian(s, P, V, 1);
        else
            add_hessian(s, P, V, 0);
        return;
    }
    if (s->table->blend && s->third)
        add_gauss_newton(s, P, V, 1, 1);
    else if (s->table->blend)
        add_gauss_newton(s, P, V, 0, 1);
    else if (s->third)
        add_gauss_newton(s, P, V, 1, 0);
    else
        add_gauss_newton(s, P, V, 0, 0);
    for (size_t i = 0; i < co_element_hessian_size(s->table->n_points) * CO_LANES; i++)
        s->matrix[i] *= 2; /* a square r^2 has 2 grad r grad r^T */
}

static void run_second_part(const co_element_hessian *s) {
    size_t n = (size_t)s->table->n_points, entries = co_element_hessian_size(s->table->n_points);
    lane(*P)[3] = (lane(*)[3])(void *)s->work, *V = (lane *)(void *)(P + n);
    gather(s->table->n_points, s->points, s->xyz, P);
    memset(s->matrix, 0, sizeof(lane) * entries);
    add_energies(s, P, V);
    if (s->exact && s->integrand.volume != 0 && !s->table->blend)
        add_volume_hessian(s, P);
}

static void run_second(const co_element_hessian *s) {
    const size_t n = (size_t)s->table->n_points;
    for (size_t part = 0; part * CO_LANES < (size_t)s->n_used; part++) {
        const co_basis_table table = table_of_part(s->table, part);
        co_element_hessian of_part = *s;
        of_part.table = &table;
        of_part.points += part * n * CO_LANES;
        of_part.matrix += part * co_element_hessian_size(s->table->n_points) * CO_LANES;
        run_second_part(&of_part);
    }
}

#define STRING_(x) #x
#define STRING(x)  STRING_(x)
const co_element_kernel CO_NAME_OF_SET(co_element_kernel) = {
    .lanes = CO_LANES, .name = STRING(CO_INSTRUCTION_SET), .run = run, .run_second = run_second};
