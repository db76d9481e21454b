/* What the tests of libcurvopt/src/solve work on. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve_setting.h"

#include "check.h"

#include "base/clock.h"
#include "constraints/given_constraints.h"
#include "constraints/given_through.h"
#include "energy/adaptive_quadrature.h"
#include "mesh/similarity.h"
#include "mesh/submesh.h"
#include "solve/multilevel.h"

static const double pi = 3.14159265358979323846;

curvopt_options solve_options(int32_t surface, int term) {
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    o.surface = surface;
    o.method = CURVOPT_METHOD_GAUSS_NEWTON;
    o.levels = 1;
    o.threads = 1;
    o.symmetry = CURVOPT_SYMMETRY_NONE;
    o.spacing = CURVOPT_SPACING_FREE;
    memset(o.weights, 0, sizeof o.weights);
    o.weights[term] = 1;
    return o;
}

double solve_area(const solve_setting *s, const double *xyz) {
    co_assembly assembly;
    co_values values;
    curvopt_error error;
    CHECK_OK(co_assembly_create(s->mesh, NULL, NULL, &s->options, s->run.tables, NULL, &assembly, &error), &error);
    co_assembly_evaluate(&assembly, xyz, &(co_request){0}, &values);
    co_assembly_free(&assembly);
    return values.integral[CO_INT_AREA] * values.radius * values.radius;
}

double solve_energy(const solve_setting *s, const double *xyz) {
    const co_quadrature_goal goal = {.tolerance = 1e-8, .terms = CO_TERMS_OBJECTIVE};
    co_assembly assembly;
    curvopt_energies energies;
    curvopt_error error;
    int resolved, changed;
    CHECK_OK(co_assembly_create(s->mesh, NULL, NULL, &s->options, s->run.tables, NULL, &assembly, &error), &error);
    CHECK_OK(co_adaptive_quadrature_resolve(&assembly, xyz, &goal, &energies, &resolved, &changed, &error), &error);
    CHECK_TRUE(resolved);
    co_assembly_free(&assembly);
    return energies.objective;
}

solve_setting *solve_setting_of(cage c, const curvopt_options *options) {
    solve_setting *s = calloc(1, sizeof *s);
    curvopt_error error;
    CHECK_TRUE(s != NULL);
    s->c = c;
    s->mesh = cage_mesh(&c);
    s->options = *options;
    s->tuning = co_tuning_defaults;
    co_basis_table_cache_create(options->surface, &s->tables);
    s->run = (co_run_context){.options = &s->options, .tuning = &s->tuning, .cancel = &s->cancel, .tables = &s->tables};
    s->run.radius = co_similarity_frame((size_t)c.n_vertices, c.xyz, s->run.centroid);
    s->run.size = (co_run_size){CURVOPT_SCALAR_AREA, solve_area(s, c.xyz)};
    CHECK_OK(co_given_constraints_create(s->mesh, c.xyz, options->constraints, &s->constraints, &error), &error);
    CHECK_OK(co_given_through_create(s->mesh, c.xyz, options, &s->constraints, &error), &error);
    if (options->symmetry == CURVOPT_SYMMETRY_NONE)
        CHECK_OK(co_symmetry_none(s->mesh, &s->symmetry, &error), &error);
    else
        CHECK_OK(co_symmetry_create(s->mesh, c.xyz, &s->constraints, 1, NULL, &s->symmetry, &error), &error);
    return s;
}

void solve_setting_free(solve_setting *s) {
    co_symmetry_free(&s->symmetry);
    co_constraints_free(&s->constraints);
    co_basis_table_cache_free(&s->tables);
    curvopt_mesh_destroy(s->mesh);
    cage_free(&s->c);
    free(s);
}

co_level *solve_level_of(solve_setting *s, co_motion motion) {
    co_level *level = NULL;
    curvopt_error error;
    CHECK_OK(co_level_create(&s->run, s->mesh, &s->symmetry, &s->constraints, motion, s->c.xyz, 1, &level, &error),
             &error);
    CHECK_OK(co_level_begin(level, &error), &error);
    level->error = NULL; /* `error` ends with this function; the tests look at statuses */
    return level;
}

co_level *solve_level(solve_setting *s) {
    return solve_level_of(s, CO_MOTION_ALL);
}

