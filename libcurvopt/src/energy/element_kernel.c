/* Energies and gradients of a block of faces of one kind, one face per vector lane. Compiled once per instruction set,
 * with CO_LANES and CO_INSTRUCTION_SET set. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/element_kernel.h"

#include "base/instruction_set.h"
#include "energy/kernel_gauss_newton.h"
#include "energy/kernel_plane.h"
#include "energy/kernel_products.h"
#include "energy/kernel_rows.h"
#include "energy/kernel_strip.h"
#include "energy/kernel_umbilic.h"
#include "energy/kernel_volume.h"

#include <string.h>

/* Points of the block, relative to each face's first one: derivatives then lose no digits to the face's distance from
 * the origin. Gradients with respect to them, and to the area's. */
typedef struct block {
    lane (*P)[3];
    lane (*G)[3];
    lane (*G_area)[3];
} block;

/* How a table's samples are read; a constant where these functions are called, so that each way is compiled without
 * the others' work. */
typedef enum { OF_ROWS, OF_PLANE, OF_STRIPS } table_form;

static table_form form_of(const co_basis_table *t) {
    return t->blend ? OF_PLANE : t->side ? OF_STRIPS : OF_ROWS;
}

/* What reads one sample of a table after the other, and gives adjoints back. */
typedef struct reader {
    const co_basis_table *table;
    const block *b;
    int32_t sample, at_side; /* at_side: its place in its strip */
    plane_state plane;
    strip points, bar, area_bar;
} reader;

CO_SIMD_INLINE void reader_begin(reader *r, table_form form, const co_basis_table *t, const block *b) {
    r->table = t;
    r->b = b;
    r->sample = r->at_side = -1;
    if (form == OF_PLANE)
        plane_begin(t, b->P, &r->plane);
}

/* To the next sample, whose derivatives are wanted up to `order`; n_gradients: 0, 1, or 2 with the area's. */
CO_SIMD_INLINE void reader_advance(reader *r, table_form form, int order, int n_gradients) {
    r->sample++;
    if (form != OF_STRIPS || ++r->at_side % r->table->n_side)
        return;
    r->at_side = 0;
    strip_begin(r->table->side + 16 * (r->sample / r->table->n_side), order, r->b->P, r->points);
    if (n_gradients > 0)
        memset(r->bar, 0, sizeof *r->bar * (size_t)(order + 1));
    if (n_gradients > 1)
        memset(r->area_bar, 0, 2 * sizeof *r->area_bar); /* strip_end() reads orders 0 and 1 */
}

CO_SIMD_INLINE const double *blend_of(const reader *r) {
    return r->table->blend + (size_t)r->sample * CO_JET;
}

/* S [first..last], on `plane` 0..9. */
CO_SIMD_INLINE void read_jets(reader *r, table_form form, int first, int last, lane S[CO_JET][3]) {
    const co_basis_table *t = r->table;
    if (form == OF_STRIPS)
        strip_jets(t->side + 16 * r->at_side, r->points, first, last, S);
    else
        jets(rows_of(t, r->sample), t->is_mixed, t->n_points, r->b->P, first, last, S);
    if (form == OF_PLANE)
        plane_forward(&r->plane, blend_of(r), S);
}

/* Adds what S_bar [first..last] contributes to the points' gradient, on strips when they end (scatter_strip). On
 * `plane` that is 0..9, and S_bar is changed. */
CO_SIMD_INLINE void scatter_jets(reader *r, table_form form, lane S[CO_JET][3], lane S_bar[CO_JET][3], int first,
                                 int last) {
    const co_basis_table *t = r->table;
    if (form == OF_PLANE)
        plane_adjoint(&r->plane, blend_of(r), S, S_bar);
    if (form == OF_STRIPS)
        strip_scatter(t->side + 16 * r->at_side, S_bar, first, last, r->bar);
    else
        transpose_jets(rows_of(t, r->sample), t->is_mixed, t->n_points, S_bar, first, last, 1, r->b->G);
}

