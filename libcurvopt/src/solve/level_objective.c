/* One level's function. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/level_objective.h"

#include "base/memory.h"
#include "constraints/held_curvatures.h"
#include "constraints/pivots.h"
#include "constraints/sliding.h"
#include "linalg/vector.h"
#include "mesh/similarity.h"
#include "solve/held_scalars.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int is_fixed(const co_level_objective *o) {
    return o->held.freedom != NULL;
}

/* Where only vertices' own limit points stand in their places these are as good places as they are. */
static const co_interpolation *map_to_cage(const co_level_objective *o) {
    return o->held.values.n ? &o->interpolation : NULL;
}

co_cage_edges co_level_objective_edges(const co_level_objective *o) {
    return (co_cage_edges){.mesh = o->mesh, .dofs = &o->reduction, .interpolation = map_to_cage(o)};
}

const double *co_level_objective_cage(co_level_objective *o) {
    if (!map_to_cage(o))
        return o->positions;
    memcpy(o->cage, o->positions, 3 * sizeof *o->cage * (size_t)o->mesh->info.n_vertices);
    co_interpolation_to_cage(&o->interpolation, o->cage);
    return o->cage;
}

/* Of the cage that was placed last, and the gradient [3 n_vertices] with respect to it, unless NULL. */
static double worth_of_cage(co_level_objective *o, double *gradient) {
    const double *x = co_level_objective_cage(o);
    const double spacing = co_spacing_value(&o->spacing, x, gradient);
    return spacing + co_corner_walls_value(&o->corners, x, gradient);
}

/* at->found and at->gradient, of normalized variables z. */
static void add_spacing(co_level_objective *o, const double *z, co_iterate *at) {
    size_t n = co_level_objective_n(o);
    double *gradient = at->gradient ? o->spacing_gradient : NULL;
    co_dof_map_expand(&o->reduction, z, o->positions);
    at->found[CO_FOUND_SPACING] = worth_of_cage(o, gradient);
    if (!gradient)
        return;
    if (map_to_cage(o))
        co_interpolation_gradient(&o->interpolation, gradient);
    co_dof_map_gradient(&o->reduction, gradient, o->step);
    co_vector_add(n, 1, o->step, at->gradient);
}

/* As add_spacing. */
static void add_repulsion(co_level_objective *o, const double *z, co_iterate *at) {
    double *gradient = at->gradient ? o->spacing_gradient : NULL;
    co_dof_map_expand(&o->reduction, z, o->positions);
    at->found[CO_FOUND_REPULSION] = co_repulsion_value(&o->repulsion, o->positions, gradient);
    if (!gradient || !isfinite(at->found[CO_FOUND_REPULSION]))
        return;
    co_dof_map_gradient(&o->reduction, gradient, o->step);
    co_vector_add(co_level_objective_n(o), 1, o->step, at->gradient);
}

void co_level_objective_restrict(const co_level_objective *o, double *d) {
    co_vector_remove(co_level_objective_n(o), (size_t)o->n_sliding, o->sliding, d);
}

static int holds_numbers(const co_level_objective *o) {
    return o->numbers.numbers.n > 0 && !o->numbers.is_idle;
}

/* Longest displacement of a vertex on its way back to held numbers. */
static double farthest_back(const co_level_objective *o) {
    return o->run->options->max_step * o->edge;
}

/* Where numbers are held nothing is known of a point that does not go back to them. */
static void leave_undefined(const co_level_objective *o, co_iterate *at) {
    at->value = (double)INFINITY;
    for (int k = 0; k < CO_N_FINDINGS; k++)
        at->found[k] = (double)NAN;
    if (at->gradient)
        memset(at->gradient, 0, co_level_objective_n(o) * sizeof *at->gradient);
}

