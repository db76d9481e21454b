/* One level of a run with TAO.
 *
 * With a fixed quadrature rule the discrete energy has no lower bound, and an optimizer finds that out (step_review.c
 * of the library). Here rules are fixed while TAO runs, and every REVIEW_EVERY iterations they
 * are compared with finer ones: if they no longer resolve the surface, TAO is stopped, rules are refined where they
 * must be, and it starts again from what then is the better one: the present cage, or the last one that stood.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "level.h"

#include "base/constants.h"
#include "base/tuning.h"
#include "collective.h"
#include "tao_solver.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum {
    MOST_ATTEMPTS = 100, /* of TAO on one level, rules being refined in between */
    REVIEW_EVERY = 20    /* steps: quadrature is checked */
};
/* Of total curvature and turning, which are a constant of the surface's topology, between two looks at it. */
static const double SUSPICIOUS = 1e-3, UNSOUND = 0.1;
static const co_tuning *const tuning = &co_tuning_defaults;

double level_now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* One level's work. */
typedef struct level {
    run *r;
    const subdomain *on;
    objective objective;
    int number;
    Vec x, safe;
    double tolerance, working_tolerance;
    double origin[3], unit; /* of x, in the user's units */
    int broke;              /* TAO was stopped: rules no longer do */
    double total;           /* curvature and turning of what was last found sound */
    int stop;
    int32_t iterations;
} level;

/* ------------------------------------------------------------------------------------------------ energies -- */

/* 2 pi chi minus what is there; NAN where sharp creases cut the surface: then no rank knows what it should be. */
static PetscErrorCode find_defect(const level *l, double *defect) {
    int32_t n_creases, n_corners;
    int mine = 0, any;
    const subdomain *on = l->on;
    PetscFunctionBeginUser;
    curvopt_mesh_count_creases(on->mesh, &n_creases, &n_corners);
    int32_t *ends = COLLECTIVE_NEW(on->comm, int32_t, 2 * (size_t)n_creases),
            *corners = COLLECTIVE_NEW(on->comm, int32_t, n_corners);
    double *sharpness = COLLECTIVE_NEW(on->comm, double, n_creases),
           *corner = COLLECTIVE_NEW(on->comm, double, n_corners);
    curvopt_mesh_get_creases(on->mesh, ends, sharpness, corners, corner);
    for (int32_t i = 0; i < n_creases; i++)
        mine |= sharpness[i] >= CURVOPT_SHARPNESS_INFINITE;
    free(ends);
    free(corners);
    free(sharpness);
    free(corner);
    PetscCallMPI(MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, on->comm));
    double euler = (double)(on->whole_vertices - on->whole_edges + on->whole_faces);
    *defect = any ? (double)NAN : fabs(l->objective.sums.gauss + l->objective.sums.turning - 2 * PETSC_PI * euler);
    PetscFunctionReturn(0);
}

/* Of what objective_compare() has found; `unit` is of length. */
static PetscErrorCode report_energies(const level *l, double value, double unit, curvopt_energies *out) {
    const objective *o = &l->objective;
    const curvopt_sums *s = &o->sums;
    PetscFunctionBeginUser;
    *out = (curvopt_energies){.objective = value, .gauss = s->gauss, .min_jacobian = s->min_jacobian};
    out->area = unit * unit * s->area;
    for (int t = 0; t < CURVOPT_MAX_TERMS; t++) {
        out->term[t] = t < CURVOPT_N_TERMS ? (objective_is_third_order(t) ? s->area : 1) * s->term[t] : (double)NAN;
        out->term_error[t] = (double)NAN; /* the objective's alone is estimated */
    }
    out->h2 = (s->term[CURVOPT_TERM_WILLMORE] + 2 * s->gauss) / 4;
    out->area_error = (double)NAN;
    out->objective_error = fabs(o->error_net) + tuning->quadrature_reference * o->error_gross;
    PetscCall(find_defect(l, &out->gauss_bonnet_defect));
    out->surface = o->options->surface;
    out->n_samples = s->samples > INT32_MAX ? INT32_MAX : (int32_t)s->samples;
    PetscFunctionReturn(0);
}

