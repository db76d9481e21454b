/* A run over a cage of several components. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/component_runs.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/vec3.h"
#include "constraints/given_through.h"
#include "constraints/symmetry.h"
#include "mesh/similarity.h"
#include "mesh/subdivide.h"
#include "mesh/submesh.h"
#include "solve/component_figures.h"
#include "solve/component_options.h"
#include "solve/run_level.h"
#include "solve/run_start.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct component_runs component_runs;

/* A component, and its run. */
typedef struct component {
    component_runs *all;
    co_component_options given;
    co_run run;
    int has_run;        /* else it is a copy, or all of it is left out of the energy */
    int is_going_on;    /* the next level is the run's */
    int32_t first_face; /* of the cage */
    int32_t times;      /* 1 and copies of it */
    int32_t copy_of;    /* component that it is the image of; -1: of none */
    int32_t element;    /* by this element of the whole's symmetry */
    int32_t *face_of;   /* [faces of the run's mesh] their numbers in the whole's mesh of the same level */
    int32_t *vertex_of; /* [vertices of the run's mesh] the same */
    double energy;      /* of its present cage */
} component;

struct component_runs {
    co_run *whole;
    double centre[3]; /* that the whole's symmetries leave where it is */
    co_components parts;
    component *item;         /* [parts.n] */
    co_component_part *part; /* [parts.n] work: figures of those that have a run */
    co_run_work done;        /* on the present level */
};

static int is_asked_to_stop(const co_run *whole) {
    return whole->is_asked_to_stop || co_run_context_is_cancelled(&whole->context);
}

/* ---------------------------------------------------------------------------------------- the whole's cage -- */

/* The image of x [3] by element g of the whole's symmetry. */
static void find_image(const component_runs *all, int32_t g, const double x[3], double to[3]) {
    const double *centre = all->centre, *matrix = all->whole->at.symmetry.matrix + 9 * (size_t)g;
    for (size_t i = 0; i < 3; i++) {
        to[i] = centre[i];
        for (size_t j = 0; j < 3; j++)
            to[i] += matrix[3 * i + j] * (x[j] - centre[j]);
    }
}

/* Where in a cage xyz of the whole the image of its vertex v is. */
static size_t image_at(const component_runs *all, int32_t g, int32_t v) {
    return 3 * (size_t)co_symmetry_vertex(&all->whole->at.symmetry, all->whole->result->mesh, g, v);
}

/* The component's cage xyz becomes a part of the whole's, and so do its copies. */
static void put(const component_runs *all, const component *c, const double *xyz) {
    const int32_t n = c->run.result->mesh->info.n_vertices, number = (int32_t)(c - all->item);
    for (int32_t v = 0; v < n; v++)
        memcpy(all->whole->at.xyz + 3 * (size_t)c->vertex_of[v], xyz + 3 * (size_t)v, 3 * sizeof *xyz);
    for (int32_t k = number + 1; k < all->parts.n && c->times > 1; k++)
        for (int32_t v = 0; all->item[k].copy_of == number && v < n; v++)
            find_image(all, all->item[k].element, xyz + 3 * (size_t)v,
                       all->whole->at.xyz + image_at(all, all->item[k].element, c->vertex_of[v]));
}

/* The caller is told of a step of one component, and sees all of them. */
static int tell(const curvopt_progress *of_one, void *user) {
    component *c = user;
    const component_runs *all = c->all;
    co_run *whole = all->whole;
    curvopt_progress p = *of_one;
    p.energy = 0;
    c->energy = of_one->energy;
    put(all, c, of_one->xyz);
    for (int32_t k = 0; k < all->parts.n; k++)
        p.energy += all->item[all->item[k].copy_of < 0 ? k : all->item[k].copy_of].energy;
    p.start_energy = whole->start_energy;
    p.xyz = whole->at.xyz;
    p.mesh = whole->result->mesh;
    p.n_vertices = p.mesh->info.n_vertices;
    p.iteration += all->done.iterations;
    p.evaluations += all->done.evaluations;
    whole->is_asked_to_stop = whole->progress(&p, whole->user) != 0;
    return whole->is_asked_to_stop;
}

/* ------------------------------------------------------------------------------------------------ copies -- */

/* Whether the component moves freely: then an image of its result is one of the other's. */
static int is_free(const component *c, const co_constraints *held) {
    for (int32_t v = 0; held->freedom && v < c->run.result->mesh->info.n_vertices; v++)
        if (held->freedom[c->vertex_of[v]] != CO_FREEDOM_ALL)
            return 0;
    return 1;
}

