/* What a run begins with. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/run_start.h"

#include "base/constants.h"
#include "base/memory.h"
#include "constraints/given_constraints.h"
#include "constraints/given_through.h"
#include "constraints/held_curvatures.h"
#include "constraints/kept_symmetry.h"
#include "constraints/look_ahead.h"
#include "constraints/loose_components.h"
#include "constraints/mirror_planes.h"
#include "constraints/value_images.h"
#include "energy/admissibility.h"
#include "mesh/ring.h"
#include "mesh/similarity.h"
#include "mesh/submesh.h"
#include "solve/component_options.h"
#include "solve/held_scalars.h"
#include "solve/moving_level.h"
#include "solve/strength.h"
#include "solve/unfold.h"
#include "surface/blend_disc_half.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a sphere's stiffness: energy of a dent of 1e-10 of the size, and less than rounding of most energies. */
static const double LEAST = 1e-20;

/* Whether nothing says how large the result is to be, though something is held: one place alone, or places in a plane.
 * Energies but the area have no size without spontaneous curvature, and the cage would shrink, for small cages are more
 * even. */
static int is_size_free(const co_run *r, const curvopt_mesh *mesh, const co_constraints *all) {
    const curvopt_options *o = r->context.options;
    int is_given = o->joshi_sequin || o->method == CURVOPT_METHOD_LMVM || o->weights[CURVOPT_TERM_AREA] > 0;
    for (int s = 0; s < CURVOPT_N_SCALARS; s++)
        is_given |= o->scalar_rule[s] == CURVOPT_SCALAR_RULE_KEEP || o->scalar_rule[s] == CURVOPT_SCALAR_RULE_VALUE;
    is_given |= fabs(r->result->start.objective) <= CO_FLAT_ENERGY; /* nothing moves it */
    return all->freedom && !r->is_live && !is_given &&
           co_constraints_allow_dilation(mesh, r->at.start, all, r->context.radius);
}

/* The numbers that are held, and the size of the result, from the input cage's. */
static int32_t hold_scalars(co_run *r, const curvopt_mesh *mesh, co_assembly *assembly, curvopt_error *error) {
    curvopt_options options = *r->context.options;
    co_constraints all = {0};
    co_values values;
    int32_t status = co_constraints_all(mesh, &r->constraints, options.boundary, &all, error);
    if (status != CURVOPT_OK)
        return status;
    const int is_framed = all.freedom != NULL;
    if (is_size_free(r, mesh, &all))
        options.scalar_rule[CURVOPT_SCALAR_AREA] = CURVOPT_SCALAR_RULE_KEEP;
    co_constraints_free(&all);
    co_assembly_evaluate(assembly, r->at.xyz, &(co_request){.volume = 1}, &values);
    status = co_held_scalars_create(&options, assembly, &values, is_framed, &r->held, &r->context.size, error);
    r->context.spontaneous =
        co_held_scalars_spontaneous(&options, &r->held, &r->context.size, is_framed, r->context.radius,
                                    values.radius * values.radius * values.integral[CO_INT_AREA]);
    r->context.wanted = r->held;
    r->context.held = r->held.n ? &r->held : NULL;
    return status;
}

static int32_t create_assembly(const co_run *r, const curvopt_mesh *mesh, const double *xyz, co_assembly *assembly,
                               curvopt_error *error) {
    const uint8_t *left_out = r->constraints.left_out;
    double *weight = left_out ? CO_NEW(double, mesh->info.n_faces) : NULL;
    if (left_out && !weight)
        return co_status_no_memory(error);
    for (int32_t f = 0; left_out && f < mesh->info.n_faces; f++)
        weight[f] = !left_out[f];
    const int32_t status =
        co_assembly_create(mesh, xyz, NULL, r->context.options, r->context.tables, weight, assembly, error);
    assembly->leaves_out = left_out != NULL;
    free(weight);
    return status;
}

/* Figures of the present cage, with an assembly of their own: what they need of quadrature, the optimization does not.
 * At the start springs are weighed by it. */
