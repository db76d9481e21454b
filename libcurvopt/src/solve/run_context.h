/* What all levels of a run share, and none changes. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_RUN_CONTEXT_H
#define CO_SOLVE_RUN_CONTEXT_H

#include "base/cancel.h"
#include "base/tuning.h"
#include "surface/basis_table.h"

typedef struct co_run_context {
    const curvopt_options *options;
    const co_tuning *tuning;
    const curvopt_cancel *cancel; /* may be NULL */
    co_basis_table_cache *tables; /* of the options' surface */
    double centroid[3];           /* of the input cage: the frame of levels that hold vertices, with `radius` */
    double radius;                /* root mean square, of the input cage */
    double area;                  /* of the input cage's surface; the result gets the same */
    const double *shape;          /* [3 n_vertices] of the present mesh: half discs are chosen by it on all of its level
                                     (blend_disc_half.h); NULL: by the cage that each objective begins with */
} co_run_context;

/* Whether the run is to end. Then evaluations are not finite, and no matrix is made any more. */
static inline int co_run_context_is_cancelled(const co_run_context *run) {
    return co_cancel_is_requested(run->cancel);
}

static inline int co_run_context_is_last(const co_run_context *run, int32_t level) {
    return level == run->options->levels;
}

#endif