/* Whether element g takes the component to the other one by its own size, too: in the whole's, which may be much
 * larger, the tolerance was. xyz: the whole's. */
static int is_image(const component *c, const double *xyz, int32_t g) {
    const double tolerance = CO_SYMMETRY_TOLERANCE * c->run.context.radius;
    for (int32_t v = 0; v < c->run.result->mesh->info.n_vertices; v++) {
        double image[3];
        find_image(c->all, g, xyz + 3 * (size_t)c->vertex_of[v], image);
        if (co_distance3(image, xyz + image_at(c->all, g, c->vertex_of[v])) > tolerance)
            return 0;
    }
    return 1;
}

/* Components that the whole's symmetry makes of this one are copies. xyz: the whole's. */
static void find_copies(component *c, const co_constraints *held, const double *xyz) {
    component_runs *all = c->all;
    const co_symmetry *s = &all->whole->at.symmetry;
    const int32_t number = (int32_t)(c - all->item);
    if (s->order == 1 || !is_free(c, held))
        return;
    for (int32_t g = 1; g < s->order; g++) {
        const int32_t image = all->parts.of_vertex[co_symmetry_vertex(s, all->whole->result->mesh, g, c->vertex_of[0])];
        component *other = &all->item[image];
        if (image <= number || other->copy_of >= 0 || !is_image(c, xyz, g))
            continue;
        other->copy_of = number;
        other->element = g;
        c->times++;
    }
}

/* Of the mirror planes that were chosen those that take the component to itself. */
static void choose_planes(const component_runs *all, int32_t vertex, curvopt_options *o) {
    const co_symmetry *s = &all->whole->at.symmetry;
    int32_t planes = 0;
    if (o->symmetry != CURVOPT_SYMMETRY_PLANES)
        return;
    for (int32_t g = 1; g < s->order; g++) {
        const int32_t image = co_symmetry_vertex(s, all->whole->result->mesh, g, vertex);
        int32_t mask = 0;
        for (int k = 0; k < 3; k++)
            mask |= s->matrix[9 * (size_t)g + 4 * (size_t)k] < 0 ? 1 << k : 0;
        if (all->parts.of_vertex[image] == all->parts.of_vertex[vertex] && (mask & (mask - 1)) == 0)
            planes |= mask;
    }
    o->symmetry_planes = planes;
    o->symmetry = planes ? CURVOPT_SYMMETRY_PLANES : CURVOPT_SYMMETRY_NONE;
}

/* ---------------------------------------------------------------------------------------------- creation -- */

/* The faces of component `number`: keep [n_faces]; returns how many of them count. */
static int32_t mark_faces(const component_runs *all, int32_t number, uint8_t *keep) {
    const uint8_t *left_out = all->whole->constraints.left_out;
    int32_t n = 0;
    for (int32_t f = 0; f < all->whole->result->mesh->info.n_faces; f++) {
        keep[f] = all->parts.of_face[f] == number;
        n += keep[f] && !(left_out && left_out[f]);
    }
    return n;
}

static int32_t list_faces(const curvopt_mesh *m, const uint8_t *keep, int32_t **out, curvopt_error *error) {
    int32_t n = 0, *face = CO_NEW(int32_t, m->info.n_faces);
    if (!face)
        return co_status_no_memory(error);
    for (int32_t f = 0; f < m->info.n_faces; f++)
        if (keep[f])
            face[n++] = f;
    *out = face;
    return CURVOPT_OK;
}

static void free_run(co_run *r) {
    co_run_result_destroy(r->result);
    r->result = NULL;
    co_run_free_parts(r);
}

static int32_t start_run(component *c, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    co_run *whole = c->all->whole;
    c->run = (co_run){.looks_ahead = whole->looks_ahead,
                      .context = {.options = &c->given.options,
                                  .tuning = whole->context.tuning,
                                  .cancel = whole->context.cancel,
                                  .tables = whole->context.tables},
                      .progress = whole->progress ? tell : NULL,
                      .user = c,
                      .started = whole->started,
                      .cancel = whole->cancel,
                      .threads = whole->threads,
                      .is_component = 1};
    int32_t status = co_run_start(&c->run, mesh, xyz, error);
    c->has_run = status == CURVOPT_OK;
    if (status != CURVOPT_OK)
        free_run(&c->run);
    return status;
}

/* The options by which objectives of components add up to the whole's where none changes its area: weights, and
 * spontaneous curvature by the whole's normals. Returns whether they are others. */