static int refuse(run *r, int status, const char *why) {
    strncpy(r->message, why, sizeof r->message - 1);
    return status;
}

/* What curvopt_problem_evaluate refuses; all ranks see the same figures. */
static int check_energies(run *r, const objective *o, const curvopt_energies *found) {
    if (!(o->sums.area > CO_LEAST_AREA))
        return refuse(r, CURVOPT_ERROR_GEOMETRY, "the cage has zero area");
    if (!isfinite(found->objective))
        return refuse(r, CURVOPT_ERROR_GEOMETRY, "the energy is not finite: the surface is degenerate");
    if (found->gauss_bonnet_defect > CO_LARGEST_DEFECT + CO_ACCEPTABLE_ERROR * found->term[CURVOPT_TERM_WILLMORE])
        return refuse(r, CURVOPT_ERROR_RESOLUTION, "the surface cannot be resolved: it is folded flat or pinched");
    return CURVOPT_OK;
}

/* Figures of the input cage. */
static PetscErrorCode report_start(level *l, int *refused) {
    run *r = l->r;
    double value, error;
    PetscFunctionBeginUser;
    PetscCall(objective_resolve(&l->objective, l->x, l->tolerance, &value, &error));
    PetscCall(report_energies(l, value, l->unit * l->objective.radius, &r->start));
    r->area = r->start.area;
    *refused = r->options->joshi_sequin ? CURVOPT_OK : check_energies(r, &l->objective, &r->start);
    PetscFunctionReturn(0);
}

/* --------------------------------------------------------------------------------------------------- solve -- */

static double total_of(const level *l) {
    return l->objective.sums.gauss + l->objective.sums.turning;
}

static PetscErrorCode test_convergence(Tao tao, void *context) {
    level *l = context;
    TaoConvergedReason reason;
    PetscInt iteration;
    Vec x;
    double value, error;
    PetscFunctionBeginUser;
    PetscCall(TaoDefaultConvergenceTest(tao, NULL));
    PetscCall(TaoGetSolutionStatus(tao, &iteration, NULL, NULL, NULL, NULL, &reason));
    PetscCall(TaoGetSolution(tao, &x));
    PetscCall(objective_set_base(&l->objective, x));
    if (l->r->options->joshi_sequin || reason != TAO_CONTINUE_ITERATING || iteration == 0 ||
        (iteration % REVIEW_EVERY && fabs(total_of(l) - l->total) <= SUSPICIOUS))
        PetscFunctionReturn(0);
    PetscCall(objective_compare(&l->objective, x, &value, &error));
    if (error <= tuning->quadrature_hysteresis * l->working_tolerance && fabs(total_of(l) - l->total) <= UNSOUND) {
        PetscCall(VecCopy(x, l->safe));
        l->total = total_of(l);
    } else {
        l->broke = 1;
        PetscCall(TaoSetConvergedReason(tao, TAO_DIVERGED_USER));
    }
    PetscFunctionReturn(0);
}

static PetscErrorCode show(Tao tao, void *context) {
    const level *l = context;
    PetscInt iteration;
    PetscReal value, gradient;
    PetscMPIInt rank;
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Comm_rank(l->r->comm, &rank));
    PetscCall(TaoGetSolutionStatus(tao, &iteration, &value, &gradient, NULL, NULL, NULL));
    if (rank == 0 && !l->r->quiet && isatty(STDERR_FILENO))
        fprintf(stderr, "\rlevel %d/%d  iteration %5d  energy %.8g  |g| %.1e  %.1f s   ", l->number,
                (int)l->r->options->levels, (int)(l->iterations + iteration), value, gradient / fabs(value),
                level_now() - l->r->started);
    PetscFunctionReturn(0);
}

static int stop_of(TaoConvergedReason reason) {
    switch (reason) {
    case TAO_CONVERGED_GATOL:
    case TAO_CONVERGED_GRTOL:
    case TAO_CONVERGED_GTTOL:
        return CURVOPT_STOP_CONVERGED;
    case TAO_DIVERGED_MAXITS:
    case TAO_DIVERGED_MAXFCN:
        return CURVOPT_STOP_LIMIT;
    case TAO_DIVERGED_NAN:
        return CURVOPT_STOP_UNRESOLVED;
    default:
        return CURVOPT_STOP_STALLED;
    }
}