/* Likewise for the area, not on `plane`. */
CO_SIMD_INLINE void scatter_area(reader *r, table_form form, lane S_bar[CO_JET][3]) {
    const co_basis_table *t = r->table;
    if (form == OF_STRIPS)
        strip_scatter(t->side + 16 * r->at_side, S_bar, 1, 2, r->area_bar);
    else
        transpose_jets(rows_of(t, r->sample), t->is_mixed, t->n_points, S_bar, 1, 2, 1, r->b->G_area);
}

/* At the end of a sample: if it is the last of its strip, the strip's adjoints go to the points' gradients. `order` as
 * of reader_advance(); area: the area's as well. */
CO_SIMD_INLINE void scatter_strip(reader *r, table_form form, int order, int area) {
    const co_basis_table *t = r->table;
    if (form != OF_STRIPS || r->at_side + 1 < t->n_side)
        return;
    strip_end(t->side + 16 * (r->sample / t->n_side), order, r->bar, r->b->G);
    if (area)
        strip_end(t->side + 16 * (r->sample / t->n_side), 1, r->area_bar, r->b->G_area);
}

/* S_bar [1], [2] += those of J times a weight; normal: S_u x S_v, and the weight over J, or of length 1. */
CO_SIMD_INLINE void add_area_adjoint(lane S[CO_JET][3], const lane normal[3], lane weight, lane S_bar[CO_JET][3]) {
    lane turned[3];
    lane_cross(S[2], normal, turned);
    lane_add_scaled(S_bar[1], weight, turned);
    lane_cross(normal, S[1], turned);
    lane_add_scaled(S_bar[2], weight, turned);
}

/* S_bar [first..last], 1 and 2 among them, of the area. */
CO_SIMD_INLINE void area_adjoint(lane S[CO_JET][3], const sample_state *m, lane weight, int first, int last,
                                 lane S_bar[CO_JET][3]) {
    memset(S_bar[first], 0, sizeof S_bar[0] * (size_t)(last - first + 1));
    add_area_adjoint(S, m->n, weight, S_bar);
}

CO_SIMD_INLINE void accumulate(const co_basis_table *t, int32_t sample, int third, const sample_state *m,
                               const sample_values *value, lane sums[CO_N_SUMS]) {
    lane weight = t->weight[sample] * m->J, jacobian = t->jacobian_scale[sample] * m->J;
    sums[CO_INT_AREA] += t->area_weight[sample] * m->J;
    sums[CO_INT_H2] += weight * value->h2;
    sums[CO_INT_K] += weight * value->gauss;
    sums[CO_INT_MEAN] += weight * value->mean;
    if (third) {
        sums[CO_INT_F1] += weight * value->f1;
        sums[CO_INT_F3] += weight * value->f3;
        sums[CO_INT_X] += weight * value->x;
    }
    sums[CO_SUM_MIN_JACOBIAN] = lane_min(sums[CO_SUM_MIN_JACOBIAN], jacobian);
    sums[CO_SUM_MEAN_JACOBIAN] += jacobian;
}

CO_SIMD_INLINE lane density_of(const co_integrand *w, int third, const sample_values *value) {
    lane density = w->h2 * value->h2 + (w->gauss * value->gauss + w->mean * value->mean);
    if (third)
        density = w->f1 * value->f1 + (w->f3 * value->f3 + (w->x * value->x + density));
    return density;
}

