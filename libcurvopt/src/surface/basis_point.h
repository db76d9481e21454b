/* Basis rows at any point of a patch. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BASIS_POINT_H
#define CO_SURFACE_BASIS_POINT_H

#include "surface/basis_table_cache.h"

/* Rows at any point (u, v) of a patch: rows [co_patches_size(kind)][CO_JET] over all of its points, derivatives with
 * respect to u and v. weight [CO_JET] is filled on the extraordinary patches of `plane`, with the blend's jet. At (0,
 * 0) of an extraordinary patch derivatives are NAN. On `limit` they are the limit's, also where a table has a blend.
 * ERROR_MEMORY. */
int32_t co_basis_point(co_basis_table_cache *cache, int32_t kind, double u, double v, double *rows, double *weight,
                       curvopt_error *error);

#endif
