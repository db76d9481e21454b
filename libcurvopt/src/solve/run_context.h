/* What all levels of a run share, and none changes but `held`. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_RUN_CONTEXT_H
#define CO_SOLVE_RUN_CONTEXT_H

#include "base/cancel.h"
#include "base/tuning.h"
#include "energy/spontaneous_curvature.h"
#include "hessian/repulsion.h"
#include "surface/basis_table_cache.h"

#include <math.h>

/* The size of the result, where nothing of the cage is held: one number, over which the others count. */
typedef struct co_run_size {
    int measure;  /* curvopt_scalar */
    double value; /* that the result gets, in units of the cage */
} co_run_size;

typedef struct co_run_context {
    const curvopt_options *options;
    const co_tuning *tuning;
    const curvopt_cancel *cancel; /* may be NULL */
    co_basis_table_cache *tables; /* of the options' surface */
    double centroid[3];           /* of the input cage: the frame of levels that hold vertices, with `radius` */
    double radius;                /* root mean square, of the input cage */
    co_run_size size;             /* of the result, where nothing of the cage is held */
    co_held_numbers *held;        /* numbers of the surface that are held, at the targets reached so far; NULL: none */
    co_held_numbers wanted;       /* the same with the targets at the end */
    co_spontaneous_curvature spontaneous; /* as levels see it */
    double least;        /* added to what is minimized: a flat surface has no energy, and relative figures need some */
    int n_finer;         /* times that the tolerance became finer, because the present level was lost */
    const double *shape; /* [3 n_vertices] of the present mesh: half discs are chosen by it on all of its level
                            (blend_disc_half.h); NULL: by the cage that each objective begins with */
    co_repulsion_exceptions *exceptions; /* with options.no_crossings, of the present mesh; else NULL */
} co_run_context;

/* Whether the run is to end. Then evaluations are not finite, and no matrix is made any more. */
static inline int co_run_context_is_cancelled(const co_run_context *run) {
    return co_cancel_is_requested(run->cancel);
}

/* What the function that is minimized has on top of energy, springs and spacing, where all runs have the same. */
static inline double co_run_context_reference(const co_run_context *run) {
    return run->least + co_spontaneous_curvature_reference(&run->spontaneous, 0);
}

/* Of quadrature of the run's figures. */
static inline double co_run_context_tolerance(const co_run_context *run) {
    double tolerance = run->options->joshi_sequin ? (double)INFINITY : run->options->tolerance;
    for (int k = 0; k < run->n_finer; k++)
        tolerance *= run->tuning->finer_factor;
    return tolerance;
}

static inline int co_run_context_is_last(const co_run_context *run, int32_t level) {
    return level == run->options->levels;
}

#endif
