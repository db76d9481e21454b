/* Numbers of the surface that are held on a level. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/held_level.h"

#include "base/memory.h"
#include "linalg/small_dense.h"
#include "linalg/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Relative distance from a target that is none, and one that stands where rounding lets nothing better be had. */
static const double EXACT = 1e-13, GOOD = 1e-11;
/* Longest step on the way back, in parts of the longest way: near a sphere, which has the most volume of all, the first
 * one is much too long. */
static const double LONGEST = 0.25;
/* Evaluations on the way back. */
enum { MOST_TRIALS = 25 };

typedef double square[CURVOPT_N_SCALARS][CURVOPT_N_SCALARS];

static size_t n_of(const co_held_level *h) {
    return (size_t)h->dofs->n_variables;
}

int32_t co_held_level_create(const co_held_numbers *numbers, const co_dof_map *dofs, co_assembly *assembly,
                             double *positions, double *point_gradient, co_held_level *out, curvopt_error *error) {
    const size_t n = (size_t)dofs->n_variables, count = (size_t)numbers->n;
    *out = (co_held_level){.numbers = *numbers,
                           .dofs = dofs,
                           .assembly = assembly,
                           .positions = positions,
                           .point_gradient = point_gradient};
    if (!count)
        return CURVOPT_OK;
    out->newton = (co_newton_held){.numbers = &out->numbers, .way = CO_NEW(double, count *n)};
    out->back = CO_NEW(double, n);
    out->gradient = CO_NEW(double, (count + 1) * n);
    out->work = CO_NEW(double, n);
    if (out->newton.way && out->back && out->gradient && out->work)
        return CURVOPT_OK;
    co_held_level_free(out);
    return co_status_no_memory(error);
}

void co_held_level_free(co_held_level *h) {
    free(h->newton.way);
    free(h->back);
    free(h->gradient);
    free(h->work);
    *h = (co_held_level){0};
}

static void place(co_held_level *h, const double *x) {
    co_dof_map_expand_some(h->dofs, h->assembly->active, h->assembly->n_active_cage, x, h->positions);
}

static void find_along(co_held_level *h) {
    const size_t n = n_of(h);
    for (int k = 0; k < h->numbers.n; k++)
        for (int l = 0; l < h->numbers.n; l++)
            h->along[k][l] = co_vector_dot(n, h->gradient + (size_t)k * n, h->newton.way + (size_t)l * n);
}

/* A, of surfaces that the assembly was evaluated at last, and A^T W. */
static void find_gradients(co_held_level *h, const double integral[CO_N_INTEGRALS], double unit) {
    const size_t n = n_of(h);
    const co_assembly *a = h->assembly;
    co_held_residual residual[CURVOPT_N_SCALARS];
    memset(h->gradient, 0, (size_t)h->numbers.n * n * sizeof *h->gradient);
    for (int k = 0; k < h->numbers.n; k++)
        residual[k] = co_held_numbers_residual(&h->numbers, k, integral);
    for (int s = 0; s < CURVOPT_N_SCALARS; s++) {
        double *of_number = h->gradient + (size_t)h->numbers.n * n;
        int is_used = 0;
        for (int k = 0; k < h->numbers.n; k++)
            is_used |= residual[k].slope[s] != 0;
        if (!is_used)
            continue;
        co_assembly_number_gradient(h->assembly, s, h->point_gradient);
        co_dof_map_gradient_of(h->dofs, a->active, a->n_active_cage, h->point_gradient, of_number);
        for (int k = 0; k < h->numbers.n; k++)
            co_vector_add(n, unit * residual[k].slope[s], of_number, h->gradient + (size_t)k * n);
    }
    find_along(h);
}

/* The largest absolute value; INFINITY where one is unknown. */
static double largest(int n, const double *x) {
    double most = 0;
    for (int k = 0; k < n; k++)
        most = isnan(x[k]) ? (double)INFINITY : fmax(most, fabs(x[k]));
    return most;
}

void co_held_level_residuals(co_held_level *h, const double *x, double residual[CURVOPT_N_SCALARS]) {
    double integral[CO_N_INTEGRALS];
    place(h, x);
    co_assembly_numbers(h->assembly, h->positions, co_held_numbers_has_mean(&h->numbers), integral);
    for (int k = 0; k < h->numbers.n; k++)
        residual[k] = co_held_numbers_residual(&h->numbers, k, integral).value;
}

