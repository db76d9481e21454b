/* Results as JSON. SPDX-License-Identifier: GPL-3.0-or-later */
#include "report_json.h"

#include <math.h>

#define PI 3.14159265358979323846

static void put_number(FILE *f, const char *key, double x, const char *after) {
    if (isfinite(x))
        fprintf(f, "\"%s\": %.17g%s", key, x, after);
    else
        fprintf(f, "\"%s\": null%s", key, after);
}

/* All but the area's, which stands by itself, in the cage's units. */
static void put_terms(FILE *f, const double *term, const char *after) {
    for (int t = 0; t < CURVOPT_TERM_AREA; t++)
        put_number(f, curvopt_term_name(t), term[t], t + 1 < CURVOPT_TERM_AREA ? ", " : after);
}

/* Over that of the sphere with the same area. */
static double reduced_volume(const curvopt_energies *e) {
    return 6 * sqrt(PI) * e->volume / (e->area * sqrt(e->area));
}

static void put_energies(FILE *f, const curvopt_energies *e, const char *indent) {
    fputs(indent, f);
    put_number(f, "area", e->area, ", ");
    put_terms(f, e->term, ",\n");
    fputs(indent, f);
    put_number(f, "h2", e->h2, ", ");
    put_number(f, "gauss", e->gauss, ", ");
    put_number(f, "gauss_bonnet_defect", e->gauss_bonnet_defect, ",\n");
    fputs(indent, f);
    put_number(f, "volume", e->volume, ", ");
    put_number(f, "reduced_volume", reduced_volume(e), ", ");
    put_number(f, "total_mean_curvature", e->total_mean_curvature, ", ");
    put_number(f, "helfrich", e->helfrich, ",\n");
    fputs(indent, f);
    put_number(f, "objective", e->objective, ", ");
    put_number(f, "quadrature_error", e->objective_error, ", ");
    put_number(f, "min_jacobian", e->min_jacobian, ",\n");
    fprintf(f, "%s\"quadrature_errors\": {", indent);
    put_number(f, "area", e->area_error, ", ");
    put_terms(f, e->term_error, "},\n");
    fprintf(f, "%s\"samples\": %d, \"surface\": \"%s\"", indent, e->n_samples, curvopt_surface_name(e->surface));
}

/* A count, or null for -1. */
static void put_count(FILE *f, const char *name, int32_t count, const char *end) {
    if (count >= 0)
        fprintf(f, "\"%s\": %d%s", name, count, end);
    else
        fprintf(f, "\"%s\": null%s", name, end);
}

static void put_verification(FILE *f, const curvopt_summary *s) {
    fprintf(f, "  \"verification\": {\"verdict\": \"%s\", ", curvopt_verdict_text(s->verdict));
    put_number(f, "newton_decrement", s->newton_decrement, ", ");
    put_number(f, "shape_decrement", s->shape_decrement, ", ");
    put_number(f, "difference_decrement", s->difference_decrement, ", ");
    put_count(f, "negative_directions", s->negative_directions, ", ");
    put_count(f, "all_negative_directions", s->all_negative_directions, ", ");
    put_count(f, "free_negative_directions", s->free_negative_directions, ", ");
    put_number(f, "touch_rise", s->touch_rise, ", ");
    fprintf(f, "\"delicate\": %s},\n", s->is_delicate ? "true" : "false");
}

static void put_levels(FILE *f, const json_report *r) {
    fprintf(f, "  \"levels\": [");
    for (int32_t i = 0; i < r->summary->n_levels; i++) {
        curvopt_level_report l = r->levels[i];
        fprintf(f, "%s\n    {\"level\": %d, \"vertices\": %d, \"iterations\": %d, \"evaluations\": %d, ", i ? "," : "",
                l.level, l.n_vertices, l.iterations, l.evaluations);
        put_number(f, "energy", l.energy, ", ");
        put_number(f, "gradient_norm", l.gradient_norm, ", ");
        put_number(f, "seconds", l.seconds, ", ");
        fprintf(f, "\"stop\": \"%s\"}", curvopt_stop_text(l.stop));
    }
    fprintf(f, "\n  ],\n  \"stop\": \"%s\", ", curvopt_stop_text(r->summary->stop));
    put_number(f, "seconds", r->summary->seconds, ",\n");
    put_verification(f, r->summary);
    fprintf(f, "  \"start\": {\n");
    put_energies(f, r->start, "    ");
    fprintf(f, "\n  },\n");
}

/* What is held of the whole surface: how much the objective gives for it, how far off it is. */
static void put_scalars(FILE *f, const curvopt_summary *s) {
    const struct {
        const char *key;
        const double *number;
    } of[] = {{"multipliers", s->multiplier}, {"scalar_residuals", s->scalar_residual}};
    for (size_t k = 0; k < sizeof of / sizeof *of; k++) {
        fprintf(f, "  \"%s\": {", of[k].key);
        for (int i = 0; i < CURVOPT_N_SCALARS; i++)
            put_number(f, curvopt_scalar_name(i), of[k].number[i], i + 1 < CURVOPT_N_SCALARS ? ", " : "},\n");
    }
}

int json_write(FILE *f, const json_report *r) {
    fprintf(f, "{\n  \"vertices\": %d, \"faces\": %d, \"euler\": %d,\n", r->info->n_vertices, r->info->n_faces,
            r->info->euler);
    fprintf(f, "  \"energy\": \"%s\", ", r->energy);
    put_number(f, "spontaneous_curvature", r->spontaneous_curvature, ",\n");
    if (r->summary) {
        fprintf(f, "  \"method\": \"%s\", \"symmetry_order\": %d,\n", r->method, r->summary->symmetry_order);
        put_levels(f, r);
    }
    if (r->summary) {
        fprintf(f, "  \"n_sliding\": %d, ", r->summary->n_sliding);
        put_number(f, "curve_deviation", r->summary->curve_deviation, ",\n  ");
        put_number(f, "discretization_error", r->summary->discretization_error, ", ");
        put_number(f, "spring_energy", r->summary->spring_energy, ",\n");
    }
    if (r->summary)
        put_scalars(f, r->summary);
    if (r->held)
        held_write_json(f, r->held);
    if (r->measures)
        measures_write_json(f, r->measures);
    if (r->more)
        fputs(r->more, f);
    put_energies(f, r->energies, "  ");
    fprintf(f, "\n}\n");
    return ferror(f);
}
