/* What springs (soft_constraints.h) add to the objective, over a reduction's variables. SPDX-License-Identifier:
 * GPL-3.0-or-later
 */
#ifndef CO_HESSIAN_PENALTY_H
#define CO_HESSIAN_PENALTY_H

#include "hessian/sparse_hessian.h"

/* A quadratic function of each node that has springs, with y = z - rest:  slope . y + y . matrix y / 2. */
typedef struct co_penalty {
    int32_t n;       /* nodes that have springs */
    int32_t *first;  /* [n] a node's first variable */
    int32_t *size;   /* [n] and how many it has */
    double *rest;    /* [n][3] */
    double *slope;   /* [n][3] of what no variable reaches: 0 but where constraints or symmetry are in the way */
    double *matrix;  /* [n][3][3] */
    double constant; /* the function at rest */
} co_penalty;

/* How much an objective with these weights (curvopt_term) resists: the stiffness of the unit sphere at a point, in
 * units of the objective over length squared.
 *
 * With u = sum u_l Y_l the normal displacement of a unit sphere, E = E_0 + sum q_l u_l^2 / 2, a force at a point moves
 * that point by sum (2 l + 1) / (4 pi q_l), and K is the inverse of this. l = 0 and l = 1, to first order scaling and
 * translation, do not count. With L = l (l + 1), int H^2 has q = L (L - 2) / 2, Willmore 2 L (L - 2), for which the sum
 * telescopes: K = 6 pi and 24 pi. Third order, times the area 4 pi: int |F1|^2 has 9/8 L (L - 2)^2 and int |F3|^2
 * L (L - 2) (L - 6) / 8; X of MVS counts as its mean over directions, 0, for a sphere is all umbilics. The sum for the
 * area diverges, slowly, and is cut off behind its first term. A fixed surface, and not the user's cage: with that, the
 * strength of a weight would depend on how rough the cage is. */
double co_penalty_stiffness(const double weights[CURVOPT_N_TERMS]);

/* Of a cage normalized by this centroid and radius. `scale` is the objective's stiffness. ERROR_MEMORY. */
int32_t co_penalty_create(const co_soft_constraints *springs, const co_dof_map *reduction, const double centroid[3],
                          double radius, double scale, co_penalty *out, curvopt_error *error);
void co_penalty_free(co_penalty *pull);
/* At z [n_variables]; gradient [n_variables] += its own, unless NULL. */
double co_penalty_value(const co_penalty *pull, const double *z, double *gradient);
/* The Hessian += its own. */
void co_penalty_add_hessian(const co_penalty *pull, co_sparse_hessian *hessian);

#endif
