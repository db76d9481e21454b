/* Whether a cage is a stationary point, and of what kind.
 *
 * The report (section 3.3) verifies its minima by Newton's method. Here two questions are asked. What is left to gain,
 * by the Newton decrement (newton_decrement.h): over motion along the cage's normals, which changes the shape and not
 * only how the cage lies in it, and, where that was minimized over, over everything that may move. And in how many
 * directions the shape could go down at second order: the Hessian's inertia on motion along normals. Vertices can
 * nearly always slide in the surface to some gain (a finer grid where curvature varies), so that the Hessian over
 * everything has negative directions that say nothing of the shape.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_CERTIFICATE_H
#define CO_SOLVE_CERTIFICATE_H

#include "solve/level.h"

/* What motion along normals says at a cage. */
typedef struct co_certificate_shape {
    double decrement; /* NAN where the Hessian has negative directions */
    /* The same by conjugate gradients on finite differences of the gradient, as the report verified its minima; NAN
     * where that meets a negative direction, or was not asked for. */
    double difference_decrement;
    int32_t negative_directions; /* -1 if they cannot be counted */
    double touch_rise;           /* as curvopt_summary's */
} co_certificate_shape;

/* A level of motion along the normals of the cage xyz [3 n_vertices], in the user's units, with this symmetry kept; by
 * the quadrature rules of `solved`, which has the same symmetry, or, if that is NULL, by new ones. As co_level_create.
 */
int32_t co_certificate_level(const co_run_context *run, const curvopt_mesh *mesh, const co_symmetry *symmetry,
                             const co_constraints *constraints, const double *xyz, const co_level *solved,
                             co_level **out, curvopt_error *error);
/* A level of motion along normals where it stands. `differences`: whether the decrement by differences is wanted.
 * ERROR_MEMORY. */
int32_t co_certificate_check_shape(co_level *level, int differences, co_certificate_shape *out, curvopt_error *error);

/* Negative directions of this motion from xyz [3 n_vertices], no symmetry kept. As co_level_create. */
int32_t co_certificate_count_negative(const co_run_context *run, const curvopt_mesh *mesh,
                                      const co_constraints *constraints, co_motion motion, const double *xyz,
                                      int32_t *n_negative, curvopt_error *error);

/* curvopt_verdict on a cage of this objective: `decrement` is that over all that the run moved at the end. */
int32_t co_certificate_verdict(const co_tuning *tuning, double objective, double decrement,
                               const co_certificate_shape *shape);

#endif