static int32_t report_cage(co_run *r, const curvopt_mesh *mesh, int is_start, curvopt_energies *out, int *resolved,
                           curvopt_error *error) {
    co_assembly assembly;
    int changed;
    const double tolerance = co_run_context_tolerance(&r->context);
    int32_t status = create_assembly(r, mesh, r->at.xyz, &assembly, error);
    if (status != CURVOPT_OK)
        return status;
    status = co_adaptive_quadrature_resolve(&assembly, r->at.xyz,
                                            &(co_quadrature_goal){.tolerance = tolerance, .terms = CO_TERMS_REPORT},
                                            out, resolved, &changed, error);
    if (status == CURVOPT_OK && !isfinite(out->objective) && co_run_context_is_cancelled(&r->context))
        status = CO_CANCELLED;
    if (status == CURVOPT_OK && is_start && !r->context.options->joshi_sequin)
        status = co_adaptive_quadrature_check(&assembly, out, error);
    if (status == CURVOPT_OK && is_start)
        status = co_strength_hold(&r->context, mesh, r->at.xyz, &assembly, &r->constraints, error);
    if (status == CURVOPT_OK && is_start)
        status = hold_scalars(r, mesh, &assembly, error);
    co_assembly_free(&assembly);
    return status;
}

int32_t co_run_evaluate(co_run *r, curvopt_energies *out, curvopt_error *error) {
    int resolved;
    return report_cage(r, r->result->mesh, 0, out, &resolved, error);
}

/* Whether the run may begin with another cage than it was given. */
static int may_unfold(const co_run *r) {
    const curvopt_options *o = r->context.options;
    return !o->joshi_sequin && !co_strength_stays_near(o);
}

/* The run begins with the cage without its folds, if these can be undone: with its symmetries and its figures, which
 * say how the energy falls. has_held: whether what is held of the input cage is known. */
static int32_t begin_unfolded(co_run *r, const curvopt_mesh *mesh, int has_held, curvopt_error *error) {
    curvopt_summary *summary = &r->result->summary;
    const int32_t boundary = r->context.options->boundary;
    co_unfolding found;
    int resolved;
    int32_t status = co_unfold(mesh, &r->constraints, boundary, &r->cancel, r->at.start, &found, error);
    summary->n_folded = found.n_folded;
    summary->n_unfolded = found.n_moved;
    if (status != CURVOPT_OK || !found.n_moved)
        return status;
    if (co_given_constraints_move_cage(mesh, &r->constraints))
        status = co_given_constraints_place(mesh, &r->constraints, boundary, r->at.start, error);
    if (status == CURVOPT_OK && r->at.symmetry.order > 1) {
        co_symmetry_free(&r->at.symmetry);
        status = co_run_find_symmetry(r, mesh, r->at.start, error);
    }
    memcpy(r->at.xyz, r->at.start, 3 * sizeof *r->at.xyz * (size_t)mesh->info.n_vertices);
    if (status == CURVOPT_OK)
        status = report_cage(r, mesh, !has_held, &r->at.energies, &resolved, error);
    r->start_energy = r->at.energies.objective;
    return status;
}

/* The figures of the input cage. Where its folds make them infinite, the run begins without these. */
static int32_t report_start(co_run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    curvopt_energies *start = &r->result->start;
    curvopt_error refusal = {0}, *const said = error ? error : &refusal;
    int resolved = 1;
    int32_t status = report_cage(r, mesh, 1, start, &resolved, said);
    r->start_energy = start->objective;
    if (!may_unfold(r) || (status == CURVOPT_OK && resolved) ||
        (status != CURVOPT_OK && status != CURVOPT_ERROR_GEOMETRY && status != CURVOPT_ERROR_RESOLUTION))
        return status;
    refusal = *said;
    const int32_t unfolded = begin_unfolded(r, mesh, status == CURVOPT_OK, said);
    if (unfolded != CURVOPT_OK || r->result->summary.n_unfolded || status == CURVOPT_OK)
        return unfolded;
    *said = refusal;
    return status;
}

int32_t co_run_report_end(co_run *r, const co_level *l, curvopt_error *error) {
    const curvopt_mesh *mesh = r->result->mesh;
    const curvopt_options *o = r->context.options;
    co_patches patches;
    if (o->surface != CURVOPT_SURFACE_POLYNOMIAL || o->blend_width == 1 || !co_ring_has_phantoms(mesh) ||
        co_run_stopped_early(r))
        return CURVOPT_OK;
    int32_t status = co_patches_create(mesh, r->at.xyz, NULL, o->surface, o->blend_width, NULL, &patches, error);
    if (status != CURVOPT_OK)
        return status;
    const int same = co_blend_disc_half_are_same(&patches.wide, &l->objective.assembly.patches.wide);
    co_patches_free(&patches);
    if (same)
        return CURVOPT_OK;
    curvopt_energies found = {0};
    status = co_run_evaluate(r, &found, error);
    if (status == CURVOPT_OK) {
        r->at.energies = found;
        r->at.report.energy = found.objective;
    }
    return status;
}

