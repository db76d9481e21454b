/* Figures of a cage from those of its components. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/component_figures.h"

#include "energy/functional.h"

#include <math.h>

/* From the best to the worst. */
static const int32_t verdicts[] = {CURVOPT_VERDICT_MINIMUM, CURVOPT_VERDICT_SADDLE, CURVOPT_VERDICT_UNKNOWN,
                                   CURVOPT_VERDICT_NOT_STATIONARY};
static const int32_t stops[] = {CURVOPT_STOP_CONVERGED, CURVOPT_STOP_SETTLED, CURVOPT_STOP_STALLED,
                                CURVOPT_STOP_LIMIT,     CURVOPT_STOP_GROWN,   CURVOPT_STOP_UNRESOLVED,
                                CURVOPT_STOP_CANCELLED};
enum { N_VERDICTS = sizeof verdicts / sizeof *verdicts, N_STOPS = sizeof stops / sizeof *stops };

static int32_t worse(const int32_t *order, int n, int32_t a, int32_t b) {
    for (int k = n - 1; k > 0; k--)
        if (order[k] == a || order[k] == b)
            return order[k];
    return order[0];
}

/* ------------------------------------------------------------------------------------------------ energies -- */

/* How often a term of a component counts in the whole's, whose areas these are. */
static double share_of(int term, double area, double whole) {
    return co_functional_is_third_order(term) ? whole / area : 1;
}

/* Whether a term of all is more than the sum of the components'. */
static int is_tied(int term) {
    return co_functional_is_third_order(term) || term == CURVOPT_TERM_AREA;
}

static void add_terms(const co_component_part *part, double area, curvopt_energies *out) {
    const curvopt_energies *e = part->energies;
    for (int t = 0; t < CURVOPT_N_TERMS; t++) {
        const double share = part->times * share_of(t, e->area, area);
        out->term[t] += share * e->term[t];
        out->term_error[t] += share * e->term_error[t];
    }
}

/* The component's objective but for terms that are tied; those of all are added later. */
static void add_objective(const co_component_part *part, const double *weights, double area, curvopt_energies *out) {
    const curvopt_energies *e = part->energies;
    double rest = e->objective, factor = 1;
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        if (is_tied(t) && weights[t] > 0) {
            rest -= part->weights[t] * e->term[t];
            factor = fmax(factor, weights[t] / part->weights[t] * share_of(t, e->area, area));
        }
    out->objective += part->times * rest;
    out->objective_error += part->times * factor * e->objective_error;
}

static void add_numbers(const co_component_part *part, curvopt_energies *out) {
    const curvopt_energies *e = part->energies;
    const double times = part->times;
    out->h2 += times * e->h2;
    out->gauss += times * e->gauss;
    out->gauss_bonnet_defect += times * e->gauss_bonnet_defect;
    out->area_error += times * e->area_error;
    out->volume += times * e->volume;
    out->total_mean_curvature += times * e->total_mean_curvature;
    out->helfrich += times * e->helfrich;
    out->n_samples += part->times * e->n_samples;
    out->min_jacobian = fmin(out->min_jacobian, e->min_jacobian);
    out->surface = e->surface;
}

void co_component_figures_energies(const co_component_part *parts, int32_t n, const double *weights, double radius,
                                   curvopt_energies *out) {
    double area = 0;
    *out = (curvopt_energies){.min_jacobian = (double)INFINITY};
    for (int32_t k = 0; k < n; k++)
        area += parts[k].times * parts[k].energies->area;
    for (int32_t k = 0; k < n; k++) {
        add_terms(&parts[k], area, out);
        add_objective(&parts[k], weights, area, out);
        add_numbers(&parts[k], out);
    }
    out->area = area;
    out->term[CURVOPT_TERM_AREA] = area / (radius * radius);
    out->term_error[CURVOPT_TERM_AREA] = out->area_error / (radius * radius);
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        if (is_tied(t) && weights[t] > 0)
            out->objective += weights[t] * out->term[t];
}

/* ------------------------------------------------------------------------------------- reports, summaries -- */

void co_component_figures_report(const co_component_part *parts, int32_t n, curvopt_level_report *out) {
    double squares = 0, sum = 0;
    out->stop = CURVOPT_STOP_CONVERGED;
    for (int32_t k = 0; k < n; k++) {
        const curvopt_level_report *r = parts[k].report;
        const double norm = r->gradient_norm * r->energy;
        squares += parts[k].times * norm * norm;
        sum += parts[k].times * r->energy;
        out->stop = worse(stops, N_STOPS, out->stop, r->stop);
    }
    out->gradient_norm = squares > 0 ? sqrt(squares) / fabs(sum) : squares;
}

static void add_decrements(const co_component_part *part, curvopt_summary *out) {
    const curvopt_summary *s = part->summary;
    out->newton_decrement += part->times * s->newton_decrement;
    out->shape_decrement += part->times * s->shape_decrement;
    out->difference_decrement += part->times * s->difference_decrement;
    out->spring_energy += part->times * s->spring_energy;
    out->touch_rise += part->times * s->touch_rise;
}

/* -1: not counted. */
static void add_count(int32_t times, int32_t count, int32_t *out) {
    *out = count < 0 || *out < 0 ? -1 : *out + times * count;
}

static void add_counts(const co_component_part *part, curvopt_summary *out) {
    const curvopt_summary *s = part->summary;
    add_count(part->times, s->negative_directions, &out->negative_directions);
    add_count(part->times, s->all_negative_directions, &out->all_negative_directions);
    add_count(part->times, s->free_negative_directions, &out->free_negative_directions);
    out->is_delicate |= s->is_delicate;
    out->n_sliding += part->times * s->n_sliding;
    out->n_folded += part->times * s->n_folded;
    out->n_unfolded += part->times * s->n_unfolded;
}

static void add_scalars(const co_component_part *part, curvopt_summary *out) {
    const curvopt_summary *s = part->summary;
    for (int k = 0; k < CURVOPT_N_SCALARS; k++) {
        const int is_only_one = part->times == 1 && out->multiplier[k] == 0;
        if (s->multiplier[k] != 0)
            out->multiplier[k] = is_only_one ? s->multiplier[k] : (double)NAN;
        if (!(fabs(s->scalar_residual[k]) <= fabs(out->scalar_residual[k])))
            out->scalar_residual[k] = s->scalar_residual[k];
    }
}

void co_component_figures_summary(const co_component_part *parts, int32_t n, curvopt_summary *out) {
    out->verdict = CURVOPT_VERDICT_MINIMUM;
    out->symmetry_order = 1;
    out->newton_decrement = out->shape_decrement = out->difference_decrement = out->spring_energy = 0;
    out->touch_rise = 0;
    out->negative_directions = out->all_negative_directions = out->free_negative_directions = 0;
    out->is_delicate = out->n_sliding = out->n_folded = out->n_unfolded = 0;
    for (int k = 0; k < CURVOPT_N_SCALARS; k++)
        out->multiplier[k] = 0;
    for (int32_t k = 0; k < n; k++) {
        const curvopt_summary *s = parts[k].summary;
        if (!s)
            continue;
        out->verdict = worse(verdicts, N_VERDICTS, out->verdict, s->verdict);
        out->method = s->method;
        out->curve_deviation = fmax(out->curve_deviation, s->curve_deviation);
        out->symmetry_order = s->symmetry_order > out->symmetry_order ? s->symmetry_order : out->symmetry_order;
        add_decrements(&parts[k], out);
        add_counts(&parts[k], out);
        add_scalars(&parts[k], out);
    }
    out->is_delicate &= out->verdict == CURVOPT_VERDICT_MINIMUM;
}
