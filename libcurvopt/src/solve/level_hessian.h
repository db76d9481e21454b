/* The matrices of one level: the Hessian and the Gauss-Newton matrix of its function, their shift and their factor.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LEVEL_HESSIAN_H
#define CO_SOLVE_LEVEL_HESSIAN_H

#include "solve/level_objective.h"

typedef struct co_level_hessian {
    co_level_objective *objective;
    co_newton_system system;
    int exists;              /* whether `system` has been made */
    int has_factor;          /* whether it can solve */
    int has_gauss_newton;    /* whether there is a Gauss-Newton matrix to mix with, at the same point */
    const double *assembled; /* [n_variables] where the Hessian was assembled; the caller's */
    double shift;            /* multiple of the unit matrix, or of the metric, that was added last */
    double *metric; /* [n_entries] in which L-BFGS' matrix is shifted (strain_metric.h); made when first needed */
} co_level_hessian;

/* objective must outlive it and stay where it is. ERROR_SIZE, ERROR_MEMORY. */
int32_t co_level_hessian_create(co_level_objective *objective, co_level_hessian *out, curvopt_error *error);
void co_level_hessian_free(co_level_hessian *hessian);

/* The least shift, of a displacement of all vertices by the surface's size costing tuning.shift_least times the energy:
 * curvature below it counts as none. */
double co_level_hessian_least_shift(const co_level_hessian *hessian, double value);

/* How much the function rises in the mean, by the matrix that was assembled last, where each vertex that it moves is
 * moved by CURVOPT_TOUCH mean edges in a random direction; of motion along normals, by what of that is along them. */
double co_level_hessian_touch_rise(const co_level_hessian *hessian);
/* For L-BFGS: the Gauss-Newton matrix at `now`, or the Hessian by coarser rules, shifted (Levenberg 1944, Marquardt
 * 1963), by a multiple of the metric of strains, and the least shift besides. The multiple is no less than that, so
 * that what the matrix does not see (sliding in the surface) is not infinitely soft, and as much more as keeps steps
 * near the cap: `step_excess` is how many times too long the last one was. ERROR_MEMORY. */
int32_t co_level_hessian_update(co_level_hessian *hessian, const co_iterate *now, double step_excess, int by_hessian,
                                curvopt_error *error);
/* For Newton's method: as co_objective's assemble and factorize; by the assembly's rules, or if not `closely` by
 * coarser ones (libcurvopt/notes/75-rules-of-a-steps-matrix.md). ERROR_MEMORY. */
int32_t co_level_hessian_assemble(co_level_hessian *hessian, const co_iterate *now, const double *before, int closely,
                                  curvopt_error *error);
int32_t co_level_hessian_factorize(co_level_hessian *hessian, const co_damping *damping, int *positive,
                                   curvopt_error *error);
/* The ways back to held numbers become those that change the energy least, by the Gauss-Newton matrix at `now`. The
 * factor is lost, the shift stays. ERROR_MEMORY. */
int32_t co_level_hessian_soften_ways(co_level_hessian *hessian, const co_iterate *now, curvopt_error *error);
/* out = M^-1 in, [n_variables] both. ERROR_MEMORY. */
int32_t co_level_hessian_solve(co_level_hessian *hessian, const double *in, double *out, curvopt_error *error);

/* The Hessian, or with `exact` 0 the Gauss-Newton matrix, at `now`, factored with the least shift. `gauge`: motions
 * that are made stiff. *positive: as co_newton_system_factorize. ERROR_MEMORY. */
int32_t co_level_hessian_factorize_at(co_level_hessian *hessian, const co_iterate *now, int exact, int *positive,
                                      curvopt_error *error);
/* The same with a shift that is raised until the matrix is positive, if the Hessian is not. ERROR_MEMORY. */
int32_t co_level_hessian_factorize_shifted(co_level_hessian *hessian, double shift, curvopt_error *error);
/* The Hessian at `now`, not factored, motions of `gauge` stiff. ERROR_MEMORY. */
int32_t co_level_hessian_assemble_exact(co_level_hessian *hessian, const co_iterate *now, co_gauge gauge,
                                        curvopt_error *error);
/* The matrix that Newton's method assembled, unmixed, with the least shift that makes it positive. ERROR_MEMORY. */
int32_t co_level_hessian_unmix(co_level_hessian *hessian, const co_iterate *now, curvopt_error *error);
/* Negative directions of the Hessian at `now`; -1 if they cannot be counted: there are too many variables, or rounding
 * leaves the count unknown. `has_hessian`: it was assembled there last, and by the assembly's rules. *decrement:
 * Newton's, if there are none, else NAN. Moebius maps count as no directions where the energy does not see them, so
 * that there may be none although the matrix has no Cholesky factor. ERROR_MEMORY. */
int32_t co_level_hessian_count_negative(co_level_hessian *hessian, const co_iterate *now, int has_hessian,
                                        int32_t *n_negative, double *decrement, curvopt_error *error);

#endif
