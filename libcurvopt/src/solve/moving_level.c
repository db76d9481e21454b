/* The first level of a run at which a vertex may move. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/moving_level.h"

#include "base/memory.h"
#include "constraints/given_constraints.h"
#include "energy/admissibility.h"
#include "mesh/subdivide.h"
#include "mesh/submesh.h"

#include <stdlib.h>

/* A level's cage, as a run begins with it: motion depends on constraints, not on what the levels before have moved. */
typedef struct stage {
    curvopt_mesh *mesh;
    double *xyz;
    co_constraints constraints;
} stage;

static void free_stage(stage *s) {
    co_mesh_destroy(s->mesh);
    free(s->xyz);
    co_constraints_free(&s->constraints);
    *s = (stage){0};
}

static int32_t look_at(const curvopt_mesh *mesh, const co_constraints *constraints, int32_t boundary, int *moves,
                       curvopt_error *error) {
    co_constraints all = {0};
    int32_t status = co_constraints_all(mesh, constraints, boundary, &all, error);
    *moves = status == CURVOPT_OK && co_constraints_allow_motion(mesh, &all);
    co_constraints_free(&all);
    return status;
}

static int32_t subdivide(stage *s, const double *xyz, curvopt_error *error) {
    stage fine = {0};
    co_sparse_rows rows = {0};
    int32_t status = co_subdivide_cage(s->mesh, s->xyz ? s->xyz : xyz, &fine.mesh, &rows, &fine.xyz, error);
    if (status == CURVOPT_OK)
        status = co_constraints_subdivide(s->mesh, fine.mesh, &rows, fine.xyz, &s->constraints, error);
    if (status == CURVOPT_OK) {
        fine.constraints = s->constraints;
        s->constraints = (co_constraints){0};
        free_stage(s);
        *s = fine;
    } else {
        free_stage(&fine);
    }
    co_sparse_rows_free(&rows);
    return status;
}

/* What may move does so by this level: three rows of vertices, held on all sides, leave one free inside a face that is
 * eight faces wide by then. What is held for other reasons stays so. */
enum { LAST_TO_FREE = 4 };

int32_t co_moving_level_find(const curvopt_mesh *mesh, const double *xyz, const co_constraints *constraints,
                             int32_t boundary, int32_t levels, int32_t *level, curvopt_error *error) {
    stage s = {0};
    int moves;
    int32_t status = look_at(mesh, constraints, boundary, &moves, error), at = 1;
    if (status == CURVOPT_OK && !moves && levels > 1) {
        status = co_submesh_copy(mesh, &s.mesh, error);
        if (status == CURVOPT_OK)
            status = co_constraints_copy(mesh, constraints, &s.constraints, error);
    }
    while (status == CURVOPT_OK && !moves && at < levels && at < LAST_TO_FREE) {
        at++;
        status = subdivide(&s, xyz, error);
        if (status == CURVOPT_OK)
            status = look_at(s.mesh, &s.constraints, boundary, &moves, error);
    }
    if (status == CURVOPT_OK)
        *level = moves ? at : 0;
    free_stage(&s);
    return status;
}

int32_t co_moving_level_of_run(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *o, int32_t *level,
                               curvopt_error *error) {
    co_constraints constraints = {0};
    co_exceptions found = {0};
    int32_t status = co_given_constraints_create(mesh, xyz, o->constraints, &constraints, error);
    if (status == CURVOPT_OK)
        status = co_exceptions_of_run(mesh, xyz, o, &found, error);
    if (status == CURVOPT_OK && found.n_left_out)
        status = co_constraints_leave_out(mesh, found.face, &constraints, error);
    if (status == CURVOPT_OK)
        status = co_moving_level_find(mesh, xyz, &constraints, o->boundary, o->levels, level, error);
    co_exceptions_free(&found);
    co_constraints_free(&constraints);
    return status;
}