/* The integrals over all samples; `third` and `form` are constants where this is called. */
CO_SIMD_INLINE void integrate_samples(const co_element_block *s, const block *b, int third, table_form form,
                                      lane sums[CO_N_SUMS]) {
    const co_basis_table *t = s->table;
    const int plane = form == OF_PLANE, order = third ? 3 : 2;
    const int first = plane ? 0 : 1, last = third || plane ? 9 : 5;
    const int volume_gradient = s->volume && s->gradient && s->integrand.volume != 0;
    lane offset[3], place[3];
    reader r;
    memset(place, 0, sizeof place);
    volume_offset(s->points, s->xyz, offset);
    reader_begin(&r, form, t, b);
    for (int32_t i = 0; i < t->n_samples && !co_cancel_is_due(s->cancel); i++) {
        lane S[CO_JET][3], S_bar[CO_JET][3];
        sample_state state;
        sample_values value = {0};
        reader_advance(&r, form, order, s->gradient ? 1 + s->area_gradient : 0);
        read_jets(&r, form, first, last, S);
        forward_second(S, &state, &value);
        if (third) {
            forward_third(S, &state);
            forward_invariants(&state, s->eps4, &value);
        }
        accumulate(t, i, third, &state, &value, sums);
        if (third && s->jump)
            sums[CO_SUM_JUMP] += umbilic_jump(&state, &value, s->eps4, t->weight[i] * state.J);
        if (s->volume) {
            if (!plane)
                read_jets(&r, form, 0, 0, S);
            from_origin(S[0], offset, place);
            sums[CO_INT_VOLUME] += volume_value(place, state.n, t->area_weight[i] * state.J);
        }
        if (!s->gradient)
            continue;
        lane density = density_of(&s->integrand, third, &value);
        adjoint_sample(S, &state, &s->integrand, s->eps4, third, t->weight[i], s->integrand.area * t->area_weight[i],
                       density, S_bar);
        memset(S_bar[0], 0, sizeof S_bar[0]);
        if (volume_gradient)
            add_volume_adjoint(place, S, s->integrand.volume * t->area_weight[i], S_bar);
        scatter_jets(&r, form, S, S_bar, first, last);
        if (volume_gradient && !plane)
            scatter_jets(&r, form, S, S_bar, 0, 0);
        if (s->area_gradient && !plane) {
            area_adjoint(S, &state, lane_all(t->area_weight[i]), 1, 2, S_bar);
            scatter_area(&r, form, S_bar);
        }
        scatter_strip(&r, form, order, s->area_gradient);
    }
    if (plane && s->gradient)
        plane_end(t, &r.plane, b->G);
}

/* The area's gradient on `plane`, whose V and n_V need an adjoint of their own: all samples once more. */
CO_SIMD_INLINE void integrate_plane_area(const co_element_block *s, const block *b) {
    const co_basis_table *t = s->table;
    const block of_area = {.P = b->P, .G = b->G_area};
    reader r;
    reader_begin(&r, OF_PLANE, t, &of_area);
    for (int32_t i = 0; i < t->n_samples && !co_cancel_is_due(s->cancel); i++) {
        lane S[CO_JET][3], S_bar[CO_JET][3];
        sample_state state;
        sample_values value;
        reader_advance(&r, OF_PLANE, 2, 1);
        read_jets(&r, OF_PLANE, 0, 9, S);
        forward_second(S, &state, &value);
        area_adjoint(S, &state, lane_all(t->area_weight[i]), 0, CO_JET - 1, S_bar);
        scatter_jets(&r, OF_PLANE, S, S_bar, 0, 9);
    }
    plane_end(t, &r.plane, b->G_area);
}

/* Area and volume alone, which need first derivatives only, and their gradients. `form` is a constant where this is
 * called. */
CO_SIMD_INLINE void integrate_first_order(const co_element_block *s, const block *b, table_form form,
                                          lane sums[CO_N_SUMS]) {
    const co_basis_table *t = s->table;
    const int last = form == OF_PLANE ? 9 : 2;
    lane offset[3];
    reader r;
    volume_offset(s->points, s->xyz, offset);
    reader_begin(&r, form, t, b);
    for (int32_t i = 0; i < t->n_samples && !co_cancel_is_due(s->cancel); i++) {
        const double weight = t->area_weight[i];
        lane S[CO_JET][3], S_bar[CO_JET][3], place[3], normal[3];
        reader_advance(&r, form, 1, s->gradient);
        read_jets(&r, form, 0, last, S);
        from_origin(S[0], offset, place);
        lane_cross(S[1], S[2], normal);
        const lane J = lane_sqrt(lane_dot(normal, normal));
        sums[CO_INT_VOLUME] += volume_value(place, normal, lane_all(weight));
        sums[CO_INT_AREA] += weight * J;
        if (!s->gradient)
            continue;
        memset(S_bar, 0, sizeof S_bar);
        add_volume_adjoint(place, S, s->integrand.volume * weight, S_bar);
        add_area_adjoint(S, normal, s->integrand.area * weight / J, S_bar);
        scatter_jets(&r, form, S, S_bar, 0, last);
        scatter_strip(&r, form, 1, 0);
    }
    if (form == OF_PLANE && s->gradient)
        plane_end(t, &r.plane, b->G);
}

