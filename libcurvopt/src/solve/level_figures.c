/* Figures of a level. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level_figures.h"

#include "solve/held_scalars.h"

#include <math.h>

static double size_of(const co_level *l, const curvopt_energies *e) {
    return co_run_size_number(&l->objective.run->size, e->area, e->volume, e->total_mean_curvature);
}

/* Numbers with units as the user sees them. */
static void scale_numbers(const co_level *l, curvopt_energies *energies) {
    const co_run_context *run = l->objective.run;
    int is_framed = l->objective.is_framed;
    const double unit = is_framed ? run->radius : co_run_size_unit(&run->size, size_of(l, energies));
    energies->area_error *= unit * unit;
    energies->area *= unit * unit;
    energies->volume *= unit * unit * unit;
    energies->total_mean_curvature *= unit;
    if (!is_framed && run->size.measure == CURVOPT_SCALAR_AREA)
        energies->area = run->size.value;
}

int co_level_finish_cancelled(co_level *l, double *xyz, curvopt_energies *energies, double *springs) {
    const double *x =
        l->reached && co_level_objective_crosses(&l->objective, l->reached) ? l->review.first : l->reached;
    if (!x)
        return 0;
    co_level_objective_place(&l->objective, x);
    co_level_objective_take_size(&l->objective);
    co_adaptive_quadrature_glance(&l->objective.assembly, l->objective.positions, energies);
    if (!(energies->area > 0))
        return 0;
    co_level_objective_to_user(&l->objective, x, size_of(l, energies), xyz);
    scale_numbers(l, energies);
    *springs = co_penalty_value(&l->objective.penalty, x, NULL);
    return 1;
}

int co_level_glance(co_level *l, const double *xyz, curvopt_energies *energies) {
    co_level_objective_value_of(&l->objective, xyz);
    co_level_objective_take_size(&l->objective);
    co_adaptive_quadrature_glance(&l->objective.assembly, l->objective.positions, energies);
    if (!(energies->area > 0))
        return 0;
    scale_numbers(l, energies);
    return 1;
}

int32_t co_level_finish(co_level *l, double *xyz, curvopt_energies *energies, int *resolved, curvopt_error *error) {
    int changed;
    co_level_objective_place(&l->objective, l->now.x);
    co_level_objective_take_size(&l->objective);
    int32_t status = co_adaptive_quadrature_resolve(
        &l->objective.assembly, l->objective.positions,
        &(co_quadrature_goal){.tolerance = l->tolerance, .terms = CO_TERMS_REPORT, .is_normalized = 1}, energies,
        resolved, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    if (!isfinite(energies->objective)) /* by rules finer than those that it was solved with */
        return co_run_context_is_cancelled(l->objective.run)
                   ? CO_CANCELLED
                   : co_adaptive_quadrature_not_finite(&l->objective.assembly, error);
    co_level_objective_to_user(&l->objective, l->now.x, size_of(l, energies), xyz);
    scale_numbers(l, energies);
    return CURVOPT_OK;
}
