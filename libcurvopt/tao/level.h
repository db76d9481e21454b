/* One level of a run with TAO: the cage's vertices moved until TAO is content, on an energy that is kept resolved.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_LEVEL_H
#define CURVOPT_TAO_LEVEL_H

#include "certificate.h"
#include "constraints.h"

/* A run, as far as its levels need it. */
typedef struct run {
    MPI_Comm comm;
    const curvopt_options *options;
    int quiet;
    double started;
    double centroid[3], radius; /* of the input cage */
    double area;                /* of its surface, in the user's units */
    int n_levels;
    curvopt_level_report level[12];
    curvopt_summary summary;
    int verified;
    verification all, shape; /* of what moves, and of motion along normals; if verified */
    char tao_type[32];
    double cpu_seconds;   /* of this rank in the library, over all levels */
    double least_seconds; /* of the clock, for a value and gradient at the last level */
    int32_t evaluations;
    char message[512]; /* why the run was refused */
} run;

/* Collective. From xyz [3 n_own], in the user's units, to the level's best, in place; *refused is a status of the
 * library, and then r->message says why. */
PetscErrorCode level_solve(run *r, const portion *on, const level_pins *pins, int number, double *xyz, int *refused);

/* Collective. The objective's gradient at xyz [3 n_own], with respect to it, into own [3 n_own]; nothing held. */
PetscErrorCode level_gradient(const portion *on, const curvopt_options *options, const double *xyz, double *own,
                              int *refused);

double level_now(void);

#endif
