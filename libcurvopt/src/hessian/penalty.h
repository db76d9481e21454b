/* The penalty that soft constraints (soft_constraints.h) add to the objective, over the variables of a dof_map.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_PENALTY_H
#define CO_HESSIAN_PENALTY_H

#include "hessian/sparse_hessian.h"
#include "hessian/surface_springs.h"

/* `weight` times the sum over nodes with springs of a quadratic function  q = constant + slope . y + y . matrix y / 2
 * of y = z - rest, or where a spring ends of the logarithmic barrier  -most ln(1 - q / most),  which is q where q is
 * small and infinite from `most` on (Fiacco, McCormick, "Nonlinear programming", 1968). */
typedef struct co_penalty {
    int32_t n;        /* number of nodes that have springs */
    int32_t *first;   /* [n] first variable of each */
    int32_t *size;    /* [n] number of its variables */
    double *rest;     /* [n][3] variables at which the vertices are as close to their anchors as they can be */
    double *slope;    /* [n][3] gradient there: 0 unless constraints or symmetry keep vertices from their anchors */
    double *matrix;   /* [n][3][3] */
    double *constant; /* [n] value at rest: 0 unless slope is not */
    double *most;     /* [n] value that springs do not reach, INFINITY where they have no end */
    double weight;    /* 1 at first */
    co_surface_springs surface; /* springs of other values of the surface: none until the caller makes them */
} co_penalty;

/* Stiffness of an objective with these weights (curvopt_term): that of the unit sphere at a point, in units of the
 * objective over length squared (libcurvopt/notes/80-soft-constraints.md).
 *
 * With u = sum u_l Y_l the normal displacement of a unit sphere, E = E_0 + sum q_l u_l^2 / 2, a force at a point moves
 * that point by sum (2 l + 1) / (4 pi q_l), and K is the inverse of this. l = 0 and l = 1, to first order scaling and
 * translation, do not count. With L = l (l + 1), int H^2 has q = L (L - 2) / 2, Willmore 2 L (L - 2), for which the sum
 * telescopes: K = 6 pi and 24 pi. Third order, times the area 4 pi: int |F1|^2 has 9/8 L (L - 2)^2 and int |F3|^2
 * L (L - 2) (L - 6) / 8; X of MVS counts as its mean over directions, 0, for a sphere is all umbilics. The sum for the
 * area diverges, slowly, and is cut off behind its first term. A fixed surface, and not the user's cage: with that, the
 * strength of a weight would depend on how rough the cage is. */
double co_penalty_stiffness(const double weights[CURVOPT_N_TERMS]);

/* The penalty of a cage normalized by this centroid and radius. `scale`: the objective's stiffness. ERROR_MEMORY. */
int32_t co_penalty_create(const co_soft_constraints *springs, const co_dof_map *dofs, const double centroid[3],
                          double radius, double scale, co_penalty *out, curvopt_error *error);
void co_penalty_free(co_penalty *penalty);
/* The value at z [n_variables], INFINITY where a spring is beyond its end; gradient [n_variables] += the gradient,
 * unless NULL. */
double co_penalty_value(const co_penalty *penalty, const double *z, double *gradient);
/* hessian += the second derivatives at z [n_variables]; where not `exact` a matrix near these that is positive
 * semidefinite. */
void co_penalty_add_hessian(const co_penalty *penalty, const double *z, int exact, co_sparse_hessian *hessian);

#endif
