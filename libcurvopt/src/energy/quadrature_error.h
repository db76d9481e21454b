/* Terms of single patches by several quadrature rules, and how far each is off.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_QUADRATURE_ERROR_H
#define CO_ENERGY_QUADRATURE_ERROR_H

#include "base/tuning.h"
#include "energy/functional.h"
#include "energy/marking.h"

#include <math.h>
#include <stddef.h>

/* A patch's contributions to every term and to the numbers of the whole surface. */
typedef struct co_patch_terms {
    double term[CURVOPT_N_TERMS];     /* third order multiplied by the whole area */
    double number[CURVOPT_N_SCALARS]; /* by curvopt_scalar; the volume is 0 where it is not evaluated */
    double
        jump; /* CO_SUM_JUMP (element_kernel.h), multiplied by the whole area: of a term with X once, as often as X */
} co_patch_terms;

/* How much an objective changes with these. */
typedef struct co_quadrature_weights {
    const double *term;               /* [CURVOPT_N_TERMS] */
    double number[CURVOPT_N_SCALARS]; /* what spontaneous curvature adds, to first order */
} co_quadrature_weights;

/* Reference of relative differences: the objective, or every term. */
typedef struct co_quadrature_error_measure {
    co_quadrature_weights weights;
    int every_term;       /* the worst term counts, not the objective alone */
    co_patch_terms whole; /* sum over all patches */
    double more;          /* in the objective, beside the terms */
} co_quadrature_error_measure;

/* Difference x - y of the objective. Inline, as co_quadrature_error_add() is: both are called for every patch. */
static inline double co_quadrature_error_difference(const co_quadrature_weights *weights, const co_patch_terms *x,
                                                    const co_patch_terms *y) {
    double sum = 0;
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        if (weights->term[t] > 0)
            sum += weights->term[t] * (x->term[t] - y->term[t]);
    for (int s = 0; s < CURVOPT_N_SCALARS; s++)
        if (weights->number[s] != 0)
            sum += weights->number[s] * (x->number[s] - y->number[s]);
    return sum;
}
/* |x - y| relative to the whole: the objective's, or the worst term's. */
double co_quadrature_error_relative(const co_quadrature_error_measure *measure, const co_patch_terms *x,
                                    const co_patch_terms *y);

/* Error of a sum over patches. Signed differences to the finest rule compared may cancel. That rule has an error of
 * unknown sign itself. */
typedef struct co_quadrature_error {
    double net;    /* sum of signed differences to the finest rule */
    double finest; /* sum of what is taken for the finest rules' own errors */
} co_quadrature_error;

/* How a patch's value changes from its own rule to the finest that it was compared with, in two steps or one. */
typedef struct co_quadrature_change {
    double all;   /* own rule less finest */
    double first; /* own rule less the finest but one, 0 if that is the same */
    double last;  /* finest but one less finest */
    double jump;  /* what the finest may miss at umbilics: `jump` by it, times the weight of X */
} co_quadrature_change;

/* fmax(), which is a call: the other number where one is not. */
static inline double co_quadrature_larger(double x, double y) {
    return x >= y || isnan(y) ? x : y;
}

/* Adds a patch. The finest rule's error is a part of what the last step to it changed (quadrature_reference,
 * base/tuning.h), or, if that is more, a part of the jump (quadrature_jump), but no more than a multiple of the
 * largest change (quadrature_agreement), so that what is no umbilic counts little. */
static inline void co_quadrature_error_add(co_quadrature_error *sum, const co_tuning *tuning,
                                           const co_quadrature_change *c) {
    const double last = fabs(c->last), largest = co_quadrature_larger(last, fabs(c->first));
    const double jump = tuning->quadrature_jump * c->jump, most = tuning->quadrature_agreement * largest;
    const double at_umbilics = jump <= most || isnan(most) ? jump : most; /* fmin() */
    sum->net += c->all;
    sum->finest += co_quadrature_larger(tuning->quadrature_reference * last, at_umbilics);
}
void co_quadrature_error_join(co_quadrature_error *sum, const co_quadrature_error *other);
/* The error that is claimed: |net| and the finest rules' own. */
double co_quadrature_error_claimed(const co_quadrature_error *sum);

/* Estimates of every patch's quadrature error. All NULL until first needed. */
typedef struct co_quadrature_estimates {
    co_patch_terms *used;             /* [n_patches] terms by the patch's own rule */
    co_patch_terms *finer;            /* [n_patches] terms by the rule one step finer */
    co_patch_terms *finest;           /* [n_patches] terms by the rule two steps finer, where has_third_rule */
    uint8_t *has_third_rule;          /* [n_patches] whether `finest` was evaluated */
    uint8_t *in_finest;               /* [n_patches] whether it is among the batches by which that is evaluated */
    double *error;                    /* [n_patches] relative difference of two rules' terms */
    double *error_per_cost;           /* [n_patches] the same per cost of changing the rule */
    co_marking_candidate *candidates; /* [n_patches] work space of the marking */
    double sum;                       /* sum of `error` when rules were last resolved */
} co_quadrature_estimates;

/* Makes room for n_patches, once. ERROR_MEMORY. */
int32_t co_quadrature_estimates_ensure(co_quadrature_estimates *estimates, size_t n_patches, curvopt_error *error);
/* Third-order terms are multiplied by the whole area, which is best known by the finest rule compared of each patch.
 * Those by the rules that are one and two steps finer have `area` as a factor, and get that one. */
void co_quadrature_estimates_use_best_area(co_quadrature_estimates *estimates, size_t n_patches, double area);
void co_quadrature_estimates_free(co_quadrature_estimates *estimates);

#endif