void co_level_objective_evaluate(co_level_objective *o, co_iterate *at) {
    const co_assembly *a = &o->assembly;
    const double *x = at->x, *z = o->normalized;
    const co_request request = {.is_normalized = 1, .gradient = at->gradient ? o->point_gradient : NULL};
    co_values values;
    if (holds_numbers(o)) {
        if (!co_held_level_go_back(&o->numbers, x, farthest_back(o))) {
            leave_undefined(o, at);
            return;
        }
        x = o->numbers.back;
    }
    double radius = is_fixed(o) ? 1 : co_dof_map_normalize(&o->reduction, x, o->normalized);
    if (is_fixed(o))
        z = x;
    co_dof_map_expand_some(&o->reduction, a->active, a->n_active_cage, z, o->positions);
    co_assembly_evaluate(&o->assembly, o->positions, &request, &values);
    at->found[CO_FOUND_SIZE] = co_run_size_number(&o->run->size, values.integral[CO_INT_AREA],
                                                  values.integral[CO_INT_VOLUME], values.integral[CO_INT_MEAN]);
    at->found[CO_FOUND_DEFECT] = co_assembly_defect(a, &values);
    at->found[CO_FOUND_MIN_JACOBIAN] = values.min_jacobian;
    at->found[CO_FOUND_SPACING] = at->found[CO_FOUND_REPULSION] = 0;
    if (at->gradient)
        co_dof_map_gradient_of(&o->reduction, a->active, a->n_active_cage, o->point_gradient, at->gradient);
    if (o->spacing.weight > 0)
        add_spacing(o, z, at);
    if (o->repulsion.mesh)
        add_repulsion(o, z, at);
    if (at->gradient && !is_fixed(o))
        co_dof_map_normalized_gradient(&o->reduction, z, radius, at->gradient);
    at->value = values.objective + values.reference + o->run->least + at->found[CO_FOUND_SPACING] +
                at->found[CO_FOUND_REPULSION] + co_penalty_value(&o->penalty, x, at->gradient);
    if (at->gradient && holds_numbers(o))
        co_held_level_reduce_gradient(&o->numbers, values.integral, 1 / radius, at->gradient);
    if (at->gradient)
        co_level_objective_restrict(o, at->gradient);
}

void co_level_objective_go_back(co_level_objective *o, co_iterate *now) {
    if (holds_numbers(o) && co_held_level_go_back(&o->numbers, now->x, farthest_back(o)))
        memcpy(now->x, o->numbers.back, co_level_objective_n(o) * sizeof *now->x);
}

/* Smallest part of what is left to a target that is gone at once. */
static const double LEAST_PART = 0.02;
/* By which part of itself a value may rise on the way; of a sphere's stiffness where the value is less: a surface that
 * is flat has nothing to rise by. */
static const double MOST_RISE = 0.5, OF_SPHERE = 1e-2;

int co_level_objective_aim(co_level_objective *o, double most, co_iterate *now, int *changed) {
    const co_run_context *run = o->run;
    co_held_numbers *at = &o->numbers.numbers, from;
    *changed = 0;
    if (!holds_numbers(o))
        return 1;
    co_held_level_take_as_targets(&o->numbers, now->x);
    co_level_objective_evaluate(o, now);
    const double before = now->value, stiffness = co_penalty_stiffness(run->options->weights),
                 most_value = before + MOST_RISE * fmax(fabs(before), OF_SPHERE * stiffness);
    from = *at;
    for (double part = 1; part > LEAST_PART; part *= 0.5) {
        for (int k = 0; k < at->n; k++)
            at->held[k].target = from.held[k].target + part * (run->wanted.held[k].target - from.held[k].target);
        if (!co_held_level_go_back(&o->numbers, now->x, most * o->edge))
            continue;
        memcpy(o->numbers.work, now->x, co_level_objective_n(o) * sizeof *now->x);
        co_level_objective_go_back(o, now);
        co_level_objective_evaluate(o, now);
        if (now->value <= most_value) {
            *changed = 1;
            *run->held = *at;
            return part == 1;
        }
        memcpy(now->x, o->numbers.work, co_level_objective_n(o) * sizeof *now->x);
    }
    *at = from;
    *run->held = *at;
    co_level_objective_evaluate(o, now);
    return 0;
}

int co_level_objective_crosses(co_level_objective *o, const double *z) {
    co_repulsion *r = &o->repulsion;
    if (!r->mesh)
        return 0;
    r->is_thorough = 1;
    co_level_objective_place(o, z);
    const double value = co_repulsion_value(r, o->positions, NULL);
    r->is_thorough = 0;
    return !isfinite(value);
}

