/* Points of a cage's surface and their derivatives, anywhere on it.
 *
 * The surface `plane` is computed here a second time, beside element_kernel.c: there on vectors of doubles and with its
 * adjoint, at tabulated points; here at any point and without adjoint. A common routine would be
 * neither as fast as the one nor as exact as the other, and tests hold the two against each other (test_evaluate.c).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/evaluate.h"

#include "base/memory.h"
#include "surface/basis_point.h"

#include <math.h>
#include <stdlib.h>

void co_sampler_free(co_sampler *s) {
    co_patches_free(&s->patches);
    free(s->points);
    free(s->first);
    free(s->next);
    free(s->rows);
    co_basis_table_cache_free(&s->tables);
}

int32_t co_sampler_create(const curvopt_mesh *mesh, const double *xyz, int32_t surface, int blend_width, co_sampler *s,
                          curvopt_error *error) {
    *s = (co_sampler){.n_faces = mesh->info.n_faces, .surface = surface};
    co_basis_table_cache_create(surface, &s->tables);
    int32_t status = co_patches_create(mesh, xyz, NULL, surface, blend_width, NULL, &s->patches, error), largest = 0;
    if (status != CURVOPT_OK)
        return status;
    const co_patches *p = &s->patches;
    for (int32_t i = 0; i < p->n_patches; i++) {
        int32_t size = co_patches_size(p->kind[i]);
        largest = size > largest ? size : largest;
    }
    s->points = CO_NEW(double, 3 * (size_t)p->n_points);
    s->first = CO_NEW(int32_t, mesh->info.n_faces);
    s->next = CO_NEW(int32_t, p->n_patches);
    s->rows = CO_NEW(double, (size_t)largest *CO_JET);
    if (!s->points || !s->first || !s->next || !s->rows) {
        co_sampler_free(s);
        return co_status_no_memory(error);
    }
    for (size_t i = 0; i < 3 * (size_t)p->n_cage; i++)
        s->points[i] = xyz[i];
    co_patches_derive(p, s->points);
    for (int32_t f = 0; f < mesh->info.n_faces; f++)
        s->first[f] = -1;
    for (int32_t i = p->n_patches - 1; i >= 0; i--) {
        s->next[i] = s->first[p->place[i].face];
        s->first[p->place[i].face] = i;
    }
    return CURVOPT_OK;
}

int co_evaluate_to_patch(const co_place *place, const double uv[2], double st[2]) {
    double scale = 1.0 / (1 << place->level), x = (uv[0] - place->origin[0]) / scale;
    double y = (uv[1] - place->origin[1]) / scale;
    for (int turn = 0; turn < place->rotation; turn++) {
        double old_x = x;
        x = y;
        y = -old_x;
    }
    st[0] = x;
    st[1] = y;
    return x >= 0 && x <= 1 && y >= 0 && y <= 1;
}

void co_evaluate_to_face(const co_place *place, int n, const double *along_st, double *along_uv) {
    static const int swaps[4] = {0, 1, 0, 1}, sign_u[4] = {1, -1, -1, 1}, sign_v[4] = {1, 1, -1, -1};
    const int r = place->rotation;
    for (int k = 0; k < n; k++) {
        const int p = co_jet_order_u[k], q = co_jet_order_v[k], order = p + q;
        const int from = swaps[r] ? co_jet_index(q, p) : co_jet_index(p, q);
        const double factor = (p % 2 ? sign_u[r] : 1) * (q % 2 ? sign_v[r] : 1) * ldexp(1, place->level * order);
        along_uv[k] = factor * along_st[from];
    }
}

static void to_face(const co_place *place, double jet[3][CO_JET], double *out) {
    double along_uv[CO_JET];
    for (int c = 0; c < 3; c++) {
        co_evaluate_to_face(place, CO_JET, jet[c], along_uv);
        for (int k = 0; k < CO_JET; k++)
            out[3 * k + c] = along_uv[k];
    }
}

static void limit_frame(const double *points, const int32_t *index, int32_t valence, const double *masks,
                        double position[3], double normal[3]) {
    int32_t n = co_ring_two_ring_size(valence);
    double sum[3][3] = {{0}};
    for (int m = 0; m < 3; m++)
        for (int32_t i = 0; i < n; i++)
            for (int c = 0; c < 3; c++)
                sum[m][c] += masks[m * n + i] * points[3 * (size_t)index[i] + (size_t)c];
    double length = 0;
    for (int c = 0; c < 3; c++) {
        int d = (c + 1) % 3, e = (c + 2) % 3;
        position[c] = sum[0][c];
        normal[c] = sum[1][d] * sum[2][e] - sum[1][e] * sum[2][d];
        length += normal[c] * normal[c];
    }
    for (int c = 0; c < 3; c++)
        normal[c] /= sqrt(length);
}

/* S' = S - w ((S - V).n) n, jet by jet. */
static int32_t flatten(const co_sampler *s, int32_t p, const double *weight, double jet[3][CO_JET],
                       curvopt_error *error) {
    int32_t valence = s->patches.kind[p]; /* the kind of a closed smooth fan */
    double *masks = CO_NEW(double, 3 * (size_t)co_ring_two_ring_size(valence));
    double position[3], normal[3];
    double height[CO_JET], product[CO_JET];
    if (!masks)
        return co_status_no_memory(error);
    co_stam_limit_masks(valence, masks);
    limit_frame(s->points, s->patches.points + s->patches.start[p], valence, masks, position, normal);
    free(masks);
    for (int k = 0; k < CO_JET; k++) {
        double sum = 0;
        for (int c = 0; c < 3; c++)
            sum += (jet[c][k] - (k == 0 ? position[c] : 0)) * normal[c];
        height[k] = sum;
    }
    co_jet_multiply(weight, height, product);
    for (int k = 0; k < CO_JET; k++)
        for (int c = 0; c < 3; c++)
            jet[c][k] -= product[k] * normal[c];
    return CURVOPT_OK;
}

