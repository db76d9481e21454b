/* Numbers of the surface that are held on a level. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/held_level.h"

#include "base/memory.h"
#include "energy/assembly_sums.h"
#include "linalg/small_dense.h"
#include "linalg/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Relative distance from a target that is none, and one from which a step leads to where rounding lets nothing better
 * be had. */
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
    out->centred = CO_NEW(double, n);
    if (out->newton.way && out->back && out->gradient && out->work && out->centred)
        return CURVOPT_OK;
    co_held_level_free(out);
    return co_status_no_memory(error);
}

void co_held_level_free(co_held_level *h) {
    free(h->newton.way);
    free(h->back);
    free(h->gradient);
    free(h->work);
    free(h->centred);
    *h = (co_held_level){0};
}

static void remove_translations(const co_held_level *h, double *v) {
    if (h->dofs->translation) /* else something is in its place */
        co_vector_remove(n_of(h), 3, h->dofs->translation, v);
}

/* Places the surface at x, with its centroid where the energy has it: by a rule of quadrature faces close up only
 * nearly, and the volume that they have depends on where they are. */
static void place(co_held_level *h, const double *x) {
    memcpy(h->centred, x, n_of(h) * sizeof *x);
    remove_translations(h, h->centred);
    co_dof_map_expand_some(h->dofs, h->assembly->active, h->assembly->n_active_cage, h->centred, h->positions);
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
    for (int k = 0; k < h->numbers.n; k++)
        remove_translations(h, h->gradient + (size_t)k * n);
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

/* The ways become combinations of themselves by which one constraint changes each, as much as it moves: smooth ones of
 * two numbers may nearly be the same. Where constraints have no slope along them they stay. */
static void separate_ways(co_held_level *h) {
    const int count = h->numbers.n;
    const size_t n = n_of(h);
    square along, inverse;
    find_along(h);
    memcpy(along, h->along, sizeof along);
    co_small_dense_invert(count, CURVOPT_N_SCALARS, along[0], inverse[0]);
    for (int k = 0; k < count; k++)
        if (!(largest(count, inverse[k]) < INFINITY))
            return;
    for (size_t i = 0; i < n; i++) {
        double of_all[CURVOPT_N_SCALARS] = {0};
        for (int k = 0; k < count; k++)
            for (int l = 0; l < count; l++)
                of_all[k] += h->newton.way[(size_t)l * n + i] * inverse[l][k];
        for (int k = 0; k < count; k++)
            h->newton.way[(size_t)k * n + i] = of_all[k];
    }
    find_along(h);
}

/* Largest change of a constraint, relative, that counts for rounding when every variable moves by the cage's size. */
static const double ROUNDING = 1e-10;

static int moves_nothing(const co_held_level *h, const double *x) {
    const size_t n = n_of(h);
    const double size = co_vector_norm(n, x);
    for (int k = 0; k < h->numbers.n; k++)
        if (co_vector_norm(n, h->gradient + (size_t)k * n) * size <= ROUNDING)
            return 1;
    return 0;
}

void co_held_level_choose_ways(co_held_level *h, const double *x) {
    double integral[CO_N_INTEGRALS];
    place(h, x);
    co_assembly_numbers(h->assembly, h->positions, co_held_numbers_has_mean(&h->numbers), integral);
    find_gradients(h, integral, 1);
    h->is_idle = moves_nothing(h, x);
    memcpy(h->newton.way, h->gradient, (size_t)h->numbers.n * n_of(h) * sizeof *h->gradient);
    separate_ways(h);
}

void co_held_level_straighten_ways(co_held_level *h, const double *x) {
    const co_dof_map *r = h->dofs;
    const co_assembly *a = h->assembly;
    double *normal = h->work;
    place(h, x);
    co_assembly_place(h->assembly, h->positions, 1);
    co_assembly_number_gradient(h->assembly, CURVOPT_SCALAR_VOLUME, h->point_gradient);
    co_dof_map_gradient_of(r, a->active, a->n_active_cage, h->point_gradient, normal);
    for (int k = 0; k < h->numbers.n; k++) {
        for (int32_t node = 0; node < r->n_nodes; node++) {
            const size_t first = (size_t)r->first[node], size = (size_t)co_dof_map_dimension(r, node);
            double *way = h->newton.way + (size_t)k * n_of(h) + first;
            const double square = co_vector_dot(size, normal + first, normal + first);
            const double part = square > 0 ? co_vector_dot(size, way, normal + first) / square : 0;
            for (size_t i = 0; i < size; i++)
                way[i] = part * normal[first + i];
        }
        remove_translations(h, h->newton.way + (size_t)k * n_of(h));
    }
    separate_ways(h);
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

/* Longest displacement of a vertex by t. */
static double length_of(const co_held_level *h, const double *t) {
    const size_t n = n_of(h);
    double *step = h->gradient + (size_t)h->numbers.n * n;
    memset(step, 0, n * sizeof *step);
    for (int k = 0; k < h->numbers.n; k++)
        co_vector_add(n, t[k], h->newton.way + (size_t)k * n, step);
    return co_dof_map_longest(h->dofs, step);
}

/* Broyden's update: what the last step t should have changed c by, and did. */
static void update_slope(int n, square slope, const double *before, const double *c, const double *t) {
    double length = 0;
    for (int k = 0; k < n; k++)
        length += t[k] * t[k];
    for (int k = 0; k < n; k++) {
        double missed = c[k] - before[k];
        for (int l = 0; l < n; l++)
            missed -= slope[k][l] * t[l];
        for (int l = 0; l < n; l++)
            slope[k][l] += missed * t[l] / length;
    }
}

int co_held_level_go_back(co_held_level *h, const double *x, double most) {
    const int count = h->numbers.n;
    const size_t n = n_of(h);
    double c[CURVOPT_N_SCALARS] = {0}, before[CURVOPT_N_SCALARS], t[CURVOPT_N_SCALARS] = {0}, total = 0;
    int is_good = 0;
    square slope; /* of c by t */
    memcpy(slope, h->along, sizeof slope);
    memcpy(h->back, x, n * sizeof *x);
    for (int trial = 0; trial < MOST_TRIALS; trial++) {
        memcpy(before, c, sizeof before);
        co_held_level_residuals(h, h->back, c);
        const double off = largest(count, c);
        if (off <= EXACT || (is_good && off <= GOOD))
            return 1;
        if (!(off < INFINITY))
            return 0;
        is_good = off <= GOOD; /* one more step; of what that changes nothing is learnt but rounding */
        if (trial > 0 && !is_good)
            update_slope(count, slope, before, c, t);
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
