/* Tables of several kinds of faces side by side, one in each vector lane. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BASIS_TABLE_MIXED_H
#define CO_SURFACE_BASIS_TABLE_MIXED_H

#include "surface/basis_table.h"

/* Whether faces of this kind may share a batch with faces of other such kinds, by the same rule. So may those of wide
 * discs away from the vertex: their tables differ in rows alone, and a symmetric cage may have only one face of each
 * kind. So may not those with large tables (MOST_MIXED). */
int co_basis_table_is_mixable(const co_basis_table *table);
/* A table whose rows are those of tables [n_tables], all of one rule, side by side, `lanes` of them at a time, which
 * divides n_tables. ERROR_MEMORY. */
int32_t co_basis_table_mix(const co_basis_table *const *tables, int32_t n_tables, int32_t lanes, co_basis_table **out,
                           curvopt_error *error);

#endif
