/* Curvatures of the surface at points. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/held_curvatures.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "constraints/freedom.h"
#include "linalg/small_dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Least sine of the angle between tangents, by rounding: below, there is no tangent plane. */
static const double LEAST_SINE = 1e-9;

/* Values of an entry: tangents, then second derivatives. */
enum { N_TANGENTS = 2, N_SECOND = 3 };

int co_held_curvatures_exist(const co_surface_values *fs) {
    int any = 0;
    for (int32_t i = 0; i < fs->n; i++)
        any |= fs->item[i].order == 2;
    return any;
}

/* Tangents t = [S_u, S_v], from which curvatures and cage both move: t is t_0 + P d, with P the projector onto what
 * their freedom leaves, and d least in
 *
 *     |d|^2 / |r_T|^2  +  sum over S_ab of (n . S_ab - wanted by t)^2 / |r_ab|^2 ,
 *
 * S_ab of the cage as it is, r the rows: about how far vertices move. */
typedef struct fit {
    const co_surface_value *tangent, *second; /* [2], [3] */
    double first[6];                          /* t_0 */
    double now[N_SECOND];                     /* n . S_ab */
    double weight[N_TANGENTS + N_SECOND];     /* of the squares */
    double side;                              /* 1 where the entry's normal is on the faces' side, else -1 */
} fit;

/* Steps at most, and halvings of each. */
enum { MOST_STEPS = 30, MOST_HALVINGS = 30 };
/* A step that lowers the sum by no more than this part is the last. */
static const double ENOUGH = 1e-6;
/* Part of the area between tangents that is left at least; .01 and .1 were tried (note 120). */
static const double LEAST_AREA = 0.1;

/* Which two tangents a second derivative is by. */
static const int of_second[N_SECOND][2] = {{0, 0}, {0, 1}, {1, 1}};

/* n . S_ab by tangents t. */
static double wanted_second(const fit *at, int k, const double t[6]) {
    double form[3];
    co_small_dense_apply_3(at->second->curvature, t + 3 * of_second[k][1], form);
    return -at->side * co_dot3(t + 3 * of_second[k][0], form);
}

/* n . (S_u x S_v) */
static double area_of(const fit *at, const double t[6]) {
    double across[3];
    co_cross3(t, t + 3, across);
    return co_dot3(across, at->second->direction);
}

/* t = t_0 + P d */
static void move_tangents(const fit *at, const double d[6], double t[6]) {
    for (size_t k = 0; k < N_TANGENTS; k++) {
        double left[9], moved[3];
        co_freedom_projector(at->tangent[k].freedom, at->tangent[k].direction, left);
        co_small_dense_apply_3(left, d + 3 * k, moved);
        for (size_t c = 0; c < 3; c++)
            t[3 * k + c] = at->first[3 * k + c] + moved[c];
    }
}

/* The sum that is to be least; infinite where tangents come too near to each other. */
static double sum_at(const fit *at, const double d[6]) {
    double t[6], sum = 0;
    move_tangents(at, d, t);
    if (!(area_of(at, t) * at->side > LEAST_AREA * area_of(at, at->first) * at->side))
        return (double)INFINITY;
    for (size_t k = 0; k < N_TANGENTS; k++)
        sum += at->weight[k] * co_dot3(d + 3 * k, d + 3 * k);
    for (int k = 0; k < N_SECOND; k++) {
        const double off = wanted_second(at, k, t) - at->now[k];
        sum += at->weight[N_TANGENTS + k] * off * off;
    }
    return sum;
}

/* Derivative by d of what is wanted of second derivative k. */
static void differentiate(const fit *at, int k, const double t[6], double slope[6]) {
    double left[9], form[3], part[3];
    memset(slope, 0, 6 * sizeof *slope);
    for (int end = 0; end < 2; end++) {
        const int own = of_second[k][end], other = of_second[k][!end];
        co_small_dense_apply_3(at->second->curvature, t + 3 * other, form);
        co_freedom_projector(at->tangent[own].freedom, at->tangent[own].direction, left);
        co_small_dense_apply_3(left, form, part);
        for (int c = 0; c < 3; c++)
            slope[3 * own + c] -= at->side * part[c];
    }
}

/* Gauss and Newton's step from d. */
static void make_step(const fit *at, const double d[6], double step[6]) {
    double t[6], slope[6], matrix[36] = {0}, inverse[36], gradient[6];
    move_tangents(at, d, t);
    for (int i = 0; i < 6; i++) {
        matrix[7 * i] = at->weight[i / 3];
        gradient[i] = at->weight[i / 3] * d[i];
    }
    for (int k = 0; k < N_SECOND; k++) {
        const double weight = at->weight[N_TANGENTS + k], off = wanted_second(at, k, t) - at->now[k];
        differentiate(at, k, t, slope);
        for (int i = 0; i < 6; i++) {
            gradient[i] += weight * off * slope[i];
            for (int j = 0; j < 6; j++)
                matrix[6 * i + j] += weight * slope[i] * slope[j];
        }
    }
    co_small_dense_invert(6, 6, matrix, inverse);
    for (int i = 0; i < 6; i++) {
        step[i] = 0;
        for (int j = 0; j < 6; j++)
            step[i] -= inverse[6 * i + j] * gradient[j];
    }
}

