/* What a run holds of the whole surface. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/held_scalars.h"

#include "base/constants.h"
#include "base/elementary.h"

#include <math.h>

static const char *const name[CURVOPT_N_SCALARS] = {[CURVOPT_SCALAR_VOLUME] = "volume",
                                                    [CURVOPT_SCALAR_AREA] = "area",
                                                    [CURVOPT_SCALAR_MEAN_CURVATURE] = "total mean curvature"};
/* By how much of the isoperimetric bound rounding may miss it. */
static const double ROUNDING = 1e-9;
/* A volume is known to a part of this of the sphere's with the same area at least. */
static const double LEAST_VOLUME = 1e-2;

/* A number of the sphere with this area. */
static double of_sphere(int scalar, double area) {
    const double radius = sqrt(area / (4 * CO_PI));
    return scalar == CURVOPT_SCALAR_VOLUME ? area * radius / 3
           : scalar == CURVOPT_SCALAR_AREA ? area
                                           : 4 * CO_PI * radius;
}

static int32_t refuse(curvopt_error *error, int scalar, const char *why) {
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, scalar, "the %s cannot be held: %s", name[scalar], why);
}

/* Whether what is asked for makes sense of this surface. */
static int32_t check(const curvopt_options *o, const co_assembly *a, curvopt_error *error) {
    const int is_whole = a->is_closed && !a->leaves_out;
    for (int s = 0; s < CURVOPT_N_SCALARS; s++) {
        const int32_t rule = o->scalar_rule[s];
        const int is_given = rule == CURVOPT_SCALAR_RULE_VALUE || rule == CURVOPT_SCALAR_RULE_REDUCED;
        if (rule == CURVOPT_SCALAR_RULE_FREE)
            continue;
        if (!is_whole && is_given && s == CURVOPT_SCALAR_VOLUME)
            return refuse(error, s,
                          "the surface is not closed, or faces are left out, and it has no volume; it can be kept");
        if (!a->is_closed && o->boundary == CURVOPT_BOUNDARY_FREE && s == CURVOPT_SCALAR_VOLUME)
            return refuse(error, s, "the boundary may move, and nothing says what is inside; hold the boundary");
    }
    return CURVOPT_OK;
}

/* What each number of the result is to be in units of the cage, NAN where that is not said. */
static void find_wanted(const curvopt_options *o, double orientation, const double start[CURVOPT_N_SCALARS],
                        double wanted[CURVOPT_N_SCALARS]) {
    for (int s = 0; s < CURVOPT_N_SCALARS; s++) {
        const double sign = s == CURVOPT_SCALAR_AREA ? 1 : orientation;
        wanted[s] = o->scalar_rule[s] == CURVOPT_SCALAR_RULE_KEEP    ? sign * start[s]
                    : o->scalar_rule[s] == CURVOPT_SCALAR_RULE_VALUE ? o->scalar_value[s]
                                                                     : (double)NAN;
    }
}

/* ERROR_ARGUMENT for more volume than a sphere has. */
static int32_t check_volume(const curvopt_options *o, const double wanted[CURVOPT_N_SCALARS], curvopt_error *error) {
    const double area = wanted[CURVOPT_SCALAR_AREA], volume = wanted[CURVOPT_SCALAR_VOLUME];
    const double most = of_sphere(CURVOPT_SCALAR_VOLUME, area), part = o->scalar_value[CURVOPT_SCALAR_VOLUME];
    if (volume > most * (1 + ROUNDING)) /* false where one of them is not held */
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, CURVOPT_SCALAR_VOLUME,
                              "a volume of %g does not fit into an area of %g: the sphere has %g", volume, area, most);
    if (o->scalar_rule[CURVOPT_SCALAR_VOLUME] == CURVOPT_SCALAR_RULE_REDUCED && part > 1)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, CURVOPT_SCALAR_VOLUME,
                              "a reduced volume of %g is more than the sphere's, which is 1", part);
    return CURVOPT_OK;
}

/* By which number a free result's size is measured: one that is held in units of the cage, the area if none is. */
static int measure_of(const double wanted[CURVOPT_N_SCALARS]) {
    static const int order[CURVOPT_N_SCALARS] = {CURVOPT_SCALAR_AREA, CURVOPT_SCALAR_VOLUME,
                                                 CURVOPT_SCALAR_MEAN_CURVATURE};
    for (int k = 0; k < CURVOPT_N_SCALARS; k++)
        if (wanted[order[k]] > 0)
            return order[k];
    return CURVOPT_SCALAR_AREA;
}

