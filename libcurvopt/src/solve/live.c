/* A solver that stays. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/live.h"

#include "base/clock.h"
#include "base/memory.h"
#include "constraints/given_constraints.h"
#include "mesh/similarity.h"
#include "mesh/submesh.h"
#include "solve/live_solve.h"
#include "solve/multilevel.h"
#include "solve/run_start.h"
#include "solve/strength.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------------------- what is given -- */

static void free_given(co_live_given *g) {
    free(g->integers);
    free(g->reals);
    free(g->places);
    *g = (co_live_given){0};
}

static void copy_reals(double *to, const double *from, size_t n, double otherwise) {
    for (size_t i = 0; i < n; i++)
        to[i] = from ? from[i] : otherwise;
}

/* A copy in which every array is there. ERROR_ARGUMENT where it cannot be read. */
static int32_t copy_given(const curvopt_constraints *from, co_live_given *out, curvopt_error *error) {
    *out = (co_live_given){0};
    if (!from || from->n == 0)
        return CURVOPT_OK;
    if (from->n < 0 || !from->vertices)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "constraints: %d of them, vertices %s", from->n,
                              from->vertices ? "given" : "is NULL");
    const size_t n = (size_t)from->n;
    out->integers = CO_NEW(int32_t, 2 * n);
    out->reals = CO_NEW(double, 4 * n);
    out->places = CO_NEW(double, 3 * n);
    if (!out->integers || !out->reals || !out->places) {
        free_given(out);
        return co_status_no_memory(error);
    }
    memcpy(out->integers, from->vertices, n * sizeof *out->integers);
    if (from->freedom)
        memcpy(out->integers + n, from->freedom, n * sizeof *out->integers);
    copy_reals(out->reals, from->weights, n, 1);
    copy_reals(out->reals + n, from->directions, 3 * n, 0);
    copy_reals(out->places, from->has_places ? from->places : NULL, 3 * n, (double)NAN);
    out->given = (curvopt_constraints){.vertices = out->integers,
                                       .freedom = out->integers + n,
                                       .directions = from->directions ? out->reals + n : NULL,
                                       .n = from->n,
                                       .has_places = 1,
                                       .weights = out->reals,
                                       .places = out->places};
    return CURVOPT_OK;
}

static int32_t copy_holes(const curvopt_options *o, int32_t **out, curvopt_error *error) {
    *out = NULL;
    if (o->n_holes == 0)
        return CURVOPT_OK;
    *out = CO_NEW(int32_t, o->n_holes);
    if (!*out)
        return co_status_no_memory(error);
    memcpy(*out, o->holes, (size_t)o->n_holes * sizeof **out);
    return CURVOPT_OK;
}

/* ------------------------------------------------------------------------------------------- the run -- */

static void destroy_run(co_run *r) {
    if (!r)
        return;
    co_run_result_destroy(r->result);
    co_run_free_parts(r);
    free(r);
}

/* All that the solver's options need, of its first cage. */
static int32_t make_run(curvopt_solver *s, co_run **out, curvopt_error *error) {
    co_run *r = *out = CO_NEW(co_run, 1);
    if (!r)
        return co_status_no_memory(error);
    r->context = (co_run_context){.options = &s->options, .tuning = s->tuning, .tables = &s->tables};
    r->started = co_clock_seconds();
    r->is_live = 1;
    int32_t status = co_run_start(r, s->mesh, s->first, error);
    if (status == CURVOPT_OK) {
        if (!r->result->summary.n_unfolded)
            memcpy(r->at.start, s->first, 3 * sizeof *s->first * (size_t)s->mesh->info.n_vertices);
        status = co_run_take_shape(r, error);
    }
    if (status != CURVOPT_OK) {
        destroy_run(r);
        *out = NULL;
    }
    return status;
}

/* What a solver cannot do. */
static int32_t check_options(const curvopt_options *o, curvopt_error *error) {
    const char *what = o->joshi_sequin                    ? "joshi_sequin"
                       : o->method == CURVOPT_METHOD_LMVM ? "the method LMVM"
                       : o->slide                         ? "slide"
                       : o->through                       ? "points that the surface goes through"
                       : o->no_crossings                  ? "no_crossings"
                                                          : NULL;
    if (!what)
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_UNSUPPORTED, -1, "a solver that stays cannot have %s", what);
}

/* What new options are made of, until they are known to do. */
typedef struct renewal {
    curvopt_options options;
    co_live_given given;
    int32_t *holes;
    co_basis_table_cache tables;
    int has_tables; /* of another surface than the solver's */
} renewal;

