/* What comes in: the cage and its pins. SPDX-License-Identifier: GPL-3.0-or-later */
#include "collective.h"
#include "main.h"
#include "obj_cage.h"
#include "partition.h"
#include "pins.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Cages that are no manifold or degenerate, or have holes, are not for this program; the library says it in its words.
 */
static int32_t check_sound(const program *p, const obj_cage *cage, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_problem *problem = NULL;
    int is_sound = 1;
    int32_t *reason = malloc(sizeof *reason * (size_t)cage->n_vertices);
    if (!reason)
        return CURVOPT_ERROR_MEMORY;
    int32_t status = curvopt_mesh_find_exceptions(mesh, cage->xyz, &p->args.options, reason, NULL, error);
    for (int32_t v = 0; status == CURVOPT_OK && v < cage->n_vertices; v++)
        is_sound &=
            reason[v] < 0 || (reason[v] > CURVOPT_EXCEPTION_PINCHED && reason[v] != CURVOPT_EXCEPTION_DEGENERATE);
    free(reason);
    if (status == CURVOPT_OK && !is_sound)
        status = curvopt_problem_create(mesh, cage->xyz, &p->args.options, &problem, error);
    curvopt_problem_destroy(problem);
    if (status == CURVOPT_OK && cage->n_holes) {
        status = CURVOPT_ERROR_UNSUPPORTED;
        snprintf(error->message, sizeof error->message, "the cage has holes, which curvopt-tao does not know");
    }
    return status;
}

static int read_cage(const program *p, obj_cage *cage, curvopt_mesh **mesh, char *message) {
    curvopt_error error = {.message = "out of memory"};
    *mesh = NULL;
    if (obj_read(p->args.input, cage, message, COLLECTIVE_MESSAGE))
        return ARGUMENTS_COULD_NOT;
    curvopt_creases creases = obj_creases(cage, p->args.boundary_rule);
    int32_t status = curvopt_mesh_create_creased(cage->n_vertices, cage->n_faces, cage->face_sizes, cage->face_vertices,
                                                 &creases, mesh, &error);
    if (status == CURVOPT_OK)
        status = check_sound(p, cage, *mesh, &error);
    if (status != CURVOPT_OK)
        curvopt_mesh_destroy(*mesh);
    if (status == CURVOPT_OK && cage->n_faces < p->n_ranks) {
        snprintf(message, COLLECTIVE_MESSAGE, "the cage has %d faces, fewer than there are ranks (%d)", cage->n_faces,
                 p->n_ranks);
        curvopt_mesh_destroy(*mesh);
    } else if (status == CURVOPT_OK) {
        return ARGUMENTS_DONE;
    } else {
        snprintf(message, COLLECTIVE_MESSAGE, "%s", error.message);
    }
    obj_free(cage);
    return ARGUMENTS_COULD_NOT;
}

/* Coordinates that the library would refuse must not come as far as any arithmetic. */
static int32_t check_positions(const program *p, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    curvopt_sampler *sampler;
    int32_t status = curvopt_sampler_create(mesh, xyz, &p->args.options, &sampler, error);
    curvopt_sampler_destroy(sampler);
    return status;
}

int input_cage(program *p) {
    obj_cage cage;
    curvopt_mesh *mesh = NULL;
    curvopt_error error;
    char message[COLLECTIVE_MESSAGE];
    int code = ARGUMENTS_DONE;
    if (p->rank == 0)
        code = read_cage(p, &cage, &mesh, message);
    if (p->rank == 0 && code == ARGUMENTS_DONE && check_positions(p, mesh, cage.xyz, &error) != CURVOPT_OK) {
        snprintf(message, sizeof message, "%s", error.message);
        obj_free(&cage);
        curvopt_mesh_destroy(mesh);
        code = ARGUMENTS_COULD_NOT;
    }
    code = program_follow(p, code);
    if (code != ARGUMENTS_DONE)
        return program_say(p, code, p->args.input, message);
    partition_source source = {.mesh = mesh, .xyz = p->rank == 0 ? cage.xyz : NULL};
    PetscCallAbort(p->comm, partition_cage(p->comm, &source, &p->on, &p->xyz));
    if (p->rank == 0) {
        obj_free(&cage);
        curvopt_mesh_destroy(mesh);
    }
    return ARGUMENTS_DONE;
}

/* The library's own words on why it refuses a cage, asked for when that cannot cost a run any more; or `message`. */
static void explain(const program *p, char *message) {
    obj_cage cage;
    curvopt_mesh *mesh;
    curvopt_result *result = NULL;
    curvopt_error error;
    pin_list pins = {0};
    char ignored[COLLECTIVE_MESSAGE];
    curvopt_options o = p->args.options;
    curvopt_constraints constraints;
    o.levels = 1;
    o.max_iterations = 0;
    if (!strcmp(p->args.input, "-") || read_cage(p, &cage, &mesh, ignored) != ARGUMENTS_DONE)
        return;
    if (p->args.pins && pins_read(p->args.pins, &pins, ignored, sizeof ignored) == 0) {
        constraints = (curvopt_constraints){
            .vertices = pins.vertices, .freedom = pins.freedom, .directions = pins.directions, .n = pins.n};
        o.constraints = &constraints;
    }
    if (curvopt_minimize(mesh, cage.xyz, &o, NULL, NULL, NULL, &result, &error) != CURVOPT_OK)
        snprintf(message, COLLECTIVE_MESSAGE, "%s", error.message);
    curvopt_result_destroy(result);
    curvopt_mesh_destroy(mesh);
    pins_free(&pins);
    obj_free(&cage);
}