/* Of a mean edge: of third order shorter ones are too short. */
static const double SHORT = 0.4;
/* What a corner of half its least share costs, in parts of what the spacing is worth by the number of corners. */
static const double CORNER = 0.3;

int32_t co_level_objective_wall_corners(co_level_objective *o, curvopt_error *error) {
    return co_corner_walls_create(o->mesh, o->held.left_out, co_level_objective_cage(o), &o->corners, error);
}

void co_level_objective_weigh_spacing(co_level_objective *o, double worth, co_iterate *now) {
    o->spaced_energy = co_level_objective_energy(o, now);
    co_level_objective_place(o, now->x);
    o->spacing.edges = co_level_objective_edges(o);
    const double *x = co_level_objective_cage(o);
    co_spacing_weigh(&o->spacing, x, worth, o->assembly.functional.has_third ? SHORT * o->edge : 0);
    if (o->corners.least) {
        o->corners.cage = o->spacing.edges;
        co_corner_walls_weigh(&o->corners, x, CORNER * worth);
    }
    co_level_objective_evaluate(o, now);
}

double co_level_objective_value(co_level_objective *o, const double *z) {
    co_iterate at = {.x = (double *)z};
    co_level_objective_evaluate(o, &at);
    return at.value;
}

double co_level_objective_length(const co_level_objective *o, const double *d) {
    return co_dof_map_longest(&o->reduction, d) / o->edge;
}

double co_level_objective_distance(co_level_objective *o, const double *from, const double *to) {
    for (size_t k = 0; k < co_level_objective_n(o); k++)
        o->step[k] = to[k] - from[k];
    return co_level_objective_length(o, o->step);
}

void co_level_objective_place(co_level_objective *o, const double *z) {
    co_dof_map_expand(&o->reduction, z, o->positions);
}

double co_level_objective_take_size(co_level_objective *o) {
    double centroid[3];
    const double before = o->radius;
    o->radius = o->is_framed ? co_similarity_mesh_frame(o->mesh, co_level_objective_cage(o), centroid) : 1;
    co_assembly_take_radius(&o->assembly, o->radius);
    return fabs(o->radius / before - 1);
}

void co_level_objective_normalize(co_level_objective *o, co_iterate *now) {
    size_t n = co_level_objective_n(o);
    co_level_objective_go_back(o, now);
    if (!is_fixed(o)) {
        double radius = co_dof_map_normalize(&o->reduction, now->x, o->normalized);
        memcpy(now->x, o->normalized, n * sizeof *now->x);
        for (size_t k = 0; k < n; k++)
            now->gradient[k] *= radius;
    }
    co_level_objective_place(o, now->x);
    o->edge = co_mesh_mean_edge(o->mesh, o->held.left_out, co_level_objective_cage(o));
}

void co_level_objective_to_user(const co_level_objective *o, const double *z, double size, double *xyz) {
    const co_run_context *run = o->run;
    size_t n = (size_t)o->mesh->info.n_vertices;
    co_dof_map_expand(&o->reduction, z, xyz);
    if (o->is_framed) {
        for (size_t i = 0; i < 3 * n; i++) {
            const double origin = o->held.of_limit[i / 3] == CO_OF_TANGENT ? 0 : run->centroid[i % 3];
            xyz[i] = o->held.freedom[i / 3] == CO_FREEDOM_NONE ? o->stays[i] : origin + run->radius * xyz[i];
        }
        if (co_held_curvatures_exist(&o->held.values)) /* of short tangents any error is divided by the square */
            co_interpolation_to_cage_exactly(&o->interpolation, o->step, xyz);
        else
            co_interpolation_to_cage(&o->interpolation, xyz);
        return;
    }
    const double scale = co_run_size_unit(&run->size, size);
    for (size_t i = 0; i < 3 * n; i++)
        xyz[i] *= scale;
    co_similarity_align(n, o->likeness, xyz);
}