/* After a solve: whether rules still do; if not, finer ones, and l->x is where to go on from. */
static PetscErrorCode review(level *l, int *again) {
    double value, error, safe_value;
    PetscFunctionBeginUser;
    *again = 0;
    if (l->r->options->joshi_sequin)
        PetscFunctionReturn(0);
    PetscCall(objective_compare(&l->objective, l->x, &value, &error));
    if (!l->broke && error <= tuning->quadrature_hysteresis * l->working_tolerance &&
        fabs(total_of(l) - l->total) <= UNSOUND) {
        PetscCall(VecCopy(l->x, l->safe));
        PetscFunctionReturn(0);
    }
    PetscCall(objective_resolve(&l->objective, l->x, l->working_tolerance, &value, &error));
    int sound = error <= CO_ACCEPTABLE_ERROR && fabs(total_of(l) - l->total) <= UNSOUND;
    PetscCall(objective_set_base(&l->objective, l->safe));
    PetscCall(objective_evaluate(&l->objective, l->safe, &safe_value, NULL));
    if (sound && value <= safe_value)
        PetscCall(VecCopy(l->x, l->safe));
    else
        PetscCall(VecCopy(l->safe, l->x));
    PetscCall(objective_set_base(&l->objective, l->x));
    l->stop = sound ? l->stop : CURVOPT_STOP_UNRESOLVED;
    *again = sound;
    PetscFunctionReturn(0);
}

static PetscErrorCode minimize(level *l) {
    const curvopt_options *o = l->r->options;
    Tao tao;
    TaoType type;
    TaoConvergedReason reason;
    PetscInt iterations;
    int again = 1;
    PetscFunctionBeginUser;
    l->total = total_of(l);
    PetscCall(objective_limit_steps(&l->objective, l->x, o->max_step));
    PetscCall(tao_solver_create(&l->objective, "", TAOLMVM, l->x, &tao));
    PetscCall(TaoSetSolution(tao, l->x));
    PetscCall(TaoSetTolerances(tao, 0, o->gradient_tolerance, 0));
    PetscCall(TaoSetMaximumFunctionEvaluations(tao, PETSC_MAX_INT));
    PetscCall(TaoSetConvergenceTest(tao, test_convergence, l));
    PetscCall(TaoSetMonitor(tao, show, l, NULL));
    for (int attempt = 0; again && attempt < MOST_ATTEMPTS && l->iterations < o->max_iterations; attempt++) {
        l->broke = 0;
        PetscCall(TaoSetMaximumIterations(tao, o->max_iterations - l->iterations));
        if (attempt == 0)
            PetscCall(TaoSetFromOptions(tao));
        PetscCall(TaoSolve(tao));
        PetscCall(TaoGetSolutionStatus(tao, &iterations, NULL, NULL, NULL, NULL, &reason));
        l->iterations += (int32_t)iterations;
        l->stop = l->broke ? CURVOPT_STOP_LIMIT : stop_of(reason);
        PetscCall(review(l, &again));
    }
    PetscCall(TaoGetType(tao, &type));
    PetscCall(PetscStrncpy(l->r->tao_type, type, sizeof l->r->tao_type));
    PetscCall(TaoDestroy(&tao));
    PetscFunctionReturn(0);
}

/* ----------------------------------------------------------------------------------------------- the level -- */

