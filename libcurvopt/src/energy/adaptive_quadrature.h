/* Adaptive quadrature: chooses the rule of each patch from error estimates.
 *
 * A patch's error is estimated by comparing its rule with the next finer one. Where the sum of errors is above the
 * tolerance, the patches with the largest error per cost of a finer rule are refined: a cost-weighted Doerfler marking
 * (marking.h). Its constants are in base/tuning.h, as quadrature_*.
 *
 *     evaluate by rules r and r + 1 --> sum of errors <= tolerance? --yes--> third rule r + 2 where errors are largest
 *          ^                                  | no                           (only for the errors that are claimed)
 *          +--- r + 1 for marked patches <----+
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ADAPTIVE_QUADRATURE_H
#define CO_ENERGY_ADAPTIVE_QUADRATURE_H

#include "energy/assembly_sums.h"

/* Which terms a call of co_adaptive_quadrature_resolve() is about. */
typedef enum co_terms {
    CO_TERMS_OBJECTIVE, /* terms with a weight */
    CO_TERMS_REPORT,    /* all are evaluated, the objective decides */
    CO_TERMS_ALL        /* all must meet the tolerance */
} co_terms;

/* The request to co_adaptive_quadrature_resolve(). */
typedef struct co_quadrature_goal {
    double tolerance;                                       /* wanted relative error */
    co_terms terms;                                         /* terms that are evaluated, and that count */
    int is_normalized;                                      /* as in co_request */
    void (*evaluated)(void *user, const co_values *values); /* told each time that the rules were evaluated; may raise
                                                               the flag. NULL: nobody is told */
    void *user;
} co_quadrature_goal;

/* Refines rules where needed until the estimated relative errors are below goal->tolerance, or rules are at their
 * finest. An assembly that met it once (`met`) is left alone while errors stay below `quadrature_hysteresis` times the
 * tolerance. `energies` gets values and error estimates; *resolved whether the error is at most CO_ACCEPTABLE_ERROR
 * or the tolerance, and int H^2 is what such a surface may have; *changed whether any rule was changed. ERROR_MEMORY.
 */
int32_t co_adaptive_quadrature_resolve(co_assembly *assembly, const double *xyz, const co_quadrature_goal *goal,
                                       curvopt_energies *energies, int *resolved, int *changed, curvopt_error *error);

/* The parts of the cage's faces, energy [n_faces], in the objective that was resolved last. */
void co_adaptive_quadrature_by_face(const co_assembly *assembly, int32_t n_faces, double *energy);

/* All figures become NAN. */
void co_adaptive_quadrature_leave_unknown(curvopt_energies *energies);
/* Energies by the rules as they are, whether or not the run is cancelled, with the errors that were estimated last; all
 * are NAN if there are no batches. For the end of a run that is cancelled. x [3 n_cage]: normalized positions. */
void co_adaptive_quadrature_glance(co_assembly *assembly, const double *x, curvopt_energies *energies);

/* Takes back rules that are not needed any more, one step each, where the values show that this changes next to
 * nothing. To be called after co_adaptive_quadrature_resolve() with CO_TERMS_OBJECTIVE, at the same positions. Rules
 * grow with the bad shapes that a run passes through. *changed: whether any was changed. ERROR_MEMORY. */
int32_t co_adaptive_quadrature_coarsen(co_assembly *assembly, double tolerance, int *changed, curvopt_error *error);

/* Whether the total curvature is what Gauss and Bonnet say, as far as errors of rules let it; where it is not known,
 * yes. */
int co_adaptive_quadrature_closes(const curvopt_energies *energies);
/* Whether resolved `energies` are those of a surface: ERROR_GEOMETRY for zero area or an energy that is not finite,
 * ERROR_RESOLUTION if Gauss-Bonnet's defect, or an integral of H^2 that no closed surface has, says that most of its
 * curvature was missed (a surface folded flat). */
int32_t co_adaptive_quadrature_check(const co_assembly *assembly, const curvopt_energies *energies,
                                     curvopt_error *error);

/* ERROR_GEOMETRY, for an energy that is not finite at the positions evaluated last. */
int32_t co_adaptive_quadrature_not_finite(const co_assembly *assembly, curvopt_error *error);

/* Values by the rules one step finer, at the positions that were evaluated last; by patch in assembly->finer_batches.
 * ERROR_MEMORY. */
int32_t co_adaptive_quadrature_evaluate_finer(co_assembly *assembly, int third, co_values *values,
                                              curvopt_error *error);

#endif
