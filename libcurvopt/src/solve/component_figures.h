/* Figures of a cage from those of its components. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_COMPONENT_FIGURES_H
#define CO_SOLVE_COMPONENT_FIGURES_H

#include "base/status.h"

/* What is known of one component, or of several that are alike. */
typedef struct co_component_part {
    int32_t times;         /* how many of them there are */
    const double *weights; /* [CURVOPT_MAX_TERMS] of the terms in its objective */
    const curvopt_energies *energies;
    const curvopt_level_report *report;
    const curvopt_summary *summary; /* NULL: nothing moves it */
} co_component_part;

/* Energies of all together by the weights of their objective; radius: root mean square distance of the cage's vertices
 * from their centroid. Third-order terms have the area of all as a factor, and of a component its own. */
void co_component_figures_energies(const co_component_part *parts, int32_t n, const double *weights, double radius,
                                   curvopt_energies *out);
/* The report of a level of all: out->energy is known, and all that is counted. */
void co_component_figures_report(const co_component_part *parts, int32_t n, curvopt_level_report *out);
/* What components' summaries say of verdicts and of what is held: the verdict is the worst one, decrements and
 * directions add up, and a multiplier is NAN where several components have one. The rest of *out stays. */
void co_component_figures_summary(const co_component_part *parts, int32_t n, curvopt_summary *out);

#endif