double co_level_objective_value_of(co_level_objective *o, const double *xyz) {
    const co_run_context *run = o->run;
    const co_request request = {.is_normalized = 1};
    co_values values;
    for (size_t i = 0; i < 3 * (size_t)o->mesh->info.n_vertices; i++)
        o->positions[i] = (xyz[i] - run->centroid[i % 3]) / run->radius;
    co_interpolation_from_cage(&o->interpolation, o->positions);
    co_assembly_evaluate(&o->assembly, o->positions, &request, &values);
    co_dof_map_variables(&o->reduction, o->positions, o->step);
    const double spacing = /* which has no weight before the level's first stage */
        o->spacing.weight > 0 ? worth_of_cage(o, NULL) : 0;
    return values.objective + values.reference + run->least + spacing + co_penalty_value(&o->penalty, o->step, NULL);
}

double co_level_objective_relative_gradient(const co_level_objective *o, const co_iterate *now) {
    double norm = co_vector_norm(co_level_objective_n(o), now->gradient);
    return norm == 0 ? 0 : norm / fabs(now->value); /* a flat surface has neither */
}

double co_level_objective_energy(const co_level_objective *o, const co_iterate *now) {
    return now->value - co_penalty_value(&o->penalty, now->x, NULL) - now->found[CO_FOUND_SPACING] -
           now->found[CO_FOUND_REPULSION];
}

/* Of the objective by which springs were made; a flat surface has none, and is to stay within their ends. */
static const double LEAST_WEIGHT = 1e-6;

int co_level_objective_weigh_springs(co_level_objective *o, double energy, double least) {
    if (!(o->held.springs.weighed_by > 0))
        return 0;
    const double weight = fmax(LEAST_WEIGHT, energy / o->held.springs.weighed_by);
    if (!(weight <= least * o->penalty.weight))
        return 0;
    o->penalty.weight = weight;
    return 1;
}

int co_level_objective_weigh_repulsion(co_level_objective *o, double energy, double least, co_iterate *now) {
    const double weight = o->run->tuning->repulsion * fmax(LEAST_WEIGHT, fabs(energy)), before = o->repulsion.weight;
    if (!o->repulsion.mesh || (before > 0 && !(weight <= least * before)))
        return 0;
    o->repulsion.weight = weight;
    co_level_objective_evaluate(o, now);
    return 1;
}

/* --------------------------------------------------------------------------------------- creation -- */

/* Positions, variables and springs, of constraints that are known. */
static int32_t create_variables(co_level_objective *o, const co_symmetry *symmetry, double *z, curvopt_error *error) {
    const co_run_context *run = o->run;
    size_t n = (size_t)o->mesh->info.n_vertices;
    double centroid[3], radius = co_similarity_mesh_frame(o->mesh, o->start, centroid);
    const double *origin = o->is_framed ? run->centroid : centroid;
    double unit = o->is_framed ? run->radius : radius;
    for (size_t i = 0; i < 3 * n; i++)
        o->positions[i] = (o->start[i] - origin[i % 3]) / unit;
    co_interpolation_from_cage(&o->interpolation, o->positions);
    memcpy(o->stays, o->start, 3 * n * sizeof *o->stays);
    co_interpolation_from_cage(&o->interpolation, o->stays);
    o->edge = co_mesh_mean_edge(o->mesh, o->held.left_out, co_level_objective_cage(o));
    int32_t status = co_dof_map_create(o->mesh, symmetry, &o->held, o->positions, &o->reduction, error);
    if (status != CURVOPT_OK)
        return status;
    co_dof_map_variables(&o->reduction, o->positions, z);
    const double scale = co_penalty_stiffness(run->options->weights);
    status = co_penalty_create(&o->held.springs, &o->reduction, origin, unit, scale, &o->penalty, error);
    if (status == CURVOPT_OK && o->held.drawn.n)
        status = co_surface_values_make_rows(o->mesh, &o->held.drawn, error);
    if (status == CURVOPT_OK && o->held.drawn.n)
        status = co_surface_springs_create(&o->held.drawn, &o->interpolation, &o->reduction, origin, unit, scale,
                                           &o->penalty.surface, error);
    return status;
}

