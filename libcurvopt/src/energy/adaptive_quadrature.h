/* Quadrature fine enough for a wanted error, and not much finer. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ADAPTIVE_QUADRATURE_H
#define CO_ENERGY_ADAPTIVE_QUADRATURE_H

#include "energy/assembly.h"

/* Which terms a call of co_adaptive_quadrature_resolve() is about. */
typedef enum co_terms {
    CO_TERMS_OBJECTIVE, /* those with a weight */
    CO_TERMS_REPORT,    /* all are evaluated, the objective decides */
    CO_TERMS_ALL        /* all must meet the tolerance */
} co_terms;

/* What co_adaptive_quadrature_resolve() is asked for. */
typedef struct co_quadrature_goal {
    double tolerance; /* wanted relative error */
    co_terms terms;
    int is_normalized; /* as in co_request */
} co_quadrature_goal;

/* Refines rules where needed until the estimated relative errors are below goal->tolerance, or rules are at their
 * finest. An assembly that met it once is left alone while errors stay within a small multiple, so that energies are
 * continuous functions of the cage but for rare steps. `energies` gets values and error estimates; *resolved whether
 * the error is acceptable, if not below the tolerance then below 1 %; *changed whether any rule was. */
int32_t co_adaptive_quadrature_resolve(co_assembly *assembly, const double *xyz, const co_quadrature_goal *goal,
                                       curvopt_energies *energies, int *resolved, int *changed, curvopt_error *error);

/* Rules grow with the bad shapes that a run passes through; this takes back what is not needed any more: after
 * co_adaptive_quadrature_resolve() by the objective alone, at the same positions, lowers rules by a step where the
 * values show that this changes next to nothing. *changed: whether any was. ERROR_MEMORY. */
int32_t co_adaptive_quadrature_coarsen(co_assembly *assembly, double tolerance, int *changed, curvopt_error *error);

/* Whether resolved `energies` are those of a surface: ERROR_GEOMETRY for zero area or an energy that is not finite,
 * ERROR_RESOLUTION if Gauss-Bonnet's defect says that most of its curvature was missed (a surface folded flat). */
int32_t co_adaptive_quadrature_check(const co_assembly *assembly, const curvopt_energies *energies,
                                     curvopt_error *error);

/* Values by the rules one step finer, at the positions that were evaluated last; by patch in `finer`. ERROR_MEMORY. */
int32_t co_adaptive_quadrature_evaluate_finer(co_assembly *assembly, int third, co_values *values,
                                              curvopt_error *error);

#endif