static void exchange(curvopt_solver *s, renewal *r) {
    const renewal was = {s->options, s->given, s->holes, s->tables, r->has_tables};
    s->options = r->options;
    s->given = r->given;
    s->holes = r->holes;
    if (r->has_tables)
        s->tables = r->tables;
    r->options = was.options;
    r->given = was.given;
    r->holes = was.holes;
    if (r->has_tables)
        r->tables = was.tables;
    s->options.constraints = s->given.given.n ? &s->given.given : NULL;
    s->options.holes = s->holes;
}

static void free_renewal(renewal *r) {
    free_given(&r->given);
    free(r->holes);
    if (r->has_tables)
        co_basis_table_cache_free(&r->tables);
}

static int32_t make_renewal(curvopt_solver *s, const curvopt_options *options, renewal *r, curvopt_error *error) {
    *r = (renewal){.options = *options, .has_tables = options->surface != s->options.surface};
    r->options.levels = 1;
    if (r->options.symmetry == CURVOPT_SYMMETRY_AUTO)
        r->options.symmetry = CURVOPT_SYMMETRY_KEEP;
    if (r->has_tables) {
        co_basis_table_cache_create(options->surface, &r->tables);
        r->tables.cancel = &s->cancel;
        r->tables.threads = s->threads;
    }
    int32_t status = check_options(options, error);
    if (status == CURVOPT_OK)
        status = copy_given(options->constraints, &r->given, error);
    return status == CURVOPT_OK ? copy_holes(options, &r->holes, error) : status;
}

int32_t co_live_set_options(curvopt_solver *s, const curvopt_options *options, curvopt_error *error) {
    renewal next;
    co_run *run = NULL;
    int32_t status = make_renewal(s, options, &next, error);
    if (status == CURVOPT_OK) {
        exchange(s, &next);
        status = make_run(s, &run, error);
        if (status == CURVOPT_OK) {
            co_live_forget_levels(s);
            destroy_run(s->run);
            s->run = run;
        } else {
            exchange(s, &next);
        }
    }
    free_renewal(&next);
    return status;
}

/* --------------------------------------------------------------------------------------- the solver -- */

int32_t co_live_create(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                       const co_tuning *tuning, curvopt_solver **out, curvopt_error *error) {
    const size_t n = 3 * (size_t)mesh->info.n_vertices;
    curvopt_solver *s = *out = CO_NEW(curvopt_solver, 1);
    if (!s)
        return co_status_no_memory(error);
    s->tuning = tuning;
    s->options.surface = CURVOPT_SURFACE_AUTO; /* there are no tables yet */
    s->first = CO_NEW(double, n);
    s->xyz = CO_NEW(double, n);
    s->level_start = CO_NEW(double, n);
    s->normals_start = CO_NEW(double, n);
    s->beside = CO_NEW(double, n);
    int32_t status =
        s->first && s->xyz && s->level_start && s->normals_start && s->beside ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = co_submesh_copy(mesh, &s->mesh, error);
    if (status == CURVOPT_OK)
        status = co_thread_pool_create(options->threads, &s->threads, error);
    if (status == CURVOPT_OK) {
        memcpy(s->first, xyz, n * sizeof *xyz);
        status = co_live_set_options(s, options, error);
    }
    if (status == CURVOPT_OK)
        memcpy(s->xyz, s->run->at.start, n * sizeof *xyz);
    if (status != CURVOPT_OK) {
        co_live_destroy(s);
        *out = NULL;
    }
    return status;
}

void co_live_destroy(curvopt_solver *s) {
    if (!s)
        return;
    co_live_forget_levels(s);
    destroy_run(s->run);
    free_given(&s->given);
    free(s->holes);
    free(s->first);
    free(s->xyz);
    free(s->level_start);
    free(s->normals_start);
    free(s->beside);
    co_mesh_destroy(s->mesh);
    co_basis_table_cache_free(&s->tables);
    co_thread_pool_destroy(s->threads);
    free(s);
}

/* The symmetries that the solver's cage has with its constraints where they are now. Where they are others, what
 * depends on them is made anew. */
static int32_t renew_symmetry(curvopt_solver *s, curvopt_error *error) {
    co_run *r = s->run;
    co_symmetry before = r->at.symmetry;
    const size_t n = 3 * (size_t)s->mesh->info.n_vertices;
    if (before.order == 1)
        return CURVOPT_OK;
    double *goal = CO_NEW(double, n);
    if (!goal)
        return co_status_no_memory(error);
    memcpy(goal, s->xyz, n * sizeof *goal);
    r->at.symmetry = (co_symmetry){0};
    int32_t status = co_given_constraints_place(s->mesh, &r->constraints, s->options.boundary, goal, error);
    if (status == CURVOPT_OK)
        status = co_run_find_symmetry(r, s->mesh, goal, error);
    if (status == CURVOPT_OK && r->at.symmetry.order != before.order) {
        co_symmetry_free(&before);
        co_live_forget_levels(s);
    } else {
        co_symmetry_free(&r->at.symmetry);
        r->at.symmetry = before;
    }
    free(goal);
    return status;
}