int32_t co_run_take_shape(co_run *r, curvopt_error *error) {
    const size_t n = 3 * (size_t)r->result->mesh->info.n_vertices;
    free(r->shape);
    r->context.shape = r->shape = CO_NEW(double, n);
    if (!r->shape)
        return co_status_no_memory(error);
    memcpy(r->shape, r->at.start, n * sizeof *r->shape);
    return CURVOPT_OK;
}

/* The mirror planes that were chosen; where nothing is held, the first level starts from a cage that has them exactly.
 */
static int32_t hold_planes(co_run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    const curvopt_options *o = r->context.options;
    co_constraints all = {0};
    int32_t status = co_mirror_planes_create(mesh, xyz, &r->constraints, o->symmetry_planes, &r->at.symmetry, error);
    if (status == CURVOPT_OK)
        status = co_constraints_all(mesh, &r->constraints, o->boundary, &all, error);
    if (status == CURVOPT_OK && !all.freedom)
        status = co_mirror_planes_symmetrize(mesh, &r->at.symmetry, r->at.start, error);
    co_constraints_free(&all);
    return status;
}

/* What is held and left out of the energy. */
static int32_t find_exceptions(co_run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    co_exceptions found;
    int32_t status = co_exceptions_of_run(mesh, r->at.xyz, r->context.options, &found, error);
    if (status == CURVOPT_OK && found.n_left_out)
        status = co_constraints_leave_out(mesh, found.face, &r->constraints, error);
    r->result->summary.n_held = found.n_held;
    r->result->summary.n_left_out = found.n_left_out;
    co_exceptions_free(&found);
    return status;
}

/* Boundary, creases and exceptions may hold a whole cage on the first of several levels: inside its faces others can
 * move. */
static int32_t check_motion(co_run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    const curvopt_options *o = r->context.options;
    int32_t level = 0,
            status = co_moving_level_find(mesh, r->at.xyz, &r->constraints, o->boundary, o->levels, &level, error);
    if (status == CURVOPT_OK)
        r->stands = level == 0;
    return r->stands && !r->is_component ? co_constraints_refuse(mesh, error) : status;
}

int32_t co_run_restrict_symmetry(co_run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    const curvopt_options *o = r->context.options;
    const int32_t order = r->at.symmetry.order;
    int32_t status = co_kept_symmetry_restrict(mesh, &r->constraints, o->boundary, &r->at.symmetry, error);
    if (status != CURVOPT_OK || o->symmetry != CURVOPT_SYMMETRY_PLANES || r->at.symmetry.order == order)
        return status;
    return co_status_fail(
        error, CURVOPT_ERROR_GEOMETRY, -1,
        "what the surface goes through leaves too little freedom for symmetry about the chosen planes: "
        "take out entries near them, or choose no planes");
}

int32_t co_run_find_symmetry(co_run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    const curvopt_options *o = r->context.options;
    const int has_planes = o->symmetry == CURVOPT_SYMMETRY_PLANES;
    co_constraints *c = &r->constraints;
    const int has_curvatures = co_held_curvatures_exist(&c->values) || co_held_curvatures_exist(&c->drawn);
    const char *drops = c->chains.n ? "chains" : has_curvatures ? "curvatures" : NULL;
    if (has_planes && drops)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1,
                              "%s that the surface goes through cannot be had with mirror planes that were chosen",
                              drops);
    if (o->joshi_sequin || o->symmetry == CURVOPT_SYMMETRY_NONE || drops)
        return co_symmetry_none(mesh, &r->at.symmetry, error);
    int32_t status = has_planes ? hold_planes(r, mesh, xyz, error)
                                : co_symmetry_create(mesh, xyz, c, o->symmetry != CURVOPT_SYMMETRY_ROTATIONS,
                                                     r->context.tables->cancel, &r->at.symmetry, error);
    if (status == CURVOPT_OK)
        status = co_value_images_adapt(mesh, &r->at.symmetry, &c->values, error);
    return status == CURVOPT_OK ? co_run_restrict_symmetry(r, mesh, error) : status;
}

static int32_t put_where_held(co_run *r, const curvopt_mesh *mesh, curvopt_error *error) {
    const curvopt_options *o = r->context.options;
    if (!(o->constraints && o->constraints->has_places) && !co_given_constraints_move_cage(mesh, &r->constraints))
        return CURVOPT_OK;
    return co_given_constraints_place(mesh, &r->constraints, o->boundary, r->at.start, error);
}

