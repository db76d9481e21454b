/* Distribution of a cage over ranks. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_PARTITION_H
#define CURVOPT_TAO_PARTITION_H

#include "subdomain.h"

/* A cage as one rank has read it. */
typedef struct partition_source {
    const curvopt_mesh *mesh;
    const double *xyz; /* [3 n_vertices] */
} partition_source;

/* Collective; `source` matters on rank 0 only, which distributes the faces by halving the cage along its longest
 * extent, again and again. own_xyz [3 n_own] is the caller's to free(). At least as many faces as ranks. */
PetscErrorCode partition_cage(MPI_Comm comm, const partition_source *source, subdomain *out, double **own_xyz);

#endif