co_certificate_shape solve_shape(solve_setting *s, const co_symmetry *symmetry, const double *xyz,
                                 const co_level *solved, int differences) {
    co_certificate_shape shape = {.negative_directions = -7};
    co_level *l = NULL;
    curvopt_error error;
    CHECK_OK(co_certificate_level(&s->run, s->mesh, symmetry, &s->constraints, xyz, solved, &l, &error), &error);
    CHECK_OK(co_certificate_check_shape(l, differences, &shape, &error), &error);
    co_level_destroy(l);
    return shape;
}

co_run *solve_run(solve_setting *s, curvopt_progress_fn progress, void *user) {
    size_t n = 3 * (size_t)s->c.n_vertices;
    co_run *r = calloc(1, sizeof *r);
    curvopt_error error;
    CHECK_TRUE(r != NULL);
    *r = (co_run){.context = s->run,
                  .progress = progress,
                  .user = user,
                  .started = co_clock_seconds(),
                  .start_energy = solve_energy(s, s->c.xyz),
                  .result = calloc(1, sizeof *r->result),
                  .at = {.start = calloc(n, sizeof(double)), .xyz = calloc(n, sizeof(double))}};
    CHECK_TRUE(r->result && r->at.start && r->at.xyz);
    memcpy(r->at.start, s->c.xyz, n * sizeof(double));
    memcpy(r->at.xyz, s->c.xyz, n * sizeof(double));
    CHECK_OK(co_submesh_copy(s->mesh, &r->result->mesh, &error), &error);
    CHECK_OK(co_constraints_copy(s->mesh, &s->constraints, &r->constraints, &error), &error);
    if (s->options.symmetry == CURVOPT_SYMMETRY_NONE)
        CHECK_OK(co_symmetry_none(s->mesh, &r->at.symmetry, &error), &error);
    else
        CHECK_OK(co_symmetry_create(s->mesh, s->c.xyz, &s->constraints, 1, NULL, &r->at.symmetry, &error), &error);
    return r;
}

void solve_run_free(co_run *r) {
    co_run_result_destroy(r->result);
    co_level_result_free(&r->at);
    co_constraints_free(&r->constraints);
    free(r);
}

int32_t solve_minimized(solve_setting *s) {
    curvopt_result *result = NULL;
    curvopt_summary summary;
    curvopt_error error;
    CHECK_OK(co_multilevel_minimize(s->mesh, s->c.xyz, &s->options, &s->tuning, NULL, NULL, NULL, &result, &error),
             &error);
    curvopt_result_get_positions(result, s->c.xyz);
    curvopt_result_get_summary(result, &summary, sizeof summary);
    curvopt_result_destroy(result);
    s->run.radius = co_similarity_frame((size_t)s->c.n_vertices, s->c.xyz, s->run.centroid);
    s->run.size.value = solve_area(s, s->c.xyz);
    return summary.stop;
}

cage cage_band(int32_t n_u, int32_t n_v, double r0, double r1, double height) {
    int32_t n_vertices = n_u * (n_v + 1), n_faces = n_u * n_v;
    int32_t *sizes = calloc((size_t)n_faces, sizeof *sizes), *vertices = calloc(4 * (size_t)n_faces, sizeof *vertices);
    double *xyz = calloc(3 * (size_t)n_vertices, sizeof *xyz);
    CHECK_TRUE(sizes && vertices && xyz);
    for (int32_t i = 0; i < n_u; i++)
        for (int32_t j = 0; j <= n_v; j++) {
            double a = 2 * pi * i / n_u, t = (double)j / n_v, r = r0 + t * (r1 - r0);
            double *p = xyz + 3 * (i * (n_v + 1) + j);
            p[0] = r * cos(a);
            p[1] = r * sin(a);
            p[2] = t * height;
        }
    for (int32_t f = 0; f < n_faces; f++) {
        int32_t v = f / n_v * (n_v + 1) + f % n_v, w = (f / n_v + 1) % n_u * (n_v + 1) + f % n_v;
        const int32_t corner[4] = {v, w, w + 1, v + 1};
        sizes[f] = 4;
        memcpy(vertices + 4 * f, corner, sizeof corner);
    }
    cage c = cage_of(n_vertices, n_faces, sizes, vertices, xyz);
    free(sizes);
    free(vertices);
    free(xyz);
    return c;
}