/* As the library's verdict: of what moves, and of motion along normals. */
static PetscErrorCode certify(level *l) {
    curvopt_summary *s = &l->r->summary;
    certificate *all = &l->r->all, *shape = &l->r->shape;
    double bearable = tuning->certificate_stationary * fabs(l->r->end.objective);
    PetscFunctionBeginUser;
    PetscCall(certificate_find(&l->objective, "verify_", l->x, all));
    PetscCall(constraints_to_normals(&l->objective, l->x));
    PetscCall(certificate_find(&l->objective, "verify_shape_", l->x, shape));
    l->r->certified = 1;
    s->newton_decrement = all->decrement;
    s->shape_decrement = s->difference_decrement = shape->positive ? shape->decrement : (double)NAN;
    s->negative_directions = shape->positive ? 0 : -1; /* some; how many is not known */
    s->all_negative_directions = all->positive ? 0 : -1;
    s->free_negative_directions = s->negative_directions;
    if (!(all->decrement <= bearable))
        s->verdict = CURVOPT_VERDICT_NOT_STATIONARY;
    else if (!shape->positive)
        s->verdict = CURVOPT_VERDICT_SADDLE;
    else
        s->verdict = shape->decrement <= bearable ? CURVOPT_VERDICT_MINIMUM : CURVOPT_VERDICT_NOT_STATIONARY;
    PetscFunctionReturn(0);
}

/* Positions in the user's units: in the frame they were taken from where something is fixed; else with the input's
 * area, centred as the level's first one was. */
static PetscErrorCode to_user(const level *l, double *xyz) {
    const PetscScalar *x;
    double unit = l->unit, scale = 1, centroid[3] = {0, 0, 0}, radius;
    size_t n = (size_t)l->on->n_own;
    PetscFunctionBeginUser;
    double *own = COLLECTIVE_NEW(l->on->comm, double, 3 * n);
    PetscCall(VecGetArrayRead(l->x, &x));
    objective_positions(&l->objective, x, own);
    PetscCall(VecRestoreArrayRead(l->x, &x));
    if (!l->objective.framed) {
        PetscCall(objective_frame(l->on, own, centroid, &radius));
        scale = sqrt(l->r->area / l->objective.sums.area) / radius;
        unit = 1;
    }
    for (size_t i = 0; i < 3 * n; i++) {
        const double *p = l->objective.project ? l->objective.project + 9 * (i / 3) : NULL;
        int fixed = l->objective.framed && p && p[0] + p[4] + p[8] < 0.5;
        if (!fixed) /* what is fixed stays, to the last bit */
            xyz[i] = l->origin[i % 3] + unit * scale * (own[i] - centroid[i % 3]);
    }
    free(own);
    PetscFunctionReturn(0);
}

static PetscErrorCode report_end(level *l, double started) {
    run *r = l->r;
    double value, error, norm;
    Vec gradient;
    int last = l->number == r->options->levels;
    PetscFunctionBeginUser;
    PetscCall(VecDuplicate(l->x, &gradient));
    PetscCall(objective_set_base(&l->objective, l->x));
    PetscCall(objective_resolve(&l->objective, l->x, last ? l->tolerance : l->working_tolerance, &value, &error));
    double unit = l->objective.framed ? l->unit : sqrt(r->area / l->objective.sums.area);
    PetscCall(report_energies(l, value, unit, &r->end));
    PetscCall(objective_evaluate(&l->objective, l->x, &value, gradient));
    PetscCall(VecNorm(gradient, NORM_2, &norm));
    PetscCall(VecDestroy(&gradient));
    r->level[r->n_levels++] = (curvopt_level_report){
        .energy = value,
        .gradient_norm = norm / fabs(value),
        .seconds = level_now() - started,
        .level = l->number,
        .n_vertices = l->on->whole_vertices,
        .iterations = l->iterations,
        .evaluations = l->objective.evaluations,
        .stop = error <= CO_ACCEPTABLE_ERROR || r->options->joshi_sequin ? l->stop : CURVOPT_STOP_UNRESOLVED};
    r->summary.stop = r->level[r->n_levels - 1].stop;
    PetscFunctionReturn(0);
}

