/* The subgroups of a cage's symmetries. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_SUBGROUPS_H
#define CO_CONSTRAINTS_SUBGROUPS_H

#include "constraints/symmetry.h"

/* One of each class of conjugate subgroups, the largest first, the whole group the first of all. */
typedef struct co_subgroups {
    int32_t n;          /* number of classes */
    int32_t n_elements; /* elements of the whole group */
    uint8_t *member;    /* [n][n_elements] whether an element is in the subgroup */
    int32_t *order;     /* [n] elements of the subgroup */
} co_subgroups;

/* At most 512 classes; others are left out. ERROR_MEMORY. */
int32_t co_subgroups_create(const co_symmetry *symmetry, co_subgroups *out, curvopt_error *error);
void co_subgroups_free(co_subgroups *subgroups);
/* The subgroup of the elements marked in member [order], which must be one. ERROR_MEMORY. */
int32_t co_subgroup_select(const co_symmetry *symmetry, const uint8_t *member, co_symmetry *out, curvopt_error *error);

#endif