static int fit_options(component *c) {
    const co_run *whole = c->all->whole;
    double *weights = c->given.options.weights;
    const double radius = c->run.context.radius / whole->context.radius;
    int is_other = 0;
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        if (weights[t] > 0 && co_functional_is_third_order(t)) {
            weights[t] *= whole->result->start.area / c->run.result->start.area;
            is_other = 1;
        }
    if (weights[CURVOPT_TERM_AREA] > 0) {
        weights[CURVOPT_TERM_AREA] *= radius * radius;
        is_other = 1;
    }
    if (c->given.options.spontaneous_curvature != 0 && c->run.held.orientation != whole->held.orientation) {
        c->given.options.spontaneous_curvature *= -1;
        is_other = 1;
    }
    return is_other;
}

/* A component that nothing moves may yet be put at places. */
static int32_t stand(component *c, curvopt_error *error) {
    co_run *r = &c->run;
    const size_t size = 3 * sizeof *r->at.xyz * (size_t)r->result->mesh->info.n_vertices;
    if (memcmp(r->at.xyz, r->at.start, size) == 0)
        return CURVOPT_OK;
    memcpy(r->at.xyz, r->at.start, size);
    int32_t status = co_run_evaluate(r, &r->at.energies, error);
    if (status == CURVOPT_OK)
        c->energy = r->at.energies.objective;
    return status;
}

/* The component by itself, from the whole's cage xyz. */
static int32_t start_component(component *c, const uint8_t *keep, const double *xyz, curvopt_error *error) {
    const curvopt_mesh *m = c->all->whole->result->mesh;
    curvopt_mesh *mesh = NULL;
    double *own = NULL;
    int32_t status = co_submesh_extract(m, keep, &mesh, &c->vertex_of, error);
    if (status == CURVOPT_OK)
        status = list_faces(m, keep, &c->face_of, error);
    if (status == CURVOPT_OK) {
        own = CO_NEW(double, 3 * (size_t)mesh->info.n_vertices);
        status = own ? CURVOPT_OK : co_status_no_memory(error);
    }
    for (int32_t v = 0; status == CURVOPT_OK && v < mesh->info.n_vertices; v++)
        memcpy(own + 3 * (size_t)v, xyz + 3 * (size_t)c->vertex_of[v], 3 * sizeof *own);
    if (status == CURVOPT_OK)
        status = start_run(c, mesh, own, error);
    if (status == CURVOPT_OK && fit_options(c)) {
        free_run(&c->run);
        status = start_run(c, mesh, own, error);
    }
    co_mesh_destroy(mesh);
    free(own);
    if (status == CURVOPT_OK) {
        c->energy = c->run.result->start.objective;
        c->is_going_on = !c->run.stands;
    }
    return status == CURVOPT_OK && c->run.stands ? stand(c, error) : status;
}

/* Says of which component a sentence is, whose numbers are its own. */
static int32_t name_component(const component *c, int32_t status, curvopt_error *error) {
    if (status == CURVOPT_OK || status == CO_CANCELLED || status == CURVOPT_ERROR_MEMORY || !error)
        return status;
    const curvopt_error own = *error;
    return co_status_fail(error, status, -1, "the piece of face %d, counted by itself: %s", c->first_face, own.message);
}

/* What all components are made of. */
typedef struct creation {
    const double *xyz;
    curvopt_options options;
    curvopt_through through; /* the options', which may be an older struct */
    co_constraints held;
    co_component_shares shares;
    uint8_t *keep; /* [n_faces] */
} creation;

static int32_t create_component(component_runs *all, creation *from, int32_t number, curvopt_error *error) {
    const curvopt_mesh *m = all->whole->result->mesh;
    component *c = &all->item[number];
    if (c->copy_of >= 0 || !mark_faces(all, number, from->keep))
        return CURVOPT_OK;
    while (all->parts.of_face[c->first_face] != number)
        c->first_face++;
    const int32_t vertex = m->corner_vertex[m->face_start[c->first_face]];
    int32_t status = co_component_options_create(&from->options, &all->parts, &from->shares, number, &c->given, error);
    if (status != CURVOPT_OK)
        return status;
    choose_planes(all, vertex, &c->given.options);
    status = name_component(c, start_component(c, from->keep, from->xyz, error), error);
    if (status == CURVOPT_OK)
        find_copies(c, &from->held, from->xyz);
    return status;
}

static void free_all(component_runs *all) {
    for (int32_t k = 0; all->item && k < all->parts.n; k++) {
        component *c = &all->item[k];
        free_run(&c->run);
        co_component_options_free(&c->given);
        free(c->face_of);
        free(c->vertex_of);
    }
    free(all->item);
    free(all->part);
    co_components_free(&all->parts);
}