/* The run begins where what is held is where it is to be, or will be on the last level. */
static int32_t place(co_run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    const curvopt_options *o = r->context.options;
    curvopt_error refusal = {0};
    if (r->looks_ahead && !o->joshi_sequin && !o->no_crossings && !co_strength_stays_near(o))
        co_look_ahead(mesh, o->levels - 1, &r->constraints);
    if (!co_looks_ahead(mesh, &r->constraints))
        return put_where_held(r, mesh, error);
    int32_t status = put_where_held(r, mesh, &refusal);
    if (status == CURVOPT_ERROR_ARGUMENT) {
        memcpy(r->at.start, xyz, 3 * sizeof *xyz * (size_t)mesh->info.n_vertices);
        status = co_look_ahead_leave_overlapping(mesh, &r->constraints, error);
        return status == CURVOPT_OK ? put_where_held(r, mesh, error) : status;
    }
    if (status != CURVOPT_OK && error)
        *error = refusal;
    return status;
}

/* Constraints, exceptions and symmetries of the input cage. */
static int32_t find_structure(co_run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    const curvopt_options *o = r->context.options;
    int32_t status = co_given_constraints_create(mesh, xyz, o->constraints, &r->constraints, error);
    if (status == CURVOPT_OK)
        status = co_given_constraints_check_strength(o->constraints, o, error);
    if (status == CURVOPT_OK)
        status = co_given_through_create(mesh, xyz, o, &r->constraints, error);
    if (status == CURVOPT_OK)
        status = find_exceptions(r, mesh, error);
    if (status == CURVOPT_OK)
        status = place(r, mesh, xyz, error);
    if (status == CURVOPT_OK && r->is_live && co_component_options_fit(o))
        status = co_loose_components_leave_out(mesh, o->boundary, &r->constraints, error);
    if (status == CURVOPT_OK)
        status = check_motion(r, mesh, error);
    if (status != CURVOPT_OK)
        return status;
    return co_run_find_symmetry(r, mesh, r->at.start, error);
}

void co_run_forget_verdict(curvopt_summary *s) {
    s->verdict = CURVOPT_VERDICT_UNKNOWN;
    s->newton_decrement = s->shape_decrement = s->difference_decrement = (double)NAN;
    s->negative_directions = s->all_negative_directions = s->free_negative_directions = -1;
    s->touch_rise = (double)NAN;
    s->is_delicate = 0;
}

int32_t co_run_start(co_run *r, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    size_t n = 3 * (size_t)mesh->info.n_vertices;
    r->result = CO_NEW(curvopt_result, 1);
    r->at.xyz = CO_NEW(double, n);
    r->at.start = CO_NEW(double, n);
    if (!r->result || !r->at.xyz || !r->at.start)
        return co_status_no_memory(error);
    co_run_forget_verdict(&r->result->summary);
    r->result->summary.clearance = (double)NAN;
    r->result->level = CO_NEW(curvopt_level_report, r->context.options->levels);
    if (!r->result->level)
        return co_status_no_memory(error);
    memcpy(r->at.xyz, xyz, n * sizeof(double));
    memcpy(r->at.start, xyz, n * sizeof(double));
    r->context.radius = co_similarity_mesh_frame(mesh, xyz, r->context.centroid);
    r->context.least = LEAST * co_penalty_stiffness(r->context.options->weights);
    int32_t status = co_submesh_copy(mesh, &r->result->mesh, error);
    if (status == CURVOPT_OK)
        status = find_structure(r, mesh, xyz, error);
    if (status == CURVOPT_OK && r->context.options->slide)
        status = co_sliding_create(mesh, xyz, &r->sliding, error);
    if (status == CURVOPT_OK)
        status = report_start(r, mesh, error);
    if (status == CURVOPT_OK && r->context.options->no_crossings) {
        status = co_no_crossings_create(mesh, xyz, r->at.start, r->threads, r->context.cancel, &r->no_crossings, error);
        r->no_crossings.exceptions.n_refused = &r->result->summary.n_refused;
        r->context.exceptions = &r->no_crossings.exceptions;
        r->result->summary.n_crossing_before = (int32_t)r->no_crossings.exceptions.pairs.n_crossing;
    }
    return status;
}

void co_run_free_parts(co_run *r) {
    co_level_result_free(&r->at);
    co_constraints_free(&r->constraints);
    co_sliding_free(&r->sliding);
    co_no_crossings_free(&r->no_crossings);
    free(r->shape);
    r->context.shape = r->shape = NULL;
}
