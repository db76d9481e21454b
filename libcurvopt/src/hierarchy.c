/* Optimize, subdivide, repeat (the report, section 3.2), on an energy that is kept resolved.
 *
 * With a fixed quadrature rule the discrete energy has no lower bound, and an optimizer finds that out. Here every
 * accepted step is looked at: Gauss-Bonnet's defect is free, and when it grows, or after RESOLVE_EVERY steps, the rules
 * are held against finer ones. A step that looked like progress only to a rule too coarse is taken back.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "hierarchy.h"

#include "certificate.h"
#include "hold.h"
#include "lmvm.h"
#include "memory.h"
#include "placement.h"
#include "refine.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { LARGEST_CERTIFIED = 50000, RESOLVE_EVERY = 20, LMVM_MEMORY = 12, RENEW_EVERY = 1 };
static const double SHIFT = 0.1;
/* Of the energy; between levels only what the next one would not do better at once. */
static const double COARSE_DECREMENT = 1e-4, FINAL_DECREMENT = 1e-6;
static const double COARSE_SETTLED = 1e-3, FINAL_SETTLED = 2e-4;
/* While a level is worked on that is not the last, quadrature may be this much coarser than what is wanted of the
 * figures at the end: the step check above needs a resolved energy, not an accurate one. */
static const double WORKING_FACTOR = 10;
static const double DEFECT_GROWTH = 4, DEFECT_FLOOR = 1e-3; /* radians of total curvature */

/* The whole run. */
typedef struct run {
    const curvopt_options *options;
    curvopt_progress_fn progress;
    void *user;
    const curvopt_cancel *cancel;
    double started;
    double start_energy, start_area;
    double centroid[3], radius; /* of the input cage: the frame of levels that hold vertices */
    curvopt_result *result;
    double *xyz;         /* of the present level, in the user's units */
    double *level_start; /* what the level began with */
} run;

/* One level's function, as the optimizer sees it. */
typedef struct level_problem {
    run *r;
    const curvopt_mesh *mesh;
    co_assembly assembly;
    double tolerance, working_tolerance;
    uint8_t *held;      /* vertices that stay, or NULL: then it is the cage's place that is held */
    double edge;        /* mean length, normalized */
    double defect;      /* Gauss-Bonnet's, when last resolved, */
    co_values last;     /* and what was evaluated last */
    co_hessian hessian; /* for a preconditioner: its matrix and factor */
    co_cholesky *factor;
    int has_factor;
    double shift;
    int32_t number;
    int32_t failed; /* status of a call that cannot report it */
    curvopt_error *error;
} level_problem;

