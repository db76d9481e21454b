/* What a solver that stays keeps. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LIVE_STATE_H
#define CO_SOLVE_LIVE_STATE_H

#include "solve/run.h"

/* The caller's constraints, copied. */
typedef struct co_live_given {
    curvopt_constraints given; /* points into what follows; n = 0: none */
    int32_t *integers;
    double *reals;
    double *places; /* [3 n] */
} co_live_given;

/* Stays where it is in memory. */
struct curvopt_solver {
    curvopt_mesh *mesh;
    curvopt_options options; /* AUTO resolved, one level; they point to `given` and `holes` */
    const co_tuning *tuning;
    co_live_given given;
    int32_t *holes;
    co_basis_table_cache tables; /* of options.surface */
    co_thread_pool *threads;
    co_cancel cancel;
    double *first;         /* [3 n_vertices] the cage that it was created with */
    double *xyz;           /* [3 n_vertices] where it stands */
    co_run *run;           /* what one arrangement of constraints and options needs */
    co_level *level;       /* over all that may move; NULL: not made yet */
    co_level *normals;     /* along normals; likewise */
    double *level_start;   /* [3 n_vertices] which `level` borrows */
    double *normals_start; /* [3 n_vertices] which `normals` borrows */
    /* [3 n_vertices] with an even spacing, where something is held: from where `level` stood at its last end to what
     * motion along normals made of it. What is shown of the level has this beside it, or a settled shape would jump
     * back to that of objective and spacing together at the first touch. */
    double *beside;
    int is_elsewhere; /* constraints are not where `level` has them */
};

#endif
