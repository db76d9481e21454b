/* One level's function: the energy of a cage, and what springs and an even spacing add, over the variables that
 * constraints and symmetry leave.
 *
 * Where nothing is held the function is invariant under similarities: it is that of the cage normalized to centroid 0
 * and root mean square radius 1. Where something is held, positions are normalized once, by the input cage's frame; on
 * normals, which are lines in space, by the frame of the cage that they are normals of.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LEVEL_OBJECTIVE_H
#define CO_SOLVE_LEVEL_OBJECTIVE_H

#include "constraints/interpolation.h"
#include "energy/assembly_sums.h"
#include "hessian/corner_walls.h"
#include "hessian/newton_system.h"
#include "hessian/penalty.h"
#include "hessian/repulsion.h"
#include "hessian/spacing.h"
#include "optimize/objective.h"
#include "solve/held_level.h"
#include "solve/run_context.h"

/* co_iterate.found. */
enum {
    CO_FOUND_SIZE,         /* of the normalized surface: co_run_size.measure */
    CO_FOUND_DEFECT,       /* Gauss-Bonnet's, in radians */
    CO_FOUND_MIN_JACOBIAN, /* least |S_u x S_v| of all samples, over the mean on the same face */
    CO_FOUND_SPACING,      /* spacing's part of the value */
    CO_FOUND_REPULSION     /* repulsion's part of the value */
};

typedef struct co_level_objective {
    const co_run_context *run;
    const curvopt_mesh *mesh;
    const double *start;            /* [3 n_vertices] the level's first cage, in the user's units */
    double *stays;                  /* [3 n_vertices] its positions, as those below: where what cannot move is */
    const double *likeness;         /* [3 n_vertices] the cage that results are placed like; `start` until replaced */
    co_constraints held;            /* pins and boundary; on normals, lines */
    co_interpolation interpolation; /* whose positions are those of all that follows */
    int is_framed;                  /* the user holds something: the result lies in the input's frame */
    co_dof_map reduction;           /* variables -> positions */
    co_held_level numbers;          /* numbers of the surface that are held */
    co_assembly assembly;           /* the energy */
    co_penalty penalty;             /* what springs add */
    co_spacing spacing;             /* what an even cage is worth; nothing on normals */
    co_corner_walls corners;        /* while a shape forms once more (level_even.h); `least` NULL: nothing */
    double spaced_energy;           /* by which both were weighed */
    co_repulsion repulsion;         /* where no crossings are wanted */
    co_gauge gauge;                 /* motions that the function does not see */
    double *sliding;          /* [n_sliding][n_variables] on normals: orthonormal, what is left of similarities there */
    int n_sliding;            /* 0 but on normals */
    double edge;              /* mean edge length of the cage that was normalized last */
    double radius;            /* root mean square radius of cages that the function is for, in its units */
    double *positions;        /* [3 n_vertices] of the point that was expanded last; limit points of those vertices
                                 that interpolate (interpolation.h) */
    double *cage;             /* [3 n_vertices] work: co_level_objective_cage() */
    double *point_gradient;   /* [3 n_vertices] work */
    double *spacing_gradient; /* [3 n_vertices] work */
    double *normalized;       /* [n_variables] work */
    double *step;             /* [n_variables] work */
} co_level_objective;

/* What may move. */
typedef enum co_motion {
    CO_MOTION_ALL,    /* all that constraints and symmetry leave */
    CO_MOTION_SLIDE,  /* besides, vertices of the constraints' curves along their tangents */
    CO_MOTION_NORMALS /* of that, what changes the shape: the cage's vertices on their normals
                         (co_constraints_to_normals) */
} co_motion;

/* Borrows run, mesh and start; constraints are copied. z [3 n_vertices at most] gets the variables of `start`. As
 * curvopt_minimize. */
int32_t co_level_objective_create(const co_run_context *run, const curvopt_mesh *mesh, const co_symmetry *symmetry,
                                  const co_constraints *constraints, co_motion motion, const double *start,
                                  co_level_objective *out, double *z, curvopt_error *error);
void co_level_objective_free(co_level_objective *objective);
/* From another cage `start` on, borrowed, whose constraints may be elsewhere: variables and springs are made anew, what
 * is made for the energy stays. z [n_variables] gets the variables of `start`. *fits: whether they are arranged as
 * before; if not, and on failure, the objective can only be freed. ERROR_MEMORY. */
int32_t co_level_objective_move(co_level_objective *objective, const co_symmetry *symmetry,
                                const co_constraints *constraints, co_motion motion, const double *start, double *z,
                                int *fits, curvopt_error *error);