/* One that is held: `wanted` in units of the cage, where it is not reduced. */
static co_held_number hold(const curvopt_options *o, int s, int is_framed, const co_run_size *size, double radius,
                           double area, double wanted) {
    const int is_reduced = o->scalar_rule[s] == CURVOPT_SCALAR_RULE_REDUCED;
    const double length = is_framed ? radius : co_run_size_unit(size, 1);
    const double scale = is_reduced ? of_sphere(s, 1) : co_power(1 / length, co_held_numbers_degree(s));
    const double sphere = of_sphere(s, is_reduced ? 1 : area / (length * length));
    const double target = scale * (is_reduced ? o->scalar_value[s] : wanted);
    return (co_held_number){.scalar = s,
                            .measure = is_reduced  ? CURVOPT_SCALAR_AREA
                                       : is_framed ? -1
                                                   : size->measure,
                            .target = target,
                            .unit =
                                s == CURVOPT_SCALAR_MEAN_CURVATURE ? sphere : fmax(fabs(target), LEAST_VOLUME * sphere),
                            .rate = scale};
}

int32_t co_held_scalars_create(const curvopt_options *o, const co_assembly *a, const co_values *start, int is_framed,
                               co_held_numbers *held, co_run_size *size, curvopt_error *error) {
    const double radius = start->radius, *integral = start->integral;
    const double number[CURVOPT_N_SCALARS] = {[CURVOPT_SCALAR_VOLUME] =
                                                  radius * radius * radius * integral[CO_INT_VOLUME],
                                              [CURVOPT_SCALAR_AREA] = radius * radius * integral[CO_INT_AREA],
                                              [CURVOPT_SCALAR_MEAN_CURVATURE] = radius * integral[CO_INT_MEAN]};
    const double area = number[CURVOPT_SCALAR_AREA];
    double wanted[CURVOPT_N_SCALARS];
    *held = (co_held_numbers){.orientation = a->is_closed && number[CURVOPT_SCALAR_VOLUME] < 0 ? -1 : 1};
    find_wanted(o, held->orientation, number, wanted);
    int32_t status = check(o, a, error);
    if (status == CURVOPT_OK)
        status = check_volume(o, wanted, error);
    const int measure = measure_of(wanted);
    *size = (co_run_size){.measure = measure, .value = wanted[measure] > 0 ? wanted[measure] : area};
    for (int s = 0; status == CURVOPT_OK && s < CURVOPT_N_SCALARS; s++) {
        const int is_reduced = o->scalar_rule[s] == CURVOPT_SCALAR_RULE_REDUCED;
        if (o->scalar_rule[s] != CURVOPT_SCALAR_RULE_FREE && (is_framed || is_reduced || s != measure))
            held->held[held->n++] = hold(o, s, is_framed, size, radius, area, wanted[s]);
    }
    return status;
}

co_spontaneous_curvature co_held_scalars_spontaneous(const curvopt_options *o, const co_held_numbers *held,
                                                     const co_run_size *size, int is_framed, double radius,
                                                     double area) {
    co_spontaneous_curvature s = co_spontaneous_curvature_of(o->weights, o->spontaneous_curvature);
    s.orientation = held->orientation;
    s.measure = is_framed ? -1 : size->measure;
    s.length = is_framed ? radius : co_run_size_unit(size, 1);
    s.area = size->measure == CURVOPT_SCALAR_AREA ? size->value : area;
    return s;
}

double co_held_scalars_multiplier_of_size(const co_run_context *run, const co_held_numbers *held,
                                          const double multiplier[CURVOPT_N_SCALARS], double area, double mean) {
    const co_spontaneous_curvature *s = &run->spontaneous;
    const double c0 = s->curvature;
    double sum = s->weight * (c0 * c0 / 2 * area - c0 * s->orientation * mean); /* by the size's logarithm */
    for (int k = 0; k < held->n; k++) {
        const co_held_number *h = &held->held[k];
        if (run->options->scalar_rule[h->scalar] != CURVOPT_SCALAR_RULE_REDUCED)
            sum += multiplier[k] * co_held_numbers_degree(h->scalar) * h->target / h->unit;
    }
    return sum / (co_held_numbers_degree(run->size.measure) * run->size.value);
}

double co_run_size_unit(const co_run_size *size, double number) {
    const double ratio = size->value / number;
    return size->measure == CURVOPT_SCALAR_AREA             ? sqrt(ratio)
           : size->measure == CURVOPT_SCALAR_MEAN_CURVATURE ? ratio
                                                            : co_exp(co_log(ratio) / 3);
}

double co_run_size_number(const co_run_size *size, double area, double volume, double mean) {
    return size->measure == CURVOPT_SCALAR_AREA     ? area
           : size->measure == CURVOPT_SCALAR_VOLUME ? fabs(volume)
                                                    : fabs(mean);
}