void co_held_level_take_as_targets(co_held_level *h, const double *x) {
    double residual[CURVOPT_N_SCALARS];
    co_held_level_residuals(h, x, residual);
    if (!(largest(h->numbers.n, residual) < INFINITY)) /* no surface, or the run is cancelled */
        return;
    for (int k = 0; k < h->numbers.n; k++)
        h->numbers.held[k].target += residual[k] * h->numbers.held[k].unit;
}

void co_held_level_choose_ways(co_held_level *h, const double *x) {
    const size_t n = n_of(h);
    double integral[CO_N_INTEGRALS];
    place(h, x);
    co_assembly_numbers(h->assembly, h->positions, co_held_numbers_has_mean(&h->numbers), integral);
    find_gradients(h, integral, 1);
    memcpy(h->newton.way, h->gradient, (size_t)h->numbers.n * n * sizeof *h->gradient);
    co_held_level_normalize_ways(h);
}

void co_held_level_normalize_ways(co_held_level *h) {
    const size_t n = n_of(h);
    for (int k = 0; k < h->numbers.n; k++) {
        double *way = h->newton.way + (size_t)k * n;
        const double length = co_vector_norm(n, way);
        for (size_t i = 0; i < n; i++)
            way[i] /= length;
    }
    find_along(h);
}

/* solution = a^-1 right, of n rows. */
static void solve(int n, square a, const double *right, double *solution) {
    square copy, inverse;
    memcpy(copy, a, sizeof copy);
    co_small_dense_invert(n, CURVOPT_N_SCALARS, copy[0], inverse[0]);
    for (int k = 0; k < n; k++) {
        solution[k] = 0;
        for (int l = 0; l < n; l++)
            solution[k] += inverse[k][l] * right[l];
    }
}

/* Longest displacement of a vertex by t at most. */
static double length_of(const co_held_level *h, const double *t) {
    double sum = 0;
    for (int k = 0; k < h->numbers.n; k++)
        sum += fabs(t[k]) * co_dof_map_longest(h->dofs, h->newton.way + (size_t)k * n_of(h));
    return sum;
}

int co_held_level_go_back(co_held_level *h, const double *x, double most) {
    const int count = h->numbers.n;
    const size_t n = n_of(h);
    double c[CURVOPT_N_SCALARS] = {0}, before[CURVOPT_N_SCALARS], t[CURVOPT_N_SCALARS] = {0}, total = 0;
    square slope; /* of c by t */
    memcpy(slope, h->along, sizeof slope);
    memcpy(h->back, x, n * sizeof *x);
    for (int trial = 0; trial < MOST_TRIALS; trial++) {
        memcpy(before, c, sizeof before);
        co_held_level_residuals(h, h->back, c);
        const double off = largest(count, c);
        if (off <= EXACT || (trial > 0 && off <= GOOD && off >= 0.5 * largest(count, before)))
            return 1;
        if (!(off < INFINITY))
            return 0;
        double square_of_step = 0;
        for (int k = 0; trial > 0 && k < count; k++)
            square_of_step += t[k] * t[k];
        for (int k = 0; trial > 0 && k < count; k++) { /* Broyden's: what the last step should have done, and did */
            double missed = c[k] - before[k];
            for (int l = 0; l < count; l++)
                missed -= slope[k][l] * t[l];
            for (int l = 0; l < count; l++)
                slope[k][l] += missed * t[l] / square_of_step;
        }
        solve(count, slope, c, t);
        const double length = length_of(h, t);
        const double scale = length > LONGEST * most ? LONGEST * most / length : 1;
        total += scale * length;
        if (!(total <= most))
            return 0;
        for (int k = 0; k < count; k++) {
            t[k] *= -scale;
            co_vector_add(n, t[k], h->newton.way + (size_t)k * n, h->back);
        }
    }
    return 0;
}

void co_held_level_reduce_gradient(co_held_level *h, const double integral[CO_N_INTEGRALS], double unit,
                                   double *gradient) {
    const int count = h->numbers.n;
    const size_t n = n_of(h);
    double along[CURVOPT_N_SCALARS];
    square transposed = {{0}};
    find_gradients(h, integral, unit);
    for (int k = 0; k < count; k++) {
        along[k] = -co_vector_dot(n, h->newton.way + (size_t)k * n, gradient);
        for (int l = 0; l < count; l++)
            transposed[k][l] = h->along[l][k];
    }
    solve(count, transposed, along, h->newton.multiplier);
    for (int k = 0; k < count; k++)
        co_vector_add(n, h->newton.multiplier[k], h->gradient + (size_t)k * n, gradient);
}
