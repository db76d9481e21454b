/* Whether a step that looks like progress is progress: the review of steps against finer quadrature.
 *
 * With a fixed quadrature rule the discrete energy has no lower bound, and an optimizer finds that out. Here the rules
 * are held against finer ones after every few steps, after a long step unless they are rough, and when Gauss-Bonnet's
 * defect, which is free, has grown. A step that looked like progress only to a rule too coarse is taken back.
 *
 * What is reviewed is a function behind callbacks: in a run a level's energy, in tests a toy.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_STEP_REVIEW_H
#define CO_SOLVE_STEP_REVIEW_H

#include "base/status.h"
#include "base/tuning.h"
#include "optimize/objective.h"

/* A function whose rules can be refined. */
typedef struct co_reviewed {
    void *context;
    size_t n;
    void (*evaluate)(void *context, co_iterate *at);
    /* Holds the rules at x against finer ones and refines them where needed. *resolved: whether they then suffice;
     * *changed: whether any was refined; *defect: Gauss-Bonnet's, by the rules that stand. */
    int32_t (*resolve)(void *context, const double *x, int *resolved, int *changed, double *defect,
                       curvopt_error *error);
    /* Takes back rules that are finer than needed, where resolve() was called last and changed nothing. *changed:
     * whether any was. */
    int32_t (*coarsen)(void *context, int *changed, curvopt_error *error);
} co_reviewed;

typedef struct co_step_review {
    const co_tuning *tuning;
    co_reviewed function;
    double *first; /* [n] the first iterate */
    double *safe;  /* [n] the last iterate that was held against finer rules and stood */
    double value;  /* at `safe`, by the rules that stood then */
    double defect; /* Gauss-Bonnet's there, in radians */
} co_step_review;

/* What is known of a step before a review. */
typedef struct co_step_facts {
    int iteration;
    int counts_length; /* a long step is due: the method takes such, and rules are not rough */
    double length;     /* of the step, in mean edges */
    double defect;     /* Gauss-Bonnet's where the step leads, by the present rules */
} co_step_facts;

/* Room for n variables, and at least one. ERROR_MEMORY. */
int32_t co_step_review_create(const co_tuning *tuning, const co_reviewed *function, co_step_review *out,
                              curvopt_error *error);
void co_step_review_free(co_step_review *review);
/* From x on, which is resolved, with this defect. Its value is not known: that is for who knows it to set. */
void co_step_review_begin(co_step_review *review, const double *x, double defect);
int co_step_review_is_due(const co_step_review *review, const co_step_facts *facts);
/* Holds `now` against finer rules. It becomes the safe iterate; or, if it cannot be resolved, or its value is not below
 * the safe one's by rules that tell them apart, it becomes the safe one itself, and the step is rejected. Where the
 * safe iterate's own value has risen to tuning->review_fold times what it was, it is in a fold that no review saw in
 * time: the verdict is STOP, as it is on an error. */
int32_t co_step_review_check(co_step_review *review, co_iterate *now, co_step_verdict *verdict, curvopt_error *error);
/* `now` becomes the safe iterate: those in between were not reviewed. */
void co_step_review_take_back(co_step_review *review, co_iterate *now);

#endif