static double now_seconds(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int is_cancelled(const run *r) {
    return r->cancel && atomic_load_explicit(&r->cancel->requested, memory_order_relaxed);
}

static double evaluate(void *context, const double *x, double *gradient) {
    level_problem *p = context;
    co_request request = {.gradient = gradient};
    co_assembly_evaluate(&p->assembly, x, &request, &p->last);
    if (gradient)
        co_hold_clear(p->held, p->mesh->info.n_vertices, gradient);
    return p->last.objective;
}

static double mean_edge(const curvopt_mesh *m, const double *x) {
    double sum = 0;
    for (int32_t e = 0; e < m->info.n_edges; e++) {
        const double *a = x + 3 * (size_t)m->corner_vertex[m->edge_corner[e]];
        const double *b = x + 3 * (size_t)co_mesh_destination(m, m->edge_corner[e]);
        sum += sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
    }
    return sum / m->info.n_edges;
}

/* Longest vertex displacement in mean edges. */
static double step_length(void *context, const double *d) {
    const level_problem *p = context;
    double longest = 0;
    for (int32_t v = 0; v < p->mesh->info.n_vertices; v++, d += 3)
        longest = fmax(longest, d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    return sqrt(longest) / p->edge;
}

/* Back to centroid 0 and radius 1, where the function is the same and the gradient scales. */
static void hold_placement(const level_problem *p, co_iterate *now) {
    size_t n = (size_t)p->mesh->info.n_vertices;
    if (p->held)
        return;
    double centroid[3], radius = co_placement_frame(n, now->x, centroid);
    for (size_t i = 0; i < 3 * n; i++) {
        now->x[i] = (now->x[i] - centroid[i % 3]) / radius;
        now->gradient[i] *= radius;
    }
}

static co_settlement step_back(level_problem *p, const co_iterate *before, co_iterate *now, co_settlement verdict) {
    memcpy(now->x, before->x, sizeof(double) * 3 * (size_t)p->mesh->info.n_vertices);
    now->value = evaluate(p, now->x, now->gradient);
    return verdict;
}

static co_settlement settle(void *context, const co_iterate *before, co_iterate *now, int iteration) {
    level_problem *p = context;
    curvopt_energies energies;
    int resolved, changed;
    if (p->failed != CURVOPT_OK) /* in between, where nobody could be told */
        return step_back(p, before, now, CO_SETTLE_STOP);
    int suspicious =
        !(co_assembly_defect(&p->assembly, &p->last) <= DEFECT_GROWTH * p->defect + DEFECT_FLOOR); /* of `now` */
    hold_placement(p, now);
    p->edge = mean_edge(p->mesh, now->x);
    /* a long step into unknown country is looked at more closely than one of many short ones */
    int due = p->factor || iteration % RESOLVE_EVERY == 0;
    if (p->r->options->as_report || (!due && !suspicious))
        return CO_SETTLE_KEEP;
    p->failed = co_assembly_resolve(&p->assembly, now->x, p->working_tolerance, CO_TERMS_OBJECTIVE, &energies,
                                    &resolved, &changed, p->error);
    if (p->failed != CURVOPT_OK)
        return step_back(p, before, now, CO_SETTLE_STOP);
    if (!resolved)
        return step_back(p, before, now, CO_SETTLE_REJECT);
    p->defect = energies.gauss_bonnet_defect;
    if (!changed)
        return CO_SETTLE_KEEP;
    double value_before = evaluate(p, before->x, now->gradient);
    now->value = evaluate(p, now->x, now->gradient);
    if (!(now->value <= value_before))
        return step_back(p, before, now, CO_SETTLE_REJECT);
    return CO_SETTLE_CHANGED;
}

/* Positions as the user sees them: in the frame they were taken from where something is held; else the area is the
 * input's, and the cage lies as the level's first one did. */
static void to_user(const level_problem *p, const double *x, double normalized_area, double *xyz) {
    size_t n = (size_t)p->mesh->info.n_vertices;
    if (p->held) {
        for (size_t i = 0; i < 3 * n; i++)
            xyz[i] = p->r->centroid[i % 3] + p->r->radius * x[i];
        co_hold_copy(p->held, (int32_t)n, p->r->level_start, xyz);
        return;
    }
    double scale = sqrt(p->r->start_area / normalized_area);
    for (size_t i = 0; i < 3 * n; i++)
        xyz[i] = scale * x[i];
    co_placement_align(n, p->r->level_start, xyz);
}

static double relative_gradient(size_t n, const co_iterate *now) {
    return co_vector_norm(n, now->gradient) / fabs(now->value);
}

static int report(void *context, const co_iterate *now, int iteration, int evaluations) {
    level_problem *p = context;
    run *r = p->r;
    if (p->failed != CURVOPT_OK || is_cancelled(r))
        return 1;
    if (!r->progress)
        return 0;
    to_user(p, now->x, p->last.integral[CO_INT_AREA], r->xyz);
    curvopt_progress progress = {.energy = now->value,
                                 .start_energy = r->start_energy,
                                 .gradient_norm = relative_gradient(3 * (size_t)p->mesh->info.n_vertices, now),
                                 .seconds = now_seconds() - r->started,
                                 .xyz = r->xyz,
                                 .mesh = p->mesh,
                                 .level = p->number,
                                 .levels = r->options->levels,
                                 .iteration = iteration,
                                 .evaluations = evaluations + 1, /* the level's first */
                                 .n_vertices = p->mesh->info.n_vertices};
    return r->progress(&progress, r->user) != 0;
}

static int32_t create_factor(level_problem *p, curvopt_error *error) {
    int32_t status = co_hessian_create(&p->assembly, &p->hessian, error);
    p->hessian.held = p->held;
    if (status == CURVOPT_OK)
        status = co_cholesky_create(3 * p->mesh->info.n_vertices, p->hessian.column_start, p->hessian.row,
                                    p->hessian.value, &p->factor, error);
    return status;
}

static double least_shift(const level_problem *p, double value) {
    return SHIFT * fabs(value) / p->mesh->info.n_vertices;
}

/* The Gauss-Newton matrix of `now`, shifted (Levenberg 1944, Marquardt 1963): so little that what the matrix does not
 * see (sliding in the surface, rigid motion) is not infinitely soft, a displacement of all vertices by the surface's
 * size costing at least SHIFT times the energy; and as much more as keeps steps near the cap. Cutting a long step back
 * to the cap instead needs ten times as many on the curved valley floor of MVS. */
static int renew(void *context, const co_iterate *now, double overshoot) {
    level_problem *p = context;
    int positive = 0;
    if (p->failed != CURVOPT_OK)
        return 1;
    double least = least_shift(p, now->value);
    double change = overshoot > 4 ? 4 : overshoot > 1.5 ? 2 : overshoot > 0.7 ? 1 : 1.0 / 3;
    p->has_factor = 0; /* factorizing spoils the old one, even if it fails */
    p->failed = co_hessian_assemble(&p->assembly, now->x, 0, &p->hessian, p->error);
    if (p->failed != CURVOPT_OK)
        return 1;
    double stiffest = co_hessian_mean_diagonal(&p->hessian);
    for (p->shift = fmax(p->shift * change, least); !positive && p->shift <= stiffest; p->shift *= positive ? 1 : 4) {
        p->failed = co_cholesky_factorize(p->factor, p->shift, &positive, p->error);
        if (p->failed != CURVOPT_OK)
            return 1;
    }
    p->has_factor = positive;
    return !positive;
}

static int precondition(void *context, const double *in, double *out) {
    level_problem *p = context;
    if (!p->has_factor)
        return 1;
    int32_t status = co_cholesky_solve(p->factor, in, out, p->error);
    if (status != CURVOPT_OK)
        p->failed = status;
    return status != CURVOPT_OK;
}

static int32_t level_create(run *r, const curvopt_mesh *mesh, int32_t number, level_problem *p, double *x,
                            curvopt_error *error) {
    size_t n = (size_t)mesh->info.n_vertices;
    *p = (level_problem){.r = r, .mesh = mesh, .number = number, .error = error};
    p->tolerance = r->options->as_report ? INFINITY : r->options->tolerance;
    p->working_tolerance = number < r->options->levels ? WORKING_FACTOR * p->tolerance : p->tolerance;
    int32_t status = co_hold_create(mesh, r->options->boundary, &p->held, error);
    if (status != CURVOPT_OK)
        return status;
    double centroid[3], radius = co_placement_frame(n, r->xyz, centroid);
    for (size_t i = 0; i < 3 * n; i++)
        x[i] = p->held ? (r->xyz[i] - r->centroid[i % 3]) / r->radius : (r->xyz[i] - centroid[i % 3]) / radius;
    p->edge = mean_edge(mesh, x);
    status = co_assembly_create(mesh, r->options, &p->assembly, error);
    p->assembly.frame_held = p->held != NULL;
    if (status == CURVOPT_OK && r->options->method != CURVOPT_METHOD_LMVM)
        status = create_factor(p, error);
    return status;
}

/* Figures of the input cage, with an assembly of their own: what they need of quadrature, the optimization does not. */
static int32_t report_start(run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    co_assembly assembly;
    int resolved, changed;
    curvopt_energies *start = &r->result->summary.start;
    double tolerance = r->options->as_report ? (double)INFINITY : r->options->tolerance;
    int32_t status = co_assembly_create(mesh, r->options, &assembly, error);
    if (status != CURVOPT_OK)
        return status;
    status = co_assembly_resolve(&assembly, r->xyz, tolerance, CO_TERMS_REPORT, start, &resolved, &changed, error);
    if (status == CURVOPT_OK && !r->options->as_report)
        status = co_assembly_check_energies(&assembly, start, error);
    r->start_energy = start->objective;
    r->start_area = start->area;
    co_assembly_free(&assembly);
    return status;
}

/* Rules, value and gradient at the level's start; refuses what has none. */
static int32_t start_level(level_problem *p, co_iterate *now, curvopt_error *error) {
    curvopt_energies energies;
    int resolved, changed;
    int32_t status = co_assembly_resolve(&p->assembly, now->x, p->working_tolerance, CO_TERMS_OBJECTIVE, &energies,
                                         &resolved, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    p->defect = energies.gauss_bonnet_defect;
    now->value = evaluate(p, now->x, now->gradient);
    if (!isfinite(now->value) || !isfinite(co_vector_norm(3 * (size_t)p->mesh->info.n_vertices, now->gradient)))
        return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, p->last.worst_face,
                              "the energy is not finite: the surface is degenerate at face %d", p->last.worst_face);
    return CURVOPT_OK;
}

/* Energies at the level's end, and its cage into r->xyz: turned and scaled back to where the run started. */
static int32_t end_level(level_problem *p, const co_iterate *now, const co_lmvm_result *solved, double started,
                         curvopt_error *error) {
    run *r = p->r;
    size_t n = (size_t)p->mesh->info.n_vertices;
    curvopt_energies *end = &r->result->summary.end;
    int resolved, changed;
    int32_t status =
        co_assembly_resolve(&p->assembly, now->x, p->tolerance, CO_TERMS_REPORT, end, &resolved, &changed, error);
    if (status != CURVOPT_OK)
        return status;
    curvopt_level_report *report = &r->result->level[r->result->summary.n_levels++];
    *report = (curvopt_level_report){.energy = end->objective,
                                     .gradient_norm = relative_gradient(3 * n, now),
                                     .level = p->number,
                                     .n_vertices = (int32_t)n,
                                     .iterations = solved->iterations,
                                     .evaluations = solved->evaluations + 1,
                                     .stop = resolved ? solved->stop : CURVOPT_STOP_UNRESOLVED,
                                     .seconds = now_seconds() - started};
    to_user(p, now->x, end->area, r->xyz);
    double unit = p->held ? r->radius * r->radius : r->start_area / end->area;
    end->area_error *= unit;
    end->area = p->held ? unit * end->area : r->start_area;
    return CURVOPT_OK;
}

/* The verdict on where the run ended. */
static int32_t certify(level_problem *p, co_iterate *now, curvopt_error *error) {
    curvopt_summary *summary = &p->r->result->summary;
    co_certificate c;
    int32_t status = p->factor ? CURVOPT_OK : create_factor(p, error);
    if (status != CURVOPT_OK)
        return status;
    now->value = evaluate(p, now->x, now->gradient); /* by the rules that end_level() has settled on */
    status = co_certify(&p->assembly, &p->hessian, p->factor, now->x, now->value, now->gradient,
                        least_shift(p, now->value), &c, error);
    summary->newton_decrement = c.newton_decrement;
    summary->negative_directions = c.negative_directions;
    summary->verdict = c.verdict;
    return status;
}

/* Whether the level was the run's last, and one to look at more closely. */
static int wants_certificate(const run *r, int32_t number) {
    return !r->options->as_report && r->result->level[number - 1].stop != CURVOPT_STOP_CANCELLED &&
           r->result->mesh->info.n_vertices <= LARGEST_CERTIFIED;
}

static int ends_run(const run *r, int32_t number) {
    int32_t stop = r->result->level[number - 1].stop;
    return number == r->options->levels || stop == CURVOPT_STOP_CANCELLED || stop == CURVOPT_STOP_UNRESOLVED;
}

static int32_t solve_level(run *r, const curvopt_mesh *mesh, int32_t number, curvopt_error *error) {
    size_t n = 3 * (size_t)mesh->info.n_vertices;
    double started = now_seconds();
    level_problem p = {0};
    co_iterate now = {.x = CO_NEW(double, n), .gradient = CO_NEW(double, n)};
    int32_t status = CURVOPT_ERROR_MEMORY;
    if (!now.x || !now.gradient) {
        co_status_no_memory(error);
        goto done;
    }
    status = level_create(r, mesh, number, &p, now.x, error);
    if (status == CURVOPT_OK)
        status = start_level(&p, &now, error);
    if (status != CURVOPT_OK)
        goto done;
    co_minimand f = {
        .context = &p, .n = n, .evaluate = evaluate, .step_length = step_length, .settle = settle, .report = report};
    co_lmvm_options lmvm = {.memory = LMVM_MEMORY,
                            .max_iterations = r->options->max_iterations,
                            .gradient_tolerance = r->options->gradient_tolerance,
                            .decrement_tolerance = number < r->options->levels ? COARSE_DECREMENT : FINAL_DECREMENT,
                            .settled_decrease = number < r->options->levels ? COARSE_SETTLED : FINAL_SETTLED,
                            .max_step = r->options->max_step,
                            .renew_every = RENEW_EVERY};
    if (p.factor) {
        f.precondition = precondition;
        f.renew = renew;
    }
    co_lmvm_result solved = {0};
    if (report(&p, &now, 0, 0))
        solved.stop = CURVOPT_STOP_CANCELLED;
    else
        status = co_lmvm(&f, &lmvm, &now, &solved, error);
    if (status == CURVOPT_OK)
        status = p.failed;
    if (status == CURVOPT_OK)
        status = end_level(&p, &now, &solved, started, error);
    if (status == CURVOPT_OK && ends_run(r, number) && wants_certificate(r, number))
        status = certify(&p, &now, error);
done:
    co_cholesky_destroy(p.factor);
    co_hessian_free(&p.hessian);
    co_assembly_free(&p.assembly);
    free(p.held);
    free(now.x);
    free(now.gradient);
    return status;
}

/* The next level's cage: r->result->mesh and r->xyz subdivided. */
static int32_t subdivide(run *r, curvopt_error *error) {
    curvopt_mesh *fine = NULL;
    co_rows rows = {0};
    int32_t status = co_refine(r->result->mesh, &fine, &rows, error);
    if (status != CURVOPT_OK)
        return status;
    double *xyz = CO_NEW(double, 3 * (size_t)rows.n_rows), *start = CO_NEW(double, 3 * (size_t)rows.n_rows);
    if (!xyz || !start) {
        free(xyz);
        free(start);
        co_mesh_destroy(fine);
        status = co_status_no_memory(error);
    } else {
        co_rows_apply(&rows, r->xyz, xyz);
        memcpy(start, xyz, sizeof(double) * 3 * (size_t)rows.n_rows);
        free(r->xyz);
        free(r->level_start);
        co_mesh_destroy(r->result->mesh);
        r->xyz = xyz;
        r->level_start = start;
        r->result->mesh = fine;
    }
    co_rows_free(&rows);
    return status;
}

static int32_t run_levels(run *r, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    for (int32_t number = 1; number <= r->options->levels; number++) {
        int32_t status = number > 1 ? subdivide(r, error) : CURVOPT_OK;
        if (status == CURVOPT_OK)
            status = solve_level(r, r->result->mesh, number, error);
        if (status != CURVOPT_OK)
            return status;
        summary->stop = r->result->level[number - 1].stop;
        if (ends_run(r, number))
            break;
    }
    summary->seconds = now_seconds() - r->started;
    summary->n_vertices = r->result->mesh->info.n_vertices;
    summary->n_faces = r->result->mesh->info.n_faces;
    summary->method = r->options->method;
    return CURVOPT_OK;
}

int32_t co_hierarchy_minimize(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                              curvopt_progress_fn progress, void *user, const curvopt_cancel *cancel,
                              curvopt_result **out, curvopt_error *error) {
    size_t n = 3 * (size_t)mesh->info.n_vertices;
    run r = {.options = options, .progress = progress, .user = user, .cancel = cancel, .started = now_seconds()};
    int32_t status = CURVOPT_ERROR_MEMORY;
    r.result = CO_NEW(curvopt_result, 1);
    if (r.result) {
        r.result->summary.newton_decrement = (double)NAN;
        r.result->summary.negative_directions = -1;
    }
    if (r.result)
        r.result->level = CO_NEW(curvopt_level_report, options->levels);
    r.xyz = CO_NEW(double, n);
    r.level_start = CO_NEW(double, n);
    if (!r.result || !r.result->level || !r.xyz || !r.level_start) {
        co_status_no_memory(error);
    } else {
        memcpy(r.xyz, xyz, n * sizeof(double));
        memcpy(r.level_start, xyz, n * sizeof(double));
        r.radius = co_placement_frame(n / 3, xyz, r.centroid);
        status = co_mesh_copy(mesh, &r.result->mesh, error);
        if (status == CURVOPT_OK)
            status = report_start(&r, mesh, error);
        if (status == CURVOPT_OK)
            status = run_levels(&r, error);
    }
    free(r.level_start);
    if (status != CURVOPT_OK) {
        free(r.xyz);
        co_hierarchy_result_destroy(r.result);
        return status;
    }
    r.result->xyz = r.xyz;
    *out = r.result;
    return CURVOPT_OK;
}

void co_hierarchy_result_destroy(curvopt_result *result) {
    if (!result)
        return;
    co_mesh_destroy(result->mesh);
    free(result->xyz);
    free(result->level);
    free(result);
}