/* Goes from t_0 to the least sum, into t. */
static void fit_tangents(const fit *at, double t[6]) {
    double d[6] = {0}, step[6], next[6], sum = sum_at(at, d);
    for (int n = 0; n < MOST_STEPS; n++) {
        double length = 1, found = (double)INFINITY;
        make_step(at, d, step);
        for (int k = 0; k < MOST_HALVINGS && !(found < sum); k++, length /= 2) {
            for (int i = 0; i < 6; i++)
                next[i] = d[i] + length * step[i];
            found = sum_at(at, next);
        }
        if (!(found < sum))
            break;
        const double before = sum;
        sum = found;
        memcpy(d, next, sizeof d);
        if (sum > (1 - ENOUGH) * before)
            break;
    }
    move_tangents(at, d, t);
}

/* The square of the length of row i. */
static double square_of_row(const co_sparse_rows *rows, int32_t i) {
    double sum = 0;
    for (size_t e = rows->start[i]; e < rows->start[i + 1]; e++)
        sum += rows->value[e] * rows->value[e];
    return sum;
}

/* Where less than LEAST_AREA is left between the tangents of what it was between those that were held before, these
 * stay: coarse cages without curvatures have minima with points that are almost singular. */
static void keep_area(fit *at) {
    double before[6];
    for (size_t k = 0; k < N_TANGENTS; k++)
        memcpy(before + 3 * k, at->tangent[k].anchor, 3 * sizeof *before);
    if (fabs(area_of(at, at->first)) < LEAST_AREA * fabs(area_of(at, before)))
        memcpy(at->first, before, sizeof before);
}

/* The values of the entry from number i on, whose values are value [5][3]. */
static int32_t make_fit(const co_surface_values *fs, int32_t i, const double *value, fit *at, curvopt_error *error) {
    const double *normal = fs->item[i + N_TANGENTS].direction;
    *at = (fit){.tangent = &fs->item[i], .second = &fs->item[i + N_TANGENTS], .side = 1};
    for (int k = 0; k < N_TANGENTS + N_SECOND; k++) {
        const double part = co_dot3(value + 3 * k, normal); /* of tangents only rounding */
        at->weight[k] = 1 / square_of_row(&fs->rows, i + k);
        for (int c = 0; c < 3 && k < N_TANGENTS; c++)
            at->first[3 * k + c] = value[3 * k + c] - part * normal[c];
        if (k >= N_TANGENTS)
            at->now[k - N_TANGENTS] = part;
    }
    keep_area(at);
    const double area = area_of(at, at->first);
    at->side = area > 0 ? 1 : -1;
    if (fabs(area) > LEAST_SINE * co_length3(at->first) * co_length3(at->first + 3))
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, at->tangent->number,
                          "entry %d: the surface has no tangent plane there to begin with", at->tangent->number);
}

static int32_t fix_entry(co_surface_values *fs, int32_t i, const double *value, curvopt_error *error) {
    co_surface_value *tangent = &fs->item[i], *second = tangent + N_TANGENTS;
    fit at;
    double t[6];
    int32_t status = make_fit(fs, i, value, &at, error);
    if (status != CURVOPT_OK)
        return status;
    fit_tangents(&at, t);
    for (int k = 0; k < N_TANGENTS; k++) {
        tangent[k].is_fixed = 1;
        memcpy(tangent[k].anchor, t + 3 * k, sizeof tangent[k].anchor);
    }
    for (int k = 0; k < N_SECOND; k++) {
        const double size = wanted_second(&at, k, t);
        second[k].is_fixed = 1;
        for (int c = 0; c < 3; c++)
            second[k].anchor[c] = size * second[k].direction[c];
    }
    return CURVOPT_OK;
}

void co_held_curvatures_release(co_surface_values *fs) {
    for (int32_t i = 0; i < fs->n; i++)
        fs->item[i].is_fixed = 0;
}

int32_t co_held_curvatures_fix(const curvopt_mesh *m, const double *xyz, co_surface_values *fs, curvopt_error *error) {
    double *value = CO_NEW(double, 3 * (size_t)fs->n);
    int32_t status = value ? co_surface_values_make_rows(m, fs, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        co_sparse_rows_apply(&fs->rows, xyz, value);
    for (int32_t i = 0; status == CURVOPT_OK && i < fs->n; i++) {
        if (fs->item[i].order != 2)
            continue;
        status = fix_entry(fs, i - N_TANGENTS, value + 3 * (size_t)(i - N_TANGENTS), error);
        i += N_SECOND - 1;
    }
    free(value);
    return status;
}
