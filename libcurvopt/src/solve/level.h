/* One level of a run: the cage's energy as a function of its variables, minimized, kept resolved.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LEVEL_H
#define CO_SOLVE_LEVEL_H

#include "energy/adaptive_quadrature.h"
#include "hessian/newton_system.h"
#include "hessian/penalty.h"
#include "linalg/vector.h"
#include "optimize/lbfgs.h"

#include <math.h>
#include <stdatomic.h>

struct curvopt_cancel {
    atomic_int requested;
};

/* What does not change during a run. */
typedef struct co_run_context {
    const curvopt_options *options;
    double centroid[3], radius;   /* of the input cage: the frame of levels that hold vertices */
    double area;                  /* of its surface, which the result gets */
    co_basis_table_cache *tables; /* of the options' surface, for all levels */
    const curvopt_cancel *cancel; /* or NULL */
    int keeps_still; /* at the last level vertices do not slide: a saddle of the shape is looked for first */
    int is_patient;  /* the first stage may be on a plateau, as near a saddle, and is not to take that for its end */
} co_run_context;

typedef struct co_level {
    const co_run_context *frame;
    const curvopt_mesh *mesh;
    const double *start; /* [3 n_vertices] what the level began with, in the user's units */
    co_constraints hold;
    co_dof_map reduction;
    co_assembly assembly;
    co_penalty pull;                     /* of springs: the objective is the assembly's and this */
    double tolerance, working_tolerance; /* of quadrature: of the figures at the end, and for the work */
    double *x, *gx;                      /* [3 n_vertices] positions that were looked at last, normalized; a gradient */
    double *step, *normalized;           /* [n_variables] work */
    double *first, *safe; /* [n_variables] the level's first iterate; the last one that was held against finer rules and
                             stood */
    double edge;          /* mean length, normalized */
    double defect;        /* Gauss-Bonnet's, when last resolved, */
    co_values last;       /* and what was evaluated last */
    co_newton_system model; /* for a preconditioner */
    int has_model;
    co_gauge gauge; /* motions that the objective does not see */
    int exact;      /* LMVM's preconditioner is the Hessian's factor, not the Gauss-Newton matrix's */
    int has_factor;
    double shift;
    const double *assembled; /* [n_variables] where Newton's matrix was: the caller's */
    int has_gauss_newton;    /* and what to mix it with is there */
    int32_t number;
    int iterations, evaluations; /* of stages that are over */
    int32_t failed;              /* status of a call that cannot report it */
    curvopt_error *error;
    int (*report)(const struct co_level *level, const co_iterate *now, int iteration, int evaluations, void *user);
    void *user;
} co_level;

/* Whether the run is to end. Then evaluations are not finite, and no matrix is made any more. */
static inline int co_run_context_is_cancelled(const co_run_context *frame) {
    return frame->cancel && atomic_load_explicit(&frame->cancel->requested, memory_order_relaxed);
}

/* Takes over neither mesh nor start; constraints are copied. z [3 n_vertices at most] gets the variables.
 * As curvopt_minimize. */
int32_t co_level_create(const co_run_context *frame, const curvopt_mesh *mesh, const co_symmetry *symmetry,
                        const co_constraints *constraints, const double *start, int32_t number, co_level *out,
                        double *z, curvopt_error *error);
void co_level_free(co_level *level);

/* Rules, value and gradient at `now`; refuses what has none. */
int32_t co_level_begin(co_level *level, co_iterate *now, curvopt_error *error);
/* The level's function as an optimizer sees it, by what the level is set to now. */
co_objective co_level_objective(co_level *level);
/* Holds `now` against finer rules. It becomes the iterate to go back to; or, if it is not resolved or its energy is not
 * below that one's by rules that tell them apart, it goes back itself. level->failed may be set. */
co_step_verdict co_level_check(co_level *level, co_iterate *now);
/* Energies at `now` by rules that give the wanted accuracy, and positions in the user's units. */
int32_t co_level_finish(co_level *level, const co_iterate *now, double *xyz, curvopt_energies *energies, int *resolved,
                        curvopt_error *error);
/* Positions as the user sees them: in the frame they were taken from where something is held; else the area is the
 * input's, and the cage lies as the level's first one did. */
void co_level_to_user(const co_level *level, const double *z, double normalized_area, double *xyz);
/* Value and gradient at z [n_variables]. */
double co_level_evaluate(co_level *level, const double *z, double *gradient);
/* The level's model becomes that of `now`, factored with the least shift. *positive: as co_newton_system_factorize. */
int32_t co_level_factorize(co_level *level, const co_iterate *now, int exact, int *positive, curvopt_error *error);
/* Negative directions of the Hessian at `now`; -1 if there are too many variables to count them. */
int32_t co_level_count_negative(co_level *level, const co_iterate *now, int32_t *n_negative, curvopt_error *error);
/* From a stationary point some way along the direction in which the Hessian is most negative; *left: whether there is
 * one that leads down. For levels that are not solved afterwards. ERROR_MEMORY. */
int32_t co_level_leave_saddle(co_level *level, co_iterate *now, int *left, curvopt_error *error);
static inline double co_level_relative_gradient(const co_level *level, const co_iterate *now) {
    return co_vector_norm((size_t)level->reduction.n_variables, now->gradient) / fabs(now->value);
}
/* Of the value at `now`, what is the surface's. */
static inline double co_level_energy(const co_level *level, const co_iterate *now) {
    return now->value - co_penalty_value(&level->pull, now->x, NULL);
}

#endif
