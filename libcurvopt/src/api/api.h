/* What the files of the exported functions share. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_API_API_H
#define CO_API_API_H

#include "energy/assembly.h"

#include <stddef.h>

/* Who is told how far a call is, and who can end it. */
typedef struct co_watch {
    curvopt_progress_fn progress; /* NULL: nobody is told */
    void *user;
    const curvopt_cancel *cancel; /* NULL: nobody can */
} co_watch;

struct curvopt_problem {
    co_assembly assembly;
    co_basis_table_cache tables;
    co_thread_pool *threads;
    co_cancel cancel;       /* of the call that is on */
    co_watch watch;         /* of the call that is on */
    curvopt_cancel stopped; /* raised: for the flag of a call whose callback ends it */
    curvopt_progress told;  /* what the callback gets */
    double started;         /* co_clock_seconds() when the call began */
    double tolerance;
    int32_t n_faces;
    int is_part; /* of a surface: the caller's weights */
};

int32_t co_api_null(curvopt_error *error, const char *name);
/* A struct of the library's into the caller's: what fits, and 0 into the rest. */
void co_api_copy_out(void *to, size_t to_size, const void *from, size_t from_size);
/* The caller's options in the library's struct, with defaults for members that the caller does not know, validated,
 * AUTO resolved. */
int32_t co_api_take_options(const curvopt_options *theirs, curvopt_options *own, curvopt_error *error);
/* The same, for functions that work on a cage: mesh and xyz, which may be NULL, are checked, too. */
int32_t co_api_take_cage(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *theirs,
                         curvopt_options *own, curvopt_error *error);
/* face_weight NULL: all faces count once, but those that are left out at xyz. */
int32_t co_api_create_problem(const curvopt_mesh *mesh, const double *xyz, const double *face_weight,
                              const curvopt_options *options, const co_watch *watch, curvopt_problem **out,
                              curvopt_error *error);

#endif