int input_refuse(const program *p, char *message) {
    if (p->rank == 0)
        explain(p, message);
    return program_say(p, ARGUMENTS_COULD_NOT, p->args.input, message);
}

/* ---------------------------------------------------------------------------------------------------- pins -- */

static int same_pin(const pin_list *pins, int32_t i, int32_t j) {
    return pins->freedom[i] == pins->freedom[j] &&
           (!pins->freedom[i] ||
            !memcmp(pins->directions + 3 * (size_t)i, pins->directions + 3 * (size_t)j, 3 * sizeof(double)));
}

/* Every rank has all pins for a moment; they are the user's lines. */
static void broadcast_pins(const program *p, pin_list *pins) {
    MPI_Bcast(&pins->n, 1, MPI_INT32_T, 0, p->comm);
    if (p->rank != 0) {
        pins->vertices = COLLECTIVE_NEW(p->comm, int32_t, pins->n);
        pins->freedom = COLLECTIVE_NEW(p->comm, int32_t, pins->n);
        pins->directions = COLLECTIVE_NEW(p->comm, double, 3 * (size_t)pins->n);
    }
    MPI_Bcast(pins->vertices, pins->n, MPI_INT32_T, 0, p->comm);
    MPI_Bcast(pins->freedom, pins->n, MPI_INT32_T, 0, p->comm);
    MPI_Bcast(pins->directions, 3 * pins->n, MPI_DOUBLE, 0, p->comm);
}

/* Pins of own vertices; nonzero if there is something wrong with any. */
static int take_pins(program *p, const pin_list *pins) {
    PetscInt whole = p->on.whole_vertices;
    int wrong = 0;
    int32_t *pin_of = COLLECTIVE_NEW(p->comm, int32_t, whole); /* 0: none, else its number and 1 */
    for (int32_t i = 0; i < pins->n; i++) {
        int32_t v = pins->vertices[i];
        const double *d = pins->directions + 3 * (size_t)i;
        double length = pins->freedom[i] ? sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) : 1;
        int in_range = v >= 0 && v < whole;
        wrong |= !in_range || !(length > 0) || !isfinite(length) ||
                 (in_range && pin_of[v] && !same_pin(pins, i, pin_of[v] - 1));
        if (in_range)
            pin_of[v] = i + 1;
    }
    p->pins.freedom = COLLECTIVE_NEW(p->comm, unsigned char, p->on.n_own);
    p->pins.direction = COLLECTIVE_NEW(p->comm, double, 3 * (size_t)p->on.n_own);
    for (PetscInt k = 0; k < p->on.n_own; k++) {
        int32_t pin = pin_of[p->on.vertex[p->on.own[k]]];
        p->pins.freedom[k] = pin ? (unsigned char)pins->freedom[pin - 1] : 3;
        if (pin)
            memcpy(p->pins.direction + 3 * (size_t)k, pins->directions + 3 * (size_t)(pin - 1), 3 * sizeof(double));
    }
    free(pin_of);
    return wrong;
}

/* What this program does not have of constraint i, a sentence's end; or NULL. */
static const char *unknown_here(const pin_list *pins, int32_t i) {
    return pins->weights[i] != 1 ? "has a weight: curvopt-tao holds vertices exactly or not at all"
           : pins->freedom[i] >= CURVOPT_FREEDOM_OF_LIMIT_POINT
               ? "is given by its limit point: curvopt-tao holds vertices themselves"
           : isnan(pins->places[3 * (size_t)i]) ? NULL
                                                : "is to be elsewhere: curvopt-tao holds vertices where they are";
}

int input_pins(program *p) {
    pin_list pins = {0};
    char message[COLLECTIVE_MESSAGE];
    int code = ARGUMENTS_DONE;
    if (!p->args.pins)
        return ARGUMENTS_DONE;
    if (p->rank == 0 && pins_read(p->args.pins, &pins, message, sizeof message))
        code = ARGUMENTS_COULD_NOT;
    for (int32_t i = 0; code == ARGUMENTS_DONE && i < pins.n; i++)
        if (unknown_here(&pins, i)) {
            snprintf(message, sizeof message, "vertex %d %s", (int)pins.vertices[i], unknown_here(&pins, i));
            code = ARGUMENTS_COULD_NOT;
        }
    code = program_follow(p, code);
    if (code != ARGUMENTS_DONE) {
        pins_free(&pins);
        return program_say(p, code, p->args.pins, message);
    }
    broadcast_pins(p, &pins);
    int wrong = take_pins(p, &pins);
    pins_free(&pins);
    strcpy(message, "two pins on one vertex contradict, or a pin has no direction, or its vertex does not exist");
    return wrong ? input_refuse(p, message) : ARGUMENTS_DONE;
}