static int32_t sample_patch(co_sampler *s, int32_t p, const double st[2], double *out, curvopt_error *error) {
    double weight[CO_JET];
    int32_t kind = s->patches.kind[p];
    int32_t status = co_basis_point(&s->tables, kind, st[0], st[1], s->rows, weight, error);
    if (status != CURVOPT_OK)
        return status;
    const int32_t *index = s->patches.points + s->patches.start[p];
    double jet[3][CO_JET];
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < CO_JET; k++) {
            jet[c][k] = 0;
            for (int32_t i = 0; i < co_patches_size(kind); i++)
                jet[c][k] += s->rows[i * CO_JET + k] * s->points[3 * (size_t)index[i] + (size_t)c];
        }
    if (co_blend_fit_surface(s->surface, kind) == CURVOPT_SURFACE_PLANE)
        status = flatten(s, p, weight, jet, error);
    to_face(&s->patches.place[p], jet, out);
    return status;
}

/* The patch of face and corner with (u, v) in it, and its own (s, t); -1 if there is none. */
static int32_t find_patch(const co_sampler *s, int32_t face, int32_t corner, const double *uv, double st[2]) {
    int32_t p = s->first[face];
    while (p >= 0 && !(s->patches.place[p].quarter == corner && co_evaluate_to_patch(&s->patches.place[p], uv, st)))
        p = s->next[p];
    return p;
}

int32_t co_sampler_jets(co_sampler *s, int32_t n, const int32_t *face, const int32_t *corner, const double *uv,
                        double *jets, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    for (int32_t i = 0; status == CURVOPT_OK && i < n; i++) {
        double st[2];
        const double *at = uv + 2 * (size_t)i;
        if (face[i] < 0 || face[i] >= s->n_faces)
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "point %d: face %d of %d", i, face[i], s->n_faces);
        int32_t p = find_patch(s, face[i], corner[i], at, st);
        if (p < 0)
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                                  "point %d: corner %d, u = %g, v = %g is not on face %d", i, corner[i], at[0], at[1],
                                  face[i]);
        status = sample_patch(s, p, st, jets + 30 * (size_t)i, error);
    }
    return status;
}
