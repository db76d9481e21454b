/* A distributed cage, into a file. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_OUTPUT_OBJ_H
#define CURVOPT_TAO_OUTPUT_OBJ_H

#include "subdomain.h"

#include <stdio.h>

/* Collective. As OBJ, in natural order, by way of rank 0, which has a block of n / ranks vertices or faces at a time;
 * `file` and *failed (nonzero if writing failed) matter there only. own_xyz [3 n_own] */
PetscErrorCode output_obj_cage(const subdomain *p, const double *own_xyz, FILE *file, int *failed);
/* A line of three numbers for each vertex, alike. */
PetscErrorCode output_obj_vectors(const subdomain *p, const double *own_vectors, FILE *file, int *failed);

#endif
