/* Away from saddles that symmetry hides.
 *
 * A minimum among cages of some symmetry is stationary among all cages, but need not be a minimum there: the Hessian
 * may be negative in directions that break the symmetry. What such a direction keeps of it is a subgroup (Golubitsky,
 * Stewart, Schaeffer, "Singularities and groups in bifurcation theory II", 1988, chapter XIII); the largest ones are
 * tried first, so that no more symmetry is lost than must be, and no more time. Among those of one order the steepest
 * way decides: any of them leads down, but often to the next saddle.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/saddle_escape.h"

#include "base/memory.h"
#include "constraints/kept_symmetry.h"
#include "constraints/subgroups.h"
#include "mesh/similarity.h"

#include <stdlib.h>
#include <string.h>

/* Where to look from. */
typedef struct place {
    const co_run_context *run;
    const curvopt_mesh *mesh;
    const co_constraints *constraints;
    co_motion motion; /* by which a way is looked for */
    const double *xyz;
    int32_t number;
} place;

void co_saddle_escape_free(co_way_down *way) {
    co_symmetry_free(&way->symmetry);
    free(way->xyz);
    *way = (co_way_down){0};
}

/* Looks for a way among cages with this symmetry; if there is one, xyz is some way along, and *gain what that brings.
 */
static int32_t look(const place *p, const co_symmetry *symmetry, double *xyz, int *found, double *gain,
                    curvopt_error *error) {
    co_level *level = NULL;
    double before = 0;
    *found = 0;
    *gain = 0;
    int32_t status =
        co_level_create(p->run, p->mesh, symmetry, p->constraints, p->motion, p->xyz, p->number, &level, error);
    if (status == CURVOPT_OK)
        status = co_level_begin(level, error);
    if (status == CURVOPT_OK && co_level_objective_n(&level->objective) && !co_run_context_is_cancelled(p->run)) {
        before = level->now.value;
        status = co_level_leave_saddle(level, found, error);
    }
    if (status == CURVOPT_OK && *found) {
        *gain = before - level->now.value;
        co_level_objective_to_user(&level->objective, level->now.x, level->now.found[CO_FOUND_SIZE], xyz);
    }
    co_level_destroy(level);
    return status;
}

static int32_t look_without_symmetry(const place *p, double *xyz, int *found, curvopt_error *error) {
    co_symmetry none = {0};
    double gain;
    int32_t status = co_symmetry_none(p->mesh, &none, error);
    if (status == CURVOPT_OK)
        status = look(p, &none, xyz, found, &gain, error);
    co_symmetry_free(&none);
    return status;
}

/* The best of what was found, and a way that is looked at. */
typedef struct search {
    co_way_down *best;
    double gain;
    double *xyz; /* [3 n_vertices] */
} search;

/* In one subgroup. */
static int32_t look_in_subgroup(const place *p, const co_symmetry *symmetry, const uint8_t *member, search *s,
                                curvopt_error *error) {
    co_symmetry sub = {0};
    double gain = 0;
    int found = 0;
    int32_t status = co_subgroup_select(symmetry, member, &sub, error);
    if (status == CURVOPT_OK)
        status = co_kept_symmetry_restrict(p->mesh, p->constraints, p->run->options->boundary, &sub, error);
    if (status == CURVOPT_OK)
        status = look(p, &sub, s->xyz, &found, &gain, error);
    if (status == CURVOPT_OK && found && (!s->best->found || gain > s->gain)) {
        co_symmetry_free(&s->best->symmetry);
        s->best->symmetry = sub;
        s->best->found = 1;
        s->gain = gain;
        memcpy(s->best->xyz, s->xyz, 3 * sizeof(double) * (size_t)p->mesh->info.n_vertices);
    } else {
        co_symmetry_free(&sub);
    }
    return status;
}

/* In subgroups of an index of at most this, the largest first; of the same order, the one where it goes down most. */
static int32_t look_in_subgroups(const place *p, const co_symmetry *symmetry, int32_t largest_index, co_way_down *out,
                                 curvopt_error *error) {
    co_subgroups groups = {0};
    search s = {.best = out, .xyz = CO_NEW(double, 3 * (size_t)p->mesh->info.n_vertices)};
    int32_t status = s.xyz ? co_subgroups_create(symmetry, &groups, error) : co_status_no_memory(error);
    for (int32_t k = 0; status == CURVOPT_OK && k < groups.n; k++) {
        if (groups.order[k] < symmetry->order / largest_index || (out->found && groups.order[k] < out->symmetry.order))
            break;
        status = look_in_subgroup(p, symmetry, groups.member + (size_t)k * (size_t)groups.n_elements, &s, error);
    }
    co_subgroups_free(&groups);
    free(s.xyz);
    return status;
}

/* Planes that the user chose are not given up. Elsewhere a way that keeps less than the largest subgroups do costs more
 * than it is worth, looked for and gone (symmetry_reduction.c); but who asks for an escape from a saddle of the
 * shape wants to know whether there is one at all. */
static int32_t largest_index(const curvopt_options *o, const co_tuning *t, const co_symmetry *symmetry,
                             co_motion among) {
    if (o->symmetry == CURVOPT_SYMMETRY_PLANES)
        return 1;
    return among == CO_MOTION_ALL ? t->escape_index : symmetry->order;
}

int32_t co_saddle_escape_find(const co_run_context *run, const curvopt_mesh *m, const co_symmetry *symmetry,
                              const co_constraints *constraints, const double *xyz, int32_t number, co_motion among,
                              co_way_down *out, curvopt_error *error) {
    const place p = {.run = run, .mesh = m, .constraints = constraints, .motion = among, .xyz = xyz, .number = number};
    int possible = 1;
    *out = (co_way_down){.xyz = CO_NEW(double, 3 * (size_t)m->info.n_vertices)};
    int32_t status = out->xyz ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK && among == CO_MOTION_NORMALS)
        status = look_without_symmetry(&p, out->xyz, &possible, error);
    if (status == CURVOPT_OK && possible)
        status = look_in_subgroups(&p, symmetry, largest_index(run->options, run->tuning, symmetry, among), out, error);
    if (status != CURVOPT_OK)
        co_saddle_escape_free(out);
    return status;
}
