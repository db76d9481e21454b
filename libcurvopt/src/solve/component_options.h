/* The options of a run, for each component of its cage. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_COMPONENT_OPTIONS_H
#define CO_SOLVE_COMPONENT_OPTIONS_H

#include "mesh/components.h"

/* Options whose constraints, entries, chains and holes are those of one component, by its own numbers. */
typedef struct co_component_options {
    curvopt_options options;
    curvopt_constraints constraints;
    curvopt_through through;
    curvopt_chain *chains;
    int32_t *integers; /* [..] all arrays of these */
    double *reals;     /* [..] */
} co_component_options;

/* Items of the options by components: those of component c are item[first[c]] to item[first[c + 1] - 1], ascending. */
typedef struct co_component_items {
    int32_t *first;
    int32_t *item;
} co_component_items;

typedef struct co_component_shares {
    co_component_items constraints, entries, chains, holes;
} co_component_shares;

/* Whether components can be minimized one by one. Not with what ties them together: a volume, an area or a mean
 * curvature of all with a given value, no crossings; nor with the report's settings. */
int co_component_options_fit(const curvopt_options *options);

/* Which component has what; the options have been checked with the whole cage. ERROR_MEMORY. */
int32_t co_component_shares_create(const curvopt_options *whole, const co_components *components,
                                   co_component_shares *out, curvopt_error *error);
void co_component_shares_free(co_component_shares *shares);

/* What component c has; curves of chains are borrowed. ERROR_MEMORY. */
int32_t co_component_options_create(const curvopt_options *whole, const co_components *components,
                                    const co_component_shares *shares, int32_t c, co_component_options *out,
                                    curvopt_error *error);
void co_component_options_free(co_component_options *options);

#endif