/* The level's frame, vector and constraints; of positions in the user's units. */
static PetscErrorCode place(level *l, const constraints_pins *pins, const double *xyz, int *refused) {
    run *r = l->r;
    double *projectors;
    int any_free;
    PetscScalar *x;
    PetscFunctionBeginUser;
    PetscCall(constraints_find(l->on, r->options->boundary, pins, &projectors, &any_free));
    if (!any_free && pins->freedom) { /* as the library: only pins can be too many */
        free(projectors);
        *refused = refuse(r, CURVOPT_ERROR_ARGUMENT, "nothing may move: all vertices are held");
        PetscFunctionReturn(0);
    }
    l->objective.framed = projectors != NULL;
    PetscCall(objective_frame(l->on, xyz, l->origin, &l->unit));
    if (l->objective.framed) {
        memcpy(l->origin, r->centroid, sizeof l->origin);
        l->unit = r->radius;
    }
    PetscCall(subdomain_vector(l->on, &l->x));
    PetscCall(VecGetArrayWrite(l->x, &x));
    for (PetscInt i = 0; i < 3 * l->on->n_own; i++)
        x[i] = (xyz[i] - l->origin[i % 3]) / l->unit;
    PetscCall(VecRestoreArrayWrite(l->x, &x));
    PetscCall(VecDuplicate(l->x, &l->safe));
    PetscCall(VecCopy(l->x, l->safe));
    if (projectors)
        PetscCall(objective_constrain(&l->objective, l->x, projectors));
    PetscFunctionReturn(0);
}

static PetscErrorCode work(level *l, double *xyz, int *refused) {
    run *r = l->r;
    double value, error, started = level_now();
    PetscFunctionBeginUser;
    if (l->number == 1)
        PetscCall(report_start(l, refused));
    else
        PetscCall(objective_resolve(&l->objective, l->x, l->working_tolerance, &value, &error));
    if (*refused)
        PetscFunctionReturn(0);
    PetscCall(minimize(l));
    PetscCall(report_end(l, started));
    PetscCall(to_user(l, xyz));
    if (r->options->verify && l->number == r->options->levels && r->summary.stop != CURVOPT_STOP_UNRESOLVED)
        PetscCall(certify(l));
    PetscFunctionReturn(0);
}

PetscErrorCode level_solve(run *r, const subdomain *on, const constraints_pins *pins, int number, double *xyz,
                           int *refused) {
    level l = {.r = r, .on = on, .number = number, .stop = CURVOPT_STOP_LIMIT};
    PetscFunctionBeginUser;
    l.tolerance = r->options->joshi_sequin ? (double)INFINITY : r->options->tolerance;
    l.working_tolerance = number < r->options->levels ? tuning->working_factor * l.tolerance : l.tolerance;
    if (number == 1)
        PetscCall(objective_frame(on, xyz, r->centroid, &r->radius));
    PetscCall(objective_create(on, r->options, &l.objective, refused, r->message));
    if (!*refused)
        PetscCall(place(&l, pins, xyz, refused));
    if (!*refused)
        PetscCall(work(&l, xyz, refused));
    r->cpu_seconds += l.objective.cpu_seconds;
    r->least_seconds = l.objective.least_seconds;
    r->evaluations += l.objective.evaluations;
    PetscCall(VecDestroy(&l.x));
    PetscCall(VecDestroy(&l.safe));
    PetscCall(objective_free(&l.objective));
    PetscFunctionReturn(0);
}

PetscErrorCode level_gradient(const subdomain *on, const curvopt_options *options, const double *xyz, double *own,
                              int *refused) {
    objective o;
    Vec x, gradient;
    double value;
    const PetscScalar *g;
    char message[COLLECTIVE_MESSAGE];
    PetscScalar *at;
    size_t bytes = 3 * (size_t)on->n_own * sizeof *own;
    PetscFunctionBeginUser;
    PetscCall(objective_create(on, options, &o, refused, message));
    if (*refused)
        PetscFunctionReturn(0);
    PetscCall(subdomain_vector(on, &x));
    PetscCall(VecDuplicate(x, &gradient));
    PetscCall(VecGetArrayWrite(x, &at));
    memcpy(at, xyz, bytes);
    PetscCall(VecRestoreArrayWrite(x, &at));
    PetscCall(objective_evaluate(&o, x, &value, gradient));
    PetscCall(VecGetArrayRead(gradient, &g));
    memcpy(own, g, bytes);
    PetscCall(VecRestoreArrayRead(gradient, &g));
    PetscCall(VecDestroy(&gradient));
    PetscCall(VecDestroy(&x));
    PetscCall(objective_free(&o));
    PetscFunctionReturn(0);
}
