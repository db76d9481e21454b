/* The tangents by which curvatures are held. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/tangent_choice.h"

#include "base/clock.h"
#include "base/memory.h"
#include "constraints/given_constraints.h"
#include "constraints/held_curvatures.h"
#include "solve/level_figures.h"

#include <stdlib.h>
#include <string.h>

/* Tangents beside those that the run has, in a copy of its constraints. */
typedef struct choice {
    co_constraints constraints;
    double *from; /* [3 n_vertices] what the level without curvatures begins with */
    double *xyz;  /* [3 n_vertices] the cage that has the curvatures by this choice */
} choice;

static size_t size_of(const co_run *r) {
    return 3 * sizeof(double) * (size_t)r->result->mesh->info.n_vertices;
}

/* xyz has what is held, to rounding. */
static int32_t place(const co_run *r, const co_constraints *constraints, double *xyz, curvopt_error *error) {
    return co_given_constraints_place(r->result->mesh, constraints, r->context.options->boundary, xyz, error);
}

/* Tangents near those at xyz, which becomes a cage that has the curvatures with them. */
static int32_t fix(const co_run *r, co_constraints *constraints, double *xyz, curvopt_error *error) {
    int32_t status = co_held_curvatures_fix(r->result->mesh, xyz, &constraints->values, error);
    return status == CURVOPT_OK ? place(r, constraints, xyz, error) : status;
}

/* Refuses a cage that has come to cross itself, where that is not wanted. */
static int32_t check_crossings(const co_run *r, const double *xyz, curvopt_error *error) {
    if (!r->context.options->no_crossings)
        return CURVOPT_OK;
    return co_no_crossings_check(r->result->mesh, xyz, &r->no_crossings, r->threads, r->context.cancel, error);
}

/* Gives the run's start its curvatures, and makes the copy, in which they are free. */
static int32_t create(co_run *r, int32_t number, choice *c, curvopt_error *error) {
    *c = (choice){.from = CO_NEW(double, size_of(r) / sizeof(double)),
                  .xyz = CO_NEW(double, size_of(r) / sizeof(double))};
    if (!c->from || !c->xyz)
        return co_status_no_memory(error);
    memcpy(c->from, r->at.start, size_of(r));
    int32_t status =
        number == 1 ? fix(r, &r->constraints, r->at.start, error) : place(r, &r->constraints, r->at.start, error);
    if (status == CURVOPT_OK && number == 1)
        status = check_crossings(r, r->at.start, error);
    if (status == CURVOPT_OK)
        status = co_constraints_copy(r->result->mesh, &r->constraints, &c->constraints, error);
    if (status == CURVOPT_OK)
        co_held_curvatures_release(&c->constraints.values);
    return status;
}

static void choice_free(choice *c) {
    co_constraints_free(&c->constraints);
    free(c->from);
    free(c->xyz);
}

/* The level's minimum without curvatures, into c->xyz, in half of the steps that the level may take. */
static int32_t solve(co_run *r, int32_t number, choice *c, co_level **level, curvopt_error *error) {
    const co_level_prospect none = {.expects_plateau = 0};
    co_outcome outcome = {.iterations = 0};
    int32_t status = co_level_create(&r->context, r->result->mesh, &r->at.symmetry, &c->constraints, CO_MOTION_ALL,
                                     c->from, number, level, error);
    if (status == CURVOPT_OK) {
        co_run_watch(r, *level);
        const int32_t left = r->context.options->max_iterations - (*level)->spent;
        (*level)->spent += left - left / 2;
        status = co_level_begin(*level, error);
    }
    if (status == CURVOPT_OK)
        status = co_level_solve(*level, &none, &outcome, error);
    r->at.report.iterations += outcome.iterations;
    r->at.report.evaluations += outcome.evaluations + 1;
    if (status == CURVOPT_OK)
        co_level_objective_to_user(&(*level)->objective, (*level)->now.x, (*level)->now.found[CO_FOUND_SIZE], c->xyz);
    return status;
}

/* Takes the choice if its cage has less of the objective. Where it cannot be had the run goes on with what it has. */
static int32_t compare(co_run *r, choice *c, co_level *l, curvopt_error *error) {
    curvopt_error reason;
    int32_t status = fix(r, &c->constraints, c->xyz, &reason);
    if (status == CURVOPT_OK)
        status = check_crossings(r, c->xyz, &reason);
    if (status == CURVOPT_ERROR_MEMORY)
        return co_status_no_memory(error);
    if (status != CURVOPT_OK)
        return status == CO_CANCELLED ? status : CURVOPT_OK;
    const double before = co_level_objective_value_of(&l->objective, r->at.start);
    if (co_level_objective_value_of(&l->objective, c->xyz) < before) {
        co_surface_values *to = &r->constraints.values;
        memcpy(r->at.start, c->xyz, size_of(r));
        memcpy(to->item, c->constraints.values.item, (size_t)to->n * sizeof *to->item);
    }
    return CURVOPT_OK;
}

/* The callback has ended the run: its result is the start, and what the choice took has been told. */
static void end_cancelled(co_run *r, co_level *l, double started) {
    curvopt_energies energies;
    const co_run_work spent = r->spent;
    if (l && co_level_glance(l, r->at.start, &energies))
        r->at.energies = energies;
    co_run_end_cancelled(r, NULL, started);
    r->at.report.iterations = spent.iterations;
    r->at.report.evaluations = spent.evaluations;
}

int32_t co_tangent_choice_make(co_run *r, int32_t number, curvopt_error *error) {
    const double started = co_clock_seconds() - r->spent.seconds;
    choice c;
    co_level *level = NULL;
    if (!co_held_curvatures_exist(&r->constraints.values) || r->is_asked_to_stop)
        return CURVOPT_OK;
    r->at.report = (curvopt_level_report){.level = number,
                                          .n_vertices = r->result->mesh->info.n_vertices,
                                          .iterations = r->spent.iterations,
                                          .evaluations = r->spent.evaluations};
    int32_t status = create(r, number, &c, error);
    if (status == CURVOPT_OK)
        status = solve(r, number, &c, &level, error);
    if (status == CURVOPT_OK && !r->is_asked_to_stop)
        status = compare(r, &c, level, error);
    r->spent = (co_run_work){r->at.report.iterations, r->at.report.evaluations, co_clock_seconds() - started};
    if (r->is_asked_to_stop)
        end_cancelled(r, level, started);
    co_level_destroy(level);
    choice_free(&c);
    memcpy(r->at.xyz, r->at.start, size_of(r));
    return status == CO_CANCELLED ? CURVOPT_OK : status; /* the level's solution sees that, too */
}
