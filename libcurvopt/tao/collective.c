/* Ranks that must come to the same end. SPDX-License-Identifier: GPL-3.0-or-later */
#include "collective.h"

#include <stdio.h>
#include <string.h>

int collective_failure(MPI_Comm comm, int failed, char *message) {
    int rank, size, first, worst;
    MPI_Comm_rank(comm, &rank);
    MPI_Comm_size(comm, &size);
    int mine = failed ? rank : size;
    MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, comm);
    if (first == size)
        return 0;
    MPI_Allreduce(&failed, &worst, 1, MPI_INT, MPI_MAX, comm);
    MPI_Bcast(message, COLLECTIVE_MESSAGE, MPI_CHAR, first, comm);
    return worst;
}

int collective_status(MPI_Comm comm, int32_t status, const curvopt_error *error, char *message) {
    if (status != CURVOPT_OK)
        snprintf(message, COLLECTIVE_MESSAGE, "%s", error->message);
    return collective_failure(comm, status, message);
}

void collective_abort(MPI_Comm comm, const char *why) {
    int rank;
    MPI_Comm_rank(comm, &rank);
    fprintf(stderr, "curvopt-tao: rank %d: %s\n", rank, why);
    fflush(stderr);
    MPI_Abort(comm, 1);
}

void collective_check(MPI_Comm comm, int32_t status, const curvopt_error *error) {
    if (status != CURVOPT_OK)
        collective_abort(comm, error->message);
}

void *collective_allocated(MPI_Comm comm, void *p) {
    if (!p)
        collective_abort(comm, "out of memory");
    return p;
}