/* The energy, over variables that are known. */
static int32_t create_energy(co_level_objective *o, const co_symmetry *symmetry, curvopt_error *error) {
    const co_run_context *run = o->run;
    double *face_weight = NULL;
    const co_substitution interpolated = {o->interpolation.vertex, &o->interpolation.cage};
    int32_t status = CURVOPT_OK;
    if (symmetry->order > 1 || o->held.left_out)
        status = co_dof_map_face_weights(o->mesh, symmetry, &face_weight, error);
    for (int32_t f = 0; status == CURVOPT_OK && o->held.left_out && f < o->mesh->info.n_faces; f++)
        face_weight[f] *= !o->held.left_out[f];
    if (status == CURVOPT_OK)
        status = co_assembly_create(o->mesh, run->shape ? run->shape : o->start, &interpolated, run->options,
                                    run->tables, face_weight, &o->assembly, error);
    o->assembly.spontaneous = run->spontaneous;
    o->assembly.leaves_out = o->held.left_out != NULL;
    o->assembly.measures_volume = run->held || run->size.measure == CURVOPT_SCALAR_VOLUME;
    if (status == CURVOPT_OK && run->held)
        status = co_held_level_create(run->held, &o->reduction, &o->assembly, o->positions, o->point_gradient,
                                      &o->numbers, error);
    free(face_weight);
    return status;
}

/* Springs that pull vertices back pull limit points back to where these were. */
static void pull_limit_points(co_level_objective *o) {
    const co_soft_constraints *springs = &o->held.springs;
    const co_interpolation *in = &o->interpolation;
    if (!springs->stiffness || !in->limit.n_rows)
        return;
    co_sparse_rows_apply(&in->limit, springs->original, in->work);
    for (int32_t i = 0; i < in->limit.n_rows; i++)
        memcpy(springs->anchor + 3 * (size_t)in->vertex[i], in->work + 3 * (size_t)i, 3 * sizeof(double));
}

/* The gauge is that of the whole problem: motion along normals does not see similarities either. */
static int32_t hold(co_level_objective *o, const co_symmetry *symmetry, const co_constraints *constraints,
                    co_motion motion, curvopt_error *error) {
    co_constraints all = {0};
    int32_t status = co_constraints_all(o->mesh, constraints, o->run->options->boundary, &all, error);
    o->gauge = co_gauge_of(o->run->options->weights, &all,
                           o->run->held != NULL || o->run->options->spontaneous_curvature != 0);
    o->is_framed = all.freedom != NULL;
    if (status == CURVOPT_OK)
        status = co_pivots_choose(o->mesh, symmetry, &all, error);
    if (motion == CO_MOTION_SLIDE && status == CURVOPT_OK)
        co_sliding_free_along(o->mesh->info.n_vertices, constraints->tangent, &all);
    if (motion != CO_MOTION_NORMALS || status != CURVOPT_OK) {
        o->held = all;
    } else {
        status = co_constraints_to_normals(o->mesh, &all, o->start, &o->held, error);
        if (status == CURVOPT_OK) {
            o->held.values = all.values;
            o->held.drawn = all.drawn;
            all.values = all.drawn = (co_surface_values){0};
        }
        co_constraints_free(&all);
    }
    if (status == CURVOPT_OK)
        status = co_interpolation_create(o->mesh, &o->held, &o->interpolation, error);
    if (status == CURVOPT_OK)
        pull_limit_points(o);
    return status;
}

/* Where nothing can move, nothing comes to cross: such are cages whose vertices are in few places. */
static int32_t create_repulsion(co_level_objective *o, curvopt_error *error) {
    const co_substitution interpolated = {o->interpolation.vertex, &o->interpolation.cage};
    if (!o->run->options->no_crossings || co_level_objective_n(o) == 0)
        return CURVOPT_OK;
    return co_repulsion_create(o->mesh, &interpolated, o->positions, o->run->tuning->repulsion_reach * o->edge,
                               o->run->exceptions, o->run->tables->threads, &o->repulsion, error);
}

/* What is left of similarities on normals. */
static int32_t span_sliding(co_level_objective *o, curvopt_error *error) {
    o->sliding = CO_NEW(double, (CO_GAUGE_MOTIONS + 1) * co_level_objective_n(o));
    if (!o->sliding)
        return co_status_no_memory(error);
    o->n_sliding =
        co_gauge_columns(&o->reduction, o->positions, co_gauge_exact(o->gauge), o->point_gradient, o->sliding);
    return CURVOPT_OK;
}