static void run_first_order(const co_element_block *s, const block *b, lane sums[CO_N_SUMS]) {
    switch (form_of(s->table)) {
    case OF_ROWS:
        integrate_first_order(s, b, OF_ROWS, sums);
        break;
    case OF_PLANE:
        integrate_first_order(s, b, OF_PLANE, sums);
        break;
    case OF_STRIPS:
        integrate_first_order(s, b, OF_STRIPS, sums);
        break;
    }
}

static void store(const co_element_block *s, const block *b, const lane sums[CO_N_SUMS]) {
    memcpy(s->sums, sums, sizeof(lane) * CO_N_SUMS);
    if (!s->gradient)
        return;
    double *out = s->gradients;
    for (int32_t p = 0; p < s->table->n_points; p++) {
        memcpy(out, b->G[p], sizeof b->G[p]);
        out += 3 * CO_LANES;
        if (s->area_gradient) {
            memcpy(out, b->G_area[p], sizeof b->G_area[p]);
            out += 3 * CO_LANES;
        }
    }
}

/* On surfaces other than `plane`. `third` is a constant where this is called. */
CO_SIMD_INLINE void integrate_linear(const co_element_block *s, const block *b, int third, lane sums[CO_N_SUMS]) {
    if (s->table->side)
        integrate_samples(s, b, third, OF_STRIPS, sums);
    else
        integrate_samples(s, b, third, OF_ROWS, sums);
}

static void run_energies(const co_element_block *s, const block *b, lane sums[CO_N_SUMS]) {
    if (s->table->blend) {
        integrate_samples(s, b, 1, OF_PLANE, sums);
        if (s->gradient && s->area_gradient)
            integrate_plane_area(s, b);
    } else if (s->third) {
        integrate_linear(s, b, 1, sums);
    } else {
        integrate_linear(s, b, 0, sums);
    }
}

/* One part of a block: L faces. */
static void run_part(const co_element_block *s) {
    size_t n = (size_t)s->table->n_points;
    block b = {.P = (lane(*)[3])(void *)s->work};
    b.G = b.P + n;
    b.G_area = b.G + n;
    lane sums[CO_N_SUMS];
    memset(sums, 0, sizeof sums);
    sums[CO_SUM_MIN_JACOBIAN] = lane_all(1e300);
    gather(s->table->n_points, s->points, s->xyz, b.P);
    if (s->gradient)
        memset(b.G, 0, sizeof *b.G * (s->area_gradient ? 2 : 1) * n);
    if (s->first_order)
        run_first_order(s, &b, sums);
    else
        run_energies(s, &b, sums);
    sums[CO_SUM_MEAN_JACOBIAN] *= 1.0 / s->table->n_samples;
    store(s, &b, sums);
}

/* A block's part, from the first: its table is the block's, from the part's rows on if it is mixed. */
static co_basis_table table_of_part(const co_basis_table *t, size_t part) {
    co_basis_table of_part = *t;
    if (t->is_mixed)
        of_part.rows += part * (size_t)t->n_samples * (size_t)t->n_points * CO_JET * CO_LANES;
    return of_part;
}

static void run(const co_element_block *s) {
    const size_t n = (size_t)s->table->n_points;
    for (size_t part = 0; part * CO_LANES < (size_t)s->n_used; part++) {
        const co_basis_table table = table_of_part(s->table, part);
        co_element_block of_part = *s;
        of_part.table = &table;
        of_part.points += part * n * CO_LANES;
        of_part.sums += part * CO_N_SUMS * CO_LANES;
        if (s->gradient)
            of_part.gradients += part * n * 3 * (s->area_gradient ? 2 : 1) * CO_LANES;
        run_part(&of_part);
    }
}

/* ---------------------------------------------------------------------------------- second derivatives -- */

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
