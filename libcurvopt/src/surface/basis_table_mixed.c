/* Tables of several kinds of faces side by side. SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/basis_table_mixed.h"

#include "base/memory.h"
#include "surface/patches.h"

#include <string.h>

enum { MOST_MIXED = 36 }; /* samples: a mixed table is as large as all of its tables */

int co_basis_table_is_mixable(const co_basis_table *t) {
    return co_fan_is_wide(t->kind) && co_patches_own_size(t->kind) == CO_RING_REGULAR && t->n_samples <= MOST_MIXED;
}

int32_t co_basis_table_mix(const co_basis_table *const *tables, int32_t n_tables, int32_t lanes, co_basis_table **out,
                           curvopt_error *error) {
    const co_basis_table *first = tables[0];
    size_t n_samples = (size_t)first->n_samples, n = n_samples * (size_t)first->n_points * CO_JET;
    co_basis_table *t = *out = CO_NEW(co_basis_table, 1);
    if (!t)
        return co_status_no_memory(error);
    *t = (co_basis_table){.surface = first->surface,
                          .kind = first->kind,
                          .n_points = first->n_points,
                          .n_own = first->n_own,
                          .n_samples = first->n_samples,
                          .is_mixed = 1,
                          .support = CO_NEW(int32_t, first->n_points),
                          .area_weight = CO_NEW(double, n_samples),
                          .weight = CO_NEW(double, n_samples),
                          .jacobian_scale = CO_NEW(double, n_samples),
                          .rows = CO_NEW_ALIGNED(double, n *(size_t)n_tables)};
    if (!t->support || !t->area_weight || !t->weight || !t->jacobian_scale || !t->rows) {
        co_basis_table_destroy(t);
        *out = NULL;
        return co_status_no_memory(error);
    }
    memcpy(t->support, first->support, sizeof *t->support * (size_t)t->n_points);
    memcpy(t->area_weight, first->area_weight, sizeof(double) * n_samples);
    memcpy(t->weight, first->weight, sizeof(double) * n_samples);
    memcpy(t->jacobian_scale, first->jacobian_scale, sizeof(double) * n_samples);
    double *to = t->rows;
    for (int32_t part = 0; part < n_tables; part += lanes)
        for (size_t i = 0; i < n; i++)
            for (int32_t lane = 0; lane < lanes; lane++)
                *to++ = tables[part + lane]->rows[i];
    return CURVOPT_OK;
}