int32_t co_level_objective_create(const co_run_context *run, const curvopt_mesh *mesh, const co_symmetry *symmetry,
                                  const co_constraints *constraints, co_motion motion, const double *start,
                                  co_level_objective *o, double *z, curvopt_error *error) {
    size_t n = 3 * (size_t)mesh->info.n_vertices;
    *o = (co_level_objective){.run = run,
                              .mesh = mesh,
                              .start = start,
                              .likeness = start,
                              .stays = CO_NEW(double, n),
                              .positions = CO_NEW(double, n),
                              .cage = CO_NEW(double, n),
                              .point_gradient = CO_NEW(double, n),
                              .spacing_gradient = CO_NEW(double, n),
                              .normalized = CO_NEW(double, n),
                              .step = CO_NEW(double, n)};
    int32_t status =
        o->stays && o->positions && o->cage && o->point_gradient && o->spacing_gradient && o->normalized && o->step
            ? CURVOPT_OK
            : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = hold(o, symmetry, constraints, motion, error);
    if (status == CURVOPT_OK)
        status = create_variables(o, symmetry, z, error);
    if (status == CURVOPT_OK)
        status = create_energy(o, symmetry, error);
    if (status == CURVOPT_OK) {
        co_level_objective_take_size(o);
        status = create_repulsion(o, error);
    }
    if (status == CURVOPT_OK && motion == CO_MOTION_NORMALS && co_level_objective_n(o) > 0)
        status = span_sliding(o, error);
    if (status != CURVOPT_OK)
        co_level_objective_free(o);
    return status;
}

static int have_same_pattern(const co_dof_map *a, const co_dof_map *b) {
    return a->n_nodes == b->n_nodes && a->n_variables == b->n_variables &&
           memcmp(a->node, b->node, (size_t)a->n_vertices * sizeof *a->node) == 0 &&
           memcmp(a->first, b->first, ((size_t)a->n_nodes + 1) * sizeof *a->first) == 0;
}

static int have_same_limits(const co_interpolation *a, const co_interpolation *b) {
    return a->limit.n_rows == b->limit.n_rows &&
           (!a->limit.n_rows || memcmp(a->vertex, b->vertex, (size_t)a->limit.n_rows * sizeof *a->vertex) == 0);
}

int32_t co_level_objective_move(co_level_objective *o, const co_symmetry *symmetry, const co_constraints *constraints,
                                co_motion motion, const double *start, double *z, int *fits, curvopt_error *error) {
    co_dof_map before = o->reduction;
    co_interpolation limits = o->interpolation;
    const int was_framed = o->is_framed;
    const double weight = o->penalty.weight;
    o->reduction = (co_dof_map){0};
    o->interpolation = (co_interpolation){0};
    co_constraints_free(&o->held);
    co_penalty_free(&o->penalty);
    free(o->sliding);
    o->sliding = NULL;
    o->n_sliding = 0;
    o->start = o->likeness = start;
    *fits = 0;
    int32_t status = hold(o, symmetry, constraints, motion, error);
    if (status == CURVOPT_OK)
        status = create_variables(o, symmetry, z, error);
    o->penalty.weight = weight;
    if (status == CURVOPT_OK)
        *fits = was_framed == o->is_framed && have_same_pattern(&before, &o->reduction) &&
                have_same_limits(&limits, &o->interpolation);
    if (*fits && motion == CO_MOTION_NORMALS && co_level_objective_n(o) > 0)
        status = span_sliding(o, error);
    if (*fits)
        co_level_objective_take_size(o);
    co_dof_map_free(&before);
    co_interpolation_free(&limits);
    return status;
}

void co_level_objective_free(co_level_objective *o) {
    co_held_level_free(&o->numbers);
    co_assembly_free(&o->assembly);
    co_repulsion_free(&o->repulsion);
    co_corner_walls_free(&o->corners);
    co_dof_map_free(&o->reduction);
    co_penalty_free(&o->penalty);
    co_constraints_free(&o->held);
    co_interpolation_free(&o->interpolation);
    free(o->sliding);
    free(o->stays);
    free(o->positions);
    free(o->cage);
    free(o->point_gradient);
    free(o->spacing_gradient);
    free(o->normalized);
    free(o->step);
    *o = (co_level_objective){0};
}