/* Places go from one set of constraints, which is freed, into another one of the same vertices. */
static void take_places(const curvopt_solver *s, const co_constraints *from, co_constraints *to) {
    const size_t n = 3 * (size_t)s->mesh->info.n_vertices;
    memcpy(to->anchor, from->anchor, n * sizeof *to->anchor);
    if (!co_strength_stays_near(&s->options) && from->springs.stiffness) {
        memcpy(to->springs.anchor, from->springs.anchor, n * sizeof *to->anchor);
        memcpy(to->springs.original, from->springs.original, n * sizeof *to->anchor);
    }
}

int32_t co_live_set_places(curvopt_solver *s, const double *places, curvopt_error *error) {
    co_constraints next = {0}, before = {0};
    const size_t n = 3 * (size_t)s->given.given.n;
    curvopt_constraints given = s->given.given;
    if (n == 0)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "there are no constraints that could have places");
    given.places = places;
    int32_t status = co_given_constraints_create(s->mesh, s->first, &given, &next, error);
    if (status == CURVOPT_OK)
        status = co_given_constraints_check_strength(&given, &s->options, error);
    if (status == CURVOPT_OK && next.freedom) /* not where all weights are 0 */
        status = co_constraints_copy(s->mesh, &s->run->constraints, &before, error);
    if (status == CURVOPT_OK && next.freedom) {
        take_places(s, &next, &s->run->constraints);
        status = renew_symmetry(s, error);
        if (status != CURVOPT_OK)
            take_places(s, &before, &s->run->constraints);
    }
    if (status == CURVOPT_OK) {
        memcpy(s->given.places, places, n * sizeof *places);
        s->is_elsewhere = 1;
    }
    co_constraints_free(&next);
    co_constraints_free(&before);
    return status;
}

int32_t co_live_set_positions(curvopt_solver *s, const double *xyz, curvopt_error *error) {
    int32_t status = xyz ? co_similarity_check(s->mesh->info.n_vertices, xyz, error) : CURVOPT_OK;
    co_run *run = NULL;
    if (status == CURVOPT_OK) /* symmetries that were given up may be there again */
        status = make_run(s, &run, error);
    if (status != CURVOPT_OK)
        return status;
    co_live_forget_levels(s);
    destroy_run(s->run);
    s->run = run;
    memcpy(s->xyz, xyz ? xyz : run->at.start, 3 * sizeof *s->xyz * (size_t)s->mesh->info.n_vertices);
    return CURVOPT_OK;
}

/* What is not known of a solution that has not been looked at. */
static void clear_figures(co_run *r) {
    co_run_forget_verdict(&r->result->summary);
    r->at.report = (curvopt_level_report){.level = 1,
                                          .n_vertices = r->result->mesh->info.n_vertices,
                                          .energy = (double)NAN,
                                          .gradient_norm = (double)NAN};
    r->at.springs = (double)NAN;
    memset(r->at.multiplier, 0, sizeof r->at.multiplier);
    memset(r->at.residual, 0, sizeof r->at.residual);
    r->is_asked_to_stop = 0;
}

int32_t co_live_solve(curvopt_solver *s, int32_t settle, curvopt_progress_fn progress, void *user,
                      const curvopt_cancel *cancel, curvopt_error *error) {
    co_run *r = s->run;
    const size_t n = 3 * (size_t)s->mesh->info.n_vertices;
    r->progress = progress;
    r->user = user;
    r->started = co_clock_seconds();
    r->context.cancel = s->cancel.flag = cancel;
    atomic_store(&s->cancel.seen, 0);
    clear_figures(r);
    memcpy(r->at.start, s->xyz, n * sizeof *s->xyz);
    int32_t status = co_live_solve_level(s, settle, r->started, error);
    if (status == CURVOPT_OK) {
        memcpy(s->xyz, r->at.xyz, n * sizeof *s->xyz);
        r->result->level[0] = r->at.report;
        r->result->summary.n_levels = 1;
        co_run_summarize(r);
    } else {
        co_live_forget_levels(s);
    }
    r->context.cancel = s->cancel.flag = NULL;
    r->progress = NULL;
    return status;
}
