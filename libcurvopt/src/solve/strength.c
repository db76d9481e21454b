/* Nearness to the input cage.
 *
 * Of a wave on a plane, of height h and wave number k, the objective weighs f(k) h^2 by area and springs c (h - h_0)^2,
 * so that c / (c + f(k)) of its height stays: half of it where f(k) = c. This is Tikhonov's regularization; of bending
 * energy, for which f(k) = k^4, it is the smoothing spline (Reinsch, "Smoothing by spline functions", 1967).
 *
 * Third-order terms have the area of the faces that count as a factor, so that f has it, too. Springs are on all
 * vertices, and end at a part of the wave's length: what is higher is no wave but a feature. Round creases and poles
 * the objective is many times that of any wave; springs there are stiffer in proportion, or so many of them would be at
 * their ends that steps get short (libcurvopt/notes/83-staying-near-the-input.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/strength.h"

#include "base/constants.h"
#include "base/memory.h"
#include "energy/functional.h"
#include "hessian/penalty.h"

#include <math.h>
#include <stdlib.h>

/* Where springs end, in lengths of the wave of which half the height stays. */
static const double REACH = 0.2;
/* What a spring is worth there at least, in parts of the objective round the vertex. */
static const double FIRMEST = 0.3;
/* What springs that are there only for their ends are worth all together at these, in parts of the objective. */
static const double LIMITING = 0.03;

int co_strength_stays_near(const curvopt_options *o) {
    return o->strength < 1 || o->within > 0;
}

/* Springs that are made. */
typedef struct springs {
    const curvopt_mesh *mesh;
    const double *xyz;
    const uint8_t *left_out;
    double radius;     /* of the cage */
    double unit;       /* stiffness of a spring that is worth 1 at length 1, in radii */
    double *stiffness; /* [n_vertices] */
    double *energy;    /* [n_faces] the faces' parts of the objective */
    double *area;      /* [n_vertices] round each vertex, in squared radii */
} springs;

/* Adds springs that are worth so much at that length, by area: at all vertices together. */
static void add_by_area(const springs *s, double density) {
    for (int32_t v = 0; v < s->mesh->info.n_vertices; v++)
        s->stiffness[v] += s->unit * density * s->area[v];
}

/* Adds `factor` times the objective's part round each vertex. */
static void add_by_energy(const springs *s, double factor) {
    const curvopt_mesh *m = s->mesh;
    for (int32_t h = 0; h < m->info.n_corners; h++) {
        int32_t f = m->corner_face[h];
        s->stiffness[m->corner_vertex[h]] +=
            s->unit * factor * s->energy[f] / (m->face_start[f + 1] - m->face_start[f]);
    }
}

/* Springs of a strength below 1; where they end, in radii. */
static double add_strength(const springs *s, const curvopt_options *o) {
    const co_functional f = co_functional_of_weights(o->weights);
    const double wave = o->strength / (1 - o->strength), reach = REACH * wave;
    const double counted = co_mesh_area(s->mesh, s->left_out, s->xyz) / (s->radius * s->radius);
    add_by_area(s, co_functional_of_wave(&f, 2 * CO_PI / wave, counted));
    add_by_energy(s, FIRMEST / (reach * reach));
    return reach;
}

/* Springs that are worth a part of the objective at their end, `reach` radii; what they are weighed by. */
static double add_limiting(const springs *s, double reach) {
    double energy = 0, area = 0;
    for (int32_t f = 0; f < s->mesh->info.n_faces; f++)
        energy += s->energy[f];
    for (int32_t v = 0; v < s->mesh->info.n_vertices; v++)
        area += s->area[v];
    add_by_area(s, LIMITING * energy / (area * reach * reach));
    return energy;
}

static int32_t add_springs(const springs *s, const curvopt_options *o, co_constraints *constraints,
                           curvopt_error *error) {
    const int are_alone = o->strength == 1 && !constraints->springs.stiffness;
    double reach = INFINITY, weighed_by = 0;
    if (o->strength < 1)
        reach = add_strength(s, o);
    if (o->within > 0) {
        reach = fmin(reach, o->within / s->radius);
        weighed_by = add_limiting(s, reach);
    }
    int32_t status = co_constraints_pull_back(s->mesh, s->xyz, s->stiffness, reach * s->radius, constraints, error);
    constraints->springs.weighed_by = status == CURVOPT_OK && are_alone ? weighed_by : 0;
    return status;
}

int32_t co_strength_hold(const co_run_context *run, const curvopt_mesh *mesh, const double *xyz,
                         const co_assembly *assembly, co_constraints *constraints, curvopt_error *error) {
    const curvopt_options *o = run->options;
    if (!co_strength_stays_near(o))
        return CURVOPT_OK;
    const size_t n = (size_t)mesh->info.n_vertices;
    springs s = {.mesh = mesh,
                 .xyz = xyz,
                 .left_out = constraints->left_out,
                 .radius = run->radius,
                 .unit = 2 / co_penalty_stiffness(o->weights),
                 .stiffness = CO_NEW(double, n),
                 .energy = CO_NEW(double, mesh->info.n_faces),
                 .area = CO_NEW(double, n)};
    int32_t status = s.stiffness && s.energy && s.area ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        co_mesh_vertex_areas(mesh, xyz, s.area);
        for (size_t v = 0; v < n; v++)
            s.area[v] /= run->radius * run->radius;
        co_adaptive_quadrature_by_face(assembly, mesh->info.n_faces, s.energy);
        status = add_springs(&s, o, constraints, error);
    }
    free(s.stiffness);
    free(s.energy);
    free(s.area);
    return status;
}
