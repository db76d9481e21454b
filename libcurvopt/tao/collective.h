/* Ranks that must come to the same end. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_COLLECTIVE_H
#define CURVOPT_TAO_COLLECTIVE_H

#include "curvopt.h"

#include <petscsys.h>

/* Collective. The largest `failed` of all ranks; if it is not 0, every rank gets the message [COLLECTIVE_MESSAGE] of
 * the first one that failed. */
enum { COLLECTIVE_MESSAGE = 512 };
int collective_failure(MPI_Comm comm, int failed, char *message);
/* The same for a call of the library. */
int collective_status(MPI_Comm comm, int32_t status, const curvopt_error *error, char *message);

/* Where a rank fails alone, in the middle of a solve: says so and ends all of them. */
void collective_abort(MPI_Comm comm, const char *why);
/* As collective_abort() unless `status` is CURVOPT_OK; `p` is not NULL. */
void collective_check(MPI_Comm comm, int32_t status, const curvopt_error *error);
void *collective_allocated(MPI_Comm comm, void *p);

/* Zeroed, or the end of all ranks. Free with free(). */
#define COLLECTIVE_NEW(comm, type, count)                                                                              \
    ((type *)collective_allocated(comm, calloc((size_t)(count) > 0 ? (size_t)(count) : 1, sizeof(type))))

#endif
