/* A cage that is shared out, into a file. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_WRITE_H
#define CURVOPT_TAO_WRITE_H

#include "subdomain.h"

#include <stdio.h>

/* Collective. As OBJ, in natural order, by way of rank 0, which has an equal share of the cage at a time; `file` and
 * *failed (nonzero if writing failed) matter there only. own_xyz [3 n_own] */
PetscErrorCode write_cage(const portion *p, const double *own_xyz, FILE *file, int *failed);
/* A line of three numbers for each vertex, alike. */
PetscErrorCode write_vectors(const portion *p, const double *own_vectors, FILE *file, int *failed);

#endif
