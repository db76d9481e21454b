/* A run: what all of its levels share, what the present level has come to, and how a level is solved.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_RUN_H
#define CO_SOLVE_RUN_H

#include "constraints/constraints.h"
#include "constraints/sliding.h"
#include "constraints/symmetry.h"
#include "solve/level_solve.h"
#include "solve/no_crossings.h"

struct curvopt_result {
    curvopt_mesh *mesh;
    double *xyz;
    curvopt_energies start, end; /* of the input cage and of the result */
    curvopt_summary summary;
    curvopt_level_report *level; /* [options.levels] */
    int32_t (*touching)[2];      /* [summary.n_touching] */
};

/* What a level has come to. */
typedef struct co_level_result {
    co_symmetry symmetry; /* that was kept */
    double *start;        /* [3 n_vertices] what the level began with, in the user's units */
    double *turn;         /* [3 n_vertices] or NULL: what its last turn along normals began with */
    double *xyz;          /* [3 n_vertices] where it ended */
    curvopt_energies energies;
    int is_resolved;                      /* these */
    double penalty;                       /* what springs add to the objective, and its reference (co_values) */
    double springs;                       /* the springs' part of that */
    double multiplier[CURVOPT_N_SCALARS]; /* of numbers that are held, by curvopt_scalar, in the user's units */
    double residual[CURVOPT_N_SCALARS];   /* how far they are from what is wanted */
    int rejected;                         /* steps that its turns took back */
    curvopt_level_report report;
} co_level_result;

/* What a level took before it was solved. */
typedef struct co_run_work {
    int32_t iterations, evaluations;
    double seconds;
} co_run_work;

typedef struct co_run {
    co_run_context context;
    curvopt_progress_fn progress;
    void *user;
    double started;      /* seconds */
    double start_energy; /* of the input cage */
    co_cancel cancel;    /* what takes long looks at this */
    co_thread_pool *threads;
    co_basis_table_cache tables;
    co_constraints constraints;   /* of the present mesh */
    double *shape;                /* [3 n_vertices] what the present level began with: context.shape */
    co_held_numbers held;         /* context.held, where that is not NULL */
    co_sliding sliding;           /* the same; nothing without options.slide */
    co_no_crossings no_crossings; /* nothing without options.no_crossings */
    co_run_work spent;            /* by sliding on the present level, until that is solved */
    int lost_steps;               /* of the present level, before it began again by finer rules */
    double first_gradient;        /* norm of that by which the present level began */
    double forming_shift;         /* of the last matrix by which a shape formed (co_level_hessian); 0: none has yet */
    const double *shown_beside;   /* [3 n_vertices] or NULL: what is added to cages of levels over everything that the
                                     caller sees, where something is held (live.h) */
    int is_live;                  /* what is held changes afterwards (live.h) */
    int looks_ahead;              /* coarse levels hold vertices of the last level's cage (look_ahead.h) */
    int is_component;             /* of a larger cage, where nothing may move on any level (component_runs.h) */
    int stands;                   /* nothing does */
    int is_asked_to_stop;         /* by the callback */
    int has_grown;                /* the level ended because the surface grows without end: CURVOPT_STOP_GROWN */
    co_level_prospect prospect;   /* of the levels to come */
    co_level_result at;           /* the present level */
    curvopt_result *result;       /* its mesh is the present one */
} co_run;

/* Most turns of motion along normals, each along those of the cage where it begins. */
enum { CO_RUN_MOST_TURNS = 8 };
/* In mean edges: normals of cages that are closer than this are the same. */
#define CO_RUN_SAME_NORMALS 1e-2

/* Tells the caller of the level's steps. On CO_MOTION_SLIDE what it sees is put back on the curves, and the level ends
 * where a vertex has slid so far that its tangent is no longer that of its curve. */
void co_run_watch(co_run *run, co_level *level);

/* Solves the present mesh from run->at.start, with the symmetry that is kept, by the level `number`; the figures and
 * positions go into run->at. Where an even spacing is wanted, the
 * last level ends with motion along normals, and *level is the level of that. It is the caller's to destroy, NULL after
 * a failure, and where the run was cancelled before the level was there. As curvopt_minimize. */
int32_t co_run_solve(co_run *run, int32_t number, co_level **level, curvopt_error *error);

/* Solves a level on from its result, by the Hessian itself. As co_run_solve. */
int32_t co_run_solve_on(co_run *run, co_level *level, curvopt_error *error);

/* Solves a level that has begun, counts what it took with what was taken before, and has its figures. `started`: by
 * co_clock_seconds(). As curvopt_minimize. */
int32_t co_run_solve_level(co_run *run, co_level *level, double started, curvopt_error *error);
/* run->at.xyz becomes what the caller sees where the level stands. */
void co_run_show(co_run *run, const co_level *level);
/* The level's result where the run was cancelled in the middle of something: what the level has reached, or its first
 * cage and the figures of before if it had not begun, or is NULL. */
void co_run_end_cancelled(co_run *run, co_level *level, double started);
/* What the run has come to, into its result. */
void co_run_summarize(co_run *run);

/* Whether a saddle that the present level's symmetries hide will be looked for: of third-order terms, whose
 * discretization is often one. The shape must stand first. */
int co_run_may_loosen(const co_run *run, const co_level *level);
/* Whether the present level was cancelled or could not be resolved. */
int co_run_stopped_early(const co_run *run);
void co_level_result_free(co_level_result *result);
void co_run_result_destroy(curvopt_result *result);

#endif