/* Of parts that have been found. */
static int32_t create_all(component_runs *all, const double *xyz, curvopt_error *error) {
    const curvopt_options *o = all->whole->context.options;
    const int32_t n = all->parts.n;
    creation from = {.xyz = xyz, .options = *o, .keep = CO_NEW(uint8_t, all->whole->result->mesh->info.n_faces)};
    all->item = CO_NEW(component, n);
    all->part = CO_NEW(co_component_part, n);
    int32_t status = from.keep && all->item && all->part ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = co_constraints_all(all->whole->result->mesh, &all->whole->constraints, o->boundary, &from.held, error);
    if (status == CURVOPT_OK && o->through)
        status = co_given_through_take(o->through, &from.through, error);
    from.options.through = o->through ? &from.through : NULL;
    if (status == CURVOPT_OK)
        status = co_component_shares_create(&from.options, &all->parts, &from.shares, error);
    co_similarity_mesh_frame(all->whole->result->mesh, all->whole->at.start, all->centre);
    if (o->symmetry == CURVOPT_SYMMETRY_PLANES && !from.held.freedom) /* there it is symmetric to rounding */
        from.xyz = all->whole->at.start;
    for (int32_t k = 0; status == CURVOPT_OK && k < n; k++)
        all->item[k] = (component){.all = all, .copy_of = -1, .times = 1};
    for (int32_t k = 0; status == CURVOPT_OK && k < n; k++)
        status = create_component(all, &from, k, error);
    free(from.keep);
    co_constraints_free(&from.held);
    co_component_shares_free(&from.shares);
    return status;
}

/* ------------------------------------------------------------------------------------------------- levels -- */

/* A component's maps, to the whole's next level. `mesh` was the whole's, `fine` is; the component is subdivided. */
static int32_t subdivide_component(component *c, const curvopt_mesh *mesh, const curvopt_mesh *fine,
                                   curvopt_error *error) {
    const curvopt_mesh *own = c->run.result->mesh;
    int32_t *face_of = CO_NEW(int32_t, own->info.n_corners), status;
    if (!face_of)
        return co_status_no_memory(error);
    for (int32_t h = 0; h < own->info.n_corners; h++) { /* a child for each corner */
        const int32_t f = own->corner_face[h];
        face_of[h] = mesh->face_start[c->face_of[f]] + h - own->face_start[f];
    }
    free(c->face_of);
    c->face_of = face_of;
    status = co_run_level_subdivide(&c->run, error);
    if (status != CURVOPT_OK)
        return status;
    own = c->run.result->mesh;
    free(c->vertex_of);
    c->vertex_of = CO_NEW(int32_t, own->info.n_vertices);
    if (!c->vertex_of)
        return co_status_no_memory(error);
    for (int32_t h = 0; h < own->info.n_corners; h++)
        c->vertex_of[own->corner_vertex[h]] = fine->corner_vertex[4 * face_of[h / 4] + h % 4];
    return CURVOPT_OK;
}

/* The whole's cage, and what goes on, to the next level. */
static int32_t subdivide(component_runs *all, curvopt_error *error) {
    co_run *whole = all->whole;
    curvopt_mesh *fine = NULL;
    co_sparse_rows rows = {0};
    double *xyz = NULL;
    int32_t status = co_subdivide_cage(whole->result->mesh, whole->at.xyz, &fine, &rows, &xyz, error);
    if (status == CURVOPT_OK)
        status = co_symmetry_subdivide(&whole->at.symmetry, error);
    if (status == CURVOPT_OK)
        status = co_constraints_subdivide_left_out(whole->result->mesh, &whole->constraints, error);
    for (int32_t k = 0; status == CURVOPT_OK && k < all->parts.n; k++)
        if (all->item[k].is_going_on)
            status = subdivide_component(&all->item[k], whole->result->mesh, fine, error);
    if (status == CURVOPT_OK) {
        free(whole->at.xyz);
        co_mesh_destroy(whole->result->mesh);
        whole->at.xyz = xyz;
        whole->result->mesh = fine;
    } else {
        free(xyz);
        co_mesh_destroy(fine);
    }
    co_sparse_rows_free(&rows);
    return status;
}

/* A component's level. */
static int32_t solve_component(component_runs *all, component *c, int32_t number, curvopt_error *error) {
    int32_t status = co_run_level_solve(&c->run, number, error);
    if (status != CURVOPT_OK)
        return name_component(c, status, error);
    c->energy = c->run.at.energies.objective;
    c->is_going_on = !co_run_level_ends_run(&c->run, number);
    c->run.result->summary.n_levels = number;
    all->done.iterations += c->run.at.report.iterations;
    all->done.evaluations += c->run.at.report.evaluations;
    put(all, c, c->run.at.xyz);
    return CURVOPT_OK;
}

