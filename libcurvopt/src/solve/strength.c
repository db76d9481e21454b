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

#include <stdlib.h>

/* Where springs end, in lengths of the wave of which half the height stays. */
static const double REACH = 0.2;
/* What a spring is worth there at least, in parts of the objective round the vertex. */
static const double FIRMEST = 0.3;

/* stiffness [n_vertices]: factor times the area round each vertex. */
static void set_by_area(const curvopt_mesh *m, const double *xyz, double factor, double *stiffness) {
    co_mesh_vertex_areas(m, xyz, stiffness);
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        stiffness[v] *= factor;
}

/* stiffness [n_vertices] += factor times the objective's part round each vertex; energy [n_faces]: the faces' parts. */
static void add_by_energy(const curvopt_mesh *m, const double *energy, double factor, double *stiffness) {
    for (int32_t h = 0; h < m->info.n_corners; h++) {
        int32_t f = m->corner_face[h];
        stiffness[m->corner_vertex[h]] += factor * energy[f] / (m->face_start[f + 1] - m->face_start[f]);
    }
}

int32_t co_strength_hold(const co_run_context *run, const curvopt_mesh *mesh, const double *xyz,
                         const co_assembly *assembly, co_constraints *constraints, curvopt_error *error) {
    const curvopt_options *o = run->options;
    if (o->strength == 1)
        return CURVOPT_OK;
    const co_functional f = co_functional_of_weights(o->weights);
    const double square = run->radius * run->radius, wave = o->strength / (1 - o->strength), reach = REACH * wave;
    const double unit = 2 / co_penalty_stiffness(o->weights); /* stiffness of a spring that is worth 1 at length 1 */
    double *stiffness = CO_NEW(double, mesh->info.n_vertices), *energy = CO_NEW(double, mesh->info.n_faces);
    int32_t status = stiffness && energy ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        double counted = co_mesh_area(mesh, constraints->left_out, xyz) / square;
        double density = co_functional_of_wave(&f, 2 * CO_PI / wave, counted);
        set_by_area(mesh, xyz, unit * density / square, stiffness);
        co_adaptive_quadrature_by_face(assembly, mesh->info.n_faces, energy);
        add_by_energy(mesh, energy, unit * FIRMEST / (reach * reach), stiffness);
        status = co_constraints_pull_back(mesh, xyz, stiffness, reach * run->radius, constraints, error);
    }
    free(stiffness);
    free(energy);
    return status;
}
