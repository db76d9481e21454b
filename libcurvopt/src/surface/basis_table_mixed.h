/* Tables of several kinds of faces side by side, one in each vector lane. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BASIS_TABLE_MIXED_H
#define CO_SURFACE_BASIS_TABLE_MIXED_H

#include "surface/basis_table.h"

/* Whether faces of this kind may share a block with others that may, by the same rule: those of wide blends away from
 * the vertex, whose tables differ in rows alone, and of which a symmetric cage may have only one of each kind. Not
 * where the table is large. */
int co_basis_table_is_mixable(const co_basis_table *table);
/* The rows of such tables [lanes], of one rule, side by side. */
int32_t co_basis_table_mix(const co_basis_table *const *tables, int32_t lanes, co_basis_table **out,
                           curvopt_error *error);

#endif