/* Figures of all components where they stand; those of a component that nothing moves are the input's. Returns their
 * number. */
static int32_t list_parts(component_runs *all) {
    int32_t n = 0;
    for (int32_t k = 0; k < all->parts.n; k++) {
        component *c = &all->item[k];
        if (!c->has_run)
            continue;
        all->part[n++] =
            (co_component_part){.times = c->times,
                                .weights = c->given.options.weights,
                                .energies = c->run.at.energies.area > 0 ? &c->run.at.energies : &c->run.result->start,
                                .report = &c->run.at.report,
                                .summary = c->run.stands ? NULL : &c->run.result->summary};
    }
    return n;
}

/* The level's report, and the figures of all. */
static void report_level(component_runs *all, int32_t number, double started) {
    co_run *whole = all->whole;
    const curvopt_mesh *m = whole->result->mesh;
    double centroid[3], radius = co_similarity_mesh_frame(m, whole->at.xyz, centroid);
    curvopt_level_report *report = &whole->at.report;
    const int32_t n = list_parts(all);
    co_component_figures_energies(all->part, n, whole->context.options->weights, radius, &whole->at.energies);
    *report = (curvopt_level_report){.level = number,
                                     .n_vertices = m->info.n_vertices,
                                     .iterations = all->done.iterations,
                                     .evaluations = all->done.evaluations,
                                     .energy = whole->at.energies.objective,
                                     .seconds = co_clock_seconds() - started};
    co_component_figures_report(all->part, n, report);
    if (is_asked_to_stop(whole))
        report->stop = CURVOPT_STOP_CANCELLED;
    whole->result->level[number - 1] = *report;
    whole->result->summary.n_levels = number;
}

static int32_t solve_level(component_runs *all, int32_t number, int *goes_on, curvopt_error *error) {
    const double started = co_clock_seconds();
    int32_t status = CURVOPT_OK;
    *goes_on = 0;
    all->done = (co_run_work){0};
    for (int32_t k = 0; status == CURVOPT_OK && k < all->parts.n && !is_asked_to_stop(all->whole); k++)
        if (all->item[k].is_going_on)
            status = solve_component(all, &all->item[k], number, error);
    for (int32_t k = 0; k < all->parts.n; k++)
        *goes_on |= all->item[k].is_going_on && !is_asked_to_stop(all->whole);
    if (status == CURVOPT_OK)
        report_level(all, number, started);
    return status;
}

/* Figures of the result, by an evaluation of all of it: where curvatures are nearly equal third-order terms depend on
 * how large the whole is (functional.h). */
static int32_t evaluate(component_runs *all, curvopt_error *error) {
    co_run *whole = all->whole;
    curvopt_energies found;
    if (is_asked_to_stop(whole))
        return CURVOPT_OK;
    int32_t status = co_run_evaluate(whole, &found, error);
    if (status == CURVOPT_OK) {
        whole->result->end = found;
        whole->result->level[whole->result->summary.n_levels - 1].energy = found.objective;
    }
    return status == CO_CANCELLED ? CURVOPT_OK : status;
}

static void summarize(component_runs *all) {
    for (int32_t k = 0; k < all->parts.n; k++)
        if (all->item[k].has_run)
            co_run_summarize(&all->item[k].run);
    co_run_summarize(all->whole);
    co_component_figures_summary(all->part, list_parts(all), &all->whole->result->summary);
}

int32_t co_component_runs_minimize(co_run *whole, const double *xyz, int *has_run, curvopt_error *error) {
    component_runs all = {.whole = whole};
    int goes_on = 1;
    *has_run = 0;
    if (whole->result->mesh->info.n_components < 2)
        return CURVOPT_OK;
    int32_t status = co_components_find(whole->result->mesh, &all.parts, error);
    *has_run = status == CURVOPT_OK && all.parts.n > 1;
    if (*has_run) {
        memcpy(whole->at.xyz, whole->at.start, 3 * sizeof *xyz * (size_t)whole->result->mesh->info.n_vertices);
        status = create_all(&all, xyz, error);
        for (int32_t number = 1; status == CURVOPT_OK && goes_on; number++) {
            if (number > 1)
                status = subdivide(&all, error);
            if (status == CURVOPT_OK)
                status = solve_level(&all, number, &goes_on, error);
        }
        if (status == CURVOPT_OK) {
            summarize(&all); /* what levels brought is a difference of sums */
            status = evaluate(&all, error);
        }
    }
    free_all(&all);
    return status;
}
