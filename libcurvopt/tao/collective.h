/* Ranks that must come to the same end. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_AGREE_H
#define CURVOPT_TAO_AGREE_H

#include "curvopt.h"

#include <petscsys.h>

/* Collective. The largest `failed` of all ranks; if it is not 0, every rank gets the message [AGREE_MESSAGE] of the
 * first one that failed. */
enum { AGREE_MESSAGE = 512 };
int agree(MPI_Comm comm, int failed, char *message);
/* The same for a call of the library. */
int agree_on_status(MPI_Comm comm, int32_t status, const curvopt_error *error, char *message);

/* Where a rank fails alone, in the middle of a solve: says so and ends all of them. */
void agree_to_end(MPI_Comm comm, const char *why);
/* As agree_to_end() unless `status` is CURVOPT_OK; `p` is not NULL. */
void agree_succeeded(MPI_Comm comm, int32_t status, const curvopt_error *error);
void *agree_allocated(MPI_Comm comm, void *p);

/* Zeroed, or the end of all ranks. Free with free(). */
#define AGREE_NEW(comm, type, count)                                                                                   \
    ((type *)agree_allocated(comm, calloc((size_t)(count) > 0 ? (size_t)(count) : 1, sizeof(type))))

#endif
