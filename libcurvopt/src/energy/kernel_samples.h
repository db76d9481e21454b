/* Sums over the samples of a block's faces: energies, and their gradients. Included once per instruction set and
 * precision, by element_kernel.c and element_kernel_single.c, as are the headers that it includes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KERNEL_SAMPLES_H
#define CO_ENERGY_KERNEL_SAMPLES_H

#include "energy/element_block.h"
#include "energy/kernel_plane.h"
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
    strip_begin(side_of_table(r->table) + 16 * (r->sample / r->table->n_side), order, r->b->P, r->points);
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
        strip_jets(side_of_table(t) + 16 * r->at_side, r->points, first, last, S);
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
        strip_scatter(side_of_table(t) + 16 * r->at_side, S_bar, first, last, r->bar);
    else
        transpose_jets(rows_of(t, r->sample), t->is_mixed, t->n_points, S_bar, first, last, 1, r->b->G);
}

/* Likewise for the area, not on `plane`. */
CO_SIMD_INLINE void scatter_area(reader *r, table_form form, lane S_bar[CO_JET][3]) {
    const co_basis_table *t = r->table;
    if (form == OF_STRIPS)
        strip_scatter(side_of_table(t) + 16 * r->at_side, S_bar, 1, 2, r->area_bar);
    else
        transpose_jets(rows_of(t, r->sample), t->is_mixed, t->n_points, S_bar, 1, 2, 1, r->b->G_area);
}

/* At the end of a sample: if it is the last of its strip, the strip's adjoints go to the points' gradients. `order` as
 * of reader_advance(); area: the area's as well. */
CO_SIMD_INLINE void scatter_strip(reader *r, table_form form, int order, int area) {
    const co_basis_table *t = r->table;
    if (form != OF_STRIPS || r->at_side + 1 < t->n_side)
        return;
    strip_end(side_of_table(t) + 16 * (r->sample / t->n_side), order, r->bar, r->b->G);
    if (area)
        strip_end(side_of_table(t) + 16 * (r->sample / t->n_side), 1, r->area_bar, r->b->G_area);
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
    const lane weight = lane_scaled(t->weight[sample], m->J), jacobian = lane_scaled(t->jacobian_scale[sample], m->J);
    sums[CO_INT_AREA] += lane_scaled(t->area_weight[sample], m->J);
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
    lane density =
        lane_scaled(w->h2, value->h2) + (lane_scaled(w->gauss, value->gauss) + lane_scaled(w->mean, value->mean));
    if (third)
        density =
            lane_scaled(w->f1, value->f1) + (lane_scaled(w->f3, value->f3) + (lane_scaled(w->x, value->x) + density));
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
            forward_invariants(&state, (real)s->eps4, &value);
        }
        accumulate(t, i, third, &state, &value, sums);
        if (third && s->jump)
            sums[CO_SUM_JUMP] += umbilic_jump(&state, &value, (real)s->eps4, lane_scaled(t->weight[i], state.J));
        if (s->volume) {
            if (!plane)
                read_jets(&r, form, 0, 0, S);
            from_origin(S[0], offset, place);
            sums[CO_INT_VOLUME] += volume_value(place, state.n, lane_scaled(t->area_weight[i], state.J));
        }
        if (!s->gradient)
            continue;
        lane density = density_of(&s->integrand, third, &value);
        adjoint_sample(S, &state, &s->integrand, (real)s->eps4, third, (real)t->weight[i],
                       (real)(s->integrand.area * t->area_weight[i]), density, S_bar);
        memset(S_bar[0], 0, sizeof S_bar[0]);
        if (volume_gradient)
            add_volume_adjoint(place, S, s->integrand.volume * t->area_weight[i], S_bar);
        scatter_jets(&r, form, S, S_bar, first, last);
        if (volume_gradient && !plane)
            scatter_jets(&r, form, S, S_bar, 0, 0);
        if (s->area_gradient && !plane) {
            area_adjoint(S, &state, lane_all((real)t->area_weight[i]), 1, 2, S_bar);
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
        area_adjoint(S, &state, lane_all((real)t->area_weight[i]), 0, CO_JET - 1, S_bar);
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
        sums[CO_INT_VOLUME] += volume_value(place, normal, lane_all((real)weight));
        sums[CO_INT_AREA] += lane_scaled(weight, J);
        if (!s->gradient)
            continue;
        memset(S_bar, 0, sizeof S_bar);
        add_volume_adjoint(place, S, s->integrand.volume * weight, S_bar);
        add_area_adjoint(S, normal, (real)(s->integrand.area * weight) / J, S_bar);
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
    const size_t n = (size_t)s->table->n_points, own = 3 * CO_LANES, stride = s->area_gradient ? 2 * own : own;
    lane_store(sums, CO_N_SUMS, s->sums);
    for (size_t p = 0; s->gradient && p < n; p++) {
        lane_store(b->G[p], 3, s->gradients + p * stride);
        if (s->area_gradient)
            lane_store(b->G_area[p], 3, s->gradients + p * stride + own);
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
    sums[CO_SUM_MIN_JACOBIAN] = lane_all(1 / CO_REAL_TINY);
    gather(s->table->n_points, s->points, s->xyz, b.P);
    if (s->gradient)
        memset(b.G, 0, sizeof *b.G * (s->area_gradient ? 2 : 1) * n);
    if (s->first_order)
        run_first_order(s, &b, sums);
    else
        run_energies(s, &b, sums);
    sums[CO_SUM_MEAN_JACOBIAN] *= (real)(1.0 / s->table->n_samples);
    store(s, &b, sums);
}

/* A block's part, from the first: its table is the block's, from the part's rows on if it is mixed. */
static co_basis_table table_of_part(const co_basis_table *t, size_t part) {
    co_basis_table of_part = *t;
    const size_t skipped = part * (size_t)t->n_samples * (size_t)t->n_points * CO_JET * CO_LANES;
    if (t->is_mixed)
#ifdef CO_SINGLE
        of_part.single_rows += skipped;
#else
        of_part.rows += skipped;
#endif
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

#endif
