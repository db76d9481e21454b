/* Nearness to the input cage.
 *
 * Of a wave on a plane, of height h and wave number k, the objective weighs f(k) h^2 by area and springs c (h - h_0)^2,
 * so that c / (c + f(k)) of its height stays: half of it where f(k) = c. This is Tikhonov's regularization; of bending
 * energy, for which f(k) = k^4, it is the smoothing spline (Reinsch, "Smoothing by spline functions", 1967).
 *
 * Third-order terms have the area of the faces that count as a factor, so that f has it, too. Springs are on all
 * vertices.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/strength.h"

#include "base/constants.h"
#include "energy/functional.h"
#include "hessian/penalty.h"

/* Wave number of the wave of which half the height stays, at radius 1. */
static double wave_number(double strength) {
    return 2 * CO_PI * (1 - strength) / strength;
}

int32_t co_strength_hold(const co_run_context *run, const curvopt_mesh *mesh, const double *xyz,
                         co_constraints *constraints, curvopt_error *error) {
    const curvopt_options *o = run->options;
    if (o->strength == 1)
        return CURVOPT_OK;
    const co_functional f = co_functional_of_weights(o->weights);
    const double unit = run->radius * run->radius;
    double whole = co_mesh_area(mesh, NULL, xyz) / unit;
    double counted = co_mesh_area(mesh, constraints->left_out, xyz) / unit;
    double density = co_functional_of_wave(&f, wave_number(o->strength), counted);
    return co_constraints_pull_back(mesh, xyz, 2 * whole * density / co_penalty_stiffness(o->weights), constraints,
                                    error);
}
