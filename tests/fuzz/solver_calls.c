/* Calls of a solver that stays, in any order. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solver_calls.h"

#include "fuzz.h"

#include <math.h>

enum { MOST_PINS = 3, MOST_CALLS = 6 };

/* A solver and what it was given. */
typedef struct stay {
    curvopt_solver *solver;
    int32_t n_vertices;
    const double *xyz;
    curvopt_options options;
    curvopt_constraints pins;
    int32_t vertex[MOST_PINS], freedom[MOST_PINS];
    double direction[3 * MOST_PINS], place[3 * MOST_PINS];
} stay;

static void check_status(int32_t status, const curvopt_error *error) {
    FUZZ_CHECK(status == CURVOPT_OK ||
               (status > 0 && status != CURVOPT_ERROR_MEMORY && error->code == status && error->message[0]));
}

static void any_places(reader *r, stay *s) {
    for (int i = 0; i < 3 * MOST_PINS; i++) {
        const int by = next(r);
        s->place[i] = s->xyz[3 * s->vertex[i / 3] + i % 3] + (by == 255 ? 1e60 : (by - 128) / 256.0);
    }
    if (next(r) % 8 == 1)
        s->place[0] = s->place[1] = s->place[2] = (double)NAN;
}

static void any_pins(reader *r, stay *s) {
    s->pins = (curvopt_constraints){.vertices = s->vertex, .freedom = s->freedom, .directions = s->direction};
    s->pins.n = next(r) % (MOST_PINS + 1);
    for (int k = 0; k < MOST_PINS; k++) {
        s->vertex[k] = next(r) % s->n_vertices;
        s->freedom[k] = next(r) % 4 == 1 ? next(r) % 3 : 0;
        for (int c = 0; c < 3; c++)
            s->direction[3 * k + c] = (k + c) % 3 - 1;
    }
    any_places(r, s);
    s->pins.has_places = next(r) % 4 != 1;
    s->pins.places = s->place;
    s->options.constraints = s->pins.n ? &s->pins : NULL;
}

/* Ends the solution at the last of so many calls. */
static int32_t count_down(const curvopt_progress *p, void *user) {
    int *left = user;
    for (int32_t i = 0; i < 3 * p->n_vertices; i++)
        FUZZ_CHECK(isfinite(p->xyz[i]));
    return --*left == 0;
}

static void call_solve(reader *r, stay *s) {
    curvopt_cancel *cancel;
    curvopt_error error = {0};
    int left = next(r) % 8;
    FUZZ_CHECK(curvopt_cancel_create(&cancel, &error) == CURVOPT_OK);
    if (next(r) % 8 == 1)
        curvopt_cancel_request(cancel);
    check_status(curvopt_solver_solve(s->solver, next(r) % 2, count_down, &left, cancel, &error), &error);
    curvopt_cancel_destroy(cancel);
}

static void call_set(reader *r, stay *s) {
    double other[3 * SOLVER_MOST_VERTICES];
    curvopt_error error = {0};
    switch (next(r) % 4) {
    case 0:
        for (int32_t i = 0; i < 3 * s->n_vertices; i++)
            other[i] = s->xyz[i] * (1 + next(r) % 4 / 16.0);
        check_status(curvopt_solver_set_positions(s->solver, next(r) % 2 ? other : NULL, &error), &error);
        break;
    case 1:
        any_pins(r, s);
        s->options.strength = next(r) % 4 == 1 ? 0.3 : 1;
        s->options.weights[next(r) % CURVOPT_N_TERMS] += 1;
        check_status(curvopt_solver_set_options(s->solver, &s->options, &error), &error);
        break;
    default:
        any_places(r, s);
        check_status(curvopt_solver_set_places(s->solver, s->place, &error), &error);
    }
}

static void check_state(const stay *s) {
    double xyz[3 * SOLVER_MOST_VERTICES];
    curvopt_summary summary;
    curvopt_energies start, end;
    curvopt_level_report level;
    curvopt_solver_get_positions(s->solver, xyz);
    curvopt_solver_get_summary(s->solver, &summary, sizeof summary);
    curvopt_solver_get_energies(s->solver, &start, &end, sizeof end);
    curvopt_solver_get_report(s->solver, &level, sizeof level);
    for (int32_t i = 0; i < 3 * s->n_vertices; i++)
        FUZZ_CHECK(isfinite(xyz[i]));
    FUZZ_CHECK(summary.n_levels == 0 || summary.n_vertices == s->n_vertices);
}

void call_solver(reader *r, const curvopt_mesh *mesh, int32_t n_vertices, const double *xyz,
                 const curvopt_options *options) {
    stay s = {.n_vertices = n_vertices, .xyz = xyz, .options = *options};
    curvopt_error error = {0};
    any_pins(r, &s);
    const int32_t status = curvopt_solver_create(mesh, xyz, &s.options, &s.solver, &error);
    check_status(status, &error);
    FUZZ_CHECK((s.solver != NULL) == (status == CURVOPT_OK));
    for (int k = next(r) % MOST_CALLS; s.solver && k >= 0; k--) {
        if (k % 2 == 0)
            call_solve(r, &s);
        else
            call_set(r, &s);
        check_state(&s);
    }
    curvopt_solver_destroy(s.solver);
}
