/* Where a cage lies: rigid motions and scale, which energies do not see. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_SIMILARITY_H
#define CO_MESH_SIMILARITY_H

#include "base/status.h"

#include <stddef.h>

/* Mean of n points, and root mean square distance from it. */
double co_similarity_frame(size_t n, const double *xyz, double centroid[3]);
/* Replaces m by the orthogonal matrix nearest to it; 0 where m is singular, and then it is undefined. */
int co_similarity_orthogonal_factor(double m[3][3]);
/* Rotates xyz [3 n] about its centroid to lie closest to `reference` [3 n] and moves its centroid there; no scaling. */
void co_similarity_align(size_t n, const double *reference, double *xyz);

/* ERROR_GEOMETRY, naming the vertex, unless xyz [3 n_vertices] is finite and of some extent: must hold before energies
 * are evaluated. */
int32_t co_similarity_check(int32_t n_vertices, const double *xyz, curvopt_error *error);

#endif
