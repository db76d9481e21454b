/* A run whose surface is to come to cross itself nowhere: what its input does already, and what touches at the end.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_NO_CROSSINGS_H
#define CO_SOLVE_NO_CROSSINGS_H

#include "hessian/repulsion.h"

typedef struct co_no_crossings {
    co_repulsion_exceptions exceptions;
    int32_t *origin; /* [n_faces] face of the input cage that each face of the present one is in */
} co_no_crossings;

/* Of the input cage xyz [3 n_vertices], and of `start` [3 n_vertices], with which the run begins, where constraints
 * have put it: refused if that crosses itself where the input does not. Errors as curvopt_find_crossings, CO_CANCELLED.
 */
int32_t co_no_crossings_create(const curvopt_mesh *mesh, const double *xyz, const double *start,
                               co_thread_pool *threads, const curvopt_cancel *cancel, co_no_crossings *out,
                               curvopt_error *error);
/* Refuses a cage xyz [3 n_vertices] that crosses itself where the input does not: ERROR_GEOMETRY. Other errors as
 * co_no_crossings_create. */
int32_t co_no_crossings_check(const curvopt_mesh *mesh, const double *xyz, const co_no_crossings *no_crossings,
                              co_thread_pool *threads, const curvopt_cancel *cancel, curvopt_error *error);
void co_no_crossings_free(co_no_crossings *no_crossings);
/* Of what repels each other at positions x [3 n_vertices]: pairs [n][2] of faces of the input cage, ascending, which
 * the caller frees, and their least distance, NAN if there are none. ERROR_MEMORY. */
int32_t co_no_crossings_touching(co_repulsion *repulsion, const double *x, int32_t (**pairs)[2], int32_t *n,
                                 double *least, curvopt_error *error);
/* From a mesh to the one that one subdivision makes of it, xyz [3 n_vertices]. Crossings that were too small to be
 * proven before (crossing_pair.h) may be now; they are the surface's, and may go on. ERROR_MEMORY. */
int32_t co_no_crossings_subdivide(const curvopt_mesh *coarse, const curvopt_mesh *fine, const double *xyz,
                                  co_thread_pool *threads, const curvopt_cancel *cancel, co_no_crossings *no_crossings,
                                  curvopt_error *error);

#endif
