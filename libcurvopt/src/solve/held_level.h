/* Numbers of the surface that are held on a level: every point goes back to where they have their values, along fixed
 * ways, and the objective is a function of where it comes to (Abadie, Carpentier 1969: the generalized reduced
 * gradient).
 *
 * With W the ways and c the constraints, x goes to x + W t with c(x + W t) = 0, t by Broyden's method (1965). The
 * gradient of the function that is left is g + A lambda, with g and A the gradients of the objective and of c there,
 * and W^T (g + A lambda) = 0: it does not see W. At a minimum lambda are Lagrange's multipliers, whatever W is.
 *
 * Where nothing of the surface is fixed c is, as the objective, a function of positions whose centroid is 0, and A and
 * W have no part along translations: by quadrature a surface with extraordinary vertices closes up only nearly, and its
 * volume depends on where it is.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_HELD_LEVEL_H
#define CO_SOLVE_HELD_LEVEL_H

#include "hessian/newton_system.h"

typedef struct co_held_level {
    co_held_numbers numbers; /* with the targets of the moment; n = 0: nothing is held, and the rest is empty */
    co_newton_held newton;   /* the ways, and the multipliers where the gradient was evaluated last */
    int is_idle;             /* nothing that may move changes the numbers: they stay as they are on this level */
    double *back;            /* [n_variables] where a point went back to */
    double *gradient;        /* [numbers.n + 1][n_variables] A, and work */
    double along[CURVOPT_N_SCALARS][CURVOPT_N_SCALARS]; /* A^T W, where the gradient was evaluated last */
    double *work;                                       /* [n_variables] the caller's to use */
    double *centred;                                    /* [n_variables] work: positions without translations */
    const co_dof_map *dofs;                             /* the caller's, as what follows */
    co_assembly *assembly;
    double *positions;      /* [3 n_vertices] work */
    double *point_gradient; /* [3 n_vertices] work */
} co_held_level;

/* Borrows dofs, assembly and work; must stay where it is. ERROR_MEMORY. */
int32_t co_held_level_create(const co_held_numbers *numbers, const co_dof_map *dofs, co_assembly *assembly,
                             double *positions, double *point_gradient, co_held_level *out, curvopt_error *error);
void co_held_level_free(co_held_level *held);
/* The ways become the constraints' gradients at x [n_variables], unless these are rounding: then the level is idle. */
void co_held_level_choose_ways(co_held_level *held, const double *x);
/* After the caller has changed them: of what each vertex moves by, only the part along the volume's gradient stays, so
 * that no way slides vertices into folds; and they are separated. x [n_variables]: where they were chosen. */
void co_held_level_straighten_ways(co_held_level *held, const double *x);
/* held->back becomes where x [n_variables] goes back to, by displacements up to `most` of a vertex; 0 if it does not.
 */
int co_held_level_go_back(co_held_level *held, const double *x, double most);
/* gradient [n_variables], the objective's at held->back, becomes that of the function that is left. The assembly was
 * evaluated there last, at positions that are `unit` times smaller. */
void co_held_level_reduce_gradient(co_held_level *held, const double integral[CO_N_INTEGRALS], double unit,
                                   double *gradient);
/* The constraints' values at x [n_variables] become the targets. */
void co_held_level_take_as_targets(co_held_level *held, const double *x);
/* c of each constraint at x [n_variables]. */
void co_held_level_residuals(co_held_level *held, const double *x, double residual[CURVOPT_N_SCALARS]);

#endif
