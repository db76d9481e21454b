/* Which energies are finite on which surface of a cage. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ADMISSIBILITY_H
#define CO_ENERGY_ADMISSIBILITY_H

#include "energy/functional.h"
#include "surface/patches.h"

/* What is held and left out of the energy (curvopt_exception). */
typedef struct co_exceptions {
    int32_t *vertex;    /* [n_vertices] curvopt_exception, -1: not held */
    int32_t *face;      /* [n_faces] curvopt_exception, -1: counts */
    int32_t n_held;     /* vertices that are held */
    int32_t n_left_out; /* faces that are left out */
} co_exceptions;

/* The exceptions of a cage at xyz [3 n_vertices], finite, to these options, of which holes count; NULL: those that
 * depend on positions are not looked for. ERROR_ARGUMENT naming a hole that is no face, ERROR_MEMORY. */
int32_t co_exceptions_find(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                           co_exceptions *out, curvopt_error *error);
void co_exceptions_free(co_exceptions *exceptions);
/* The same for a run or an evaluation. With options->strict the cage is refused instead if it is no manifold
 * (ERROR_TOPOLOGY) or degenerate (ERROR_GEOMETRY), and what else has no finite energy is left in, for
 * co_admissibility_check to refuse. ERROR_SURFACE if no face counts. */
int32_t co_exceptions_of_run(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                             co_exceptions *out, curvopt_error *error);

/* ERROR_SURFACE naming the vertex (-1 where it is the centre of a face, which the message names) if the functional is
 * infinite or not known on this cage's `surface` (curvopt_surface). *third_allowed: whether third-order energies are
 * finite. */
int32_t co_admissibility_check(const curvopt_mesh *mesh, const co_patches *patches, const co_functional *functional,
                               int32_t surface, int *third_allowed, curvopt_error *error);

#endif