static inline size_t co_level_objective_n(const co_level_objective *o) {
    return (size_t)o->reduction.n_variables;
}

/* Value and findings at at->x, and the gradient unless at->gradient is NULL.
 *
 * On normals a similarity of the cage keeps its normal part only. That is the similarity, which changes nothing, less a
 * motion along the surface: to first order it slides, and the shape stays. So what is left of similarities there is
 * no variable: the gradient has no component along it, and no direction may have one. */
void co_level_objective_evaluate(co_level_objective *objective, co_iterate *at);
/* Where no crossings are wanted: whether z has one that a look on the way has missed. */
int co_level_objective_crosses(co_level_objective *objective, const double *z);
/* Corners of faces are to keep some of the share that they have in the cage that was placed last, from when the spacing
 * is weighed next until co_corner_walls_free. ERROR_MEMORY. */
int32_t co_level_objective_wall_corners(co_level_objective *objective, curvopt_error *error);
/* An even spacing is to be worth so much at `now`, in units of the objective; 0: nothing. `now` is evaluated again. */
void co_level_objective_weigh_spacing(co_level_objective *objective, double worth, co_iterate *now);
/* Where numbers are held: `now` goes back to where they have their values, and is evaluated. The targets become what
 * the run wants, or as much of that as vertices can go to at once by `most` mean edges at most. Returns whether they
 * are what the run wants; *changed: whether they are others than before. */
int co_level_objective_aim(co_level_objective *objective, double most, co_iterate *now, int *changed);
/* `now` goes back to held numbers, where its value and gradient are the same. */
void co_level_objective_go_back(co_level_objective *objective, co_iterate *now);
/* Where no crossings are wanted: repulsion is weighed by the energy at `now` if that makes it `least` times as strong
 * or less, or if it had no weight; whether it does. `now` is evaluated again. */
int co_level_objective_weigh_repulsion(co_level_objective *objective, double energy, double least, co_iterate *now);
/* The value alone, at z [n_variables]. */
double co_level_objective_value(co_level_objective *objective, const double *z);
/* Takes from a direction d [n_variables] what the gradient has no component along. */
void co_level_objective_restrict(const co_level_objective *objective, double *d);
/* The longest displacement of a vertex by d [n_variables], in mean edges. */
double co_level_objective_length(const co_level_objective *objective, const double *d);
/* The same from one point to another. */
double co_level_objective_distance(co_level_objective *objective, const double *from, const double *to);
/* Back to centroid 0 and radius 1 where nothing is held: the function is the same there, and the gradient scales.
 * objective->positions become the cage, objective->edge its mean edge. */
void co_level_objective_normalize(co_level_objective *objective, co_iterate *now);
/* objective->positions become those of z. */
void co_level_objective_place(co_level_objective *objective, const double *z);
/* The function becomes the one for cages of the size of objective->positions: by that umbilics are smoothed
 * (functional.h), and where positions are not normalized, the function does not see it change. Returns by how much of
 * itself it has. */
double co_level_objective_take_size(co_level_objective *objective);
/* The cage's edges, of the positions that the variables move; none of them copied. */
co_cage_edges co_level_objective_edges(const co_level_objective *objective);
/* Places of the vertices [3 n_vertices] for objective->positions, until these change: the positions, or where values of
 * the surface stand in for vertices the cage. */
const double *co_level_objective_cage(co_level_objective *objective);
/* Positions xyz [3 n_vertices] as the user sees them: in the frame of the input where something is held; else the
 * surface has the run's size, `size` being its measure at z, and the cage lies as the level's first one did. */
void co_level_objective_to_user(const co_level_objective *objective, const double *z, double size, double *xyz);
/* |gradient| / |value| */
double co_level_objective_relative_gradient(const co_level_objective *objective, const co_iterate *now);
/* The value at a cage xyz [3 n_vertices, the user's units] that variables need not reach; of springs what they reach.
 * Where something is held. */
double co_level_objective_value_of(co_level_objective *objective, const double *xyz);
/* The surface's part of the value at `now`, with its reference (co_values). */
double co_level_objective_energy(const co_level_objective *objective, const co_iterate *now);
/* Where springs are worth a part of the objective, whatever it becomes (co_soft_constraints.weighed_by): weighs them by
 * this one if that makes them `least` times as stiff or less; whether it does. Values are others then. */
int co_level_objective_weigh_springs(co_level_objective *objective, double energy, double least);

#endif
